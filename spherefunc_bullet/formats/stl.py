"""STL, ASCII and binary, read by trimesh."""

from __future__ import annotations

import numpy as np

from . import FormatError
from .files import require_counts, require_text_size
from .scenes.parts import scene_of
from .sources import Geometry, Source


def _count_facets(data: bytes) -> int | None:
    """Return the number of facets that an ASCII file starts; None for a binary file."""
    if len(data) >= 84 and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        require_counts(triangles=int.from_bytes(data[80:84], "little"))
        return None
    require_text_size(data)
    text = data.lower()
    if not text.lstrip().startswith(b"solid"):
        raise FormatError("expected 'solid' or a binary STL as long as its header says; is it cut off or no STL?")
    return text.count(b"facet normal")


def read_stl(source: Source) -> Geometry:
    """Return the vertices (N, 3), repeated for each face, and the triangles (M, 3)."""
    data = source.data
    facets = _count_facets(data)
    meshes = list(scene_of(data, "stl").geometry.values())  # one for each 'solid'; STL has no transforms
    count = sum(len(mesh.faces) for mesh in meshes)
    if not count or facets not in (None, count):
        raise FormatError(f"expected {facets or 'some'} facets, got {count}; is the file cut off or damaged?")
    vertices = np.concatenate([mesh.vertices[mesh.faces.reshape(-1)] for mesh in meshes])
    return Geometry(vertices, np.arange(len(vertices)).reshape(-1, 3))
