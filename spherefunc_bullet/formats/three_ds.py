"""3DS, read by assimp after a check that its chunks fit into each other."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from . import FormatError
from .sources import Geometry, Source, joined_meshes

_MAIN, _OBJECT, _MESH, _VERTICES, _FACES = 0x4D4D, 0x4000, 0x4100, 0x4110, 0x4120
_CONTAINERS = (_MAIN, 0x3D3D, _OBJECT)  # file, editor, object
_DAMAGED = "expected 3DS chunks that fit into each other, got {}; is the file cut off or damaged?"


def _word(data: bytes, position: int) -> int:
    return int.from_bytes(data[position : position + 2], "little")


def _chunks(data: bytes, start: int, end: int) -> Iterator[tuple[int, int, int]]:
    """Yield the identifier, start and end of each chunk between two positions, or raise FormatError."""
    while start < end:
        size = int.from_bytes(data[start + 2 : start + 6], "little")
        if size < 6 or start + size > end:
            raise FormatError(_DAMAGED.format(f"one of {size} bytes where {end - start} are left"))
        yield _word(data, start), start + 6, start + size
        start += size


def _require_list(data: bytes, item_size: int, start: int, end: int) -> int:
    """Return the number of items in a list, or raise FormatError if it declares more than its chunk holds."""
    count = _word(data, start)
    if start + 2 + count * item_size > end:
        raise FormatError(_DAMAGED.format(f"a list of {count} in {end - start} bytes"))
    return count


def _require_mesh(data: bytes, start: int, end: int) -> None:
    """Raise FormatError unless the lists of a mesh fit and its faces refer to vertices that exist."""
    vertex_count, corners = 0, np.empty(0)
    for identifier, begin, stop in _chunks(data, start, end):
        if identifier == _VERTICES:
            vertex_count = _require_list(data, 12, begin, stop)
        elif identifier == _FACES:
            count = _require_list(data, 8, begin, stop)
            corners = np.frombuffer(data, "<u2", 4 * count, begin + 2).reshape(-1, 4)[:, :3]
    if corners.size and corners.max() >= vertex_count:
        raise FormatError(f"expected faces of its {vertex_count} vertices, got number {corners.max()}; is it damaged?")


def _require_chunks(data: bytes, start: int, end: int) -> None:
    """Raise FormatError unless the chunks between two positions fit, and so do the chunks inside them."""
    for identifier, begin, stop in _chunks(data, start, end):
        if identifier == _OBJECT:  # starts with its name and a zero
            begin = data.find(b"\0", begin, stop) + 1 or stop
        if identifier == _MESH:
            _require_mesh(data, begin, stop)
        elif identifier in _CONTAINERS:
            _require_chunks(data, begin, stop)


def read_3ds(source: Source) -> Geometry:
    """Return the vertices (N, 3) and triangles (M, 3) of all objects in the file's own axes."""
    import assimp_py

    data = source.data
    if _word(data, 0) != _MAIN:
        raise FormatError("expected a 3DS file, which begins with 'MM', found another; is it a 3DS file?")
    _require_chunks(data, 0, len(data))
    flags = assimp_py.Process_Triangulate | assimp_py.Process_PreTransformVertices
    with TemporaryDirectory() as folder:  # assimp reads from a path only; it gets the bytes that were checked
        (Path(folder) / "object.3ds").write_bytes(data)
        meshes = assimp_py.import_file(f"{folder}/object.3ds", flags).meshes
    parts = [(np.array(mesh.vertices, np.float64), np.array(mesh.indices, np.int64)) for mesh in meshes]
    vertices, faces = joined_meshes([(points.reshape(-1, 3), faces.reshape(-1, 3)) for points, faces in parts])
    x, z, y = vertices.T  # assimp rotates 3DS, which is z up, to y up
    return Geometry(np.column_stack([x, -y, z]), faces)
