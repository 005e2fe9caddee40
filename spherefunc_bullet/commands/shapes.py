"""``spherefunc shapes``: what collision shapes keep of what an object is for, and what they cost."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..console import Failures, print_json, print_table, say, show
from ..errors import InputError
from .options import BY_FILE, Json, PackagePath, Units, Up

if TYPE_CHECKING:
    from ..shapes.compared import BestShape

COLUMNS = ["name", "pieces", "faces", "bytes", "build_seconds", "step_us", "capacity_ml", "capacity_kept", "level_kept"]
COLUMNS += ["level_higher_mm", "settled_kept", "moved_mm", "deeper", "openings_closed", "keeps", "verdict"]
SUFFIX = {"urdf": ".urdf", "sdf": ".sdf", "mjcf": ".xml"}


def shapes(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Meshes, URDFs, or folders of them.")],
    collision: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Collision geometry: URDF, SDF, MJCF, or a mesh.")
    ] = None,
    best: Annotated[bool, typer.Option("--best", help="Find and write the cheapest that keeps everything.")] = False,
    still: Annotated[bool, typer.Option("--static", help="It never moves: --best may be the concave mesh.")] = False,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Where --best writes.")] = Path("."),
    form: Annotated[str, typer.Option("--format", help="Of what --best writes: urdf, sdf or mjcf.")] = "urdf",
    keep: Annotated[
        float | None,
        typer.Option(help="Share of capacity, level, places to be kept. Default: 0.9; of --best see docs."),
    ] = None,
    coacd: Annotated[str | None, typer.Option(help="CoACD's thresholds, such as 0.05,0.2; minutes.")] = None,
    only: Annotated[bool, typer.Option("--only-collision", help="Compare the collision geometry alone.")] = False,
    table: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Write a row per shape, also for files that failed.")
    ] = None,
    up: Up = BY_FILE,
    units: Units = "m",
    package_path: PackagePath = None,
    json: Json = False,
):
    """Say what of an object each collision shape keeps: what it holds, carries and lets through, and at what cost."""
    from ..formats.writing import prepare_folder
    from ..shapes.compared import compare_shapes

    if form not in SUFFIX:
        raise InputError(f"--format {form}: expected urdf, sdf or mjcf")
    if still and form == "mjcf":
        raise InputError("--static: expected --format urdf or sdf, since MuJoCo takes the hull of every mesh")
    prepare_folder(out if best else None)
    thresholds = thresholds_of(coacd)
    failures, results = Failures(), []
    for file in objects_in(files):
        try:
            compared = compare_shapes(
                file, collision, shapes=not only, coacd=thresholds, keep=keep, units=units, up=up, report=say
            )
            row = compared.as_dict(str(file))
            if best:
                row["best"] = written(compared.best_for(still), file, out, form)
        except InputError as error:
            failures.add(error)
            row = {"file": str(file), "error": str(error)}
        results.append(row)
    if table is not None:
        write_table(table, results)
    if json:
        print_json(results)
    else:
        for row in results:
            if "error" not in row:
                print_shapes(row)
    failures.exit()


def objects_in(files: list[Path]) -> Iterator[Path]:
    """Yield files, and of folders those that are URDFs or, where there are none, meshes."""
    from ..formats.reading import READERS

    for file in files:
        if not file.is_dir():
            yield file
            continue
        inside = sorted(path for path in file.iterdir() if path.suffix.lower() in READERS)
        found = [path for path in inside if path.suffix.lower() == ".urdf"] or inside
        if not found:
            raise InputError(f"{file}: expected URDFs or meshes in the folder, found none")
        yield from found


def write_table(path: Path, results: list[dict[str, Any]]):
    """Write all shapes of all objects as CSV."""
    from ..formats.writing import write_csv

    rows = []
    for result in results:
        shown = [*result.get("shapes", []), *([result["best"]] if "best" in result else [])] or [{}]
        rows += [[result["file"], *(row.get(name, "") for name in COLUMNS), result.get("error", "")] for row in shown]
    write_csv(path, ["file", *COLUMNS, "error"], rows)


def thresholds_of(text: str | None) -> tuple[float, ...]:
    """Return CoACD's thresholds."""
    try:
        return tuple(float(part) for part in text.split(",")) if text else ()
    except ValueError as error:
        raise InputError(f"--coacd {text}: expected numbers, such as 0.05,0.2") from error


def written(shape: BestShape, file: Path, out: Path, form: str) -> dict[str, Any]:
    """Write the best shape of an object, and return what is printed of it."""
    from ..shapes.compared import as_row

    if not shape.row.keeps:
        say(f"{file.name}: none that was tried keeps everything; written is the one that keeps most")
    place = shape.write(out / f"{file.stem}{SUFFIX[form]}", form)
    return {"file": str(place)} | as_row(shape.row)


def print_shapes(results: dict[str, Any]):
    """Print an object's table."""
    head = ["shape", "pieces", "faces", "build s", "step µs", "capacity", "level", "spheres", "moved mm"]
    names = ["name", "pieces", "faces", "build_seconds", "step_us"]
    kept = ["capacity_kept", "level_kept", "settled_kept", "moved_mm"]
    rows = [*results["shapes"], *([results["best"]] if "best" in results else [])]
    table = [["" if row[name] is None else row[name] for name in [*names, *kept]] for row in rows]
    holds = f", holds {results['capacity_ml']:.0f} ml" if results["capacity_ml"] else ""
    functions = [name for name, about in results["functions"].items() if about["member"]]
    seed = f"another seed keeps {results['seed_spread']:.2f}"
    title = f"{results['file']}: {', '.join(functions) or 'no function'}{holds}; {seed}"
    print_table(title, head, table)
    show("\n".join(f"{row['name']}: {row['verdict']}" for row in rows))
