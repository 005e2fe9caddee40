"""Do two objects interpenetrate? Where the surface of one crosses that of the other, deeper than touching."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from spherefunc_bullet.clouds.cloud import Mesh

from .placing import ArrangedObject

SUNK = 0.002  # metres: what is no deeper in another object touches it
NEAR = 0.012  # metres from the other's surface: who crosses it has points there, on either side
STEP = 0.008  # metres between neighbouring samples of one surface, at most


def crossing(one: ArrangedObject, other: ArrangedObject) -> np.ndarray | None:
    """Return a place (3,) where two objects' surfaces cross, metres, the world's frame; None where they do not.

    One of them has to be a mesh; of two clouds nothing is known. An object that is wholly within a hollow one crosses
    nothing.
    """
    if not boxes_meet(one, other):
        return None
    for crossed, passing in ((one, other), (other, one)):
        if crossed.cloud.mesh is not None:
            place = first_crossing(crossed.cloud.mesh, passing.cloud.points)
            if place is not None:
                return place
    return None


def boxes_meet(one: ArrangedObject, other: ArrangedObject) -> bool:
    """Return whether two objects' boxes have more than a touch in common."""
    (low, high), (other_low, other_high) = one.cloud.bounds, other.cloud.bounds
    return bool((np.minimum(high, other_high) - np.maximum(low, other_low) > SUNK).all())


def first_crossing(mesh: Mesh, points: np.ndarray) -> np.ndarray | None:
    """Return where neighbours among points (N, 3) lie on either side of a mesh, none nearer to it than a touch."""
    from open3d.core import Tensor
    from open3d.t.geometry import RaycastingScene

    low, high = mesh.vertices.min(axis=0) - NEAR, mesh.vertices.max(axis=0) + NEAR
    points = points[((points >= low) & (points <= high)).all(axis=1)]
    if not len(points):
        return None
    scene = RaycastingScene()
    scene.add_triangles(Tensor(mesh.vertices.astype(np.float32)), Tensor(mesh.faces.astype(np.uint32)))
    away = scene.compute_distance(Tensor(points.astype(np.float32))).numpy()
    points = points[(away > SUNK) & (away < NEAR)]
    pairs = cKDTree(points).query_pairs(STEP, output_type="ndarray") if len(points) else np.empty((0, 2), int)
    if not len(pairs):
        return None
    start, way = points[pairs[:, 0]], points[pairs[:, 1]] - points[pairs[:, 0]]
    met = scene.cast_rays(Tensor(np.concatenate([start, way], axis=1).astype(np.float32)))["t_hit"].numpy()
    crossed = np.flatnonzero(met < 1)
    return None if not len(crossed) else start[crossed[0]] + met[crossed[0]] * way[crossed[0]]
