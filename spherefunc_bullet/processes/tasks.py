"""Tasks in processes of their own: one that dies costs its task's result, and the others go on."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from ..errors import InputError, attempt, one_line

if TYPE_CHECKING:
    from .worker import Worker, WorkerTask


def run_tasks(
    function: Callable,
    tasks: Sequence[tuple],
    names: Sequence[object],
    *,
    jobs: int = 1,
    isolate: bool = False,
    time_limit: float = math.inf,
    memory_limit: int | None = None,
) -> Iterator[tuple[int, Any]]:
    """Call a function of a module's top level with each task's arguments, in worker processes if it has to be.

    A script that calls this does so under ``if __name__ == "__main__"``, as with all of `multiprocessing`.

    Parameters
    ----------
    tasks : sequence of tuple
        Arguments.
    names : sequence
        What errors of this module call each task, such as its file's path.
    jobs : int
        Processes that work at once; -1: one per core. One alone is this process, unless ``isolate`` or a limit
        asks for another.
    time_limit : float
        Seconds a task may take before its process is ended.
    memory_limit : int, optional
        Bytes that each process may have, interpreter and libraries included (Linux).

    Yields
    ------
    index, outcome : int, object or InputError
        In the order in which they are done; with one job in the order of the tasks. An InputError that the function
        raises is its outcome, and so is one for a task whose process died or took too long, twice: `Crashed`,
        `OutOfMemory` or `TimedOut`.

    Raises
    ------
    Exception
        Whatever else the function raises, with the worker's traceback as a note.
    """
    count = min(worker_count(jobs), len(tasks))
    if count <= 1 and not isolate and time_limit == math.inf and memory_limit is None:
        yield from ((index, attempt(function, task)) for index, task in enumerate(tasks))
        return
    from .worker import (  # not where this process alone works: a first answer waits for what that loads
        Worker,
        WorkerTask,
    )

    left = (WorkerTask(*named) for named in zip(range(len(tasks)), map(one_line, names), tasks, strict=True))
    workers = [Worker(function, time_limit, says=number == 0, memory_limit=memory_limit) for number in range(count)]
    try:
        yield from finish(workers, left)
    finally:
        for worker in workers:
            worker.end()


def worker_count(jobs: int) -> int:
    """Return how many processes work at once; below zero, all cores but ``-jobs - 1``."""
    if jobs == 0:
        raise InputError("jobs 0: expected at least 1, or -1 for one per core")
    if jobs > 0:
        return jobs
    from joblib import cpu_count  # knows a container's share of the machine

    return max(1, cpu_count() + 1 + jobs)


def finish(workers: Sequence[Worker], left: Iterator[WorkerTask]) -> Iterator[tuple[int, Any]]:
    """Hand out tasks until none is left, and yield their outcomes."""
    from multiprocessing.connection import wait

    for worker in workers:
        worker.begin(next(left))
    busy = set(workers)
    while busy:
        until = min(worker.deadline for worker in busy)
        timeout = None if until == math.inf else max(0.0, until - time.monotonic())
        wait([end for worker in busy for end in (worker.pipe, worker.process.sentinel)], timeout)
        for worker in list(busy):
            for outcome in worker.outcomes():
                done, following = worker.task, next(left, None)
                worker.begin(following) if following else busy.remove(worker)
                yield done.index, outcome
