"""Objects as sensors give them: how corrupted clouds of objects of sources that were not learnt are classified.

The corruptions of ModelNet40-C (Sun et al., 2022) that make sense where sizes are metres, five severities each.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from operator import itemgetter
from typing import Any

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.clouds.preparation import prepare
from spherefunc_bullet.console import passed, print_table
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.method import AnyMethod
from spherefunc_bullet.learning.profiles.calibration import UNCERTAIN_MARGIN
from spherefunc_bullet.processes.tasks import run_tasks
from spherefunc_bullet.scenes.impairment.folder import evenly_spread
from spherefunc_bullet.scenes.impairment.specimen import FUNCTIONS, NONE
from spherefunc_bullet.scenes.impairment.use.sensed import CORRUPTIONS, corrupted
from spherefunc_bullet.settling.cached_runs import DropConfig
from spherefunc_bullet.settling.records import ObjectRecord, shape_of
from spherefunc_bullet.settling.settling import settle

from ..evaluation import Trial
from ..features import SPHERES
from ..protocol import Labels, Split, labels_of, sources_or_halves
from ..readings import ProfileFeatures, calibrated_across_sources, readings

CLEAN = "clean"
SEVERITIES = (1, 2, 3, 4, 5)
OTHERS = 2  # times as many objects without a function as of each
TRIALS = 2  # random halves, where there are no sources to leave out
Failed = Callable[[InputError], None]
Rates = dict[str, Any]  # of all objects under one corruption of one severity, as shares; see `rates_of`
Corruptions = dict[str, dict[str, Rates]]  # by kind, then severity


@dataclass(frozen=True, kw_only=True)
class CorruptedSet:
    """Whole objects, followed by corrupted clouds of some of them."""

    simulated: Simulated  # both
    whole: int  # number of whole objects
    originals: np.ndarray  # (C,) the whole object of each corrupted cloud
    kinds: Sequence[tuple[str, str]]  # kind and severity of each corrupted cloud


def corruption_rates(
    learnt: Simulated,
    tested: Simulated | None,
    drop_config: DropConfig,
    method: AnyMethod,
    *,
    copied: int | None = None,
    jobs: int = -1,
    failed: Failed,
) -> Corruptions:
    """Return the rates of spheres and every baseline under each corruption and severity.

    Parameters
    ----------
    learnt : Simulated
        The objects to learn from: all of them where others are tested, those of other sources (or of a random half
        where the manifest names fewer than two) where they are tested themselves.
    tested : Simulated, optional
        The objects to test.
    copied : int
        The maximum number of objects of each function, evenly chosen; twice as many without a function.
    """
    corrupted_set = corrupted_set_of(learnt, tested, drop_config, copied, jobs, failed)
    labels = labels_of(corrupted_set.simulated)
    splits = splits_of(corrupted_set, labels, None if tested is None else len(learnt.objects), drop_config.seed)
    rates: Corruptions = {}
    for name, features in readings(corrupted_set.simulated, drop_config.radii, method).items():
        if isinstance(features, ProfileFeatures):  # how sure it is was measured on sources that were not learnt
            features = calibrated_across_sources(features, corrupted_set.simulated.objects)
        found = rates_of(corrupted_set, labels, features.trials([[split] for split in splits]))
        if name == SPHERES:
            rates = found
            continue
        for kind, rows in found.items():
            for severity, of_baseline in rows.items():
                rates[kind][severity].setdefault("baselines", {})[name] = of_baseline
    return rates


def corrupted_set_of(
    learnt: Simulated, tested: Simulated | None, drop_config: DropConfig, copied: int | None, jobs: int, failed: Failed
) -> CorruptedSet:
    """Return whole objects, and their corrupted clouds with the spheres that fell on these."""
    whole = learnt if tested is None else learnt + tested
    first = 0 if tested is None else len(learnt.objects)
    rows = {item.path: row for row, item in enumerate(whole.objects) if row >= first}
    some = chosen(whole.objects[first:], copied)
    tasks = [(item, drop_config) for item in some]
    outcomes = run_tasks(corrupted_records, tasks, [item.path for item in some], jobs=jobs, isolate=False)
    done = passed(outcomes, len(some), "corrupting", failed)
    made = [(rows[some[index].path], *corruption) for index, corruptions in done for corruption in corruptions]
    made.sort(key=itemgetter(0, 1, 2))
    copies = [whole.objects[row] for row, *_ in made], [record for *_, record in made]
    return CorruptedSet(
        simulated=whole + Simulated(learnt.name, *map(tuple, copies)),
        whole=len(whole.objects),
        originals=np.array([row for row, *_ in made], int),
        kinds=[(kind, severity) for _, kind, severity, _ in made],
    )


def chosen(objects: Sequence[DatasetObject], copied: int | None) -> list[DatasetObject]:
    """Return the objects to corrupt; those whose only functions are disputed are left out."""
    most = {function: copied for function in FUNCTIONS} | {NONE: None if copied is None else OTHERS * copied}
    return [item for function, count in most.items() for item in evenly_spread(objects, function, count)]


def corrupted_records(item: DatasetObject, drop_config: DropConfig) -> list[tuple[str, str, ObjectRecord]]:
    """Return the record of spheres on an object's points as they are, and corrupted in each way and severity."""
    points, name = drop_config.cloud(item.path).points, zlib.crc32(item.path.name.encode())
    made = [(CLEAN, "0", record_of(points, item, drop_config))]
    for kind in CORRUPTIONS:
        for severity in SEVERITIES:
            rng = np.random.default_rng([drop_config.seed, name, zlib.crc32(kind.encode()), severity])
            made.append((kind, str(severity), record_of(corrupted(points, kind, severity, rng), item, drop_config)))
    return made


def record_of(points: np.ndarray, item: DatasetObject, drop_config: DropConfig) -> ObjectRecord:
    """Return the record of the spheres that settle on points (N, 3), with the shape that baselines need."""
    cloud = prepare(Cloud(points, item.path.name))
    settled = settle(cloud, drop_config.simulator, drop_config.radii, drop_config.seed, drop_config.run_limit)
    shape = shape_of(cloud)
    return ObjectRecord(path=item.path, size=shape["size"], occupied=partial(shape.get, "voxels"), settled=settled)


def splits_of(corrupted_set: CorruptedSet, labels: Labels, learnt: int | None, seed: int) -> list[Split]:
    """Return splits that learn whole objects and test corrupted clouds of others."""
    if learnt is not None:
        return [Split(np.arange(learnt), corrupted_set.whole + np.arange(len(corrupted_set.originals)))]
    splits = []
    for one in sources_or_halves(labels.groups[: corrupted_set.whole], TRIALS, seed):
        corrupted_rows = np.flatnonzero(np.isin(corrupted_set.originals, one.test))
        if len(corrupted_rows):
            splits.append(Split(one.train, corrupted_set.whole + corrupted_rows))
    return splits


def rates_of(corrupted_set: CorruptedSet, labels: Labels, trials: Sequence[Trial]) -> Corruptions:
    """Return the rates of one feature."""
    trial = Trial.joined(trials)
    near = (np.abs(trial.scores - 0.5) < UNCERTAIN_MARGIN).any(axis=1)
    unsure = near if trial.unsure is None else trial.unsure  # by the rule that was learnt, where there is one
    wrong, members = trial.wrong(labels), labels.members[trial.rows]
    serves, classified = members.any(axis=1), (trial.predicted & members).any(axis=1)
    kinds = np.array([corrupted_set.kinds[row - corrupted_set.whole] for row in trial.rows])
    rates: Corruptions = {}
    for kind, severity in dict.fromkeys(corrupted_set.kinds):
        of_kind = (kinds == [kind, severity]).all(axis=1)
        rates.setdefault(kind, {})[severity] = {
            "told": share(classified[of_kind & serves]),  # of those with a function, classified as such
            "unsure": share(unsure[of_kind]),
            "wrong_and_sure": share((wrong & ~unsure)[of_kind]),
        }
    return rates


def share(which: np.ndarray) -> float:
    """Return the share that is True, to four places."""
    return round(float(which.mean()), 4) if len(which) else float("nan")


def print_corruptions(rates: Corruptions):
    """Print a row for each corruption, with the shares of its severities."""
    names = {"told": "classified", "unsure": "unsure", "wrong_and_sure": "wrong and sure"}
    rows = [
        [kind.replace("_", " "), words, *(f"{rows[severity][name]:.2f}" for severity in sorted(rows))]
        for kind, rows in rates.items()
        for name, words in names.items()
    ]
    wide = [row + ["-"] * (2 + len(SEVERITIES) - len(row)) for row in rows]
    title = "\nobjects that were not learnt, as sensors give them, by severity"
    print_table(title, ["corruption", "share", *map(str, SEVERITIES)], wide)
