"""A batch on other machines: on any `concurrent.futures.Executor`, such as that of a Dask cluster.

Only the caller accesses the folder of the run. An object is sent as the content of its files, or as a path that all
machines share; its settled spheres come back as files, and are kept as if they had been simulated here. In a worker of
the executor an object runs in a process of its own, so that a crash affects that object and not the worker.
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

IN_FLIGHT = 256  # tasks that an executor has at a time: enough for that many workers, and few enough to be sent
PATIENCE = 15.0  # seconds to find the scheduler


@dataclass(frozen=True, kw_only=True)
class TaskResult:
    """The result of a task: its rows or its error, and the files of all runs that were simulated."""

    outcome: list[LedgerRow] | InputError
    settled: dict[str, bytes]  # content of each file by run


def packed(task: SimulationTask, shared_path: bool) -> SimulationTask:
    """Return a task as it is sent: with the content of its files, or with a path that all machines share.

    Raises
    ------
    InputError
        If a file cannot be read or is too large.
    """
    if shared_path:
        return replace(task, path=task.path.resolve())
    source = as_source(task.path)
    for part in source.parts():
        part.data  # noqa: B018 - reads the file, whose content is then sent
    return replace(task, source=source)


def deliver(task: SimulationTask, limits: ObjectLimits) -> TaskResult:
    """Do a task in the process of this thread; called in a worker of the executor."""
    with TemporaryDirectory(prefix="spherefunc-") as scratch:
        folder = RunFolder(Path(scratch) / "run")
        folder.make()
        ((_, outcome),) = finish([resident(limits)], iter([WorkerTask(0, str(task.path), (task, folder))]))
        if isinstance(outcome, InputError):
            # A full disk of this worker is not that of the run.
            kind = Unexpected if isinstance(outcome, FullDisk) else type(outcome)
            outcome = kind(str(outcome).replace(str(task.path), task.name))
        entries = (folder.partial / KIND).rglob("*.npz")
        return TaskResult(outcome=outcome, settled={entry.stem: entry.read_bytes() for entry in entries})


def resident(limits: ObjectLimits) -> Worker:
    """Return the worker process of this thread, which is kept for the next task."""
    workers = _residents.__dict__.setdefault("workers", {})
    if limits not in workers:
        multiprocessing.current_process().daemon = False  # Dask's workers are daemons, which must not have children
        workers[limits] = Worker(settled_rows, limits.seconds, verbose=False, memory_limit=limits.memory)
    return workers[limits]


_residents = threading.local()


def on_executor(
    executor: Executor, folder: RunFolder, limits: ObjectLimits | None = None, *, shared_path: bool = False
) -> Callable[[Sequence[SimulationTask]], Outcomes]:
    """Return a function that does the tasks of a batch on an executor, for ``work`` of `batch.run_batch`.

    Parameters
    ----------
    executor : concurrent.futures.Executor
        Of threads, processes, or a cluster; this package must be installed where its workers run.
    folder : RunFolder
        Of the batch; accessed on this machine only.
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
    """Write the files of a finished task to the folder, and return its outcome."""
    try:
        result = future.result()
    except CancelledError as error:
        raise InputError("the cluster was lost; finished objects are kept, and the same command continues") from error
    except Exception as error:  # of the executor, as when its worker was lost repeatedly
        return Crashed(f"{task.path}: expected a result, but its worker was lost; {type(error).__name__}: {error}")
    for run, content in result.settled.items():
        folder.put(run, content)
    return result.outcome


@dataclass(frozen=True, kw_only=True)
class DaskExecutor(Executor):
    """The executor of a Dask client.

    The executor of ``Client.get_executor`` gathers a result before it checks the status of the task: if the worker with
    the result is lost in between, it mistakes the result for an error.
    """

    client: Client

    def submit(self, function: Callable, /, *arguments: Any) -> Future:
        """Return the future of a call on a worker; cancelling it cancels the call."""
        local, remote = Future(), self.client.submit(function, *arguments, pure=False)
        local.add_done_callback(lambda done: remote.cancel() if done.cancelled() else None)
        remote.add_done_callback(lambda done: pass_on(done, local))
        return local


def pass_on(remote: Any, local: Future):
    """Pass the result or the error of a Dask future on to another future, unless that was cancelled."""
    if local.set_running_or_notify_cancel():
        try:
            local.set_result(remote.result())
        except Exception as error:  # any error of the call, or its cancellation
            local.set_exception(error)


def within(seconds: float, call: Callable[[], Any]) -> Any:
    """Return the result of a call, or raise TimeoutError: Dask waits without end for a server that is no scheduler."""
    done = Future()

    def run():
        """Pass the result or the error on."""
        try:
            done.set_result(call())
        except BaseException as error:
            done.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    if not wait([done], seconds).done:
        raise TimeoutError(f"no answer within {seconds:g} s; is it the port of a dashboard?")
    return done.result()


@contextmanager
def on_scheduler(
    address: str, folder: RunFolder, limits: ObjectLimits, *, shared_path: bool = False
) -> Iterator[Callable[[Sequence[SimulationTask]], Outcomes]]:
    """Yield a function that does the tasks of a batch on a Dask cluster, whose workers may come and go.

    Raises
    ------
    InputError
        If `dask.distributed` is not installed, or no scheduler answers.
    """
    with explaining("--scheduler: expected dask.distributed; pip install 'spherefunc-bullet[cluster]'", ImportError):
        from distributed import Client
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what is lost is repeated, or one line here
    with explaining(f"--scheduler {address}: expected a Dask scheduler that answers", OSError, ValueError, why="; "):
        client = within(2 * PATIENCE, lambda: Client(address, timeout=PATIENCE))
    with client:
        yield on_executor(DaskExecutor(client=client), folder, limits, shared_path=shared_path)
