"""The paper's protocol (§IV-B): the labels of the objects, which of them train, and which are tested."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.datasets.dataset import Dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.labels import memberships
from spherefunc_bullet.settling.records import ObjectRecord

from . import TRAIN_SIZES

FAIR = "F fair: objects whose column `also` names the function do not count"
PAPER = {"cup": 0.80, "sittable": 0.74, "table": 0.85}  # F-measures on its authors' own 200 models


@dataclass(frozen=True)
class Labels:
    """The true functions and the sources of objects."""

    functions: tuple[str, ...]
    members: np.ndarray  # (N, F) bool, the primary functions
    also: np.ndarray  # (N, F) bool, true as well, so not counted in the fair score
    groups: np.ndarray  # (N,) str, the sources

    def __len__(self) -> int:
        return len(self.members)

    def of(self, rows: np.ndarray) -> Labels:
        """Return the labels of some objects; a row may occur more than once."""
        return Labels(self.functions, self.members[rows], self.also[rows], self.groups[rows])

    def of_function(self, column: int) -> Labels:
        """Return the labels with one function alone."""
        only = [column]
        return Labels((self.functions[column],), self.members[:, only], self.also[:, only], self.groups)


def labels_of(simulated: Simulated | Dataset) -> Labels:
    """Return the labels of a data set's objects.

    Raises
    ------
    InputError
        If all objects have the same label, so that there is nothing to distinguish.
    """
    objects = simulated.objects
    functions = tuple(sorted(set().union(*(item.functions for item in objects))))
    members = memberships([item.functions for item in objects], functions)
    if not functions or len(np.unique(members, axis=0)) < 2:
        raise InputError(f"{simulated.name}: expected objects of at least two labels, got one only")
    also = memberships([item.also - item.functions for item in objects], functions)
    return Labels(functions, members, also, np.array([item.group for item in objects]))


def repeated_objects(learnt: Simulated, tested: Simulated) -> str:
    """Return a warning about objects to test that have the geometry of others to learn; empty if there are none."""
    first = {drops_key(record): record for record in reversed(learnt.records)}
    pairs = [(first.get(drops_key(record), record), record) for record in tested.records]
    same = [pair for pair in pairs if pair[0] is not pair[1] and np.array_equal(*(one.voxels for one in pair))]
    if not same:
        return ""
    advice = "keep one of each, or test by --groups with both in one" if learnt is tested else "leave them out of one"
    return (
        f"{tested.name}: {len(same)} of {len(tested.records)} objects have the geometry of others, such as "
        f"{' and '.join(str(one.path) for one in same[0])}; where one is learnt and one tested, scores are too high: "
        f"{advice}"
    )


def drops_key(record: ObjectRecord) -> tuple[bytes, ...]:
    """Return a key for the drops on an object; objects of the same geometry have the same."""
    return record.size.tobytes(), *(drops.rows().tobytes() for drops in record.settled.values())


@dataclass(frozen=True)
class Split:
    """One trial: rows that train, rows that are tested."""

    train: np.ndarray
    test: np.ndarray

    def testing(self, rows: np.ndarray) -> Split:
        """Return a split that tests only those of its objects that are among some rows."""
        return Split(self.train, self.test[np.isin(self.test, rows)])


@dataclass(frozen=True, kw_only=True)
class Protocol:
    """How a data set is split: random halves at each training size, and objects or sources left out in turn."""

    train_sizes: tuple[int, ...] = ()  # objects, ascending
    trials: int = 10
    seed: int = 0
    leave_one_out: bool = False
    groups: bool = False

    def splits(self, labels: Labels) -> Splits:
        """Return the splits, the same for every feature.

        Raises
        ------
        InputError
            If a training set is larger than half of the objects, or there are no two groups to leave out.
        """
        count, left_out = len(labels), {}
        if self.leave_one_out:
            left_out["leave_one_out"] = leave_one_out(count, self.seed)
        if self.groups:
            left_out["leave_one_group_out"] = leave_one_group_out(labels.groups)
        halves = {size: random_splits(count, size, self.trials, self.seed) for size in self.train_sizes}
        return Splits(halves=halves, left_out=left_out)


@dataclass(frozen=True, kw_only=True)
class Splits:
    """The splits of a protocol."""

    halves: Mapping[int, Sequence[Split]]  # training size in objects -> the trials
    left_out: Mapping[str, Sequence[Split]] = field(default_factory=dict)  # name -> splits that test every object once


def random_splits(count: int, train_size: int, trials: int, seed: int) -> list[Split]:
    """Return the paper's trials: the first ``train_size`` of a random half train, the other half is tested.

    The same seed gives the same halves whatever the training size, so that sizes can be compared.

    Raises
    ------
    InputError
        If the half is smaller than the training set.
    """
    half = count // 2
    if not 0 < train_size <= half:
        raise InputError(f"training size {train_size}: expected at most {half}, half of the {count} objects")
    orders = [np.random.default_rng([seed, trial]).permutation(count) for trial in range(trials)]
    return [Split(order[:train_size], order[half:]) for order in orders]


def leave_one_out(count: int, seed: int) -> list[Split]:
    """Return splits that leave out one object each, in random order; `evaluation.pooled_trial` groups them in folds."""
    order = np.random.default_rng([seed, count]).permutation(count)
    return [Split(np.delete(np.arange(count), i), np.array([i])) for i in order]


def leave_one_group_out(groups: np.ndarray) -> list[Split]:
    """Return splits that leave out all objects of one source each.

    Raises
    ------
    InputError
        If there are not at least two sources.
    """
    names = sorted(set(groups.tolist()))
    if len(names) < 2:
        raise InputError("--groups: expected a manifest with a column group that names at least two sources")
    return [Split(np.flatnonzero(groups != name), np.flatnonzero(groups == name)) for name in names]


def sources_or_halves(groups: np.ndarray, trials: int, seed: int) -> list[Split]:
    """Return splits that leave out one source each, or this many random halves where there are fewer than two."""
    if len(set(groups.tolist())) > 1:
        return leave_one_group_out(groups)
    return random_splits(len(groups), len(groups) // 2, trials, seed)


FEWEST = 4  # objects: two to learn from, two to test on


def parse_sizes(text: str, count: int) -> list[int]:
    """Return the training sizes of a list such as ``20,45,half``, ascending, whether they fit or not.

    Raises
    ------
    InputError
        If a size is no number.
    """
    try:
        return sorted({count // 2 if part.strip() == "half" else int(part) for part in text.split(",")})
    except ValueError:
        raise InputError(f"--train-sizes {text}: expected numbers and half, such as {TRAIN_SIZES}") from None


def wanted_sizes(text: str, count: int) -> list[int]:
    """Return the training sizes; those of the default list that are too large for the data are left out.

    Raises
    ------
    InputError
        If a size is no number, or one that was asked for is larger than half of the objects.
    """
    half, sizes = count // 2, parse_sizes(text, count)
    if half < 2:
        raise InputError(f"expected at least 4 objects, half of which are learnt, got {count}")
    if text == TRAIN_SIZES:
        sizes = [size for size in sizes if size <= half]
    if not sizes or sizes[0] < 2 or sizes[-1] > half:
        raise InputError(f"--train-sizes {text}: expected from 2 to {half}, half of the {count} objects")
    return sizes


def fitting_sizes(text: str, count: int) -> tuple[tuple[int, ...], list[int]]:
    """Return the training sizes, half of the objects in place of each that is larger, and those that are.

    Raises
    ------
    InputError
        If a size is no number, or less than two.
    """
    half, requested = count // 2, parse_sizes(text, count)
    if requested[0] < 2:
        raise InputError(f"--train-sizes {text}: expected numbers from 2, got {requested[0]}")
    return tuple(sorted({min(size, half) for size in requested})), [size for size in requested if size > half]


def require_enough(name: str, count: int, which: str = ""):
    """Raise InputError if so few objects cannot be split."""
    if count < FEWEST:
        halves = "half to learn and half to test"
        raise InputError(f"{name}: expected at least {FEWEST} objects{which}, {halves}, got {count}")
