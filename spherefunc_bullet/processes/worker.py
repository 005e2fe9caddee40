"""One worker, as its parent sees it: a process that can die at any time.

Every worker has a pipe to itself, so that one that dies in the midst of an answer spoils nobody else's.
"""

from __future__ import annotations

import logging
import math
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from ..errors import Crashed, InputError, OutOfMemory, TimedOut
from .child import OUT_OF_MEMORY, start_process

NATIVE_DEATHS = (-signal.SIGABRT, -signal.SIGSEGV, -signal.SIGBUS)  # of native code that was refused memory, too
PATIENCE = 5.0  # seconds that a process has to be gone once its pipe is closed


@dataclass(frozen=True)
class Task:
    """What a worker is to do."""

    index: int
    name: str  # begins its errors
    arguments: tuple


class Worker:
    """A process that does one task at a time, and is replaced when it dies.

    One among several says what takes long (`logging`), the others only what goes wrong.
    """

    def __init__(self, function: Callable, time_limit: float, says: bool, memory_limit: int | None = None):
        logger = logging.getLogger("spherefunc")
        self.function, self.time_limit, self.memory_limit = function, time_limit, memory_limit
        self.level = logger.level if says and logger.handlers else None
        self.process = None

    def begin(self, task: Task, again: bool = False):
        """Start a task, perhaps once more, and a process where there is none."""
        self.task, self.again = task, again
        if self.process is None:
            self.ready, self.deadline = False, math.inf
            self.process, self.pipe = start_process(self.function, self.level, self.memory_limit)
        else:
            self.send()

    def send(self):
        """Send the task to the process, which is ready for it."""
        self.deadline = time.monotonic() + self.time_limit
        with suppress(ConnectionError):  # the process has died, as its sentinel says
            self.pipe.send(self.task.arguments)

    def outcomes(self) -> list:
        """Return the outcome of the task in a list, which is empty as long as there is none."""
        if self.pipe.poll():
            return self.receive()
        if not self.process.is_alive():
            return self.retry_lost()
        if time.monotonic() > self.deadline:
            self.end()
            late = f"expected a result within {self.time_limit:g} s; stopped twice"
            return self.retry_or(TimedOut(f"{self.task.name}: {late}"))
        return []

    def receive(self) -> list:
        """Read what the process sent: that it is ready, an outcome, or an error that is ours."""
        try:
            answer = self.pipe.recv()
        except (EOFError, OSError):
            return self.retry_lost()
        if not self.ready:
            self.ready = True
            self.send()
            return []
        outcome, error = answer
        if error is not None:
            raise error
        return [outcome]

    def retry_lost(self) -> list:
        """Try the task of a process that died once more, since memory may have been short; then give it up."""
        code = self.end(PATIENCE)
        if not self.ready and code >= 0:
            raise RuntimeError(f"a worker process could not start (exit code {code}), for the reason that it printed")
        return self.retry_or(loss(self.task.name, code, self.memory_limit))

    def retry_or(self, error: InputError) -> list:
        """Begin the task once more in a fresh process; the second time the error is its outcome."""
        if self.again:
            return [error]
        self.begin(self.task, again=True)
        return []

    def end(self, patience: float = 0.0) -> int:
        """End the process, which may be gone by itself within some seconds, and return its exit code."""
        if self.process is None:
            return 0
        self.pipe.close()
        self.process.join(patience)
        self.process.kill()
        self.process.join()
        code, self.process = self.process.exitcode, None
        return code


def loss(name: str, code: int, memory_limit: int | None) -> InputError:
    """Return the error of a task whose process ended with an exit code, twice."""
    limit = "" if memory_limit is None else f" than the {memory_limit >> 20} MiB that a worker may have"
    if code == OUT_OF_MEMORY:
        return OutOfMemory(f"{name}: expected to need no more memory{limit or ' than there is'}; ended twice")
    hint = f"; it may have needed more memory{limit}" if limit and code in NATIVE_DEATHS else ""
    kind = OutOfMemory if code == -signal.SIGKILL else Crashed
    return kind(f"{name}: expected a result, but its process ended twice, {cause(code)}{hint}")


def cause(code: int) -> str:
    """Say why a process ended.

    Examples
    --------
    >>> cause(3)
    'with exit code 3'
    >>> cause(-11)
    'by SIGSEGV (Segmentation fault)'
    """
    if code >= 0:
        return f"with exit code {code}"
    names = {number.value: number.name for number in signal.Signals}
    hint = "; is there enough memory?" if -code == signal.SIGKILL else ""
    return f"by {names.get(-code, f'signal {-code}')} ({signal.strsignal(-code)}){hint}"
