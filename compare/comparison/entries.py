"""The contest: every simulator on the same objects, and on some of them again with another seed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.console import Failures, say
from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject
from spherefunc_bullet.errors import InputError

from ..evaluation.evaluation import labels_of
from ..evaluation.sizes import FEWEST
from .experiment import Contestant, Experiment

CHEAP = 120.0  # seconds that all simulators together may have taken for everything to be dropped again
SOME = 40  # objects that are dropped on again where that is not cheap


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What one simulator did: the objects that every other one did as well."""

    contestant: Contestant
    simulated: Simulated
    again: Simulated  # some of the same objects, with the second seed
    failed: tuple[str, ...]  # why objects could not be simulated


@dataclass(frozen=True, kw_only=True)
class Contest:
    """The same objects by every simulator."""

    entries: tuple[Entry, ...]
    left_out: tuple[DatasetObject, ...]  # failed in one simulator at least

    @property
    def objects(self) -> tuple[DatasetObject, ...]:
        return self.entries[0].simulated.objects

    @property
    def repeated(self) -> int:
        """How many objects were dropped on again."""
        return len(self.entries[0].again.objects)


@dataclass(kw_only=True)
class Complaints:
    """What went wrong, by simulator; said once each, however many simulators say the same."""

    failures: Failures
    consequence: str
    said: set[str] = field(default_factory=set)
    of: dict[str, list[str]] = field(default_factory=dict)

    def by(self, name: str) -> Callable[[InputError], None]:
        """Return what takes one simulator's failures."""

        def failed(error: InputError):
            """Keep a failure, and say it unless another simulator's was the same."""
            self.of.setdefault(name, []).append(str(error))
            if str(error) not in self.said:
                self.said.add(str(error))
                self.failures.add(InputError(f"{error} ({name}; {self.consequence})"))

        return failed


def hold(
    dataset: Dataset, contestants: Sequence[Contestant], experiment: Experiment, jobs, failures, run=None
) -> Contest:
    """Drop spheres on every object by every simulator, from the cache what it has, and keep what all of them did.

    A comparison that was cut off goes on where it stopped, since every finished run is in the cache, or in the run
    directory ``run`` in its place.

    Raises
    ------
    InputError
        If too few objects are left to split, or all of one label.
    """
    complaints = Complaints(failures=failures, consequence="left out of every backend")
    first = drop_all(contestants, dataset, experiment.seeds[0], experiment.loading, jobs, complaints, run)
    require_splittable(dataset.name, first[0].objects, " that every backend can simulate")
    again = drop_again(contestants, dataset, first, experiment, jobs, failures, run)
    kept = {each.path for each in first[0].objects}
    return Contest(
        entries=tuple(
            Entry(contestant=each, simulated=one, again=two, failed=tuple(complaints.of.get(each.name, ())))
            for each, one, two in zip(contestants, first, again, strict=True)
        ),
        left_out=tuple(each for each in dataset.objects if each.path not in kept),
    )


def drop_all(
    contestants, dataset: Dataset, seed: int, loading, jobs: int, complaints: Complaints, run=None
) -> list[Simulated]:
    """Return a data set simulated by every contestant, those objects that none of them failed at."""
    done = []
    for each in contestants:
        options = {"seed": seed, "loading": loading, "jobs": jobs, "run": run, "failed": complaints.by(each.name)}
        try:
            done.append(simulate_dataset(dataset, each.simulator, each.radii, **options))
        except InputError as error:
            raise InputError(f"{each.name}: {error}") from error
    return shared(done)


def drop_again(
    contestants, dataset: Dataset, first: Sequence[Simulated], experiment: Experiment, jobs, failures, run
) -> list[Simulated]:
    """Return some of the objects simulated with the second seed; none where there is nobody to agree with."""
    if len(contestants) == 1:
        return [only(first[0], ())]
    objects = first[0].objects
    chosen = replace(dataset, objects=evenly(objects, repeated(first, experiment.repeated)))
    say(f"seed {experiment.seeds[1]}, for the agreement: {len(chosen)} of {len(objects)} objects")
    complaints = Complaints(failures=failures, consequence="left out of the agreement of histograms")
    return drop_all(contestants, chosen, experiment.seeds[1], experiment.loading, jobs, complaints, run)


def require_splittable(name: str, objects: Sequence[DatasetObject], which: str = ""):
    """Raise InputError if objects cannot be split, or have one label only."""
    if len(objects) < FEWEST:
        raise InputError(
            f"{name}: expected at least {FEWEST} objects{which}, half to learn and half to test, got {len(objects)}"
        )
    labels_of(Simulated(name, tuple(objects), ()))


def shared(all_simulated: Sequence[Simulated]) -> list[Simulated]:
    """Return what every simulator did of the objects that none of them failed at."""
    paths = set.intersection(*({each.path for each in simulated.objects} for simulated in all_simulated))
    return [only(simulated, paths) for simulated in all_simulated]


def only(simulated: Simulated, paths: Iterable) -> Simulated:
    """Return the objects of these paths alone."""
    kept = [i for i, each in enumerate(simulated.objects) if each.path in paths]
    return Simulated(
        simulated.name, tuple(simulated.objects[i] for i in kept), tuple(simulated.records[i] for i in kept)
    )


def repeated(first: Sequence[Simulated], asked: int | None) -> int:
    """Return how many objects to drop on again: as asked, or all where that costs little, or `SOME`."""
    count = len(first[0].objects)
    if asked is not None:
        return min(asked, count)
    spent = sum(sum(record.seconds.values()) for simulated in first for record in simulated.records)
    return count if spent <= CHEAP else min(SOME, count)


def evenly(objects: Sequence[DatasetObject], count: int) -> tuple[DatasetObject, ...]:
    """Return so many objects, evenly spread over the order of the manifest."""
    chosen = np.linspace(0, len(objects) - 1, count).round().astype(int)
    return tuple(objects[i] for i in np.unique(chosen))


def settled_experiment(experiment, contest):
    """Return the experiment with everything that was left open settled, so that it repeats exactly."""
    from dataclasses import replace

    path = Path(experiment.data)
    return replace(
        experiment,
        data=str(path.resolve()) if path.exists() else experiment.data,
        radii={each.contestant.name: each.contestant.radii for each in contest.entries},
        repeated=contest.repeated or None,
    )
