"""A batch on other machines: on any `concurrent.futures.Executor`, such as that of a Dask cluster.

Only the caller touches the run's folder. An object travels as its files' content, or by a path that all machines
share; what its worker settled comes back as files, and is kept as if it had been settled here. In the executor's
worker an object runs in a process of its own, so that a crash costs that object and not the worker.
"""

from __future__ import annotations

import logging
import multiprocessing
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from ..errors import Crashed, InputError, Unexpected, explaining
from ..formats.sources import as_source
from ..processes.tasks import finish
from ..processes.worker import Worker, WorkerTask
from .batch import ObjectLimits, Outcomes
from .folder import KIND, FullDisk, RunFolder
from .ledger import LedgerRow
from .task import SimulationTask, settled_rows

if TYPE_CHECKING:
    from distributed import Client

IN_FLIGHT = 256  # tasks given to an executor at once: enough for as many workers, little enough to be sent
PATIENCE = "15s"  # to find the scheduler


@dataclass(frozen=True, kw_only=True)
class TaskResult:
    """What comes back: rows or the reason why there are none, and the files of all radii that were settled."""

    outcome: list[LedgerRow] | InputError
    settled: dict[str, bytes]  # run -> file


def packed(task: SimulationTask, shared_path: bool) -> SimulationTask:
    """Return a task as it is sent: with the content of its files, unless all machines have them at the same path.

    Raises
    ------
    InputError
        If a file cannot be read or is too large.
    """
    if shared_path:
        return replace(task, path=task.path.resolve())
    source = as_source(task.path)
    for part in source.parts():
        part.data  # noqa: B018 - is kept, and travels
    return replace(task, source=source)


def deliver(task: SimulationTask, limits: ObjectLimits) -> TaskResult:
    """Do a task in a process of this thread's own; called where the executor's workers are."""
    with TemporaryDirectory(prefix="spherefunc-") as scratch:
        folder = RunFolder(Path(scratch) / "run")
        folder.make()
        ((_, outcome),) = finish([resident(limits)], iter([WorkerTask(0, str(task.path), (task, folder))]))
        if isinstance(outcome, InputError):
            kind = Unexpected if isinstance(outcome, FullDisk) else type(outcome)  # that disk is not the run's
            outcome = kind(str(outcome).replace(str(task.path), task.name))
        entries = (folder.partial / KIND).rglob("*.npz")
        return TaskResult(outcome=outcome, settled={entry.stem: entry.read_bytes() for entry in entries})


def resident(limits: ObjectLimits) -> Worker:
    """Return this thread's worker process, which stays for the next task."""
    workers = _residents.__dict__.setdefault("workers", {})
    if limits not in workers:
        multiprocessing.current_process().daemon = False  # Dask's workers are, and then may have no children
        workers[limits] = Worker(settled_rows, limits.seconds, verbose=False, memory_limit=limits.memory)
    return workers[limits]


_residents = threading.local()


def on_executor(
    executor: Executor, folder: RunFolder, limits: ObjectLimits | None = None, *, shared_path: bool = False
) -> Callable[[Sequence[SimulationTask]], Outcomes]:
    """Return what does a batch's tasks on an executor: the ``work`` of `batch.run_batch`.

    Parameters
    ----------
    executor : concurrent.futures.Executor
        Of threads, processes, or a cluster; its workers have this package.
    folder : RunFolder
        Of the batch; on this machine alone.
    shared_path : bool
        Whether the workers find the objects' files at the same path; else files are sent.
    """
    return lambda tasks: outcomes(executor, tasks, folder, limits or ObjectLimits(), shared_path)


def outcomes(
    executor: Executor, tasks: Sequence[SimulationTask], folder: RunFolder, limits: ObjectLimits, shared_path: bool
) -> Outcomes:
    """Yield the index and outcome of each task, as they are done."""
    left = iter(enumerate(tasks))
    running: dict[Future, int] = {}
    try:
        while True:
            for index, task in left:
                try:
                    running[executor.submit(deliver, packed(task, shared_path), limits)] = index
                except InputError as error:
                    yield index, error
                if len(running) >= IN_FLIGHT:
                    break
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                index = running.pop(future)
                yield index, received(future, tasks[index], folder)
    finally:
        for future in running:
            future.cancel()


def received(future: Future, task: SimulationTask, folder: RunFolder) -> list[LedgerRow] | InputError:
    """Return the outcome of a task that is done, its files put into the folder."""
    try:
        delivery = future.result()
    except CancelledError as error:
        raise InputError("the cluster is lost: its scheduler is gone; what is done is kept, begin again") from error
    except Exception as error:  # of the executor: its worker was lost again and again, say
        return Crashed(f"{task.path}: expected a result, but its worker was lost; {type(error).__name__}: {error}")
    for run, content in delivery.settled.items():
        folder.put_bytes(run, content)
    return delivery.outcome


@dataclass(frozen=True, kw_only=True)
class DaskExecutor(Executor):
    """The executor of a Dask client.

    That of ``Client.get_executor`` gathers a result and looks at the task's status after that: if the worker that held
    the result is lost in between, it takes the result for an error that it cannot unpack.
    """

    client: Client

    def submit(self, function: Callable, /, *arguments: Any) -> Future:
        """Return the future of a call on some worker; cancelling it cancels the call."""
        local, remote = Future(), self.client.submit(function, *arguments, pure=False)
        local.add_done_callback(lambda done: remote.cancel() if done.cancelled() else None)
        remote.add_done_callback(lambda done: pass_on(done, local))
        return local


def pass_on(remote: Any, local: Future):
    """Give what came of a Dask future to another one, unless nobody wants it any more."""
    if local.set_running_or_notify_cancel():
        try:
            local.set_result(remote.result())
        except Exception as error:  # whatever the call raised, or that it was cancelled: for who asks
            local.set_exception(error)


@contextmanager
def on_scheduler(
    address: str, folder: RunFolder, limits: ObjectLimits, *, shared_path: bool = False
) -> Iterator[Callable[[Sequence[SimulationTask]], Outcomes]]:
    """Give what does a batch's tasks on a Dask cluster, whose workers may come and go.

    Raises
    ------
    InputError
        If `dask.distributed` is not installed, or no scheduler answers.
    """
    with explaining("--scheduler: expected dask.distributed; pip install 'spherefunc-bullet[cluster]'", ImportError):
        from distributed import Client
    logging.getLogger("distributed.client").setLevel(logging.ERROR)  # a lost worker's task is done again, unasked
    with explaining(f"--scheduler {address}: expected a Dask scheduler that answers", OSError, ValueError, why="; "):
        client = Client(address, timeout=PATIENCE)
    with client:
        yield on_executor(DaskExecutor(client=client), folder, limits, shared_path=shared_path)
