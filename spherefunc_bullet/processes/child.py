"""A worker process: where it comes from, and how it does its tasks."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from multiprocessing.connection import Connection

from ..console import log_on_stderr
from ..errors import attempt
from .memory import cap_memory

PRELOADED = ["spherefunc_bullet.settling.records", "spherefunc_bullet.commands.command_line"]
OUT_OF_MEMORY = 77  # exit code of a worker that was refused memory
LIBRARIES = ("OMP_NUM", "OPENBLAS_NUM", "MKL_NUM", "BLIS_NUM", "NUMBA_NUM", "VECLIB_MAXIMUM")
ONE_THREAD = {f"{library}_THREADS": "1" for library in LIBRARIES}  # so that n workers use n cores


def start_process(
    function: Callable, level: int | None, memory_limit: int | None = None
) -> tuple[multiprocessing.Process, Connection]:
    """Start a process that serves a function; it first sends that it is ready.

    Parameters
    ----------
    memory_limit : int or None
        Bytes that it may have.
    level : int or None
        From which on it logs on stderr; None: as Python does by default, warnings.
    """
    ours, theirs = context().Pipe()
    arguments = (theirs, function, dict(os.environ) | ONE_THREAD, os.getcwd(), level, memory_limit)
    process = context().Process(target=serve, args=arguments, daemon=True)
    with _starting, one_thread():
        process.start()
    theirs.close()
    return process, ours


_starting = threading.Lock()  # the environment, changed for a moment, is one for all threads


@cache
def context():
    """Return how processes start: from a server without threads, since a fork of this one could come to a standstill.

    The server lives as long as this process and has loaded what every worker needs.
    """
    forking = "forkserver" in multiprocessing.get_all_start_methods()
    chosen = multiprocessing.get_context("forkserver" if forking else "spawn")
    chosen.set_forkserver_preload(PRELOADED)
    return chosen


@contextmanager
def one_thread() -> Iterator[None]:
    """Have the server load its libraries for one thread each."""
    before = {name: os.environ[name] for name in ONE_THREAD if name in os.environ}
    os.environ.update(ONE_THREAD)
    try:
        yield
    finally:
        for name in ONE_THREAD:
            os.environ.pop(name)
        os.environ.update(before)


def serve(
    pipe: Connection,
    function: Callable,
    environment: dict[str, str],
    folder: str,
    level: int | None,
    memory_limit: int | None,
):
    """Do one task after another until the parent is gone, in its environment and folder."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to the parent, which ends its workers
    threading.Thread(target=end_with_parent, daemon=True).start()
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what C libraries print would spoil the parent's JSON
    if level is not None:
        log_on_stderr(level)
    cap_memory(memory_limit)
    with suppress(EOFError, ConnectionError):
        pipe.send("ready")
        while True:
            pipe.send_bytes(answer(function, pipe.recv_bytes()))


def end_with_parent():
    """End this process when the parent does, however that comes."""
    multiprocessing.parent_process().join()
    os._exit(1)


def answer(function: Callable, task: bytes) -> bytes:
    """Return the outcome of a pickled task and None, or None and the error, pickled."""
    try:
        return pickle.dumps((attempt(function, pickle.loads(task)), None), pickle.HIGHEST_PROTOCOL)
    except MemoryError:
        os._exit(OUT_OF_MEMORY)  # a fresh process may have more
    except BaseException as error:
        error.add_note(f"in a worker process:\n{traceback.format_exc()}")
        return pickle.dumps((None, portable(error)))


def portable(error: BaseException) -> Exception:
    """Return an error, or one of the same text where it can't be sent or would end the process that gets it."""
    with suppress(Exception):
        pickle.loads(pickle.dumps(error))
        if isinstance(error, Exception):
            return error
    return RuntimeError("\n".join([repr(error), *error.__notes__]))
