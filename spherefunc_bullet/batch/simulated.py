"""From a data set to settled spheres and labels; files that cannot be used are left out."""

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
        """Return the objects of both, with the name of this one."""
        return Simulated(self.name, self.objects + other.objects, self.records + other.records)

    @property
    def settled(self) -> list[DropsByRadius]:
        """The drops of each object by radius."""
        return [record.settled for record in self.records]


def simulate_dataset(
    dataset: Dataset,
    drop_config: DropConfig,
    *,
    jobs: int = -1,
    run: Path | None = None,
    failed: Callable[[InputError], None],
) -> Simulated:
    """Simulate every object of a data set; files that cannot be used are left out, and their errors go to ``failed``.

    Parameters
    ----------
    run : path, optional
        A run directory of `batch`, used in place of the cache: its runs are not simulated again, and objects that
        failed there are not tried again.

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

    A result without objects is no error here; see `require_some`.

    Parameters
    ----------
    failed : sequence of callable
        For each drop config, a function that gets the error of each file.
    """
    known = [{} if run is None else known_failures(run, dataset, drop_config) for drop_config in drop_configs]
    for errors, report in zip(known, failed, strict=True):
        for error in errors.values():
            report(error)
    missing = [[number for number, errors in enumerate(known) if item.path not in errors] for item in dataset.objects]
    left = [index for index, numbers in enumerate(missing) if numbers]
    tasks = [(dataset.objects[index].path, [drop_configs[number] for number in missing[index]]) for index in left]
    records: list[dict[int, ObjectRecord]] = [{} for _ in drop_configs]
    done = simulate_by_several(tasks, jobs=jobs, home=run)
    for position, outcomes in progress(done, len(tasks), f"dropping spheres on {dataset.name}"):
        index = left[position]
        for number, outcome in zip(missing[index], outcomes, strict=True):
            if isinstance(outcome, InputError):
                failed[number](outcome)
            else:
                records[number][index] = outcome
    return [
        Simulated(dataset.name, tuple(dataset.objects[i] for i in sorted(own)), tuple(own[i] for i in sorted(own)))
        for own in records
    ]


def require_some(simulated: Simulated) -> Simulated:
    """Return a simulated data set; InputError if no object is left in it."""
    if not simulated.records:
        raise InputError(f"{simulated.name}: expected at least one object that can be simulated, got none")
    return simulated
