"""PyBullet, which may be missing and which says on stderr when it was built.

Its calls hold Python's lock, so engines in several threads take turns, and each is its own.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from ..errors import explaining

CLONE_FILES = 0x400  # of Linux's sched.h
CLOSE_RANGE_UNSHARE, NONE = 2, 2**32 - 1  # of its close_range.h, and where no descriptor is
LARGEST_KEPT = 2**25 - 2**13  # bytes
MISSING = (
    "backend 'bullet' needs PyBullet, which is not installed: pip install 'pybullet>=3.2.7' "
    "(ready-made for CPython up to 3.11 on Linux; for others pip builds it with a C++ compiler)"
)


@cache  # each look reads the package's metadata, and every run asks
def engine_version() -> str:
    """Return the version of the PyBullet that is installed.

    Raises
    ------
    InputError
        If there is none.
    """
    with explaining(MISSING, PackageNotFoundError):
        return version("pybullet")


@cache
def pybullet():
    """Return the PyBullet module; imported when it is first needed.

    Raises
    ------
    InputError
        If it is missing or broken.
    """
    engine_version()
    with explaining("backend 'bullet': PyBullet is installed but cannot be imported", ImportError, why=": "):
        with ThreadPoolExecutor(1) as apart:
            apart.submit(import_silently).result()
        import pybullet
    keep_memory()
    return pybullet


class Engine:
    """One engine in this process, in DIRECT mode; to be closed, best by ``with``."""

    def __init__(self, **parameters: float):
        p = pybullet()
        self.client = p.connect(p.DIRECT)
        self.engine = {"physicsClientId": self.client}
        p.setPhysicsEngineParameter(deterministicOverlappingPairs=1, **parameters, **self.engine)
        # The default visual shape would be tessellated for every body, and read from its file with a warning.
        self.visual = p.createVisualShape(p.GEOM_BOX, halfExtents=[0.01] * 3, **self.engine)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Give the engine back."""
        if self.client is not None:
            pybullet().disconnect(self.client)
            self.client = None


def import_silently():
    """Import PyBullet in a thread that is at its end then, so that nobody reads when it was built.

    Standard error is turned off for this thread alone, which Linux can do; elsewhere the line is seen once.
    """
    with suppress(OSError, AttributeError):
        own_descriptors()
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    import pybullet  # noqa: F401


def own_descriptors():
    """Give this thread file descriptors that are its own: what it does to them no other thread sees.

    Raises
    ------
    OSError, AttributeError
        If the system cannot.
    """
    import ctypes

    libc = ctypes.CDLL(None)
    # In containers the first is often forbidden; the second, of no descriptor at all, does the same.
    if libc.unshare(CLONE_FILES) and libc.close_range(ctypes.c_uint(NONE), ctypes.c_uint(NONE), CLOSE_RANGE_UNSHARE):
        raise OSError("descriptors stay those of the process")


def keep_memory():
    """Have the memory of one engine serve the next, instead of going back to the system and being fetched anew.

    The C library of Linux keeps blocks as large as the largest that was ever freed, up to 32 MiB, so that some engines
    later it would do so anyhow. The block below is never written to.
    """
    np.empty(LARGEST_KEPT, np.uint8)
