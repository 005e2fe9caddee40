"""Compiled kernels: kept for the next process, said when they are made, and never of an older source.

Numba keeps compiled code beside its source, and compiles anew when the kernel's own file has changed, but not when a
kernel that it calls, or a constant that it uses, has changed in another file. So the code of each file's kernels is
kept in a folder that is named for everything that they are made of, and numba does the rest.
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
KEPT = "kernels"  # begins the names of folders with compiled code
logger = logging.getLogger("spherefunc")
_choosing = threading.Lock()  # numba has one setting for all threads


def njit(function: Callable | None = None, *, cache: bool = False, **options: Any) -> Any:
    """Return what numba's own ``njit`` does; with ``cache``, its code is kept where only today's sources find it."""
    if function is None:
        return partial(njit, cache=cache, **options)
    if not cache:
        return numba.njit(**options)(function)
    with _choosing:
        users, config.CACHE_DIR = config.CACHE_DIR, str(folder_of(function.__module__))
        try:
            kernel = numba.njit(cache=True, **options)(function)
        finally:
            config.CACHE_DIR = users
    load_alone(kernel)
    return kernel


# Of kernels that are given all that they write into: nothing is to be counted, and a process that calls only such ones
# does without numba's runtime, 20 ms of a first answer.
lean_njit = partial(njit, _nrt=False)


@cache
def folder_of(module: str) -> Path:
    """Return where the code of a module's kernels is kept; beside the module that of older sources is removed."""
    file = Path(sys.modules[module].__file__)
    beside, name = file.parent / "__pycache__", f"{KEPT}-{file.stem}-{decided_by(module)[:16]}"
    for other in beside.glob(f"{KEPT}-{file.stem}-*"):
        if other.name != name:
            shutil.rmtree(other, ignore_errors=True)
    return home_of(beside) / name


def home_of(beside: Path) -> Path:
    """Return $NUMBA_CACHE_DIR, or the folder beside a module, or the user's where that may not be written."""
    if config.CACHE_DIR:
        return Path(config.CACHE_DIR)
    if os.access(beside if beside.exists() else beside.parent, os.W_OK):
        return beside
    users = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return users / "spherefunc" / KEPT


@cache
def decided_by(module: str) -> str:
    """Return a hash of what a module's kernels are made of: its file, kernels of other files, and numbers.

    Arrays are none of it, since no kernel takes one from its module.
    """
    loaded = sys.modules[module]
    digest = hashlib.sha256(Path(loaded.__file__).read_bytes())
    for name, value in sorted(vars(loaded).items()):
        origin = getattr(value, "__module__", None) or ""
        if type(value).__module__.startswith("numba.") and origin != module and origin in sys.modules:
            digest.update(f"{name} {decided_by(origin)}".encode())
        elif is_constant(value):
            digest.update(f"{name} {value!r}".encode())
    return digest.hexdigest()


def is_constant(value: object) -> bool:
    """Return whether numba takes a value for a number, or for a tuple of such."""
    return isinstance(value, NUMBERS) or (isinstance(value, tuple) and all(map(is_constant, value)))


class Announcer(event.Listener):
    """Says once in a process that kernels of this package are compiled."""

    said = False

    def on_start(self, event: event.Event):
        """Say so, before the first of them."""
        ours = event.data["dispatcher"].__module__.partition(".")[0] == PACKAGE
        if ours and not self.said:
            self.said = True
            logger.info("compiling what this machine has not run before, to be kept: some 15 seconds ...")

    def on_end(self, event: event.Event):
        """Do nothing."""


event.register("numba:compile", Announcer())


def load_alone(kernel: Any):
    """Let a kernel's kept code be loaded without all that numba needs to compile one, a quarter of a new process.

    This alone reaches into numba. Where there is no code for what the kernel is called with, numba loads that when it
    compiles; another version of numba may load what it wants.
    """
    with suppress(ImportError, AttributeError):
        from numba.core.runtime import rtsys

        code = kernel._cache
        load, guarded = code._load_overload, code._guard_against_spurious_io_errors

        def load_overload(signature: Any, context: Any) -> Any:
            """Return the kept code for a signature, or None."""
            if kernel.targetoptions.get("_nrt", True):
                rtsys.initialize(context)
            with guarded():
                return load(signature, context)
            return None

        code.load_overload = load_overload
