"""Sensitivity of scan recognition to each hand-set number: halved and doubled.

    python -m spherefunc_bullet.compare.rooms.sensitivity DATA [--stages pool] [--rooms 4] [--jobs 2] [--list] [--json]
    python -m spherefunc_bullet.compare.rooms.sensitivity SCANS --scans [--stages pool] [--jobs 2] [--json]

In virtual rooms of models that were not learnt, or in real scans. Numbers are those of `scenes.settings`, without the
few pairs and rows of numbers there. A number that changes no answer, neither in rooms nor in scans, may go.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Annotated

import joblib
import numpy as np
import typer
from joblib import Parallel, delayed

from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, progress, run, show
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import require_known
from spherefunc_bullet.function_model import FunctionModel
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.scenes import settings
from spherefunc_bullet.scenes.recognition.partial_places import room_places
from spherefunc_bullet.scenes.recognition.recognition import recognise
from spherefunc_bullet.scenes.recognition.room import Room
from spherefunc_bullet.scenes.scans.scan import Scan, load_scan
from spherefunc_bullet.scenes.virtual_rooms.lived_in import furnish_lived_in, parse_lived_in
from spherefunc_bullet.scenes.virtual_rooms.scans import VirtualScan, scan_room

from .matching import MatchCounts, counts_by_function, match_objects, score_of
from .real_scans import scan_files
from .truth import recognised_in, true_objects

VIEWS = (3, 1, 5, 2)  # of the rooms, in turn
FACTORS = (0.5, 2.0)
CHANGED, MOST = 3, 0.9  # answers, and share of the functions found as usual, of variations that count for the spread
DIGITS = 2  # of a place in metres: nearer places are the same answer

Answers = tuple[MatchCounts, list[str]]  # the counts of functions in all rooms, and each room's answer for comparison


@dataclass(frozen=True, kw_only=True)
class SettingField:
    """A field of a stage's settings."""

    stage: str  # of `STAGES`
    name: str

    @property
    def title(self) -> str:
        """Its full name, such as ``pool.slab``."""
        return f"{self.stage}.{self.name}"

    @property
    def value(self) -> int | float:
        """Its value."""
        return getattr(settings.STAGES[self.stage], self.name)

    @contextmanager
    def times(self, factor: float) -> Iterator[None]:
        """Multiply the number while the context lasts."""
        # By the module, which other processes import: its settings alone are copied to them.
        stage, value = settings.STAGES[self.stage], self.value
        object.__setattr__(stage, self.name, type(value)(value * factor))
        try:
            yield
        finally:
            object.__setattr__(stage, self.name, value)


def numbers_of(stage: str) -> list[SettingField]:
    """Return the numbers of a stage, without pairs and rows of numbers."""
    single = [field for field in fields(settings.STAGES[stage]) if not isinstance(field.default, tuple)]
    return [SettingField(stage=stage, name=field.name) for field in single]


def answer_of(room: Room, places: object = ()) -> str:
    """Return what is answered about a room, for comparison: each point's functions, and places."""
    given = {item.id: item.members for item in room.objects}
    of_points = np.array(["+".join(sorted(given.get(k, ()))) for k in range(-3, len(room.objects))])
    return f"{joblib.hash(of_points[room.labels + 3])} {places}"


def answers_in_rooms(scanned: Sequence[VirtualScan], model: FunctionModel) -> Answers:
    """Return the answers in virtual rooms."""
    total, found = MatchCounts(), []
    for scan in scanned:
        room = recognise(Scan(name=scan.room.name, points=scan.points), model)
        total = sum(counts_by_function(room, scan.labels, scan.functions(), model.functions_).values(), total)
        found.append(answer_of(room))
    return total, found


def answers_in_scans(paths: Sequence[Path], model: FunctionModel) -> Answers:
    """Return the answers in real scans, with what is unsure or inferred, and with places to sit, put and pour."""
    total, found = MatchCounts(), []
    for path in paths:
        scan = load_scan(path)
        room, truth = recognise(scan, model), true_objects(path)
        if truth is not None:
            score = score_of(match_objects(truth, recognised_in(scan, room)))
            total += MatchCounts(score["found"], score["false"], score["missed"])
        places = [
            (place.function, np.round(place.position, DIGITS).tolist())
            for some in room_places(scan, room).values()
            for place in some
        ]
        doubts = [(item.id, room.unsure_functions(item)) for item in room.objects]
        inferred = [np.round(one.box.center, DIGITS).tolist() for one in room.inferred]
        found.append(answer_of(room, (places, doubts, inferred)))
    return total, found


def row_of(number: SettingField, answers: Callable[[], Answers], before: Sequence[str]) -> list[str]:
    """Return a row: the number, and the results with it halved and doubled."""
    row = [number.title, f"{number.value:g}"]
    for factor in FACTORS:
        with number.times(factor):
            try:
                counts, after = answers()
            except Exception as error:  # recognition fails with this setting, which is a result too
                row += ["-", "-", type(error).__name__]
                continue
        changed = sum(one != other for one, other in zip(after, before, strict=True))
        row += [str(counts.hits), str(counts.false_alarms), str(changed)]
    return row


def spread_of(rows: Sequence[Sequence[str]], before: MatchCounts) -> str:
    """Return in one line the mean counts over the variations that change some answers and still find most objects."""
    some = [row[at : at + 3] for row in rows for at in (2, 5)]
    counts = np.array([list(map(int, one)) for one in some if one[0] != "-"], int).reshape(-1, 3)
    counts = counts[(counts[:, 2] >= CHANGED) & (counts[:, 0] >= MOST * before.hits)]
    if len(counts) < 2:
        return "too few variations change some answers for a mean"
    means, deviations = counts.mean(axis=0), counts.std(axis=0, ddof=1)
    found, false = (f"{means[k]:.1f} ± {deviations[k]:.1f}" for k in (0, 1))
    return f"{len(counts)} variations change some answers: {found} found, {false} false"


def print_list():
    """Print the name, value, unit and meaning of every number."""
    for stage, settings_of_stage in settings.STAGES.items():
        show(f"{stage}: {type(settings_of_stage).__doc__}")
        for field in fields(settings_of_stage):
            value = field.default if isinstance(field.default, tuple) else f"{field.default:g}"
            words = " ".join(filter(None, [f"{field.name} = {value}", field.metadata["unit"]]))
            show(f"    {words}: {field.metadata['meaning']}")
    single = sum(len(numbers_of(stage)) for stage in settings.STAGES)
    rows = sum(len(fields(settings_of_stage)) for settings_of_stage in settings.STAGES.values()) - single
    show(f"{single} hand-set numbers, and {rows} pairs and rows of numbers")


def main(
    data: Annotated[str, typer.Argument(help="Models that furnish rooms, not learnt by the model for scans.")],
    stages: Annotated[str, typer.Option(help="Names of settings, separated by commas.")] = ",".join(settings.STAGES),
    rooms: Annotated[int | None, typer.Option(min=1, help="How many. Default: 4.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Random seed of the rooms. Default: 0.")] = None,
    scans: Annotated[bool, typer.Option("--scans", help="DATA is a folder of labelled scans.")] = False,
    listed: Annotated[bool, typer.Option("--list", help="Only list all settings.")] = False,
    jobs: options.Jobs = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON on stdout.")] = False,
):
    """Measure and print."""
    if listed:
        print_list()
        return
    options.require_beside("--scans", scans, {"--rooms": rooms, "--seed": seed}, {})
    chosen, failures = stages.split(","), Failures()
    require_known("--stages", chosen, settings.STAGES)
    numbers = [number for stage in chosen for number in numbers_of(stage)]
    model = load_model(shipped_model("fast", scans=True))
    if scans:
        answers = partial(answers_in_scans, scan_files(Path(data), ""), model)
    else:
        how = {"seed": seed or 0, "failed": failures.add, "lived_in": parse_lived_in("all=0.5")}
        furnished = furnish_lived_in(open_dataset(data), rooms or 4, **how)
        scanned = [scan_room(room, VIEWS[k % len(VIEWS)], 1.0, seed or 0) for k, room in enumerate(furnished)]
        answers = partial(answers_in_rooms, scanned, model)
    counts, before = answers()
    tasks = (delayed(row_of)(number, answers, before) for number in numbers)
    found = Parallel(n_jobs=jobs, return_as="generator")(tasks)
    rows = list(progress(found, len(numbers), "changing numbers"))
    columns = ["number", "value", *(f"{what}, x{by:g}" for by in FACTORS for what in ("found", "false", "changed"))]
    if as_json:
        print_json([dict(zip(columns, row, strict=True)) for row in rows])
    else:
        still = sum(row[4] == row[7] == "0" for row in rows)
        title = f"{len(before)} {'scans' if scans else 'rooms'}: {counts.hits} found, {counts.false_alarms} false"
        print_table(f"{title}; {still} of {len(rows)} change nothing", columns, rows)
        show(spread_of(rows, counts))
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
