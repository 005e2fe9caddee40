"""How safely an object would stand: the static stability of a resting pose."""

from __future__ import annotations

import numpy as np

_TOUCHING = 0.02  # of the largest extent: points this low count as touching the ground


def centroid(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the centre of a surface, or of points without faces, (3,)."""
    if not len(faces):
        return vertices.mean(axis=0)
    corners = vertices[faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.average(corners.mean(axis=1), axis=0, weights=areas + 1e-300)


def standing_margin(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Return how far inside its support polygon an object's centroid lies, over its footprint's side.

    The support polygon is the convex hull, seen from above, of the points that touch the ground.

    Parameters
    ----------
    vertices : (N, 3) float64, z up
    faces : (M, 3) int64; none for a cloud

    Returns
    -------
    float
        Below zero if the object would tip over; minus infinity if it touches the ground in a line or a point.
    """
    from scipy.spatial import ConvexHull, QhullError

    heights = vertices[:, 2] - vertices[:, 2].min()
    touching = vertices[heights <= _TOUCHING * np.ptp(vertices, axis=0).max(), :2]
    try:
        support, footprint = ConvexHull(touching), ConvexHull(vertices[:, :2])
    except (QhullError, ValueError):  # too few points, or all in a line
        return -np.inf
    outside = support.equations[:, :2] @ centroid(vertices, faces)[:2] + support.equations[:, 2]
    return float(-outside.max() / np.sqrt(footprint.volume))  # a polygon's "volume" is its area
