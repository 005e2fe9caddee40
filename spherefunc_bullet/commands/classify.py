"""``spherefunc classify``: say what objects are for."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..console import Failures, print_json, print_table, progress, say
from ..errors import InputError
from ..quantities import format_length
from .options import BY_FILE, Json, Units, Up

if TYPE_CHECKING:
    from ..learning.classifier import CloudClassifier, Membership
    from ..learning.cube_classifier import CubeClassifier
    from ..learning.function_classifier import FunctionClassifier
    from ..settling.drops import Length
    from ..settling.settling import Settled
    from ..simulator import Simulator

Row = dict[str, Any]  # what the contract prints of one file
CUBES = 3  # that speak for a function, and as many that speak against it


def classify(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Models or scans.")],
    model: Annotated[Path | None, typer.Option(help="A model file; without one, the model that ships.")] = None,
    backend: Annotated[str | None, typer.Option(help="The backend that the model must be for.")] = None,
    explain: Annotated[bool, typer.Option(help="Say why: in words, by what decided, by training objects.")] = False,
    up: Up = BY_FILE,
    units: Units = "m",
    json: Json = False,
):
    """Say what each object is for."""
    from ..learning.model_file import load_model, shipped_model
    from ..processes.tasks import run_tasks
    from ..simulator import isolated, make_simulator

    classifier = load_model(model or shipped_model(backend or "fast"), backend)
    failures, rows = Failures(), []
    tasks = [settling(file, classifier, up, units) for file in files]
    outcomes = run_tasks(settled_file, tasks, files, isolate=isolated(make_simulator(classifier.simulator)))
    for index, outcome in progress(outcomes, len(files), "classifying"):
        if isinstance(outcome, InputError):
            failures.add(outcome)
        else:
            rows.append(scored(files[index], *outcome, classifier, explain))
    print_json(rows) if json else print_functions(rows, classifier.functions_, explain)
    failures.exit()


def classified(file: Path, classifier: CloudClassifier, explain: bool, up: str, units: str) -> Row:
    """Return the scores of one file's object."""
    return scored(file, *settled_file(*settling(file, classifier, up, units)), classifier, explain)


def settling(file: Path, classifier: CloudClassifier, up: str, units: str) -> tuple:
    """Return the arguments of `settled_file` for a file."""
    return file, classifier.simulator, classifier.chosen_radii(), classifier.seed, classifier.length, up, units


def settled_file(
    file: Path, simulator: Simulator, radii: Sequence[float], seed: int, length: Length, up: str, units: str
) -> tuple[Settled, float]:
    """Return the settled centres on one file's object for each radius, and the seconds that it took."""
    from ..clouds.cloud import load_cloud
    from ..settling.settling import settle

    started = time.perf_counter()
    cloud = load_cloud(file, up=up, units=units, report=say)
    return settle(cloud, simulator, radii, seed, length), time.perf_counter() - started


def scored(file: Path, settled: Settled, seconds: float, classifier: CloudClassifier, explain: bool) -> Row:
    """Return the scores of one file's object, on which the spheres have fallen."""
    from ..learning.function_classifier import FunctionClassifier

    started = time.perf_counter()
    told = classifier.memberships_of([settled])[0]
    row = {"file": str(file), "functions": {name: asdict(membership) for name, membership in told.items()}}
    by_words = isinstance(classifier, FunctionClassifier)
    doubtful, reasons = in_words(classifier, settled, told) if by_words else ([], [])
    row |= {"unsure": bool(doubtful), "reasons": [*reasons, *doubtful]}
    row["seconds"] = round(seconds + time.perf_counter() - started, 3)
    if explain:
        row |= quantities_named(classifier, settled) if by_words else cubes_named(classifier, settled)
    return row


def in_words(
    classifier: FunctionClassifier, settled: Settled, told: dict[str, Membership]
) -> tuple[list[str], list[str]]:
    """Return what is doubtful about an answer, and the answer in sentences."""
    from ..learning.reasons.words import doubts, sentences

    scores = [membership.score for membership in told.values()]
    return doubts(classifier, settled, scores), sentences(classifier, settled, scores)


def quantities_named(classifier: FunctionClassifier, settled: Settled) -> Row:
    """Return the quantities that decided about each function, and the nearest training objects."""
    from ..learning.reasons.words import deciding, nearest

    decided = {name: deciding(classifier, settled, name) for name in classifier.functions_}
    return {"quantities": decided, "nearest": nearest(classifier, settled)}


def cubes_named(classifier: CubeClassifier, settled: Settled) -> Row:
    """Return the training objects and the cubes of space that decided about each function."""
    from ..learning.reasons.cubes import strongest_cubes

    return {
        "neighbors": {name: classifier.neighbors(settled, name) for name in classifier.functions_},
        "cubes": {name: strongest_cubes(classifier, settled, name, CUBES) for name in classifier.functions_},
    }


def print_functions(rows: list[Row], functions: tuple[str, ...], explain: bool):
    """Print what each object is for, with its scores."""
    table = []
    for row in rows:
        members = [name for name in functions if row["functions"][name]["member"]]
        scores = [f"{row['functions'][name]['score']:.2f}" for name in functions]
        answer = (", ".join(members) or "none") + (", unsure" if row["unsure"] else "")
        table.append([Path(row["file"]).name, answer, *scores])
    if table:
        print_table("What objects are for (scores; above 0.5 it is)", ["file", "for", *functions], table)
    for row in rows if explain else []:
        print_reasons(row)
        for name in functions:
            if "quantities" in row:
                print_quantities(row, name)
            else:
                print_neighbors(row, name)
                print_cubes(row, name)


def print_reasons(row: Row):
    """Print one object's answer in sentences, and the training objects that are most like it."""
    if not row["reasons"]:
        return
    print(f"\n{Path(row['file']).name}")
    for reason in row["reasons"]:
        print(f"  {reason}")
    near = [f"{near['name']} ({', '.join(near['functions']) or 'none'})" for near in row["nearest"]]
    print(f"  nearest training objects: {', '.join(near)}")


def print_quantities(row: Row, name: str):
    """Print which quantities decided about one function of one object."""
    from ..learning.reasons.words import unit_of, with_unit

    table = [
        [
            decided["meaning"],
            format_length(decided["radius"]),
            *(with_unit(decided[key], unit_of(decided["quantity"])) for key in ("value", "median")),
            f"{-decided['share']:+.2f}",
        ]
        for decided in row["quantities"][name]
    ]
    if not table:
        return
    title = f"\n{Path(row['file']).name}: why {name} {row['functions'][name]['score']:.2f}"
    print_table(title, ["quantity", "spheres", "here", "median learnt", "score without it"], table)


def print_neighbors(row: Row, name: str):
    """Print which training objects decided one function of one object."""
    table = [
        [
            neighbor["name"],
            format_length(neighbor["radius"]),
            "yes" if neighbor["member"] else "no",
            f"{neighbor['distance']:.2f}",
            f"{neighbor['weight']:.3f}",
        ]
        for neighbor in row["neighbors"][name]
    ]
    title = f"\n{Path(row['file']).name}: why {name} {row['functions'][name]['score']:.2f}, by nearest training objects"
    print_table(title, ["training object", "spheres", f"is {name}", "distance", "weight"], table)


def print_cubes(row: Row, name: str):
    """Print which cubes of space speak for and against one function of one object."""
    table = [
        [
            "for" if cube["share"] > 0 else "against",
            " ".join(f"{100 * (low + cube['side'] / 2):.1f}" for low in cube["corner"]),
            *(f"{cube[key]:.1f}" for key in ("spheres", "members", "others")),
            f"{abs(cube['share']):.0%}",
        ]
        for cube in row["cubes"][name]
    ]
    if table:
        first = row["cubes"][name][0]
        title = f"by cubes of {100 * first['side']:.3g} cm, spheres of {format_length(first['radius'])}"
        head = ["speaks", "middle x y z, cm", "spheres here", f"nearest {name}", "nearest others", "weight"]
        print_table(title, head, table)
