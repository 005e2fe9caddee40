"""Ray casting against triangles, with Open3D."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from open3d.t.geometry import RaycastingScene


def raycasting_scene(*meshes: tuple[np.ndarray, np.ndarray], threads: int = 0) -> RaycastingScene:
    """Return a scene of meshes, given by vertices (V, 3) and faces (F, 3); with 0 threads it uses all cores."""
    from open3d.t.geometry import RaycastingScene

    scene = RaycastingScene(nthreads=threads)
    for vertices, faces in meshes:
        if len(faces):
            scene.add_triangles(np.ascontiguousarray(vertices, np.float32), np.ascontiguousarray(faces, np.uint32))
    return scene


def rays_from(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return rays (..., 6) float32 from origins along directions, as a scene expects them."""
    return np.concatenate(np.broadcast_arrays(origins, directions), axis=-1).astype(np.float32)
