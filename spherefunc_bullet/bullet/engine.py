"""PyBullet, which may be missing and which talks on standard output."""

from __future__ import annotations

import os
from contextlib import contextmanager
from functools import cache
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from ..errors import InputError

LARGEST_KEPT = 2**25 - 2**13  # bytes
MISSING = (
    "backend 'bullet' needs PyBullet, which is not installed: pip install 'pybullet>=3.2.7' "
    "(ready-made for CPython up to 3.11 on Linux; for others pip builds it with a C++ compiler)"
)


def engine_version() -> str:
    """Return the version of the PyBullet that is installed.

    Raises
    ------
    InputError
        If there is none.
    """
    try:
        return version("pybullet")
    except PackageNotFoundError as error:
        raise InputError(MISSING) from error


@cache
def pybullet():
    """Return the PyBullet module; imported when it is first needed.

    Raises
    ------
    InputError
        If it is missing or broken.
    """
    engine_version()
    try:
        with quiet(1, 2):  # it says when it was built
            import pybullet
    except ImportError as error:
        raise InputError(f"backend 'bullet': PyBullet is installed but cannot be imported: {error}") from error
    keep_memory()
    return pybullet


def keep_memory():
    """Have the memory of one engine serve the next, instead of going back to the system and being fetched anew.

    The C library of Linux keeps blocks as large as the largest that was ever freed, up to 32 MiB, so that some engines
    later it would do so anyhow. The block below is never written to.
    """
    np.empty(LARGEST_KEPT, np.uint8)


@contextmanager
def quiet(*descriptors: int):
    """Keep what C code prints on file descriptors, by default standard output, out of ours."""
    descriptors = descriptors or (1,)
    saved, nowhere = [os.dup(descriptor) for descriptor in descriptors], os.open(os.devnull, os.O_WRONLY)
    try:
        for descriptor in descriptors:
            os.dup2(nowhere, descriptor)
        yield
    finally:
        for descriptor, original in zip(descriptors, saved, strict=True):
            os.dup2(original, descriptor)
            os.close(original)
        os.close(nowhere)
