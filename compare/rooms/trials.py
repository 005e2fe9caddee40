"""Virtual rooms through segmentation and recognition, from whole scans to single noisy views (paper, §IV-C)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np

from spherefunc_bullet.console import progress
from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.scenes.recognition.completion import DEFAULT
from spherefunc_bullet.scenes.recognition.proposals import KINDS
from spherefunc_bullet.scenes.recognition.recognition import recognise, recognise_objects
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.segmentation.segmentation import Segmentation
from spherefunc_bullet.scenes.virtual_rooms.furnishing import VirtualRoom
from spherefunc_bullet.scenes.virtual_rooms.lived_in import LivedIn, furnish_lived_in
from spherefunc_bullet.scenes.virtual_rooms.scans import AS_SEEN, Resolution, VirtualScan, scan_room
from spherefunc_bullet.settling.records import simulate_objects

from .matching import Functions, MatchCounts, Matches, Row, function_counts, match_parts, rounded, segmentation_counts

Failed = Callable[[InputError], None]
Summand = TypeVar("Summand")


@dataclass(frozen=True, kw_only=True)
class Condition:
    """How a room is scanned."""

    views: int | None  # None: whole surfaces
    noise: float  # as a multiple of a Kinect's

    def __str__(self) -> str:
        return "whole" if self.views is None else f"{self.views} view{'s' if self.views > 1 else ''}"


@dataclass(frozen=True, kw_only=True)
class RoomTrial:
    """How rooms are furnished and scanned, and how the scans are segmented and classified."""

    rooms: int = 12
    conditions: tuple[Condition, ...] = ()
    seed: int = 0
    settings: Segmentation = field(default_factory=Segmentation)
    completion: tuple[str, ...] = DEFAULT
    proposals: tuple[str, ...] = KINDS  # "clusters", "pools", or both
    cut_out: bool = False  # whether to classify objects cut out by the ground truth as well
    lived_in: LivedIn = field(default_factory=LivedIn)
    resolution: Resolution = AS_SEEN


@dataclass(frozen=True, kw_only=True)
class ConditionCounts:
    """The counts of one condition, which add up over rooms."""

    rooms: int = 0
    objects: int = 0  # objects that the scans show well enough
    hidden: int = 0  # all other objects
    points: int = 0
    segmentation: MatchCounts = MatchCounts()
    labelled: dict[str, MatchCounts] = field(default_factory=dict)  # by function, from scan to label
    sure: dict[str, MatchCounts] = field(default_factory=dict)  # the same of sure answers alone
    cut_out: dict[str, MatchCounts] = field(default_factory=dict)  # given the true segmentation
    whole: dict[str, MatchCounts] = field(default_factory=dict)  # the same objects as whole models
    stages: dict[str, float] = field(default_factory=dict)  # seconds

    def __add__(self, other: ConditionCounts) -> ConditionCounts:
        return ConditionCounts(**summed(vars(self), vars(other)))

    def row(self, condition: Condition) -> Row:
        """Return the figures for a report."""
        functions = {}
        for name, counts in self.labelled.items():
            cut_out, sure = self.cut_out.get(name, MatchCounts()), self.sure[name]
            functions[name] = counts.row() | {
                "f_measure_cut_out": rounded(cut_out.f_measure),
                "f_measure_whole": rounded(self.whole[name].f_measure),
                "true_sure_claims": sure.hits,
                "sure_claims": sure.hits + sure.false_alarms,
            }
        return {
            "views": str(condition),
            "noise": condition.noise,
            "rooms": self.rooms,
            "objects": self.objects,
            "hidden": self.hidden,
            "points": self.points,
            "segmentation": self.segmentation.row(),
            "functions": functions,
            "seconds": {name: round(seconds / self.rooms, 3) for name, seconds in self.stages.items()},
        }


def summed(one: Summand, other: Summand) -> Summand:
    """Return a sum; that of two dictionaries has the sums of the values that both have under a key.

    Examples
    --------
    >>> summed({"cup": 1, "table": 2}, {"table": 3})
    {'cup': 1, 'table': 5}
    """
    if isinstance(one, dict):
        return one | other | {name: summed(one[name], other[name]) for name in one if name in other}
    return one + other


@dataclass(frozen=True, kw_only=True, eq=False)
class Fold:
    """Objects to furnish rooms with, and a model that has not learnt them."""

    dataset: Dataset
    model: CloudClassifier
    of_models: dict[Path, frozenset[str]] = field(default_factory=dict)  # by whole model, its predicted functions

    def settle_whole_models(self, items: Iterable[DatasetObject], jobs: int):
        """Classify the whole models of objects that were not classified before, and keep the answers."""
        paths = sorted({item.path for item in items} - self.of_models.keys())
        for index, record in simulate_objects(paths, self.model.drop_config(), jobs=jobs):
            [functions] = self.model.memberships_of([record.settled])
            self.of_models[paths[index]] = frozenset(name for name, one in functions.items() if one.member)


def run_trial(folds: Sequence[Fold], trial: RoomTrial, failed: Failed, jobs: int) -> dict[Condition, ConditionCounts]:
    """Return the counts of each condition, over all rooms of all folds.

    Parameters
    ----------
    failed : callable
        Is called with the error of each file that cannot be used; all others are used.
    jobs : int
        Number of parallel processes, each with one room; -1: one per core.
    """
    from joblib import Parallel, delayed

    tasks, how = [], {"seed": trial.seed, "failed": failed, "lived_in": trial.lived_in}
    for fold, count in zip(folds, shares(trial.rooms, len(folds)), strict=True):
        rooms = list(furnish_lived_in(fold.dataset, count, **how))
        fold.settle_whole_models((placed.item for room in rooms for placed in room.objects), jobs)
        tasks += [delayed(room_counts)(room, fold, trial) for room in rooms]
    total = dict.fromkeys(trial.conditions, ConditionCounts())
    for counts in progress(Parallel(n_jobs=jobs, return_as="generator")(tasks), trial.rooms, "scanning rooms"):
        total = summed(total, counts)
    return total


def room_counts(room: VirtualRoom, fold: Fold, trial: RoomTrial) -> dict[Condition, ConditionCounts]:
    """Return the counts of one room under each condition."""
    counts = {}
    for condition in trial.conditions:
        scan = scan_room(room, condition.views, condition.noise, trial.seed, trial.resolution)
        counts[condition] = scan_counts(scan, fold, trial)
    return counts


def shares(total: int, parts: int) -> list[int]:
    """Return a total divided into parts as equal as possible.

    Examples
    --------
    >>> shares(5, 2)
    [3, 2]
    """
    return [total // parts + (part < total % parts) for part in range(parts)]


def scan_counts(scan: VirtualScan, fold: Fold, trial: RoomTrial) -> ConditionCounts:
    """Return the counts of one scan after segmentation and classification."""
    seen = scan.seen().tolist()
    items = {number: scan.room.objects[number].item for number in seen}
    labels = {number: item.functions for number, item in items.items()}
    how = {"settings": trial.settings, "completion": trial.completion, "proposals": trial.proposals}
    room = recognise(Scan(name=scan.room.name, points=scan.points), fold.model, **how)
    matches, itself = match_parts(scan.labels, room.labels, seen), {number: number for number in seen}

    def counts(matches: Matches, given: Functions) -> dict[str, MatchCounts]:
        return {name: function_counts(matches, given, labels, name) for name in fold.model.functions_}

    return ConditionCounts(
        rooms=1,
        objects=len(seen),
        hidden=len(scan.room.objects) - len(seen),
        points=len(scan.points),
        segmentation=segmentation_counts(matches, seen),
        labelled=counts(matches, {item.id: item.members for item in room.objects}),
        sure=counts(matches, {item.id: item.members.difference(room.unsure_functions(item)) for item in room.objects}),
        cut_out=counts(itself, functions_cut_out(scan, fold, trial)) if trial.cut_out else {},
        whole=counts(itself, {number: fold.of_models[item.path] for number, item in items.items()}),
        stages=room.stages,
    )


def functions_cut_out(scan: VirtualScan, fold: Fold, trial: RoomTrial) -> dict[int, frozenset[str]]:
    """Return the predicted functions of each seen object when the ground truth cuts it out of the scan."""
    seen = scan.seen()
    place = np.full(len(scan.room.objects) + 1, -1)  # the last one is that of labels below 0
    place[seen] = np.arange(len(seen))
    labels = place[np.maximum(scan.labels, -1)]
    recognised = recognise_objects(scan.points, labels, fold.model, completion=trial.completion)
    return {int(seen[item.id]): item.members for item in recognised}


def split_in_halves(dataset: Dataset, seed: int) -> tuple[Dataset, Dataset]:
    """Return two halves of a data set with as many objects of each label in one as in the other."""
    rng = np.random.default_rng(seed)
    by_label: dict[frozenset, list[DatasetObject]] = {}
    for item in dataset.objects:
        by_label.setdefault(item.functions, []).append(item)
    parts: tuple[list, list] = ([], [])
    for label in sorted(by_label, key=sorted):
        for place, index in enumerate(rng.permutation(len(by_label[label]))):
            parts[place % 2].append(by_label[label][index])
    return tuple(Dataset(f"{dataset.name}-{name}", tuple(part)) for name, part in zip("ab", parts, strict=True))
