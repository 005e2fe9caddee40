"""``spherefunc together``: several objects in their places, and what each takes away from the others."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spherefunc_bullet.commands.options import BY_FILE, Json, Model, PackagePath, Seed, Units, Up, require_drawings
from spherefunc_bullet.console import print_json, print_table, say
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import format_length, parse_length

if TYPE_CHECKING:
    from spherefunc_bullet.function_model import FunctionModel

    from ..arrangements.placing import Placement
    from ..arrangements.together import ArrangedResult, Together, TogetherSettings

Row = dict[str, Any]
PLACES = "FILE[@x,y[,z[,heading]]] in metres and degrees; without z, the object is put on what stands there."


def together(
    files: Annotated[list[str], typer.Argument(metavar="FILE@PLACE...", help=PLACES)],
    radius: Annotated[str | None, typer.Option(help="Sphere radius. Default: by the object's size.")] = None,
    drops: Annotated[
        int, typer.Option(min=1, help="Spheres dropped on each object, alone and together, to measure areas.")
    ] = 1000,
    model: Model = None,
    backend: Annotated[
        str | None, typer.Option(help="Simulator (fast or bullet) the model must have been trained with.")
    ] = None,
    seed: Seed = 0,
    up: Up = BY_FILE,
    units: Units = "m",
    package_path: PackagePath = None,
    picture: Annotated[
        Path | None,
        typer.Option(metavar="PNG", help="Draw the objects; each sphere has the colour of the object that carries it."),
    ] = None,
    page: Annotated[
        Path | None, typer.Option(metavar="HTML", help="Write the picture and the table as an HTML page.")
    ] = None,
    json: Json = False,
):
    """Arrange several objects, and report what each carries, its functions, and what it takes from others."""
    from spherefunc_bullet.learning.model_file import inference_model, shipped_model
    from spherefunc_bullet.processes.tasks import run_tasks
    from spherefunc_bullet.simulator import isolated, make_simulator

    from ..arrangements.placing import parse_placed
    from ..arrangements.together import FEWEST, TogetherSettings

    placed = [parse_placed(text) for text in files]
    require_drawings([path for path, _ in placed], picture, page)
    if len(placed) < FEWEST:
        raise InputError(f"{files[0]}: expected at least two files; `spherefunc simulate` drops on one alone")
    settings = TogetherSettings(radius=None if radius is None else parse_length(radius), drops=drops, seed=seed)
    classifier = inference_model(model or shipped_model(backend or "fast"), backend)
    isolate = isolated(make_simulator(classifier.simulator))
    tasks = [(placed, classifier, settings, up, units)]
    [(_, found)] = run_tasks(classify_files, tasks, ["all together"], isolate=isolate)
    if isinstance(found, InputError):
        raise found
    names = list(found.objects[0].alone)
    head = ["file", "stands on", "at, m", "spheres", "level alone, m²", "together", "taken by", *names]
    rows = [row_of(item) for item in found.objects]
    draw(found, picture, page, head, rows)
    for note in found.notes:
        say(note)
    if json:
        print_json(as_json(found, [path for path, _ in placed]))
    else:
        print_table(f"Spheres of radius {format_length(found.radius)} on all of them", head, rows)


def classify_files(
    placed: list[tuple[Path, Placement]], classifier: FunctionModel, settings: TogetherSettings, up: str, units: str
) -> Together:
    """Return the objects of files in their places, classified alone and together."""
    from spherefunc_bullet.clouds.cloud import load_cloud

    from ..arrangements.together import classify_together, put_down

    clouds = [load_cloud(path, up=up, units=units, report=say) for path, _ in placed]
    return classify_together(put_down(clouds, [placement for _, placement in placed]), classifier, settings)


def draw(found: Together, picture: Path | None, page: Path | None, head: list[str], rows: list[list[str]]):
    """Write the picture and the page of objects, with the table in it, if they are wanted."""
    if picture is None and page is None:
        return
    from spherefunc_bullet.viewer.mechanics_pictures import write_picture

    from ..arrangements.picture import together_picture, write_together_page

    drawn = together_picture(found)
    if picture is not None:
        write_picture(drawn, picture)
    if page is not None:
        write_together_page(found, drawn, head, rows, page)


def as_json(found: Together, files: list[Path]) -> Row:
    """Return an arrangement for JSON: areas in square metres, places in metres."""
    drop = found.drop
    return {
        "objects": [json_of(item, file) for item, file in zip(found.objects, files, strict=True)],
        "drop": {"radius": found.radius, "drops": drop.drops, "settled": drop.settled, "rolled_off": drop.rolled_off},
        "notes": list(found.notes),
        "seconds": round(found.seconds, 3),
        "provenance": found.provenance,
    }


def json_of(item: ArrangedResult, file: Path) -> Row:
    """Return one object for JSON."""
    level = item.level
    return {
        "file": str(file),
        "name": item.name,
        "place": item.placed.shift.round(4).tolist(),
        "heading_deg": item.placed.placement.heading_deg,
        "stands_on": list(item.stands_on),
        "spheres": len(item.carries),
        "level": level and {name: rounded(value) for name, value in asdict(level).items()},
        "functions": {
            name: {
                among: {"member": one.member, "score": one.score}
                for among, one in (("alone", alone), ("together", item.together[name]))
            }
            for name, alone in item.alone.items()
        },
    }


def rounded(value: Any) -> Any:
    """Return a number, or the numbers in a dictionary, with five decimals."""
    if isinstance(value, dict):
        return {name: rounded(one) for name, one in value.items()}
    return round(value, 5) if isinstance(value, float) else value


def row_of(item: ArrangedResult) -> list[str]:
    """Return one object's row; scores alone and together where they differ."""
    at = " ".join(f"{coordinate:.2f}" for coordinate in item.placed.shift)
    start, scores = [item.name, ", ".join(item.stands_on), at, str(len(item.carries))], []
    for name, membership in item.alone.items():
        before, after = f"{membership.score:.2f}", f"{item.together[name].score:.2f}"
        scores.append(after if before == after else f"{before} → {after}")
    if item.level is None:
        return [*start, "", "", "", *scores]
    taken = [f"{name} {area:.3g}" for name, area in item.level.taken.items() if area > 0]
    return [*start, f"{item.level.alone:.3g}", f"{item.level.together:.3g}", ", ".join(taken), *scores]
