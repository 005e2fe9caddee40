"""The entries of a comparison: every simulator on the same objects, and on some of them again with a second seed."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated, require_some, simulate_by_all
from spherefunc_bullet.console import Failures, say
from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.settling.records import ObjectRecord

from ..evaluation.evaluation import Evaluation
from ..evaluation.protocol import labels_of, require_enough
from .experiment import ComparedSimulator, Experiment

CHEAP = 120.0  # seconds: if all runs together took no more, they are all repeated with the second seed
SOME = 40  # objects whose runs are repeated otherwise
Item = TypeVar("Item")


@dataclass(frozen=True, kw_only=True)
class Runs:
    """The runs of one simulator on objects, at some radii, and their cost.

    Seconds are those of the simulation alone, measured when a run was made: without loading, sampling, compilation.
    """

    records: Sequence[ObjectRecord]
    radii: Sequence[float]  # metres

    def alone(self, radius: float) -> Runs:
        """Return the runs of one radius."""
        return replace(self, radii=[radius])

    @property
    def seconds(self) -> list[float]:
        """Seconds of each object, all radii together."""
        return [sum(record.seconds[radius] for radius in self.radii) for record in self.records]

    @property
    def drops(self) -> list[int]:
        """Drops on each object, all radii together."""
        return [sum(record.drops[radius] for radius in self.radii) for record in self.records]

    @property
    def settled(self) -> list[int]:
        """Settled spheres on each object, all radii together."""
        return [sum(len(record.centers(radius)) for radius in self.radii) for record in self.records]

    @property
    def settled_share(self) -> float | None:
        """The share of all spheres that settled."""
        drops = sum(self.drops)
        return round(sum(self.settled) / drops, 4) if drops else None

    def timing(self) -> dict[str, Any]:
        """Return the seconds that an object takes, all radii together, the median first, and the drops per second."""
        seconds, drops = np.array(self.seconds), sum(self.drops)
        total = float(seconds.sum())
        return {
            "seconds_per_object": round(float(np.median(seconds)), 6),
            "seconds_per_object_p95": round(float(np.percentile(seconds, 95)), 6),
            "seconds_total": round(total, 4),
            "drops": drops,
            "drops_per_second": round(drops / total, 1) if total > 0 else None,
        }


@dataclass(frozen=True, kw_only=True)
class ComparedRun:
    """The runs of one simulator on the objects that every simulator could use."""

    candidate: ComparedSimulator
    simulated: Simulated
    again: Simulated  # some of the same objects, with the second seed
    failed: tuple[str, ...]  # the errors of objects that could not be simulated

    @property
    def name(self) -> str:
        return self.candidate.name

    @property
    def radii(self) -> tuple[float, ...]:
        """Metres, ascending."""
        return self.candidate.radii

    @property
    def records(self) -> tuple[ObjectRecord, ...]:
        return self.simulated.records

    @property
    def runs(self) -> Runs:
        return Runs(records=self.records, radii=self.radii)

    def object_figures(self, evaluation: Evaluation) -> list[dict[str, Any]]:
        """Return each object's seconds, drops, settled spheres and scores, with all others learnt."""
        functions, runs, figures = evaluation.labels.functions, self.runs, []
        columns = zip(runs.seconds, runs.drops, runs.settled, evaluation.scores.tolist(), strict=True)
        for seconds, drops, settled, scores in columns:
            by_function = {name: round(score, 4) for name, score in zip(functions, scores, strict=True)}
            figures.append({"seconds": round(seconds, 6), "drops": drops, "settled": settled, "scores": by_function})
        return figures


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """The runs of every simulator on the same objects."""

    entries: tuple[ComparedRun, ...]
    left_out: tuple[DatasetObject, ...]  # at least one simulator failed on them

    @property
    def simulated(self) -> Simulated:
        """The objects, with the first simulator's records."""
        return self.entries[0].simulated

    @property
    def repeated(self) -> int:
        """The number of objects with runs of the second seed."""
        return len(self.entries[0].again.objects)


@dataclass(kw_only=True)
class FailureLog:
    """The errors of simulators; those that are the same for several simulators are reported once."""

    failures: Failures
    consequence: str
    of: dict[str, list[str]] = field(default_factory=dict)  # by simulator

    def add(self, name: str, error: InputError):
        """Keep a simulator's error, and report it unless another simulator had the same."""
        known = any(str(error) in said for said in self.of.values())
        self.of.setdefault(name, []).append(str(error))
        if not known:
            self.failures.add(InputError(f"{error} ({name}; {self.consequence})"))


def simulate_candidates(
    dataset: Dataset,
    candidates: Sequence[ComparedSimulator],
    experiment: Experiment,
    jobs: int,
    failures: Failures,
    run: Path | None = None,
) -> Comparison:
    """Drop spheres on every object by every simulator, or read cached runs; keep the objects that all could use.

    A comparison that was interrupted continues where it stopped, since every finished run is in the cache, or in the
    run directory ``run`` instead.

    Raises
    ------
    InputError
        If too few objects are left to split, or all of one label.
    """
    log = FailureLog(failures=failures, consequence="left out of every backend")
    first = drop_all(candidates, dataset, log, jobs, run)
    require_splittable(dataset.name, first[0].objects, " that every backend can simulate")
    if len(candidates) == 1:  # there is no agreement to measure
        again = [subset(first[0], ())]
    else:
        chosen = evenly(first[0].objects, repeated_count(first, experiment.repeated))
        say(f"seed {experiment.seeds[1]}, for the agreement: {len(chosen)} of {len(first[0].objects)} objects")
        fewer = FailureLog(failures=failures, consequence="left out of the agreement of histograms")
        reseeded = [replace(candidate, seed=experiment.seeds[1]) for candidate in candidates]
        again = drop_all(reseeded, replace(dataset, objects=chosen), fewer, jobs, run)
    paths, entries = {item.path for item in first[0].objects}, []
    for candidate, simulated, second in zip(candidates, first, again, strict=True):
        failed = tuple(log.of.get(candidate.name, ()))
        entries.append(ComparedRun(candidate=candidate, simulated=simulated, again=second, failed=failed))
    left_out = tuple(item for item in dataset.objects if item.path not in paths)
    return Comparison(entries=tuple(entries), left_out=left_out)


def drop_all(
    candidates: Sequence[ComparedSimulator], dataset: Dataset, log: FailureLog, jobs: int, run: Path | None
) -> list[Simulated]:
    """Return the runs of every simulator on the objects on which none of them failed; see `simulate_by_all`."""
    failed = [partial(log.add, candidate.name) for candidate in candidates]
    drop_configs = [candidate.drop_config for candidate in candidates]
    done = simulate_by_all(dataset, drop_configs, failed=failed, jobs=jobs, run=run)
    for candidate, simulated in zip(candidates, done, strict=True):
        try:
            require_some(simulated)
        except InputError as error:
            raise InputError(f"{candidate.name}: {error}") from error
    paths = set.intersection(*({item.path for item in simulated.objects} for simulated in done))
    return [subset(simulated, paths) for simulated in done]


def require_splittable(name: str, objects: Sequence[DatasetObject], which: str = ""):
    """Raise InputError if objects cannot be split, or have one label only."""
    require_enough(name, len(objects), which)
    labels_of(Simulated(name, tuple(objects), ()))


def subset(simulated: Simulated, paths: Collection[Path]) -> Simulated:
    """Return the runs on the objects of these paths alone."""
    rows = [i for i, item in enumerate(simulated.objects) if item.path in paths]
    objects, records = (tuple(column[i] for i in rows) for column in (simulated.objects, simulated.records))
    return Simulated(simulated.name, objects, records)


def repeated_count(first: Sequence[Simulated], requested: int | None) -> int:
    """Return the number of objects to repeat with the second seed: as requested, or all if that is cheap, or `SOME`."""
    count = len(first[0].objects)
    if requested is not None:
        return min(requested, count)
    spent = sum(sum(record.seconds.values()) for simulated in first for record in simulated.records)
    return count if spent <= CHEAP else min(SOME, count)


def dropped_twice(entry: ComparedRun) -> dict[int, ObjectRecord]:
    """Return the records of the second seed by the row of their object."""
    again = {record.path: record for record in entry.again.records}
    return {row: again[record.path] for row, record in enumerate(entry.records) if record.path in again}


def evenly(objects: Sequence[Item], count: int) -> tuple[Item, ...]:
    """Return a number of objects, evenly spread over their order."""
    chosen = np.linspace(0, len(objects) - 1, count).round().astype(int)
    return tuple(objects[i] for i in np.unique(chosen))


def repeatable(experiment: Experiment, comparison: Comparison) -> Experiment:
    """Return the experiment with all defaults filled in, so that it can be repeated exactly."""
    path = Path(experiment.data)
    return replace(
        experiment,
        data=str(path.resolve()) if path.exists() else experiment.data,
        radii={entry.name: entry.radii for entry in comparison.entries},
        repeated=comparison.repeated or None,
    )
