"""The cache: arrays kept by the hash of what produced them, in the user's cache folder or in a run's."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from ..formats.npz import DAMAGE, read_arrays
from ..formats.writing import cache_home, write_whole

_ANSWER = "told"  # what entries call the answer of a check


def entry_path(kind: str, name: str, home: Path | None = None) -> Path:
    """Return where an entry lies in a folder, by default the cache."""
    return (home or cache_home()) / kind / name[:2] / f"{name}.npz"


def read_entry(path: Path, names: Sequence[str] | None = None) -> dict[str, np.ndarray] | None:
    """Return an entry's arrays, all or those of some names, or None where there is none that is whole."""
    try:
        return read_arrays(path, names)
    except DAMAGE:
        return None  # absent, or cut short by an earlier crash: computed again


def write_entry(path: Path, arrays: dict[str, np.ndarray]):
    """Write an entry if that is possible: a full or read-only disk costs the cache, not the run."""
    with suppress(OSError):
        write_whole(path, packed(arrays))


def packed(arrays: dict[str, np.ndarray]) -> bytes:
    """Return arrays as a compressed NPZ file; the same arrays give the same bytes.

    At zlib's first level, which numpy does not offer: a fifth of the time of its usual one, and entries no larger.
    """
    buffer = io.BytesIO()
    try:
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            for name, array in arrays.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                    np.lib.format.write_array(file, np.asanyarray(array), allow_pickle=False)
    except ValueError as error:
        # Interrupted between two of its lines, zipfile cannot close its archive, and says that instead.
        if isinstance(error.__context__, KeyboardInterrupt):
            raise KeyboardInterrupt from None
        raise
    return buffer.getvalue()


def kept_answer(content: str, name: str, check: Callable[[], bool], home: Path | None = None) -> bool:
    """Return what ``check``, which is known by a name, says of the object with this hash."""
    return bool(computed_once(entry_path(name, content, home), lambda: {_ANSWER: np.array(check())})[_ANSWER])


def computed_once(
    entry: Path, compute: Callable[[], dict[str, np.ndarray]], names: Sequence[str] | None = None
) -> dict[str, np.ndarray]:
    """Return the arrays of an entry, all or those of some names; where there is none they are computed and kept."""
    arrays = read_entry(entry, names)
    if arrays is None:
        arrays = compute()
        write_entry(entry, arrays)
    return arrays
