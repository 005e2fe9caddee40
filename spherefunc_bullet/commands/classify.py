"""``spherefunc classify``: say what objects are for."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..console import Failures, error_line, print_json, progress, say
from ..errors import InputError
from .answer_tables import Row, members_of, print_functions
from .options import BY_FILE, Json, Model, PackagePath, Units, Up

if TYPE_CHECKING:
    from ..function_model import FunctionModel
    from ..settling.records import Loading

STDIN = Path("-")  # in place of a file: their names, one a line, come on stdin


def classify(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="Models or scans, folders of them, or - for names on stdin.")
    ],
    model: Model = None,
    backend: Annotated[str | None, typer.Option(help="The simulator the model must have been trained with.")] = None,
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
    from ..learning.model_file import inference_model, model_for_views
    from ..processes.tasks import run_tasks
    from ..settling.records import Loading
    from ..simulator import isolated, make_simulator

    if table is not None:
        require_place(table)
    classifier = inference_model(model, backend)
    classifier = classifier if function is None else classifier.only(function)
    names, failures = list(listed_files(files)), Failures()
    if any_pose:
        from .poses import classify_any_pose

        return classify_any_pose(names, classifier, units, json)
    view_model = partial(model_for_views, classifier, given=model is not None)
    how = (classifier, Loading(up=up, units=units), view_model, json or explain, explain)
    isolate = isolated(make_simulator(classifier.simulator))
    outcomes = run_tasks(classified_file, [(file, *how) for file in names], names, jobs=jobs, isolate=isolate)
    rows: list[Row | None] = [None] * len(names)
    for index, outcome in progress(outcomes, len(names), "classifying"):
        rows[index] = outcome
        if isinstance(outcome, InputError):
            failures.add(outcome)
            rows[index] = {"file": str(names[index]), "error": error_line(outcome)}
    if table is not None:
        write_rows(rows, classifier.functions_, table)
    print_json(rows) if json else print_functions(rows, classifier.functions_, explain)
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
    model: FunctionModel,
    loading: Loading,
    view_model: Callable[[], FunctionModel],
    reasons: bool = True,
    explain: bool = True,
) -> Row:
    """Return what the contract prints of one file, reasons and what decided where that is wanted; for a worker."""
    from ..classification import classify as decision_about
    from ..settling.kept_object import KeptFile

    started = time.perf_counter()
    decision = decision_about(KeptFile(file, model.dropping(loading), report=say), model, view_model)
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
