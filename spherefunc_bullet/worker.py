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

from .errors import InputError
from .reading import one_line
from .serving import start_process

PATIENCE = 5.0  # seconds that a process has to be gone once its pipe is closed


class Worker:
    """A process that does one task at a time, and is replaced when it dies.

    One among several says what takes long (`logging`), the others only what goes wrong.
    """

    def __init__(self, function: Callable, time_limit: float, says: bool):
        logger = logging.getLogger("spherefunc")
        self.function, self.time_limit = function, time_limit
        self.level = logger.level if says and logger.handlers else None
        self.process = None

    def begin(self, index: int, task: tuple, again: bool = False):
        """Start a task, perhaps once more, and a process where there is none."""
        self.index, self.task, self.again = index, task, again
        if self.process is None:
            self.ready, self.deadline = False, math.inf
            self.process, self.pipe = start_process(self.function, self.level)
        else:
            self.send()

    def send(self):
        """Send the task to the process, which is ready for it."""
        self.deadline = time.monotonic() + self.time_limit
        with suppress(ConnectionError):  # the process has died, as its sentinel says
            self.pipe.send(self.task)

    def outcomes(self) -> list:
        """Return the outcome of the task in a list, which is empty as long as there is none."""
        if self.pipe.poll():
            return self.receive()
        if not self.process.is_alive():
            return self.mourn()
        if time.monotonic() > self.deadline:
            self.end()
            name = one_line(self.task[0])
            return [InputError(f"{name}: expected a result within {self.time_limit:g} s; stopped")]
        return []

    def receive(self) -> list:
        """Read what the process sent: that it is ready, an outcome, or an error that is ours."""
        try:
            answer = self.pipe.recv()
        except (EOFError, OSError):
            return self.mourn()
        if not self.ready:
            self.ready = True
            self.send()
            return []
        outcome, error = answer
        if error is not None:
            raise error
        return [outcome]

    def mourn(self) -> list:
        """Try the task of a process that died once more, since memory may have been short; then give it up."""
        code = self.end(PATIENCE)
        if not self.ready and code >= 0:
            raise RuntimeError(f"a worker process could not start (exit code {code}), for the reason that it printed")
        if not self.again:
            self.begin(self.index, self.task, again=True)
            return []
        return [InputError(f"{one_line(self.task[0])}: expected a result, but its process ended twice, {cause(code)}")]

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
    names = {each.value: each.name for each in signal.Signals}
    hint = "; is there enough memory?" if -code == signal.SIGKILL else ""
    return f"by {names.get(-code, f'signal {-code}')} ({signal.strsignal(-code)}){hint}"
