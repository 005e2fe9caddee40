"""``spherefunc classify``: say what objects are for."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..console import Failures, error_line, print_json, progress, say
from ..errors import InputError
from .answer_tables import Row, members_of, print_functions
from .options import BY_FILE, Json, PackagePath, Units, Up

if TYPE_CHECKING:
    from ..learning.cube_classifier import CubeClassifier
    from ..learning.function_model import FunctionModel
    from ..learning.profiles.profile_model import ProfileModel
    from ..settling.records import Dropping
    from ..settling.settling import Settled

CUBES = 3  # that speak for a function, and as many that speak against it
STDIN = Path("-")  # in place of a file: their names, one a line, come on stdin


@dataclass(frozen=True, kw_only=True)
class Settling:
    """What became of the drops on one file's object, and what else decides about it."""

    settled: Settled
    one_view: bool  # whether it looks like one, asked where it is for nothing
    falls_over: bool  # when it is put down, asked where it is for something
    seconds: float
    on_top: int = 0  # objects that stand on it, asked of tables


def classify(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="Models or scans, folders of them, or - for names on stdin.")
    ],
    model: Annotated[Path | None, typer.Option(help="A model file; without one, the model that ships.")] = None,
    backend: Annotated[str | None, typer.Option(help="The backend that the model must be for.")] = None,
    function: Annotated[
        str | None, typer.Option(help="Ask for this one alone; by cubes, at its own radius alone.")
    ] = None,
    explain: Annotated[bool, typer.Option(help="Say why: in words, by what decided, by training objects.")] = False,
    table: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Write a row for each file, failed ones too.")
    ] = None,
    jobs: Annotated[int, typer.Option(help="Processes that work at once; -1: one per core.")] = 1,
    any_pose: Annotated[bool, typer.Option(help="However it lies: in the best pose for each function.")] = False,
    up: Up = BY_FILE,
    units: Units = "m",
    package_path: PackagePath = None,
    json: Json = False,
):
    """Say what each object is for."""
    from ..formats.writing import require_place
    from ..learning.model_file import model_to_ask
    from ..learning.reasons.answer import model_of_views
    from ..processes.tasks import run_tasks
    from ..simulator import isolated, make_simulator

    if table is not None:
        require_place(table)
    classifier = model_to_ask(model, backend)
    classifier = classifier if function is None else classifier.only(function)
    of_views = model_of_views(classifier, model, function)
    names, failures = list(listed_files(files)), Failures()
    if any_pose:
        from .any_pose import classify_any_pose

        return classify_any_pose(names, classifier, units, json)
    tasks = [(file, dropping_of(classifier, up, units), classifier) for file in names]
    outcomes = run_tasks(settled_file, tasks, names, jobs=jobs, isolate=isolated(make_simulator(classifier.simulator)))
    rows: list[Row | None] = [None] * len(names)
    for index, outcome in progress(outcomes, len(names), "classifying"):
        if isinstance(outcome, InputError):
            failures.add(outcome)
            rows[index] = {"file": str(names[index]), "error": error_line(outcome)}
        else:
            row = scored(names[index], outcome, classifier, explain)
            rows[index] = told_as_view(row, outcome, tasks[index][1], of_views(), explain) if outcome.one_view else row
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


def classified(file: Path, classifier: FunctionModel, explain: bool, up: str, units: str) -> Row:
    """Return the scores of one file's object."""
    return scored(file, settled_file(file, dropping_of(classifier, up, units), classifier), classifier, explain)


def dropping_of(classifier: FunctionModel, up: str, units: str) -> Dropping:
    """Return how spheres are dropped on what a classifier is asked about."""
    from ..settling.records import Dropping, Loading

    return Dropping(
        simulator=classifier.simulator,
        radii=tuple(classifier.chosen_radii()),
        seed=classifier.seed,
        loading=Loading(up=up, units=units),
        length=classifier.length,
    )


def settled_file(file: Path, dropping: Dropping, classifier: FunctionModel) -> Settling:
    """Return what became of as many drops on one file's object as its answer needs, and what else decides about it."""
    from ..learning.reasons import laid
    from ..learning.reasons.one_view import looks_like_one_view
    from ..settling.records import KeptFile
    from ..simulator.statics.falling_over import falls_over

    started = time.perf_counter()
    kept = KeptFile(file, dropping, report=say)
    settled = classifier.settled_by(kept.runs)
    told = classifier.memberships_of([settled])[0]
    on_top, name = 0, f"on_top_{dropping.simulator.name}"
    if laid.TABLE in told and told[laid.TABLE].member:
        on_top = kept.counts(name, lambda cloud: laid.standing_on(cloud, settled))
    for_nothing = not any(membership.member for membership in told.values())
    return Settling(
        settled=settled,
        one_view=for_nothing and kept.tells("one_view", looks_like_one_view),
        falls_over=classifier.serves_nobody(told, lambda: kept.tells("falls_over", falls_over)),
        seconds=time.perf_counter() - started,
        on_top=on_top,
    )


def scored(file: Path, dropped: Settling, classifier: FunctionModel, explain: bool) -> Row:
    """Return the scores of one file's object, on which the spheres have fallen."""
    from ..learning.profiles.profile_model import ProfileModel
    from ..learning.reasons.answer import told_in_words
    from ..learning.reasons.laid import remark

    started, settled = time.perf_counter(), dropped.settled
    memberships, reasons, doubtful = told_in_words(classifier, settled, lambda: dropped.falls_over)
    row = {"file": str(file), "functions": {name: asdict(membership) for name, membership in memberships.items()}}
    row |= {"unsure": bool(doubtful), "reasons": [*reasons, *filter(None, [remark(dropped.on_top)]), *doubtful]}
    row["seconds"] = round(dropped.seconds + time.perf_counter() - started, 3)
    if explain:
        if isinstance(classifier, ProfileModel):
            row |= quantities_named(classifier.reader_of(settled), settled, decide=not dropped.falls_over)
        else:
            row |= cubes_named(classifier, settled)
    return row


def told_as_view(row: Row, dropped: Settling, dropping: Dropping, model: FunctionModel, explain: bool) -> Row:
    """Return the row of a file that is for nothing and looks like one view, or that of the object completed.

    Parameters
    ----------
    model : FunctionModel
        That for single views.
    """
    from ..learning.reasons.one_view import COMPLETED, NOTHING, nothing_settled, settled_on_completed

    file, lost = Path(row["file"]), nothing_settled(dropped.settled)
    completed = settled_on_completed(dropping.cloud(file), model)
    if completed is not None:
        whole = scored(file, replace(dropped, settled=completed, seconds=row["seconds"]), model, explain)
        if lost or any(told["member"] for told in whole["functions"].values()):
            return whole | {"unsure": True, "reasons": [*whole["reasons"], COMPLETED]}
    return row | {"unsure": True, "reasons": [*row["reasons"], NOTHING]} if lost else row


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


def quantities_named(classifier: ProfileModel, settled: Settled, decide: bool) -> Row:
    """Return the quantities that decided about each function, if any did, and the nearest training objects."""
    from ..learning.reasons.words import deciding, nearest

    decided = {name: deciding(classifier, settled, name) if decide else [] for name in classifier.functions_}
    return {"quantities": decided, "nearest": nearest(classifier, settled)}


def cubes_named(classifier: CubeClassifier, settled: Settled) -> Row:
    """Return the training objects and the cubes of space that decided about each function."""
    from ..learning.reasons.cubes import strongest_cubes

    return {
        "neighbors": {name: classifier.neighbors(settled, name) for name in classifier.functions_},
        "cubes": {name: strongest_cubes(classifier, settled, name, CUBES) for name in classifier.functions_},
    }
