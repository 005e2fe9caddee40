"""Batch runs: every object at every radius is simulated once, even if a run is interrupted and resumed.

A run is kept in a folder (`folder`) with a ledger (`ledger`). Workers write settled centres to the folder and return
rows; the caller syncs the files and then writes the rows. If a run is killed at any time, the next call finds either
both, or a complete file without a row, which it reads instead of simulating, or nothing.
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
from ..errors import InputError, one_line, warn_renamed
from ..processes.tasks import run_tasks
from ..settling.cached_runs import DropConfig
from .folder import RunFolder, is_running
from .ledger import Ledger, LedgerRow, RunConfig
from .task import SimulationTask, rows_to_record, settled_rows, source_stamps, valid_row

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
        """The files by their names in the ledger."""
        return {self.dataset.name_of(item.path): item.path for item in self.dataset.objects}

    def run_config(self, radius: float) -> RunConfig:
        """Return the run configuration of a radius, as the ledger describes it."""
        config, simulator = self.drop_config, self.drop_config.simulator
        settings = config.settings(radius) | {"version": simulator.version, "options": simulator.options()}
        settings["loading"] = config.loading.to_dict()
        del settings["radius"]
        text = json.dumps(settings, sort_keys=True, default=str)
        return RunConfig(backend=simulator.name, settings=text, radius=radius, seed=config.seed)


@dataclass(frozen=True, kw_only=True)
class ObjectLimits:
    """The limits of time and memory for one object."""

    seconds: float = math.inf  # for all radii together; then its process is stopped
    memory: int | None = None  # bytes of a worker process, including interpreter and libraries

    def __post_init__(self):
        if self.memory is not None and self.memory < LEAST_MEMORY:
            least = f"at least {LEAST_MEMORY >> 20} MiB, since interpreter and libraries take most of that"
            raise InputError(f"memory limit: expected {least}, got {self.memory >> 20} MiB")


@dataclass(frozen=True, kw_only=True)
class FinishedObject:
    """The result for one object."""

    name: str
    errors: tuple[str, ...] = ()  # why it could not be simulated, at all or at some radii
    skipped: bool = False  # whether it was finished before this call


def run_batch(
    batch: Batch,
    *,
    jobs: int = -1,
    limits: ObjectLimits | None = None,
    retry_failed: bool = False,
    work: Callable[[Sequence[SimulationTask]], Outcomes] | None = None,
) -> Iterator[FinishedObject]:
    """Simulate every object at every radius that is missing in the run, and keep every result.

    Parameters
    ----------
    jobs : int
        Worker processes on this machine; -1: one per core.
    retry_failed : bool
        Whether to try objects again that failed before and whose files have not changed.
    work : callable, optional
        Does tasks on other machines, and yields their index and outcome (`cluster.on_executor`).

    Yields
    ------
    FinishedObject
        First the objects that were finished before, then each object when it is finished.

    Raises
    ------
    InputError
        If the folder or its ledger cannot be used, or the disk is full. All finished objects are kept.
    """
    batch.folder.make()
    with batch.folder.ledger(make=True) as ledger:
        ledger.check()
        if is_running(ledger) is False:
            ledger.forget_waiting()
        about = {"host": socket.gethostname(), "process": os.getpid(), "data": one_line(batch.dataset.name)}
        ledger.begin_call({"jobs": jobs} | about)
        tasks, finished = left_to_do(batch, ledger, retry_failed)
        yield from finished
        work = work or (lambda tasks: on_this_machine(tasks, batch.folder, jobs, limits or ObjectLimits()))
        for index, outcome in work(tasks):  # a task without an outcome, as when a cluster is lost, stays waiting
            rows = rows_to_record(tasks[index], outcome, batch.folder)
            ledger.write(rows)
            yield finished_object(tasks[index].name, rows)
        ledger.end_call()
        batch.folder.sweep()


def on_this_machine(tasks: Sequence[SimulationTask], folder: RunFolder, jobs: int, limits: ObjectLimits) -> Outcomes:
    """Do tasks in worker processes of this machine, always isolated, so that a crash affects one object only."""
    arguments = [(task, folder) for task in tasks]
    limited = {"time_limit": limits.seconds, "memory_limit": limits.memory}
    return run_tasks(settled_rows, arguments, [task.path for task in tasks], jobs=jobs, isolate=True, **limited)


def left_to_do(batch: Batch, ledger: Ledger, retry_failed: bool) -> tuple[list[SimulationTask], list[FinishedObject]]:
    """Return tasks for the runs that are missing in the ledger, and the objects of which no run is missing."""
    objects = batch.objects
    ways = {ledger.number(batch.run_config(radius)): radius for radius in batch.drop_config.radii}
    ledger.expect(objects, tuple(ways))
    missing: dict[str, dict[int, float]] = {name: {} for name in objects}
    valid: dict[str, list[LedgerRow]] = {name: [] for name in objects}
    changed = []
    for row in ledger.rows(tuple(ways)):
        if row.object not in objects:
            continue  # it belongs to another data set or shard in the same folder
        now = valid_row(row, objects[row.object], batch.folder, batch.drop_config, retry_failed)
        if now is None:
            missing[row.object][row.way] = ways[row.way]
            now = LedgerRow(object=row.object, way=row.way)
        else:
            valid[row.object].append(now)
        changed += [now] if now != row else []
    ledger.write(changed)
    stamps = source_stamps(objects[name] for name in objects if missing[name])
    tasks = [
        SimulationTask(path=path, name=name, stamp=stamps[path], radii=missing[name], drop_config=batch.drop_config)
        for name, path in objects.items()
        if missing[name]
    ]
    done = [finished_object(name, valid[name], skipped=True) for name in objects if not missing[name]]
    return tasks, done


def known_failures(run: Path, dataset: Dataset, drop_config: DropConfig) -> dict[Path, InputError]:
    """Return the errors of objects, by path, that failed in a run and have not changed since.

    Raises
    ------
    InputError
        If there is no such run.
    """
    batch = Batch(dataset=dataset, drop_config=drop_config, folder=RunFolder(run))
    objects, failed = batch.objects, {}
    with batch.folder.ledger() as ledger:
        for row in ledger.failures([batch.run_config(radius) for radius in drop_config.radii]):
            path = objects.get(row.object)
            if path is not None and valid_row(row, path, batch.folder, drop_config, retry_failed=False):
                failed[path] = InputError(f"{row.error} (in {run}; `batch --retry-failed` tries again)")
    return failed


def finished_object(name: str, rows: Iterable[LedgerRow], skipped: bool = False) -> FinishedObject:
    """Return the result for an object from all its rows."""
    errors = tuple(dict.fromkeys(row.error for row in rows if row.error))
    return FinishedObject(name=name, errors=errors, skipped=skipped)
