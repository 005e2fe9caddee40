"""``spherefunc classify``: classify the functions of objects."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator, Sequence
from itertools import chain, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..console import Failures, as_options, print_json, print_table, progress, say, show, shown_names, with_path
from ..errors import InputError, one_line
from ..formats.units import format_length
from .options import BY_FILE, Json, Model, PackagePath, Units, Up

if TYPE_CHECKING:
    from ..classification import ModelPair
    from ..settling.cached_runs import LoadOptions

STDIN = Path("-")  # in place of a file: the names of files come on stdin, one per line
Row = dict[str, Any]  # JSON entry of one file
SHOWN = 4  # most functions with a column each; of more, only the best of each object are shown
BEST = 2  # number of functions that are shown then


def classify(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...", readable=False, help="Models or scans, folders of them, or - for names on stdin."
        ),
    ],
    model: Model = None,
    backend: Annotated[
        str | None,
        typer.Option(help="Simulator of the model; with fast,bullet, the first answers and the second checks."),
    ] = None,
    function: Annotated[
        str | None, typer.Option(help="Classify this function only; models by cubes then run its radius only.")
    ] = None,
    explain: Annotated[
        bool, typer.Option(help="Explain: reasons, the quantities that decided, similar training objects.")
    ] = False,
    table: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Write one row per file, also for files that failed.")
    ] = None,
    jobs: Annotated[int, typer.Option(help="Number of parallel processes; -1: one per core.")] = 1,
    any_pose: Annotated[
        bool, typer.Option(help="Classify in every stable pose; report the best pose for each function.")
    ] = False,
    up: Up = BY_FILE,
    units: Units = "m",
    package_path: PackagePath = None,
    json: Json = False,
):
    """Classify the function of each object."""
    from ..formats.files import require_place
    from ..learning.model_file import models_for
    from ..processes.tasks import run_tasks
    from ..settling.cached_runs import LoadOptions
    from ..simulator import isolated, make_simulator

    if any_pose and (explain or table is not None):
        raise InputError("--any-pose: expected without --csv and --explain, which answer for one pose")
    if any_pose and up != BY_FILE:
        raise InputError(f"--up {up}: expected without --any-pose, which tries every pose")
    models = models_for(model, backend, function)
    functions = models[0][0].functions_
    names, failures = list(listed_files(files)), Failures()
    if table is not None:
        require_place(table, names)
    if any_pose:
        from .poses import classify_any_pose

        if len(models) > 1:
            raise InputError(f"--backend {backend}: expected one with --any-pose")
        return classify_any_pose(names, models[0][0], units, json, jobs)
    how = (models, LoadOptions(up=up, units=units), json or explain, explain)
    isolate = any(isolated(make_simulator(chosen.simulator)) for chosen, _ in models)
    outcomes = run_tasks(classified_file, [(file, *how) for file in names], names, jobs=jobs, isolate=isolate)
    rows: list[Row | None] = [None] * len(names)
    for index, outcome in progress(outcomes, len(names), "classifying"):
        rows[index] = outcome = with_path(outcome, names[index])
        if isinstance(outcome, InputError):
            failures.add(outcome)
            rows[index] = {"file": str(names[index]), "error": as_options(one_line(outcome))}
    if table is not None:
        write_rows(rows, functions, table)
    print_json(rows) if json else print_functions(rows, functions, explain)
    failures.exit()


def listed_files(places: Sequence[Path]) -> Iterator[Path]:
    """Yield files, those below folders that can be read, folders without any, and files named on stdin.

    Links to files that are missing, as of git-annex, count as files, so that they are reported.
    """
    from ..datasets.dataset import SUFFIXES, names_below
    from ..formats.files import is_broken_link

    for place in places:
        if place == STDIN:
            yield from listed_files([Path(line) for line in sys.stdin.read().splitlines() if line.strip()])
        elif os.path.isdir(place):
            files = [path for path in names_below(place) if path.suffix.lower() in SUFFIXES]
            yield from [path for path in files if path.is_file() or is_broken_link(path)] or [place]
        else:
            yield place


def classified_file(
    file: Path, models: Sequence[ModelPair], loading: LoadOptions, reasons: bool = True, explain: bool = True
) -> Row:
    """Return the JSON entry of one file, with reasons and evidence if requested; runs in a worker."""
    from ..classification import classify_by_all
    from ..formats.files import require_not_folder
    from ..settling.cached_runs import CachedFile

    started = time.perf_counter()
    require_not_folder(file, "models or scans")
    reports = chain([say], repeat(None))  # warnings about the file are printed once
    decision = classify_by_all(lambda model: CachedFile(file, model.drop_config(loading), next(reports)), models)
    row = decision.row(str(file), round(time.perf_counter() - started, 3), reasons)
    if explain:
        from ..answer import evidence

        row |= evidence(decision)
    return row


def write_rows(rows: Sequence[Row], functions: Sequence[str], path: Path):
    """Write a CSV with a row for each file: its functions, each score, or the error."""
    from ..datasets.dataset import label_text
    from ..formats.files import write_csv

    columns = ("file", "functions", *functions, "unsure", "error")
    table = []
    for row in rows:
        memberships = row.get("functions", {})
        scores = [memberships[name]["score"] if name in memberships else "" for name in functions]
        label = label_text(members_of(row)) if memberships else ""
        table.append([row["file"], label, *scores, row.get("unsure", ""), row.get("error", "")])
    write_csv(path, columns, table)


def members_of(row: Row) -> list[str]:
    """Return the functions that a file's object has."""
    return [name for name, membership in row["functions"].items() if membership["member"]]


def print_functions(rows: Sequence[Row], functions: Sequence[str], explain: bool):
    """Print the functions and scores of each object, and how many files could not be classified."""
    from ..classification import WRONG_UP_AXIS

    shown = shown_names(row["file"] for row in rows)
    done = [row | {"shown": shown[row["file"]]} for row in rows if "error" not in row]
    print_table("What objects are for (scores; positive if > 0.5)", *table_of(done, functions))
    for row in [] if explain else done:
        if WRONG_UP_AXIS in row.get("reasons", ()):
            show(as_options(f"{row['shown']}: {WRONG_UP_AXIS}"))
    if len(done) < len(rows) > 1:
        say(f"{len(rows) - len(done)} of {len(rows)} files could not be classified; see the errors above")
    for row in done if explain else []:
        print_reasons(row)
        for name in functions:
            if "quantities" in row:
                print_quantities(row, name)
            else:
                print_neighbors(row, name)
                print_cubes(row, name)


def table_of(rows: Sequence[Row], functions: Sequence[str]) -> tuple[list[str], list[list[str]]]:
    """Return the columns and rows of a table: with every score if it fits, else with the best scores of each object."""
    starts = []
    for row in rows:
        answer = ", ".join(members_of(row)) or "none"
        starts.append([row["shown"], answer + ", unsure" * row["unsure"]])
    scores = [[(about["score"], name) for name, about in row["functions"].items()] for row in rows]
    columns = ["file", "for", *functions]
    table = [start + [f"{score:.2f}" for score, _ in own] for start, own in zip(starts, scores, strict=True)]
    width = sum(max(map(len, column)) + 2 for column in zip(columns, *table, strict=True))
    if len(functions) <= SHOWN and width <= terminal_width():
        return columns, table
    best = [sorted(own, key=lambda item: -item[0])[:BEST] for own in scores]
    texts = [" ".join(f"{name} {score:.2f}" for score, name in own) for own in best]
    return ["file", "for", "best scores"], [[*start, text] for start, text in zip(starts, texts, strict=True)]


def terminal_width() -> int:
    """Return the width of the terminal in characters; unlimited in a pipe."""
    from rich.console import Console

    console = Console()
    return console.width if console.is_terminal else sys.maxsize


def print_reasons(row: Row):
    """Print the reasons for one object, and the most similar training objects."""
    if not row["reasons"]:
        return
    members = members_of(row)
    show(f"\n{row['shown']}")
    first, *others = row["reasons"]
    show(f"  {first}" if members else f"  likeliest: {first}")
    for reason in others:
        show(f"  {as_options(reason)}")
    if rejected := [f"{name} {about['score']:.2f}" for name, about in row["functions"].items() if not about["member"]]:
        show(f"  not {', '.join(rejected)}")
    near = [  # those with the same functions, or all if unsure
        f"{near['name']} ({', '.join(near['functions']) or 'none'})"
        for near in row.get("nearest", [])
        if row["unsure"] or set(near["functions"]) == set(members)
    ]
    if near:
        show(f"  nearest training objects: {', '.join(near)}")


def print_quantities(row: Row, name: str):
    """Print which quantities decided about one function of one object."""
    from ..learning.profiles.words import table_cells

    table = [table_cells(decided) for decided in row["quantities"][name] if round(decided["share"], 2)]
    title = f"\n{row['shown']}: why {name} {row['functions'][name]['score']:.2f}"
    print_table(title, ["quantity", "spheres", "here", "median learnt", "change without it"], table)


def print_neighbors(row: Row, name: str):
    """Print which training objects decided one function of one object."""
    table = []
    for near in row["neighbors"][name]:
        start = [near["name"], format_length(near["radius"]), "yes" if near["member"] else "no"]
        table.append([*start, f"{near['distance']:.2f}", f"{near['weight']:.3f}"])
    title = f"\n{row['shown']}: why {name} {row['functions'][name]['score']:.2f}, by nearest training objects"
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
