"""From a data set to settled spheres and labels, whatever happens to single files."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..console import progress
from ..datasets.dataset import Dataset, DatasetObject
from ..errors import InputError
from ..settling.drops import DropsByRadius
from ..settling.records import Dropping, ObjectRecord, simulate_objects
from .batch import known_failures


@dataclass(frozen=True)
class Simulated:
    """A data set's objects that could be simulated, with their records, in the order of the manifest."""

    name: str
    objects: tuple[DatasetObject, ...]
    records: tuple[ObjectRecord, ...]

    @property
    def settled(self) -> list[DropsByRadius]:
        return [record.settled for record in self.records]


def simulate_dataset(
    dataset: Dataset,
    dropping: Dropping,
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
    known = {} if run is None else known_failures(run, dataset, dropping)
    left = [index for index, item in enumerate(dataset.objects) if item.path not in known]
    paths = [dataset.objects[index].path for index in left]
    done = simulate_objects(paths, dropping, jobs=jobs, home=run)
    records: dict[int, ObjectRecord] = {}
    for error in known.values():
        failed(error)
    for position, outcome in progress(done, len(paths), f"dropping spheres on {dataset.name}"):
        if isinstance(outcome, InputError):
            failed(outcome)
        else:
            records[left[position]] = outcome
    if not records:
        raise InputError(f"{dataset.name}: expected at least one object that can be simulated, got none")
    kept = sorted(records)
    return Simulated(dataset.name, tuple(dataset.objects[i] for i in kept), tuple(records[i] for i in kept))
