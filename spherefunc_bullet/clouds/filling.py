"""Sparse clouds of one object: the triangles between neighbours are filled, so that spheres do not fall through."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .cloud import Cloud, placed
from .corners import corners_of
from .thinning import one_per_cell

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

PITCH = 0.004  # metres between points that fill: as far apart as a mesh's samples
SPARSE = 0.0075  # metres to the sixth neighbour: of a mesh's samples it is 4 to 6 mm away
MANY = 15_000  # points: of more, spheres that are dropped on furniture find no gap, and filling would take seconds
LOOKED_AT = 1_000  # points that tell
NEIGHBORS = 6, 9  # that tell how sparse it is; among which triangles are looked for
REACH = 1.3, 0.02  # radius of a triangle's circle: times the distance of the sixth neighbour, at most, metres


def filled(cloud: Cloud) -> Cloud:
    """Return a cloud whose gaps between neighbouring points are filled, itself where it is dense or has a mesh.

    Triangles of neighbours are filled whose circle is small against how far points are apart, and never as large as an
    object's mouth. The order of the points does not matter.
    """
    if cloud.mesh is not None or not NEIGHBORS[1] < len(cloud) <= MANY:
        return cloud
    some = cloud.points[:: max(1, len(cloud) // LOOKED_AT)]
    if np.median(cloud.tree.query(some, NEIGHBORS[0] + 1)[0][:, -1]) < SPARSE:
        return cloud
    triangles = cloud.points[neighbouring(cloud.points, cloud.tree)]
    more = on_triangles(triangles)
    more = one_per_cell(more, PITCH, corners_of(more)) if len(more) else more
    return Cloud(placed(np.concatenate([cloud.points, more])), cloud.name)


def neighbouring(points: np.ndarray, tree: cKDTree) -> np.ndarray:
    """Return the triangles (T, 3) of points (N, 3) with two of their neighbours each whose circles are small."""
    distances, near = tree.query(points, NEIGHBORS[1] + 1)
    first, second = np.triu_indices(NEIGHBORS[1], 1)
    own = np.repeat(np.arange(len(points)), len(first))
    triangles = np.column_stack([own, near[:, 1 + first].ravel(), near[:, 1 + second].ravel()])
    reach = np.minimum(REACH[0] * distances[:, NEIGHBORS[0]], REACH[1])
    small = circle_radii(points[triangles]) < np.repeat(reach, len(first))
    return np.unique(np.sort(triangles[small], axis=1), axis=0)


def circle_radii(triangles: np.ndarray) -> np.ndarray:
    """Return the radius of the circle through the corners of triangles (T, 3, 3), (T,); infinite of flat ones."""
    sides = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2)
    edges = triangles[:, 1:] - triangles[:, :1]
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
    return np.divide(sides.prod(axis=1), 4 * areas, out=np.full(len(areas), np.inf), where=areas > 1e-12)


def on_triangles(triangles: np.ndarray) -> np.ndarray:
    """Return points (M, 3) on triangles (T, 3, 3), no farther apart than `PITCH` along their sides."""
    longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1, initial=0)
    steps, parts = np.ceil(longest / PITCH).astype(int), [np.empty((0, 3))]
    for count in np.unique(steps[steps > 1]).tolist():
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
        inside = i + j <= count
        weights = np.stack([i[inside], j[inside], count - i[inside] - j[inside]], axis=1) / count
        parts.append(np.einsum("wc,tcx->twx", weights, triangles[steps == count]).reshape(-1, 3))
    return np.concatenate(parts)
