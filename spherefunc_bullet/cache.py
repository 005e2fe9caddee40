"""The cache: arrays kept by the hash of what produced them, in the user's cache folder."""

from __future__ import annotations

import io
import os
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np


def cache_home() -> Path:
    """Return the folder for what can be computed again: $SPHEREFUNC_CACHE, or the user's cache folder."""
    given = os.environ.get("SPHEREFUNC_CACHE")
    users = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return Path(given) if given else users / "spherefunc"


def entry_path(kind: str, name: str) -> Path:
    """Return where a cache entry lies."""
    return cache_home() / kind / name[:2] / f"{name}.npz"


def read_entry(path: Path) -> dict[str, np.ndarray] | None:
    """Return a cache entry's arrays, or None where there is none that is whole."""
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile):
        return None  # absent, or cut short by an earlier crash: computed again


def write_entry(path: Path, arrays: dict[str, np.ndarray]):
    """Write a cache entry under a name of its own first, so that nobody ever reads half of it."""
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    scratch = path.with_suffix(f".{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch.write_bytes(buffer.getvalue())
        os.replace(scratch, path)
    except OSError:
        with suppress(OSError):  # a full or read-only disk costs the cache, not the run
            scratch.unlink(missing_ok=True)
