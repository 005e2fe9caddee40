"""Tasks in worker processes: if one dies, only the result of its task is lost."""

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
    """Call a function, defined at the top level of a module, with the arguments of each task, in workers if necessary.

    A script must call this under ``if __name__ == "__main__"``, as with all of `multiprocessing`.

    Parameters
    ----------
    tasks : sequence of tuple
        Arguments.
    names : sequence
        The name of each task in the errors of this module, such as the path of its file.
    jobs : int
        Number of parallel processes; -1: one per core. With 1, this process does the work, unless ``isolate`` or a
        limit requires another one.
    time_limit : float
        Seconds that a task may take before its process is killed.
    memory_limit : int, optional
        Memory of each process in bytes, including the interpreter and libraries (Linux).

    Yields
    ------
    index, outcome : int, object or InputError
        In the order of completion; with one job in the order of the tasks. An InputError that the function raises is an
        outcome, and so is the error of a task whose process died or took too long twice: `Crashed`, `OutOfMemory` or
        `TimedOut`. Any other exception becomes one too, `Unexpected`: a fault of this package costs one task.
    """
    count = min(worker_count(jobs), len(tasks))
    if count <= 1 and not isolate and time_limit == math.inf and memory_limit is None:
        named = enumerate(zip(tasks, map(one_line, names), strict=True))
        yield from ((index, attempt(function, task, name)) for index, (task, name) in named)
        return
    # Not imported if this process does the work, since loading it would delay the first classification.
    from .worker import Worker, WorkerTask

    left = (WorkerTask(*named) for named in zip(range(len(tasks)), map(one_line, names), tasks, strict=True))
    workers = [Worker(function, time_limit, verbose=number == 0, memory_limit=memory_limit) for number in range(count)]
    try:
        yield from finish(workers, left)
    finally:
        for worker in workers:
            worker.end()


def worker_count(jobs: int) -> int:
    """Return the number of parallel processes; for negative numbers, all cores except ``-jobs - 1``."""
    if jobs == 0:
        raise InputError("jobs 0: expected at least 1, or -1 for one per core")
    if jobs > 0:
        return jobs
    from joblib import cpu_count  # respects the limits of a container

    return max(1, cpu_count() + 1 + jobs)


def finish(workers: Sequence[Worker], left: Iterator[WorkerTask]) -> Iterator[tuple[int, Any]]:
    """Distribute tasks until none is left, and yield their outcomes."""
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
