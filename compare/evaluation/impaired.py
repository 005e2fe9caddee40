"""Does it still work? How impaired copies of objects are classified, where their sources were not learnt.

If everything that looks like a chair is one, a benchmark cannot distinguish function from appearance. Here are copies
that look right and do not work, and copies that look different and do work.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated, require_some, simulate_by_all
from spherefunc_bullet.console import print_table
from spherefunc_bullet.datasets.catalogue import built_once
from spherefunc_bullet.datasets.dataset import Dataset, label_text
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.files import cache_home
from spherefunc_bullet.learning.method import AnyMethod
from spherefunc_bullet.learning.profiles.calibration import COPY_WEIGHT, CopyGroups
from spherefunc_bullet.scenes.impairment.folder import CopyRow, evenly_chosen, function_of, impair_dataset, read_copies
from spherefunc_bullet.scenes.impairment.impairments import IMPAIRMENTS
from spherefunc_bullet.settling.cached_runs import DropConfig, LoadOptions

from .features import SPHERES
from .protocol import Labels, Split, labels_of, sources_or_halves
from .readings import FeatureMethod, ProfileFeatures, readings, spheres_read, trials_of

VERSION = 3  # of the copies; with another number they are made again
TRIALS = 4  # random halves, where there are no sources to leave out
# Endings of a feature's name: without the check whether objects fall over; trained on copies of other sources' objects
# as well; and that without the kind of copy that is tested.
HELD, COPIES_LEARNT, UNSEEN_KIND = ", held up", ", copies learnt", ", this kind left out"
USELESS, HARMLESS = "useless, mean", "harmless, mean"
Failed = Callable[[InputError], None]
KindShare = dict[str, Any]  # whether copies of a kind work, how many there are, and the share by feature set
Shares = dict[str, dict[str, KindShare]]  # by function, then kind


@dataclass(frozen=True, kw_only=True)
class ImpairedSet:
    """Whole objects first, their copies after them."""

    simulated: Simulated  # both
    labels: Labels  # of both; a copy's labels are those that it still has
    copies: Sequence[CopyRow]
    originals: np.ndarray  # (C,) the row of the whole object of which each is a copy

    @property
    def whole(self) -> int:
        """The number of whole objects."""
        return len(self.labels) - len(self.copies)

    @cached_property
    def made(self) -> list[tuple[str, str]]:
        """The function of each copy's original, and the copy's kind."""
        objects = self.simulated.objects
        return [(function_of(objects[row]), copy.kind) for row, copy in zip(self.originals, self.copies, strict=True)]

    def with_copies(self, split: Split, unseen: str | None = None) -> Split:
        """Return a split that also learns the copies of its training objects, except those of one kind."""
        rows = self.rows_of(split.train)
        learnt = [row for row in rows if self.copies[row - self.whole].kind != unseen]
        return Split(np.concatenate([split.train, np.array(learnt, int)]), split.test)

    def rows_of(self, originals: np.ndarray) -> np.ndarray:
        """Return the rows of the copies of some whole objects."""
        return self.whole + np.flatnonzero(np.isin(self.originals, originals))


def impaired_shares(
    impaired: ImpairedSet,
    drop_config: DropConfig,
    method: AnyMethod,
    *,
    baselines: bool = True,
    unseen_kinds: bool = False,
) -> Shares:
    """Return the share of each kind of copy that is still classified by its function, by spheres and every baseline.

    All whole objects of other sources are learnt, or those of a random half where the manifest names fewer than two.

    Parameters
    ----------
    baselines : bool
        Whether to measure the baselines too.
    unseen_kinds : bool
        Whether classifiers that learn copies are also tested on each kind after learning all other kinds alone.
    """
    both, radii, splits = impaired.simulated, drop_config.radii, held_out(impaired, drop_config.seed)
    methods = readings(both, radii, method) if baselines else {SPHERES: spheres_read(both, radii, method)}
    alone = [[split] for split in splits]
    predicted, held = {}, {}
    for name, read in methods.items():
        predicted[name], held[name] = apply_stability_check(read, alone)
    for name, read in methods.items():
        if isinstance(read, ProfileFeatures):
            having_learnt = with_copies_learnt(impaired, read)
            more = [[impaired.with_copies(split)] for split in splits]
            predicted[name + COPIES_LEARNT] = [trial.predicted for trial in having_learnt.trials(more)]
            if unseen_kinds:
                predicted[name + COPIES_LEARNT + UNSEEN_KIND] = scores_for_unseen_kinds(impaired, having_learnt, splits)
            if baselines and read.checks is not None:
                predicted[name + HELD] = held[name]
    return shares_of(impaired, splits, predicted)


def apply_stability_check(
    read: FeatureMethod, alone: Sequence[Sequence[Split]]
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return the predicted functions of copies with all checks of use, and without them; both are learnt at once."""
    checks = read.checks if isinstance(read, ProfileFeatures) else None
    trials = (read if checks is None else replace(read, checks=None)).trials(alone)
    held = [trial.predicted for trial in trials]
    if checks is None:
        return held, held
    excluded = [checks.excluded(trial.rows, trial.scores, read.labels.functions)[0] for trial in trials]
    return [positive & ~without for positive, without in zip(held, excluded, strict=True)], held


def impaired_copies(
    learnt: Sequence[Simulated],
    dataset: Dataset,
    drop_configs: Sequence[DropConfig],
    *,
    copied: int | None = None,
    jobs: int = -1,
    failed: Failed,
) -> list[ImpairedSet]:
    """Return the whole objects and impaired copies of some of them, spheres dropped on all, for each drop config.

    Parameters
    ----------
    learnt : sequence of Simulated
        The whole objects of the data set by each drop config.
    drop_configs : sequence of DropConfig
        How spheres are dropped; the seed of the first is also that of the copies.
    copied : int
        The maximum number of objects of each function that are copied, evenly chosen; all objects are learnt.
    failed : callable
        Is called with the error of each file that cannot be used.
    """
    whole = replace(dataset, objects=evenly_chosen(learnt[0].objects, copied))
    folder = built_copies(whole, drop_configs[0], jobs, failed)
    copies = {copy.item.path: copy for copy in read_copies(folder)}
    data = Dataset(f"impaired copies of {dataset.name}", tuple(copy.item for copy in copies.values()), folder)
    loaded = [replace(drop_config, loading=LoadOptions()) for drop_config in drop_configs]
    done = simulate_by_all(data, loaded, jobs=jobs, failed=[failed] * len(loaded))
    pairs = zip(learnt, map(require_some, done), strict=True)
    return [with_originals(originals, simulated, dataset, copies) for originals, simulated in pairs]


def with_originals(
    learnt: Simulated, simulated: Simulated, dataset: Dataset, copies: Mapping[Path, CopyRow]
) -> ImpairedSet:
    """Return whole objects, followed by their copies."""
    both = learnt + simulated
    rows = {dataset.name_of(item.path): row for row, item in enumerate(learnt.objects)}
    of_copies = [copies[item.path] for item in simulated.objects]
    of = np.array([rows[copy.of] for copy in of_copies])
    return ImpairedSet(simulated=both, labels=labels_of(both), copies=of_copies, originals=of)


def with_copies_learnt(impaired: ImpairedSet, read: ProfileFeatures) -> ProfileFeatures:
    """Return features whose classifier learns copies with their originals, as the models of the package do."""
    originals = np.concatenate([np.arange(impaired.whole), impaired.originals])
    weights = np.where(np.arange(len(originals)) < impaired.whole, 1.0, COPY_WEIGHT)
    return replace(read, copy_groups=CopyGroups(weights=weights, groups=originals))


def scores_for_unseen_kinds(impaired: ImpairedSet, read: ProfileFeatures, splits: Sequence[Split]) -> list[np.ndarray]:
    """Return the predicted functions of copies after learning copies of other sources' objects, but none of their kind.

    Only the function of a copy's original is predicted; everything else is False.
    """
    predicted = [np.zeros((len(split.test), len(impaired.labels.functions)), bool) for split in splits]
    alone = [replace(read, labels=impaired.labels.of_function(column)) for column in range(predicted[0].shape[1])]
    tested, work = [], []
    for where, split in enumerate(splits):
        for made in sorted({impaired.made[row] for row in split.test - impaired.whole}):
            column, kind = impaired.labels.functions.index(made[0]), made[1]
            rows = impaired.whole + np.flatnonzero([each == made for each in impaired.made])
            tested.append((where, column))
            work.append((alone[column], [impaired.with_copies(split, unseen=kind).testing(rows)]))
    for (where, column), trial in zip(tested, trials_of(work), strict=True):
        predicted[where][np.searchsorted(splits[where].test, trial.rows), column] = trial.predicted[:, 0]
    return predicted


def built_copies(dataset: Dataset, drop_config: DropConfig, jobs: int, failed: Failed) -> Path:
    """Return the folder of a data set's copies, which is made in the cache the first time."""
    how = {"seed": drop_config.seed, "up": drop_config.loading.up, "units": drop_config.loading.units}
    folder = cache_home() / "impaired" / content_name(dataset, drop_config)
    built_once(folder, lambda place: impair_dataset(dataset, place, **how, jobs=jobs, failed=failed))
    return folder


def content_name(dataset: Dataset, drop_config: DropConfig) -> str:
    """Return the hash of everything that decides the copies: files, labels, how they are loaded, and the seed."""
    digest = hashlib.sha256(f"{version('spherefunc-bullet')} {VERSION} {drop_config.seed}".encode())
    digest.update(" ".join(impairment.kind for impairment in IMPAIRMENTS).encode())
    for item in dataset.objects:
        about = (label_text(item.functions), label_text(item.also), item.category, item.group)
        digest.update("\n".join([dataset.name_of(item.path), *about]).encode())
        digest.update(drop_config.content_hash(item.path).encode())
    return digest.hexdigest()


def held_out(impaired: ImpairedSet, seed: int) -> list[Split]:
    """Return splits that learn whole objects and test copies of others: source by source, or in random halves."""
    whole = sources_or_halves(impaired.labels.groups[: impaired.whole], TRIALS, seed)
    splits = [Split(split.train, impaired.rows_of(split.test)) for split in whole]
    return [split for split in splits if len(split.test)]


def shares_of(impaired: ImpairedSet, splits: Sequence[Split], predicted: Mapping[str, Sequence[np.ndarray]]) -> Shares:
    """Return for each function and kind the share of its copies that every feature still classifies by the function."""
    rows = np.concatenate([split.test for split in splits]) - impaired.whole
    called = {name: np.concatenate(answers) for name, answers in predicted.items()}
    shares: Shares = {}
    made = np.array([impaired.made[row] for row in rows])  # (T, 2) function and kind
    for column, function in enumerate(impaired.labels.functions):
        for impairment in IMPAIRMENTS:  # whole first, useless, harmless
            of_kind = (made == [function, impairment.kind]).all(axis=1)
            if function not in impairment.functions or not of_kind.any():
                continue
            shares.setdefault(function, {})[impairment.kind] = {
                "works": impairment.works,
                "copies": len(set(rows[of_kind].tolist())),
                "share": {name: round(float(answers[of_kind, column].mean()), 4) for name, answers in called.items()},
            }
    return shares


def print_shares(shares: Shares):
    """Print a row for each kind and a column for each feature set."""
    title = "\nimpaired copies of objects that were not learnt: share still classified by the function"
    print_table(title, *share_rows(shares))


def share_rows(shares: Shares) -> tuple[list[str], list[list[str]]]:
    """Return the column names, one for each feature set, and a row for each kind and each mean over kinds."""
    features = list(next(iter(next(iter(shares.values())).values()))["share"])
    rows = [
        [f"{function}, {kind.replace('_', ' ')}", "yes" if row["works"] else "no", str(row["copies"])]
        + [f"{row['share'][name]:.2f}" for name in features]
        for function, kinds in shares.items()
        for kind, row in [*kinds.items(), *mean_rows(kinds, features)]
    ]
    return ["copy", "works", "copies", *(name.replace("_", " ") for name in features)], rows


def mean_shares(shares: Shares, features: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return the shares of useless and of harmless copies by feature set, means over kinds and then over functions.

    Where there are no such copies, they are NaN.
    """
    rows, means = [dict(mean_rows(kinds, features)) for kinds in shares.values()], {}
    for name in (USELESS, HARMLESS):
        feature_shares = [row[name]["share"] for row in rows if name in row] or [dict.fromkeys(features, np.nan)]
        means[name] = {feature: float(np.mean([share[feature] for share in feature_shares])) for feature in features}
    return means


def mean_rows(kinds: Mapping[str, KindShare], features: Sequence[str]) -> Iterator[tuple[str, KindShare]]:
    """Yield the means over useless kinds and over harmless ones, each kind counted once, whole objects excluded."""
    for name, works in ((USELESS, False), (HARMLESS, True)):
        rows = [row for kind, row in kinds.items() if row["works"] == works and kind != "whole"]
        if rows:
            means = {feature: float(np.mean([row["share"][feature] for row in rows])) for feature in features}
            yield name, {"works": works, "copies": sum(row["copies"] for row in rows), "share": means}
