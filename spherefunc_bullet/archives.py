"""NPZ archives of plain arrays: read without running what is in them, and never more than a stated size."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from typing import BinaryIO

import numpy as np

from .limits import require_members

# What reading a damaged archive raises; a bare array in place of an archive is a TypeError.
DAMAGE = (OSError, ValueError, KeyError, EOFError, TypeError, MemoryError, NotImplementedError, RuntimeError)
DAMAGE += (zipfile.BadZipFile, zlib.error)


def read_arrays(file: str | Path | BinaryIO) -> dict[str, np.ndarray]:
    """Return the arrays of an archive by name; pickled objects are refused.

    Raises
    ------
    one of DAMAGE
        If it is no archive, not whole, or unpacks to more than `limits.MAX_UNPACKED_BYTES`.
    """
    with zipfile.ZipFile(file) as archive:
        require_members(archive)
    if not isinstance(file, str | Path):
        file.seek(0)
    with np.load(file, allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}
