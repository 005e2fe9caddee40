"""Geometry from files."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .errors import InputError


@dataclass(frozen=True)
class Geometry:
    """What a file holds, in the file's own units and axes."""

    vertices: np.ndarray  # (N, 3) float64
    faces: np.ndarray = field(default_factory=lambda: np.empty((0, 3), dtype=np.int64))  # (M, 3); none: a cloud


def read_geometry(path: str | Path) -> Geometry:
    """Return the vertices and triangles of a file."""
    import trimesh

    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: expected a file, found none; check the path")
    scene = trimesh.load_scene(path, process=False, skip_materials=True)
    loaded = scene.to_geometry() if len(scene.geometry) else None
    if loaded is None:
        raise InputError(f"{path}: expected a mesh or points, found none")
    faces = np.asarray(getattr(loaded, "faces", np.empty((0, 3))), dtype=np.int64)
    return Geometry(np.asarray(loaded.vertices, dtype=np.float64), faces)
