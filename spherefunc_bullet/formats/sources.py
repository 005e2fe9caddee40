"""Sources: all files that readers read are opened here, and hashed here as well.

A reader gets a source and opens no files itself. The files that a file names (the meshes of a URDF, the buffers of a
glTF) are sources too, so the hash that names a cache entry covers everything that was read.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from ..errors import InputError, one_line
from . import FormatError
from .files import MAX_FILE_BYTES, refusing, require_counts, require_file

# Formats whose files name other files; the module of their reader has a function `named_sources` that returns them.
NAMING = (".gltf", ".glb", ".urdf", ".sdf", ".xml", ".mjcf", ".usd", ".usda", ".usdc")
LFS = "Git LFS"  # files of a few lines that stand for others, which were not fetched
# First bytes by which a file with the wrong ending is recognised.
_SIGNATURES = {
    b"\x89PNG": "PNG", b"\xff\xd8\xff": "JPEG", b"GIF8": "GIF", b"%PDF": "PDF", b"\x1f\x8b": "gzip",
    b"PK\x03\x04": "NPZ, 3MF, USDZ or ZIP", b"ply\n": "PLY", b"ply\r": "PLY", b"glTF": "GLB", b"OFF\n": "OFF",
    b"# .PCD": "PCD", b"LASF": "LAS or LAZ", b"\x93NUMPY": "NPY", b"#usda ": "USD or USDA", b"PXR-USDC": "USD or USDC",
    b"version https://git-lfs": LFS,
}  # fmt: skip
BAGS = (".bag", ".db3", ".mcap")  # of ROS: scans, which `scenes.ros` reads
# The module in ``formats`` and its function for each ending; imported when the first such file is read.
READERS = {
    ".ply": ("ply", "read_ply"),
    ".pcd": ("points.pcd", "read_pcd"),
    ".obj": ("obj", "read_obj"),
    ".stl": ("stl", "read_stl"),
    ".3ds": ("three_ds", "read_3ds"),
    ".off": ("off", "read_off"),
    ".glb": ("scenes.gltf", "read_gltf"),
    ".gltf": ("scenes.gltf", "read_gltf"),
    ".dae": ("scenes.collada", "read_dae"),
    ".3mf": ("scenes.three_mf", "read_3mf"),
    ".urdf": ("scenes.urdf", "read_urdf"),
    ".sdf": ("scenes.sdf", "read_sdf"),
    ".xml": ("scenes.mjcf", "read_mjcf"),
    ".mjcf": ("scenes.mjcf", "read_mjcf"),
    ".usd": ("scenes.usd", "read_usd"),
    ".usda": ("scenes.usd", "read_usd"),
    ".usdc": ("scenes.usd", "read_usd"),
    ".usdz": ("scenes.usd", "read_usd"),
    ".xyz": ("points.xyz", "read_xyz"),
    ".csv": ("points.xyz", "read_xyz"),
    ".txt": ("points.xyz", "read_xyz"),
    ".las": ("points.las", "read_las"),
    ".laz": ("points.las", "read_las"),
    ".npz": ("npz", "read_npz"),
    ".npy": ("npz", "read_npy"),
}


@dataclass(frozen=True, eq=False)
class Source:
    """A file to be read: its bytes, which are read once, and the files that it names."""

    path: Path
    kind: str  # ending of the format as which it is read, in lower case; empty for plain bytes

    @cached_property
    def data(self) -> bytes:
        """The bytes; InputError if they cannot be read or are those of another format."""
        shown = one_line(self.path)
        require_file(self.path)
        try:
            data = self.path.read_bytes()
        except OSError as error:
            reason = error.strerror or str(error)
            raise InputError(f"{shown}: cannot be read: {reason}; check the path and its permissions") from error
        if not data:
            raise InputError(f"{shown}: expected a mesh or a cloud, got an empty file; was its download cut off?")
        if self.kind in READERS:  # a format that is not read may be any archive
            _require_own_signature(data, self.kind, one_line(self.path.name))
        return data

    @cached_property
    def named(self) -> dict[str, Source]:
        """The sources that the file names, by name; InputError if one is missing or may not be read."""
        if self.kind not in NAMING:
            return {}
        module, _ = READERS[self.kind]
        with refusing(self.path):
            named = importlib.import_module(f".{module}", __package__).named_sources(self)
            _require_total_size(self.path, named)
        return named

    def parts(self) -> Iterator[Source]:
        """Yield the source itself and, recursively, the sources that it names, in a fixed order."""
        yield self
        for name in sorted(self.named):
            yield from self.named[name].parts()

    def digests(self) -> Iterator[bytes]:
        """Yield bytes that identify the content: the hash of the file, then name and digests of each file it names."""
        yield hashlib.sha256(self.data).digest()
        for name in sorted(self.named):
            yield f"[{name!r}".encode()
            yield from self.named[name].digests()
            yield b"]"


def as_source(file: str | Path | Source) -> Source:
    """Return the source of a file, to be read as the format of its ending."""
    return file if isinstance(file, Source) else Source(Path(file), Path(file).suffix.lower())


def inside(place: Path, trees: Sequence[Path]) -> Path | None:
    """Return the path with all links resolved; None if there is no such file, or it is in none of the folders."""
    try:
        target = place.resolve()
    except (OSError, ValueError, RuntimeError):  # too long, a null byte, circular links
        return None
    return target if os.path.exists(target) and any(target.is_relative_to(tree) for tree in trees) else None


def _require_total_size(path: Path, named: dict[str, Source]) -> None:
    """Raise InputError for files that are not regular, or too large in total, without reading them."""
    files = {source.path for source in named.values()}
    for file in files:
        require_file(file)
    total = sum(file.stat().st_size for file in files)
    if total > MAX_FILE_BYTES:
        limit = f"expected at most {MAX_FILE_BYTES >> 20} MiB with the files that it names, got {total >> 20} MiB"
        raise InputError(f"{one_line(path.name)}: {limit}; simplify it")


def _require_own_signature(data: bytes, kind: str, name: str) -> None:
    """Raise InputError for a file whose first bytes belong to another format than its ending."""
    found = next((found for magic, found in _SIGNATURES.items() if data.startswith(magic)), None)
    expected = kind[1:].upper()
    is_binary_stl = expected == "STL" and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little")
    if found and expected not in found and not is_binary_stl:  # a binary STL may begin with any 80 bytes
        advice = "fetch it by git lfs pull" if found == LFS else "give it the ending of what it is"
        raise InputError(f"{name}: expected {expected}, got a {found} file; {advice}")


@dataclass(frozen=True, eq=False)
class Geometry:
    """A mesh or a cloud, in the file's own units and axes."""

    vertices: np.ndarray  # (N, 3) float64; in a cloud, NaN where the sensor measured nothing
    faces: np.ndarray = field(default_factory=lambda: np.empty((0, 3), np.int64))  # (M, 3) int64; empty for a cloud
    colors: np.ndarray | None = None  # (N, 3) uint8
    labels: np.ndarray | None = None  # (N,) int64

    def checked(self) -> Geometry:
        """Return the geometry as contiguous arrays, or raise FormatError if it is neither a mesh nor a cloud."""
        vertices = np.ascontiguousarray(self.vertices, dtype=np.float64)
        faces = np.ascontiguousarray(self.faces, dtype=np.int64)
        count = len(vertices)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or not count:
            raise FormatError(f"expected vertices or points, got {count}; is the file empty?")
        require_counts(vertices=count, triangles=len(faces))
        if len(faces):
            if faces.min() < 0 or faces.max() >= count:
                wrong = faces.min() if faces.min() < 0 else faces.max()
                raise FormatError(f"expected faces of its {count} vertices, got one of number {wrong}; is it damaged?")
            if broken := int((~np.isfinite(vertices)).any(axis=1).sum()):
                raise FormatError(f"expected finite vertices, got NaN or infinity in {broken} of {count}; repair it")
        return replace(self, vertices=vertices, faces=faces)


def joined_meshes(parts: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices (N, 3) and faces (M, 3) of several parts as one mesh."""
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    faces = [faces + start for (_, faces), start in zip(parts, starts[:-1], strict=True)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)


def fan_triangles(counts: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the triangles of polygons, each divided into a fan around its first corner (exact for convex polygons).

    Parameters
    ----------
    counts : (P,) int
        Number of corners of each polygon, at least 1; those with 1 or 2, which some programs write, have no surface.
    corners : (sum of counts,) int
        Vertex numbers of all polygons, one polygon after the other.

    Returns
    -------
    (M, 3) int64

    Examples
    --------
    >>> fan_triangles(np.array([3, 4]), np.array([0, 1, 2, 3, 4, 5, 6]))
    array([[0, 1, 2],
           [3, 4, 5],
           [3, 5, 6]])
    """
    counts, corners = np.asarray(counts, dtype=np.int64), np.asarray(corners, dtype=np.int64)
    if len(counts) and counts.min() < 1:
        raise FormatError(f"expected faces of 3 corners or more, got one of {counts.min()}; is it damaged?")
    fans = np.maximum(counts - 2, 0)
    first = np.repeat(np.cumsum(counts) - counts, fans)
    step = np.arange(len(first)) - np.repeat(np.cumsum(fans) - fans, fans)
    return np.column_stack([corners[first], corners[first + step + 1], corners[first + step + 2]]).reshape(-1, 3)


def read_geometry(file: str | Path | Source) -> Geometry:
    """Return the vertices and triangles of a file, or its points.

    Parameters
    ----------
    file : str, Path or Source
        PLY, PCD, OBJ, STL, 3DS, OFF, GLB, glTF, DAE, 3MF, URDF, SDF, MJCF (also XML), USD (also USDA, USDC, USDZ), XYZ,
        CSV, TXT, LAS, LAZ, NPZ or NPY, recognised by the ending. Polygons are divided into triangles; the parts of a
        scene become one object in the scene's frame.

    Returns
    -------
    Geometry
        In the file's own units and axes, except that DAE and USD, which state both, come in metres with z up, and 3MF,
        which states its unit, in metres; with the colours and labels of the vertices if a PLY or PCD file has them. The
        points of a cloud may be NaN where the sensor measured nothing; the vertices of a mesh are finite.

    Raises
    ------
    InputError
        If the file does not exist, is damaged or too large, or is not of the format of its ending.
    """
    source = as_source(file)
    if source.kind not in READERS and os.path.exists(source.path) and not os.path.isdir(source.path):
        endings, name = ", ".join(READERS), one_line(source.path)
        suffix = source.path.suffix
        hint = "of a bag, `spherefunc scene` reads the clouds" if suffix in BAGS else "convert it"
        raise InputError(f"{name}: expected one of {endings}, got '{suffix}'; {hint}")
    source.data  # noqa: B018 - a missing file is reported before a missing reader
    with refusing(source.path), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        module, name = READERS[source.kind]
        reader = getattr(importlib.import_module(f".{module}", __package__), name)
        return reader(source).checked()
