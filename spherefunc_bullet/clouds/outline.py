"""Outlines: the bounding box of points, and the free borders and sharp edges of a mesh."""

from __future__ import annotations

import numpy as np

_FLAT = np.cos(np.radians(30.0))  # two faces at a smaller angle belong to one smooth surface


def corners_of(points: np.ndarray) -> np.ndarray:
    """Return the lowest and the highest corner (2, 3) of the bounding box of points (N, 3), metres."""
    return np.array([[axis.min() for axis in points.T], [axis.max() for axis in points.T]])


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
