"""``spherefunc classify``: say what objects are for."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator, Sequence
from itertools import chain, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..console import Failures, error_line, print_json, progress, say
from ..errors import InputError
from .answer_tables import Row, members_of, print_functions
from .options import BY_FILE, Json, Model, PackagePath, Units, Up

if TYPE_CHECKING:
    from ..classification import Asked
    from ..settling.records import Loading

STDIN = Path("-")  # in place of a file: their names, one a line, come on stdin


def classify(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="Models or scans, folders of them, or - for names on stdin.")
    ],
    model: Model = None,
    backend: Annotated[
        str | None, typer.Option(help="Simulator of the model; of several (fast,bullet) the others confirm the first.")
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
    from ..formats.writing import require_place
    from ..learning.model_file import models_to_ask
    from ..processes.tasks import run_tasks
    from ..settling.records import Loading
    from ..simulator import isolated, make_simulator

    if table is not None:
        require_place(table)
    asked = models_to_ask(model, backend, function)
    functions = asked[0][0].functions_
    names, failures = list(listed_files(files)), Failures()
    if any_pose:
        from .poses import classify_any_pose

        if len(asked) > 1:
            raise InputError(f"--backend {backend}: expected one with --any-pose")
        return classify_any_pose(names, asked[0][0], units, json)
    how = (asked, Loading(up=up, units=units), json or explain, explain)
    isolate = any(isolated(make_simulator(one.simulator)) for one, _ in asked)
    outcomes = run_tasks(classified_file, [(file, *how) for file in names], names, jobs=jobs, isolate=isolate)
    rows: list[Row | None] = [None] * len(names)
    for index, outcome in progress(outcomes, len(names), "classifying"):
        rows[index] = outcome
        if isinstance(outcome, InputError):
            failures.add(outcome)
            rows[index] = {"file": str(names[index]), "error": error_line(outcome)}
    if table is not None:
        write_rows(rows, functions, table)
    print_json(rows) if json else print_functions(rows, functions, explain)
    failures.exit()


def listed_files(places: Sequence[Path]) -> Iterator[Path]:
    """Yield the files, those below folders that can be read by their ending, and those named on stdin.

    Raises
    ------
    InputError
        If a folder holds none.
    """
    from ..datasets.dataset import SUFFIXES

    for place in places:
        if place == STDIN:
            yield from listed_files([Path(line) for line in sys.stdin.read().splitlines() if line.strip()])
        elif os.path.isdir(place):
            files = [path for path in sorted(place.rglob("*")) if path.suffix.lower() in SUFFIXES and path.is_file()]
            if not files:
                kinds = ", ".join(sorted(SUFFIXES))
                raise InputError(f"{place}: expected a folder with models or scans ({kinds}), found none")
            yield from files
        else:
            yield place


def classified_file(
    file: Path,
    asked: Sequence[Asked],
    loading: Loading,
    reasons: bool = True,
    explain: bool = True,
) -> Row:
    """Return what the contract prints of one file, reasons and what decided where that is wanted; for a worker."""
    from ..classification import classify_by_all
    from ..settling.kept_object import KeptFile

    started = time.perf_counter()
    reports = chain([say], repeat(None))  # what is odd about the file is said once
    decision = classify_by_all(lambda model: KeptFile(file, model.dropping(loading), next(reports)), asked)
    row = decision.row(str(file), round(time.perf_counter() - started, 3), reasons)
    if not explain:
        return row
    from ..answer import evidence

    return row | evidence(decision)


def write_rows(rows: Sequence[Row], functions: Sequence[str], path: Path):
    """Write a CSV with a row for each file: its functions, each score, and what went wrong where nothing else could."""
    from ..datasets.dataset import label_text
    from ..formats.writing import write_csv

    columns = ("file", "functions", *functions, "unsure", "error")
    table = []
    for row in rows:
        memberships = row.get("functions", {})
        scores = [memberships[name]["score"] if name in memberships else "" for name in functions]
        label = label_text(members_of(row)) if memberships else ""
        table.append([row["file"], label, *scores, row.get("unsure", ""), row.get("error", "")])
    write_csv(path, columns, table)
