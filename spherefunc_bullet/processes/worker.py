"""Worker processes, which may die at any time, and their control by the parent.

Every worker has its own pipe, so that one that dies while it sends a result does not damage the results of others.
"""

from __future__ import annotations

import logging
import math
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from pathlib import Path

from ..console import log_on_stderr
from ..errors import Crashed, InputError, OutOfMemory, TimedOut, attempt

PRELOADED = ["spherefunc_bullet.settling.records", "spherefunc_bullet.commands.command_line"]
FIRST_TO_GO = Path("/proc/self/oom_score_adj")  # Linux
OUT_OF_MEMORY = 77  # exit code of a worker whose allocation failed
NATIVE_DEATHS = (-signal.SIGABRT, -signal.SIGSEGV, -signal.SIGBUS)  # native code may also die of a failed allocation
PATIENCE = 5.0  # seconds that a process has to end after its pipe was closed
LIBRARIES = ("OMP_NUM", "OPENBLAS_NUM", "MKL_NUM", "BLIS_NUM", "NUMBA_NUM", "VECLIB_MAXIMUM")
ONE_THREAD = {f"{library}_THREADS": "1" for library in LIBRARIES}  # so that n workers use n cores


def start_process(
    function: Callable, level: int | None, memory_limit: int | None = None
) -> tuple[multiprocessing.Process, Connection]:
    """Start a process that serves a function; first it sends that it is ready.

    Parameters
    ----------
    level : int or None
        Lowest level that it logs on stderr; None: Python's default, warnings.
    memory_limit : int or None
        Its memory in bytes.
    """
    ours, theirs = context().Pipe()
    arguments = (theirs, function, dict(os.environ) | ONE_THREAD, os.getcwd(), level, memory_limit)
    process = context().Process(target=serve, args=arguments, daemon=True)
    with _starting, environment_of_server(), without_ctrl_c():
        process.start()
    theirs.close()
    return process, ours


_starting = threading.Lock()  # the environment, which is changed temporarily, is shared by all threads


@cache
def context():
    """Return the context that starts processes: from a server without threads, since forking this process may deadlock.

    The server lives as long as this process and has imported what every worker needs.
    """
    forking = "forkserver" in multiprocessing.get_all_start_methods()
    chosen = multiprocessing.get_context("forkserver" if forking else "spawn")
    chosen.set_forkserver_preload(PRELOADED)
    return chosen


@contextmanager
def environment_of_server() -> Iterator[None]:
    """Make the server load its libraries with one thread each, and from the same paths as this process.

    By default Python would search the current folder first, whatever it contains.
    """
    wanted = ONE_THREAD if {"", os.getcwd()} & set(sys.path) else ONE_THREAD | {"PYTHONSAFEPATH": "1"}
    before = {name: os.environ[name] for name in wanted if name in os.environ}
    os.environ.update(wanted)
    try:
        yield
    finally:
        for name in wanted:
            os.environ.pop(name)
        os.environ.update(before)


@contextmanager
def without_ctrl_c() -> Iterator[None]:
    """Let Ctrl-C wait until a process is started, which inherits that: the parent handles Ctrl-C and ends it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # to start it later would let Ctrl-C through
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def serve(
    pipe: Connection,
    function: Callable,
    environment: dict[str, str],
    folder: str,
    level: int | None,
    memory_limit: int | None,
):
    """Do one task after another until the parent is gone, in its environment and folder."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles Ctrl-C and ends its workers
    threading.Thread(target=end_with_parent, daemon=True).start()
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # output of C libraries would corrupt the parent's JSON
    if level is not None:
        log_on_stderr(level)
    cap_memory(memory_limit)
    with suppress(EOFError, ConnectionError):
        pipe.send("ready")
        while True:
            pipe.send_bytes(answer(function, pipe.recv_bytes()))


def end_with_parent():
    """End this process when the parent ends, for whatever reason."""
    multiprocessing.parent_process().join()
    os._exit(1)


def answer(function: Callable, task: bytes) -> bytes:
    """Return, pickled, the outcome of a pickled task with its name; see `run_tasks`."""
    name, arguments = pickle.loads(task)
    try:  # a result that cannot be pickled is an error of the function too
        outcome = attempt(lambda: pickle.dumps(function(*arguments), pickle.HIGHEST_PROTOCOL), (), name)
    except MemoryError:
        os._exit(OUT_OF_MEMORY)  # a new process may get more
    return outcome if isinstance(outcome, bytes) else pickle.dumps(outcome)


@dataclass(frozen=True)
class WorkerTask:
    """A task of a worker."""

    index: int
    name: str  # starts its error messages
    arguments: tuple


class Worker:
    """A process that does one task at a time, and is replaced when it dies.

    One of several workers logs progress, the others only problems.
    """

    def __init__(self, function: Callable, time_limit: float, verbose: bool, memory_limit: int | None = None):
        logger = logging.getLogger("spherefunc")
        self.function, self.time_limit, self.memory_limit = function, time_limit, memory_limit
        self.level = logger.level if verbose and logger.handlers else None
        self.process = None

    def begin(self, task: WorkerTask, again: bool = False):
        """Start a task, perhaps for the second time, and a process if there is none."""
        self.task, self.again = task, again
        if self.process is None:
            self.ready, self.deadline = False, math.inf
            self.process, self.pipe = start_process(self.function, self.level, self.memory_limit)
        else:
            self.send()

    def send(self):
        """Send the task to the process, which is ready for it."""
        self.deadline = time.monotonic() + self.time_limit
        with suppress(ConnectionError):  # the process has died, which its sentinel will show
            self.pipe.send((self.task.name, self.task.arguments))

    def outcomes(self) -> list:
        """Return the outcome of the task in a list, which is empty until there is one."""
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
        """Receive a message of the process: that it is ready, or an outcome."""
        try:
            outcome = self.pipe.recv()
        except (EOFError, OSError):
            return self.retry_lost()
        if not self.ready:
            self.ready = True
            self.send()
            return []
        return [outcome]

    def retry_lost(self) -> list:
        """Retry the task of a process that died once, since memory may have been short."""
        code = self.end(PATIENCE)
        if not self.ready and code >= 0:
            raise RuntimeError(f"a worker process could not start (exit code {code}), for the reason that it printed")
        return self.retry_or(lost_task_error(self.task.name, code, self.memory_limit))

    def retry_or(self, error: InputError) -> list:
        """Start the task again in a new process; the second time, the error is its outcome."""
        if self.again:
            return [error]
        self.begin(self.task, again=True)
        return []

    def end(self, patience: float = 0.0) -> int:
        """End the process, which gets some seconds to end by itself, and return its exit code."""
        if self.process is None:
            return 0
        self.pipe.close()
        self.process.join(patience)
        self.process.kill()
        self.process.join()
        code, self.process = self.process.exitcode, None
        return code


def lost_task_error(name: str, code: int, memory_limit: int | None) -> InputError:
    """Return the error of a task whose process ended twice, with an exit code."""
    limit = "" if memory_limit is None else f" than the {memory_limit >> 20} MiB that a worker may have"
    if code == OUT_OF_MEMORY:
        return OutOfMemory(f"{name}: expected to need no more memory{limit or ' than there is'}; ended twice")
    hint = f"; it may have needed more memory{limit}" if limit and code in NATIVE_DEATHS else ""
    kind = OutOfMemory if code == -signal.SIGKILL else Crashed
    return kind(f"{name}: expected a result, but its process ended twice, {cause(code)}{hint}")


def cause(code: int) -> str:
    """Return a description of why a process ended.

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


def cap_memory(limit: int | None):
    """Limit the memory of this process, in bytes, on Linux.

    Also without a limit, a system that runs out of memory kills this process before its parent.
    """
    with suppress(OSError):
        FIRST_TO_GO.write_text("1000", encoding="ascii")
    if limit is not None:
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
