"""3DS, read by assimp, once its chunks are known to fit into each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..orientation import turned_up
from . import FormatError

_MAIN, _OBJECT, _VERTICES, _FACES = 0x4D4D, 0x4000, 0x4110, 0x4120
_CONTAINERS = (_MAIN, 0x3D3D, _OBJECT, 0x4100)  # file, editor, object, triangle mesh
_DAMAGED = "expected 3DS chunks that fit into each other, got {}; is the file cut off or damaged?"


def _word(data: bytes, position: int) -> int:
    return int.from_bytes(data[position : position + 2], "little")


def _require_list(data: bytes, identifier: int, start: int, end: int) -> None:
    """Raise FormatError if a list of vertices or faces declares more than its chunk holds."""
    item = 12 if identifier == _VERTICES else 8
    if start + 2 + _word(data, start) * item > end:
        raise FormatError(_DAMAGED.format(f"a list of {_word(data, start)} in {end - start} bytes"))


def _require_chunks(data: bytes, start: int, end: int) -> None:
    """Raise FormatError unless the chunks between two positions, and those inside them, fit."""
    while start < end:
        size = int.from_bytes(data[start + 2 : start + 6], "little")
        identifier, body, next_start = _word(data, start), start + 6, start + size
        if size < 6 or next_start > end:
            raise FormatError(_DAMAGED.format(f"one of {size} bytes where {end - start} are left"))
        if identifier in (_VERTICES, _FACES):
            _require_list(data, identifier, body, next_start)
        if identifier in _CONTAINERS:
            if identifier == _OBJECT:  # begins with its name and a zero
                body = data.find(b"\0", body, next_start) + 1 or next_start
            _require_chunks(data, body, next_start)
        start = next_start


def read_3ds(data: bytes, path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the vertices (N, 3) and triangles (M, 3) of all objects in the file's own axes."""
    import assimp_py

    if _word(data, 0) != _MAIN:
        raise FormatError("expected a 3DS file, which begins with 'MM', found another; is it a 3DS file?")
    _require_chunks(data, 0, len(data))
    flags = assimp_py.Process_Triangulate | assimp_py.Process_PreTransformVertices
    meshes = assimp_py.import_file(str(path), flags).meshes
    vertices = [np.array(mesh.vertices, dtype=np.float64).reshape(-1, 3) for mesh in meshes]
    starts = np.cumsum([0] + [len(part) for part in vertices])
    faces = [np.array(mesh.indices, dtype=np.int64).reshape(-1, 3) for mesh in meshes]
    joined = np.concatenate([part + start for part, start in zip(faces, starts[:-1], strict=True)])
    return turned_up(np.concatenate(vertices), "y"), joined  # assimp turns 3DS, which is z up, to y up
