"""NPZ and NPY: a mesh or cloud as arrays ``points``, or ``vertices`` and ``faces``, or the only array of shape (N, 3).

Also the cache: arrays are stored under the hash of everything that decides them, in the user's cache or a run folder.
"""

from __future__ import annotations

import io
import math
import signal
import threading
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

import numpy as np

from . import FormatError
from .files import cache_home, require_counts, require_members, require_unpacked, write_whole
from .sources import Geometry, Source

# What reading a damaged archive raises; a single array instead of an archive raises TypeError.
DAMAGE = (OSError, ValueError, KeyError, EOFError, TypeError, MemoryError, NotImplementedError, RuntimeError)
DAMAGE += (zipfile.BadZipFile, zlib.error)


def _read_header(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype]:
    """Return the shape and type that an NPY file declares."""
    is_first_version = np.lib.format.read_magic(file) == (1, 0)
    read = np.lib.format.read_array_header_1_0 if is_first_version else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(file)
    return shape, dtype


def _shape(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> tuple[int, ...] | None:
    """Return the shape of a member from its header; None if it is not an array of real numbers."""
    with archive.open(member) as file:
        shape, dtype = _read_header(file)
        begin = file.tell()
    if dtype.kind not in "fiu":
        return None
    size = math.prod(shape) * dtype.itemsize
    require_unpacked(size)
    if begin + size != member.file_size:
        raise FormatError(f"expected '{member.filename}' as long as its shape {shape}, it is not; is it damaged?")
    return shape


def _load(archive: zipfile.ZipFile, name: str, kinds: str, wanted: str) -> np.ndarray:
    """Return an array of shape (N, 3) whose dtype is of one of the given kinds."""
    with archive.open(f"{name}.npy") as file:
        shape, dtype = _read_header(file)
    if dtype.kind not in kinds or len(shape) != 2 or shape[1] != 3:
        raise FormatError(f"expected '{name}' as {wanted}, got {dtype} of shape {shape}")
    require_counts(**{"triangles" if kinds == "iu" else "vertices": shape[0]})
    return np.load(io.BytesIO(archive.read(f"{name}.npy")), allow_pickle=False)


def _points_name(shapes: dict[str, tuple[int, ...] | None]) -> str:
    """Return the name of the array that contains the points."""
    names = [name for name in ("points", "vertices") if name in shapes][:1]
    names = names or [name for name, shape in shapes.items() if shape and len(shape) == 2 and shape[1] == 3]
    if len(names) != 1:
        others = ", ".join(sorted(shapes)[:8]) or "none"
        raise FormatError(f"expected an array named points or vertices, or one of shape (N, 3), got {others}")
    return names[0]


def read_npz(source: Source) -> Geometry:
    """Return the vertices (N, 3) and triangles (M, 3); a cloud has no triangles."""
    with zipfile.ZipFile(io.BytesIO(source.data)) as archive:
        require_members(archive)
        members = [member for member in archive.infolist() if member.filename.endswith(".npy")]
        shapes = {member.filename.removesuffix(".npy"): _shape(archive, member) for member in members}
        name = _points_name(shapes)
        vertices = _load(archive, name, "fiu", "real numbers (N, 3)")
        if name != "vertices" or "faces" not in shapes:
            return Geometry(vertices)
        return Geometry(vertices, _load(archive, "faces", "iu", "integers (M, 3)"))


def read_npy(source: Source) -> Geometry:
    """Return the points (N, 3)."""
    data = source.data
    file = io.BytesIO(data)
    shape, dtype = _read_header(file)
    if dtype.kind not in "fiu" or len(shape) != 2 or shape[1] != 3:
        raise FormatError(f"expected points as real numbers (N, 3), got {dtype} of shape {shape}")
    require_counts(points=shape[0])
    if file.tell() + shape[0] * 3 * dtype.itemsize != len(data):
        raise FormatError(f"expected a file as long as its shape {shape}, it is not; is it damaged?")
    return Geometry(np.load(io.BytesIO(data), allow_pickle=False))


class Archive(Mapping[str, np.ndarray]):
    """The arrays of an archive by name, each unpacked on every access; pickled objects are refused.

    Raises
    ------
    one of DAMAGE
        If it is not an archive, or unpacks to more than `files.MAX_UNPACKED_BYTES`; on access, if an array is damaged.
    """

    def __init__(self, data: bytes):
        self.data = data
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            require_members(archive)
        self.arrays = np.load(io.BytesIO(data), allow_pickle=False)

    def __getitem__(self, name: str) -> np.ndarray:
        return self.arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays.files)

    def __len__(self) -> int:
        return len(self.arrays.files)

    def __contains__(self, name: object) -> bool:
        return name in self.arrays.files

    def __reduce__(self):
        return Archive, (self.data,)


def entry_path(kind: str, name: str, home: Path | None = None) -> Path:
    """Return the path of an entry in a folder, by default the cache."""
    return (home or cache_home()) / kind / name[:2] / f"{name}.npz"


def read_entry(path: Path, names: Sequence[str] | None = None) -> dict[str, np.ndarray] | None:
    """Return the arrays of an entry, all or the named ones; None if it is missing or damaged."""
    try:
        archive = Archive(path.read_bytes())
        return {name: archive[name] for name in names or archive}
    except DAMAGE:
        return None  # damaged entries, such as by an earlier crash, are computed again


def write_entry(path: Path, arrays: dict[str, np.ndarray]):
    """Write an entry if possible; with a full or read-only disk the run goes on without the cache."""
    with suppress(OSError):
        write_whole(path, packed(arrays))


def packed(arrays: dict[str, np.ndarray]) -> bytes:
    """Return arrays as a compressed NPZ file; the same arrays give the same bytes.

    The compression level is 1, which numpy does not offer: a fifth of the time of the default level, and no larger.
    """
    buffer = io.BytesIO()
    with uninterrupted(), zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, np.asanyarray(array), allow_pickle=False)
    return buffer.getvalue()


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Let Ctrl-C wait for the end of the block: zipfile cannot close an archive whose writing was interrupted."""
    handler, waiting = signal.getsignal(signal.SIGINT), []
    if handler is None or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, lambda *came: waiting.append(came))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
    if waiting:
        signal.raise_signal(signal.SIGINT)


def cached_check(content: str, name: str, check: Callable[[], bool], home: Path | None = None) -> bool:
    """Return the result of ``check`` for the object with this hash, cached under a name."""
    entry = entry_path(name, content, home)
    return bool(computed_once(entry, lambda: {"result": np.array(check())}, ["result"])["result"])


def computed_once(
    entry: Path, compute: Callable[[], dict[str, np.ndarray]], names: Sequence[str] | None = None
) -> dict[str, np.ndarray]:
    """Return the arrays of a cache entry, all or the named ones; a missing entry is computed and written."""
    arrays = read_entry(entry, names)
    if arrays is None:
        arrays = compute()
        write_entry(entry, arrays)
    return arrays
