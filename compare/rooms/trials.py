"""Virtual rooms through segmentation and recognition, from whole scans to single noisy views (paper, §IV-C)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.validation import THRESHOLD
from spherefunc_bullet.scenes.recognition.completion import DEFAULT
from spherefunc_bullet.scenes.recognition.recognition import recognise, recognise_objects
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.segmentation.segmentation import Segmentation
from spherefunc_bullet.scenes.virtual_rooms.furnishing import VirtualRoom, furnish
from spherefunc_bullet.scenes.virtual_rooms.scans import VirtualScan, scan_room
from spherefunc_bullet.settling.records import simulate_objects

from .scores import Counts, function_counts, matched, segmentation_counts


@dataclass(frozen=True, kw_only=True)
class Condition:
    """What a room is scanned with."""

    views: int | None  # None: whole surfaces
    noise: float  # times a Kinect's

    def __str__(self) -> str:
        return "whole" if self.views is None else f"{self.views} view{'s' if self.views > 1 else ''}"


@dataclass(frozen=True, kw_only=True)
class RoomTrial:
    """Which rooms are made, how they are scanned, and how the scans are taken apart."""

    rooms: int = 12
    conditions: tuple[Condition, ...] = ()
    seed: int = 0
    settings: Segmentation = field(default_factory=Segmentation)
    completion: tuple[str, ...] = DEFAULT
    cut_out: bool = False  # whether to tell the functions of objects cut out by the truth as well


@dataclass
class Tally:
    """The counts of one condition, summed over rooms."""

    functions: tuple[str, ...]
    rooms: int = 0
    objects: int = 0  # of which the scans show enough
    hidden: int = 0  # of which they do not
    points: int = 0
    segmentation: Counts = Counts()
    labelled: dict[str, Counts] = field(default_factory=dict)  # from scan to function
    cut_out: dict[str, Counts] = field(default_factory=dict)  # given the true segmentation
    whole: dict[str, Counts] = field(default_factory=dict)  # the same objects as whole models, by the same classifier
    stages: dict[str, float] = field(default_factory=dict)  # seconds

    def add(self, name: str, counts: dict[str, Counts]):
        """Add a room's counts of each function to ``labelled``, ``cut_out`` or ``whole``."""
        before = getattr(self, name)
        for function, each in counts.items():
            before[function] = before.get(function, Counts()) + each

    def __iadd__(self, other: Tally) -> Tally:
        self.rooms += other.rooms
        self.objects += other.objects
        self.hidden += other.hidden
        self.points += other.points
        self.segmentation += other.segmentation
        for name in ("labelled", "cut_out", "whole"):
            self.add(name, getattr(other, name))
        for name, seconds in other.stages.items():
            self.stages[name] = self.stages.get(name, 0.0) + seconds
        return self

    def row(self) -> dict:
        """Return the figures for a report."""
        kinds = {"f_measure": self.labelled, "f_measure_cut_out": self.cut_out, "f_measure_whole": self.whole}
        functions = {
            name: self.labelled[name].row()
            | {kind: rounded(counts.get(name, Counts()).f_measure) for kind, counts in kinds.items()}
            for name in self.functions
        }
        return {
            "rooms": self.rooms,
            "objects": self.objects,
            "hidden": self.hidden,
            "points": self.points,
            "segmentation": self.segmentation.row(),
            "functions": functions,
            "seconds": {name: round(seconds / self.rooms, 3) for name, seconds in self.stages.items()},
        }


def rounded(value: float | None) -> float | None:
    """Return a figure as reports have it."""
    return None if value is None else round(value, 4)


@dataclass(frozen=True, kw_only=True, eq=False)
class Fold:
    """Objects to furnish rooms with, and a model that has not learnt them."""

    dataset: Dataset
    model: FunctionClassifier
    jobs: int = 1
    told: dict[Path, frozenset[str]] = field(default_factory=dict)

    def of_models(self, items: Iterable[DatasetObject]):
        """Keep in ``told`` what the model says of the whole models of objects; each is asked for once."""
        paths = sorted({item.path for item in items} - self.told.keys())
        done = simulate_objects(
            paths, self.model.simulator, self.model.chosen_radii(), seed=self.model.seed, jobs=self.jobs
        )
        for index, record in done:
            scores = self.model.score_settled([record.settled])[0]
            self.told[paths[index]] = frozenset(
                name for name, score in zip(self.model.functions_, scores, strict=True) if score > THRESHOLD
            )


def run_trial(
    folds: Sequence[Fold],
    trial: RoomTrial,
    failed: Callable[[InputError], None],
    shown: Callable = lambda rooms: rooms,
    jobs: int = 1,
) -> dict[Condition, Tally]:
    """Return the counts of each condition, over all rooms of all folds.

    Parameters
    ----------
    failed : callable
        Is given the error of each file that cannot be used; the rest goes on.
    shown : callable
        Passes an iterator of rooms on, and may show how far it is.
    jobs : int
        Processes that work at once, on a room each; -1: one per core.
    """
    from joblib import Parallel, delayed

    rooms = list(furnished(folds, trial, failed))
    for fold in folds:
        fold.of_models(each.item for room, own in rooms if own is fold for each in room.objects)
    tasks = (delayed(tallies_of)(room, fold, trial) for room, fold in rooms)
    found = {condition: Tally(folds[0].model.functions_) for condition in trial.conditions}
    for tallies in shown(Parallel(n_jobs=jobs, return_as="generator")(tasks)):
        for condition, tally in tallies.items():
            found[condition] += tally
    return found


def tallies_of(room: VirtualRoom, fold: Fold, trial: RoomTrial) -> dict[Condition, Tally]:
    """Return what comes of one room under each condition."""
    found = {}
    for condition in trial.conditions:
        found[condition] = Tally(fold.model.functions_)
        count_scan(found[condition], scan_room(room, condition.views, condition.noise, trial.seed), fold, trial)
    return found


def furnished(folds: Sequence[Fold], trial: RoomTrial, failed) -> Iterator[tuple[VirtualRoom, Fold]]:
    """Yield the rooms of all folds, each with its fold."""
    for fold, count in zip(folds, shares(trial.rooms, len(folds)), strict=True):
        for room in furnish(fold.dataset, count, seed=trial.seed, failed=failed):
            yield room, fold


def shares(total: int, parts: int) -> list[int]:
    """Return how many of a total fall to each part.

    Examples
    --------
    >>> shares(5, 2)
    [3, 2]
    """
    return [total // parts + (part < total % parts) for part in range(parts)]


def count_scan(tally: Tally, scan: VirtualScan, fold: Fold, trial: RoomTrial):
    """Take a scan apart and add what came of it."""
    seen = scan.seen().tolist()
    items = {number: scan.room.objects[number].item for number in seen}
    labels = {number: item.functions for number, item in items.items()}
    room = recognise(
        Scan(name=scan.room.name, points=scan.points), fold.model, settings=trial.settings, completion=trial.completion
    )
    answer = matched(scan.labels, room.labels, seen)
    given = {each.id: members(each.functions) for each in room.objects}
    tally.rooms += 1
    tally.objects += len(seen)
    tally.hidden += len(scan.room.objects) - len(seen)
    tally.points += len(scan.points)
    tally.segmentation += segmentation_counts(answer, seen)
    tally.add("labelled", counted(tally.functions, answer, given, labels))
    itself = {number: number for number in seen}
    if trial.cut_out:
        tally.add("cut_out", counted(tally.functions, itself, functions_cut_out(scan, fold, trial), labels))
    as_models = {number: fold.told[item.path] for number, item in items.items()}
    tally.add("whole", counted(tally.functions, itself, as_models, labels))
    for name, seconds in room.stages.items():
        tally.stages[name] = tally.stages.get(name, 0.0) + seconds


def functions_cut_out(scan: VirtualScan, fold: Fold, trial: RoomTrial) -> dict[int, frozenset[str]]:
    """Return the functions that each seen object is given when the truth cuts it out of the scan."""
    seen = scan.seen()
    place = np.full(len(scan.room.objects) + 1, -1)  # the last one is that of labels below 0
    place[seen] = np.arange(len(seen))
    labels = place[np.maximum(scan.labels, -1)]
    found = recognise_objects(scan.points, labels, fold.model, completion=trial.completion)
    return {int(seen[each.id]): members(each.functions) for each in found}


def members(functions: dict[str, dict]) -> frozenset[str]:
    """Return the functions that an object was given."""
    return frozenset(name for name, each in functions.items() if each["member"])


def counted(functions: Iterable[str], answer, given, labels) -> dict[str, Counts]:
    """Return the counts of each function."""
    return {name: function_counts(answer, given, labels, name) for name in functions}


def halves(dataset: Dataset, seed: int) -> tuple[Dataset, Dataset]:
    """Return two halves of a data set with as many objects of each label in one as in the other."""
    rng = np.random.default_rng(seed)
    by_label: dict[frozenset, list[DatasetObject]] = {}
    for item in dataset.objects:
        by_label.setdefault(item.functions, []).append(item)
    parts: tuple[list, list] = ([], [])
    for label in sorted(by_label, key=sorted):
        order = rng.permutation(len(by_label[label]))
        for place, index in enumerate(order):
            parts[place % 2].append(by_label[label][index])
    return tuple(Dataset(f"{dataset.name}-{name}", tuple(part)) for name, part in zip("ab", parts, strict=True))
