"""From a data set to settled spheres and labels, whatever happens to single files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..console import progress
from ..datasets.dataset import Dataset, DatasetObject
from ..errors import InputError
from ..settling.cached_runs import DropConfig
from ..settling.drops import DropsByRadius
from ..settling.records import ObjectRecord, simulate_by_several
from .batch import known_failures


@dataclass(frozen=True)
class Simulated:
    """A data set's objects that could be simulated, with their records, in the order of the manifest."""

    name: str
    objects: tuple[DatasetObject, ...]
    records: tuple[ObjectRecord, ...]

    def __add__(self, other: Simulated) -> Simulated:
        """The objects of both, under this one's name."""
        return Simulated(self.name, self.objects + other.objects, self.records + other.records)

    @property
    def settled(self) -> list[DropsByRadius]:
        return [record.settled for record in self.records]


def simulate_dataset(
    dataset: Dataset,
    drop_config: DropConfig,
    *,
    jobs: int = -1,
    run: Path | None = None,
    failed: Callable[[InputError], None],
) -> Simulated:
    """Simulate every object of a data set; a file that cannot be used goes to ``failed`` and is left out.

    Parameters
    ----------
    run : path, optional
        A run directory of `batch` in place of the cache: what it holds is not simulated again, and what failed
        there is not tried again.

    Raises
    ------
    InputError
        If no object is left, or there is no such run.
    """
    [simulated] = simulate_by_all(dataset, [drop_config], jobs=jobs, run=run, failed=[failed])
    return require_some(simulated)


def simulate_by_all(
    dataset: Dataset,
    drop_configs: Sequence[DropConfig],
    *,
    jobs: int = -1,
    run: Path | None = None,
    failed: Sequence[Callable[[InputError], None]],
) -> list[Simulated]:
    """Return the results of `simulate_dataset` for each of several drop configs; each file is loaded once.

    Of one that no object is left for, it has none; see `require_some`.

    Parameters
    ----------
    failed : sequence of callable
        For each dropping, what is given the error of each file.
    """
    known = [{} if run is None else known_failures(run, dataset, drop_config) for drop_config in drop_configs]
    for own, tell in zip(known, failed, strict=True):
        for error in own.values():
            tell(error)
    missing = [[way for way, own in enumerate(known) if item.path not in own] for item in dataset.objects]
    left = [index for index, ways in enumerate(missing) if ways]
    tasks = [(dataset.objects[index].path, [drop_configs[way] for way in missing[index]]) for index in left]
    records: list[dict[int, ObjectRecord]] = [{} for _ in drop_configs]
    done = simulate_by_several(tasks, jobs=jobs, home=run)
    for position, outcomes in progress(done, len(tasks), f"dropping spheres on {dataset.name}"):
        index = left[position]
        for way, outcome in zip(missing[index], outcomes, strict=True):
            if isinstance(outcome, InputError):
                failed[way](outcome)
            else:
                records[way][index] = outcome
    return [
        Simulated(dataset.name, tuple(dataset.objects[i] for i in sorted(own)), tuple(own[i] for i in sorted(own)))
        for own in records
    ]


def require_some(simulated: Simulated) -> Simulated:
    """Return what was simulated if there is any.

    Raises
    ------
    InputError
        If no object is left.
    """
    if not simulated.records:
        raise InputError(f"{simulated.name}: expected at least one object that can be simulated, got none")
    return simulated
