"""Batch runs that lose nothing: every object at every radius, each done once, whatever happens in between.

A run lives in a folder (`run_folder`) with a ledger (`ledger`). Workers write settled centres to the folder and
answer with rows; the caller syncs the files and then writes the rows. Killed at any instant, the next call finds
either both, or a whole file without a row, which it reads instead of simulating, or nothing.
"""

from __future__ import annotations

import json
import math
import os
import socket
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import InitVar, dataclass
from pathlib import Path

from ..datasets.dataset import Dataset
from ..errors import InputError, warn_renamed
from ..processes.tasks import run_tasks
from ..settling.cached_runs import DropConfig
from .folder import RunFolder
from .ledger import Ledger, LedgerRow, RunConfig
from .task import SimulationTask, rows_to_record, settled_rows, valid_row

LEAST_MEMORY = 256 << 20
Outcomes = Iterator[tuple[int, list[LedgerRow] | InputError]]


@dataclass(frozen=True, kw_only=True)
class Batch:
    """A data set to simulate, how spheres are dropped, and the folder of the run."""

    dataset: Dataset
    drop_config: DropConfig | None = None
    folder: RunFolder
    dropping: InitVar[DropConfig | None] = None  # the old name of ``drop_config``

    def __post_init__(self, dropping: DropConfig | None):
        if dropping is not None:
            warn_renamed("Batch(dropping=)", "drop_config=")
            object.__setattr__(self, "drop_config", dropping)

    @property
    def objects(self) -> dict[str, Path]:
        """The files by what the ledger calls them."""
        return {self.dataset.name_of(item.path): item.path for item in self.dataset.objects}

    def way(self, radius: float) -> RunConfig:
        """Return how the ledger describes the runs of one radius."""
        simulator = self.drop_config.simulator
        settings = self.drop_config.settings(radius) | {
            "version": simulator.version,
            "options": simulator.options(),
            "loading": self.drop_config.loading.to_dict(),
        }
        del settings["radius"]
        same_text = json.dumps(settings, sort_keys=True, default=str)
        return RunConfig(backend=simulator.name, settings=same_text, radius=radius, seed=self.drop_config.seed)


@dataclass(frozen=True, kw_only=True)
class ObjectLimits:
    """What an object may cost."""

    seconds: float = math.inf  # all radii together, before its process is stopped
    memory: int | None = None  # bytes of a worker process, interpreter and libraries included

    def __post_init__(self):
        if self.memory is not None and self.memory < LEAST_MEMORY:
            least = f"at least {LEAST_MEMORY >> 20} MiB, since interpreter and libraries take most of that"
            raise InputError(f"memory limit: expected {least}, got {self.memory >> 20} MiB")


@dataclass(frozen=True, kw_only=True)
class FinishedObject:
    """What became of one object."""

    name: str
    errors: tuple[str, ...] = ()  # why it, or some of its radii, could not be simulated
    skipped: bool = False  # had been dealt with before


def run_batch(
    batch: Batch,
    *,
    jobs: int = -1,
    limits: ObjectLimits | None = None,
    retry_failed: bool = False,
    work: Callable[[Sequence[SimulationTask]], Outcomes] | None = None,
) -> Iterator[FinishedObject]:
    """Simulate every object at every radius that the run does not have yet, and keep every result.

    Parameters
    ----------
    jobs : int
        Worker processes on this machine; -1: one per core.
    retry_failed : bool
        Also those objects that failed before, though their files have not changed.
    work : callable, optional
        Does tasks and yields their index and outcome, elsewhere than here (`cluster.on_executor`).

    Yields
    ------
    Finished
        Those that were dealt with before first, then each as it is done.

    Raises
    ------
    InputError
        If the folder or its ledger cannot be used, or the disk is full. What was done is kept.
    """
    batch.folder.make()
    with batch.folder.ledger(make=True) as ledger:
        ledger.check()
        about = {"host": socket.gethostname(), "process": os.getpid(), "data": batch.dataset.name}
        ledger.begin_call({"jobs": jobs} | about)
        tasks, finished = left_to_do(batch, ledger, retry_failed)
        yield from finished
        work = work or (lambda tasks: here(tasks, batch.folder, jobs, limits or ObjectLimits()))
        for index, outcome in work(tasks):  # a task left out, such as of a lost cluster, keeps waiting
            rows = rows_to_record(tasks[index], outcome, batch.folder)
            ledger.write(rows)
            yield finished_object(tasks[index].name, rows)
        ledger.end_call()
        batch.folder.sweep()


def here(tasks: Sequence[SimulationTask], folder: RunFolder, jobs: int, limits: ObjectLimits) -> Outcomes:
    """Do tasks in worker processes of this machine, always isolated: what happens to one costs that object."""
    arguments = [(task, folder) for task in tasks]
    limited = {"time_limit": limits.seconds, "memory_limit": limits.memory}
    return run_tasks(settled_rows, arguments, [task.path for task in tasks], jobs=jobs, isolate=True, **limited)


def left_to_do(batch: Batch, ledger: Ledger, retry_failed: bool) -> tuple[list[SimulationTask], list[FinishedObject]]:
    """Return what the ledger lacks, and the objects of which it has everything."""
    objects = batch.objects
    ways = {ledger.number(batch.way(radius)): radius for radius in batch.drop_config.radii}
    ledger.expect(objects, tuple(ways))
    missing: dict[str, dict[int, float]] = {name: {} for name in objects}
    standing: dict[str, list[LedgerRow]] = {name: [] for name in objects}
    moved = []
    for row in ledger.rows(tuple(ways)):
        if row.object not in objects:
            continue  # of another data set, or another shard, in the same folder
        now = valid_row(row, objects[row.object], batch.folder, batch.drop_config, retry_failed)
        if now is None:
            missing[row.object][row.way] = ways[row.way]
        else:
            standing[row.object].append(now)
            moved += [now] if now != row else []
    ledger.write(moved)
    tasks = [
        SimulationTask(path=objects[name], name=name, radii=radii, drop_config=batch.drop_config)
        for name, radii in missing.items()
        if radii
    ]
    done = [finished_object(name, standing[name], skipped=True) for name in objects if not missing[name]]
    return tasks, done


def known_failures(run: Path, dataset: Dataset, drop_config: DropConfig) -> dict[Path, InputError]:
    """Return the objects that failed in a run, by path, whose files have not changed since.

    Raises
    ------
    InputError
        If there is no such run.
    """
    batch = Batch(dataset=dataset, drop_config=drop_config, folder=RunFolder(run))
    objects, failed = batch.objects, {}
    with batch.folder.ledger() as ledger:
        for row in ledger.failures([batch.way(radius) for radius in drop_config.radii]):
            path = objects.get(row.object)
            if path is not None and valid_row(row, path, batch.folder, drop_config, retry_failed=False):
                failed[path] = InputError(f"{row.error} (in {run}; `batch --retry-failed` tries again)")
    return failed


def finished_object(name: str, rows: Iterable[LedgerRow], skipped: bool = False) -> FinishedObject:
    """Return what became of an object of which all rows are known."""
    errors = tuple(dict.fromkeys(row.error for row in rows if row.error))
    return FinishedObject(name=name, errors=errors, skipped=skipped)
