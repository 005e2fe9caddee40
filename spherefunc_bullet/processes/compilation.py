"""Compilation of kernels: compiled code is cached for the next process, and never reused for a changed source.

Numba caches compiled code next to its source, and recompiles a kernel when its own file has changed, but not when a
kernel that it calls, or a constant that it uses, has changed in another file. So the code of each file's kernels is
cached in a folder named by a hash of everything that it depends on; numba does the rest.
"""

from __future__ import annotations

import hashlib
import logging
import os
import shutil
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba import config
from numba.core import event

PACKAGE = __name__.partition(".")[0]
NUMBERS = (int, float, np.generic)
KEPT = "kernels"  # prefix of the names of folders with compiled code
logger = logging.getLogger("spherefunc")
_choosing = threading.Lock()  # numba has one setting for all threads


def njit(function: Callable | None = None, *, cache: bool = False, **options: Any) -> Any:
    """Return a kernel as numba's ``njit`` does; with ``cache``, its code is cached for the current sources only.

    Kernels release Python's lock: they write only to arrays that they are given, so threads run side by side. Where no
    folder for it can be written, the code is compiled again in each process.
    """
    if function is None:
        return partial(njit, cache=cache, **options)
    options = {"nogil": True, **options}
    if not cache:
        return numba.njit(**options)(function)
    with _choosing:
        users, config.CACHE_DIR = config.CACHE_DIR, str(folder_of(function.__module__))
        try:
            kernel = numba.njit(cache=True, **options)(function)
        except RuntimeError:
            say_uncached(Path(config.CACHE_DIR).parent)
            kernel = numba.njit(**options)(function)
        finally:
            config.CACHE_DIR = users
    load_alone(kernel)
    return kernel


@cache
def say_uncached(folder: Path):
    """Log once for each folder that compiled code cannot be kept in it."""
    logger.warning("compiled code cannot be kept in %s; set NUMBA_CACHE_DIR to a folder that can be written", folder)


# For kernels that allocate nothing: they need no reference counts, and a process that calls only such kernels does not
# load numba's runtime, which saves 20 ms of the first classification.
lean_njit = partial(njit, _nrt=False)


@cache
def folder_of(module: str) -> Path:
    """Return the folder of the compiled code of a module; folders of older sources next to the module are removed."""
    file = Path(sys.modules[module].__file__)
    local, name = file.parent / "__pycache__", f"{KEPT}-{file.stem}-{dependency_hash(module)[:16]}"
    for other in local.glob(f"{KEPT}-{file.stem}-*"):
        if other.name != name:
            shutil.rmtree(other, ignore_errors=True)
    return cache_folder(local) / name


def cache_folder(local: Path) -> Path:
    """Return $NUMBA_CACHE_DIR, or the folder next to a module, or the user's cache if that is not writable."""
    if config.CACHE_DIR:
        return Path(config.CACHE_DIR)
    if os.access(local if local.exists() else local.parent, os.W_OK):
        return local
    users = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return users / "spherefunc" / KEPT


@cache
def dependency_hash(module: str) -> str:
    """Return a hash of what a module's kernels depend on: this file, its own, kernels of other files, and numbers.

    Arrays are not included, since no kernel uses one from its module.
    """
    loaded = sys.modules[module]
    digest = hashlib.sha256(Path(__file__).read_bytes() + Path(loaded.__file__).read_bytes())
    for name, value in sorted(vars(loaded).items()):
        origin = getattr(value, "__module__", None) or ""
        if type(value).__module__.startswith("numba.") and origin != module and origin in sys.modules:
            digest.update(f"{name} {dependency_hash(origin)}".encode())
        elif is_constant(value):
            digest.update(f"{name} {value!r}".encode())
    return digest.hexdigest()


def is_constant(value: object) -> bool:
    """Return whether a value is a constant for numba: a number, or a tuple of numbers."""
    return isinstance(value, NUMBERS) or (isinstance(value, tuple) and all(map(is_constant, value)))


class Announcer(event.Listener):
    """Logs once per process that kernels of this package are compiled."""

    logged = False

    def on_start(self, event: event.Event):
        """Log a message before the first kernel is compiled."""
        ours = event.data["dispatcher"].__module__.partition(".")[0] == PACKAGE
        if ours and not self.logged:
            self.logged = True
            logger.info("compiling code for the first run on this machine: about 15 seconds ...")

    def on_end(self, event: event.Event):
        """Do nothing."""


event.register("numba:compile", Announcer())


def load_alone(kernel: Any):
    """Make a kernel load its cached code without numba's compiler, which saves a quarter of the time of a new process.

    Also make it work where there is no room to keep the code.

    This is the only place that uses numba's internals. If there is no cached code for the types of a call, numba loads
    its compiler then; with another version of numba this function may have no effect.
    """
    with suppress(ImportError, AttributeError):
        from numba.core.runtime import rtsys

        code = kernel._cache
        load, guarded, save = code._load_overload, code._guard_against_spurious_io_errors, code.save_overload

        def load_overload(signature: Any, context: Any) -> Any:
            """Return the cached code for a signature, or None."""
            if kernel.targetoptions.get("_nrt", True):
                rtsys.initialize(context)
            with guarded():
                return load(signature, context)
            return None

        def save_overload(signature: Any, data: Any):
            """Keep the code for a signature, or log that there is no room for it."""
            try:
                save(signature, data)
            except OSError:
                say_uncached(folder_of(kernel.py_func.__module__).parent)

        code.save_overload = save_overload
        code.load_overload = load_overload
