"""Outlines: the bounding box and convex hull of points, and the free borders and sharp edges of a mesh."""

from __future__ import annotations

import numpy as np

STRAIGHT = 1e-15  # square metres: twice the area of a triangle whose corners are collinear up to rounding
_INSIDE = 1e-6  # square metres between a side and a point well inside; rounding errors are smaller
_FLAT = np.cos(np.radians(30.0))  # two faces at a smaller angle belong to one smooth surface


def corners_of(points: np.ndarray) -> np.ndarray:
    """Return the lowest and the highest corner (2, 3) of the bounding box of points (N, 3), metres."""
    return np.array([[axis.min() for axis in points.T], [axis.max() for axis in points.T]])


def well_within(points: np.ndarray) -> np.ndarray:
    """Return which points (N, 2) lie inside the octagon of the extreme ones, (N,) bool (Akl and Toussaint, 1978)."""
    x, y = np.ascontiguousarray(points.T)
    turning = (x, x + y, y, y - x)  # four of the eight directions; the others are their opposites
    ends = [int(np.argmax(way)) for way in turning] + [int(np.argmin(way)) for way in turning]
    within, area, other = np.ones(len(points), bool), np.empty_like(x), np.empty_like(x)  # new memory would be slow
    for a, b in zip(ends, [*ends[1:], ends[0]], strict=True):
        if a != b:
            np.multiply(np.subtract(y, y[a], out=area), x[b] - x[a], out=area)
            np.multiply(np.subtract(x, x[a], out=other), y[b] - y[a], out=other)
            within &= np.subtract(area, other, out=area) > _INSIDE
    within[ends] = False  # also where all are one point
    return within


def convex_outline(points: np.ndarray) -> np.ndarray:
    """Return the corners (K, 2) of the convex hull of points (N, 2), metres, counterclockwise; fewer than 3 for a line.

    SciPy's hull has the same corners, but loading it takes longer than most classifications.
    """
    ends = points[[np.argmin(points[:, 0]), np.argmax(points[:, 0])]]
    corners = np.array([ends[0], *beyond(points, *ends), ends[1], *beyond(points, *ends[::-1])])
    while len(corners) > 2:
        before, behind = np.roll(corners, 1, axis=0) - corners, np.roll(corners, -1, axis=0) - corners
        straight = np.flatnonzero(behind[:, 0] * before[:, 1] - behind[:, 1] * before[:, 0] <= STRAIGHT)
        if not len(straight):
            break
        corners = np.delete(corners, straight[0], axis=0)  # one at a time: of two equal corners the other one stays
    return corners


def beyond(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> list[np.ndarray]:
    """Return the corners of the hull to the right of a line, in order, among points (N, 2) (quickhull, Eddy 1977)."""
    (x, y), (along_x, along_y) = points.T, end - start
    area = along_y * (x - start[0]) - along_x * (y - start[1])
    outside = area > STRAIGHT
    if not outside.any():
        return []
    farthest = points[np.argmax(area)]
    left = points[outside]
    return [*beyond(left, start, farthest), farthest, *beyond(left, farthest, end)]


def merge_vertices(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mesh with vertices at equal coordinates merged (STL repeats each one per face).

    Parameters
    ----------
    vertices : (N, 3) float64, metres
    faces : (M, 3) int64

    Returns
    -------
    vertices : (K, 3) float64, metres, sorted
    faces : (M, 3) int64
    """
    order = np.lexsort(vertices.T)
    ordered = vertices[order]
    is_new = np.ones(len(order), dtype=bool)
    is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    merged = np.empty(len(order), dtype=np.int64)
    merged[order] = np.cumsum(is_new) - 1
    return ordered[is_new], merged[faces]


def outline_edges(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the free and sharp edges of a mesh whose equal vertices are merged.

    An edge is smooth if its faces lie on both sides of it in one plane, whatever their winding, and even if faces are
    duplicated.

    Parameters
    ----------
    vertices : (N, 3) float64, metres
    faces : (M, 3) int64

    Returns
    -------
    (E, 2) int64, vertex numbers, ascending
    """
    ends = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    order = np.argsort(ends[:, 0] * len(vertices) + ends[:, 1], kind="stable")
    ends, apex = ends[order], faces[:, [2, 0, 1]].reshape(-1)[order]
    is_first = np.ones(len(ends), dtype=bool)
    is_first[1:] = (ends[1:] != ends[:-1]).any(axis=1)
    starts = np.flatnonzero(is_first)
    along, across = vertices[ends[:, 1]] - vertices[ends[:, 0]], vertices[apex] - vertices[ends[:, 0]]
    share = np.einsum("ex,ex->e", across, along) / np.maximum(np.einsum("ex,ex->e", along, along), 1e-300)
    across = across - along * share[:, None]  # from each edge, at right angles to it, to the third corner of the face
    side = across / np.maximum(np.linalg.norm(across, axis=1), 1e-300)[:, None]
    cosine = np.einsum("ex,ex->e", side, side[starts][np.cumsum(is_first) - 1])  # with the edge's first face
    is_bent = np.logical_or.reduceat(np.abs(cosine) <= _FLAT, starts)
    has_opposite = np.logical_or.reduceat(cosine < -_FLAT, starts)
    edges = ends[starts]
    return edges[(is_bent | ~has_opposite) & (edges[:, 0] != edges[:, 1])]


def outline_points(vertices: np.ndarray, faces: np.ndarray, pitch: float) -> np.ndarray:
    """Return points along the outline: first its corners, then each edge in equal steps.

    Parameters
    ----------
    vertices : (N, 3) float64, metres
    faces : (M, 3) int64
    pitch : float, metres
        The longest step along an edge.

    Returns
    -------
    (K, 3) float64, metres
    """
    edges = outline_edges(vertices, faces)
    start, end = vertices[edges[:, 0]], vertices[edges[:, 1]]
    steps = np.ceil(np.linalg.norm(end - start, axis=1) / pitch).astype(np.int64)
    inner = np.maximum(steps - 1, 0)
    edge = np.repeat(np.arange(len(edges)), inner)
    step = np.arange(len(edge)) - np.repeat(np.cumsum(inner) - inner, inner) + 1
    along = start[edge] + (end - start)[edge] * (step / steps[edge])[:, None]
    is_corner = np.zeros(len(vertices), dtype=bool)
    is_corner[edges.ravel()] = True
    return np.concatenate([vertices[is_corner], along])
