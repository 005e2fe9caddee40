"""The outline of a mesh: its open borders and the edges where the surface bends sharply."""

from __future__ import annotations

import numpy as np
from numba import njit

_FLAT = np.cos(np.radians(30.0))  # two faces that bend less than this belong to one smooth surface


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


@njit(cache=True)
def _sideways(start, end, apex):
    """Return the unit direction from an edge to a face's third corner, perpendicular to the edge."""
    along = end - start
    across = apex - start
    across = across - along * (np.dot(across, along) / max(np.dot(along, along), 1e-300))
    return across / max(np.sqrt(np.dot(across, across)), 1e-300)


@njit(cache=True)
def _outline_mask(vertices, start, end, apex):
    """Return which of the edges, sorted so that equal ones are neighbours, open a sharp or free edge.

    An edge is smooth when its faces lie on both sides of it and in one plane, whatever their winding
    and however often a sheet is doubled. Only the first of equal edges is ever marked.
    """
    mask = np.zeros(len(start), dtype=np.bool_)
    first = 0
    while first < len(start):
        last = first + 1
        while last < len(start) and start[last] == start[first] and end[last] == end[first]:
            last += 1
        a, b = vertices[start[first]], vertices[end[first]]
        side = _sideways(a, b, vertices[apex[first]])
        has_opposite = False
        is_bent = False
        for other in range(first + 1, last):
            cosine = np.dot(side, _sideways(a, b, vertices[apex[other]]))
            has_opposite |= cosine < -_FLAT
            is_bent |= abs(cosine) <= _FLAT
        mask[first] = (is_bent or not has_opposite) and start[first] != end[first]
        first = last
    return mask


def outline_edges(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the free and sharp edges of a mesh whose equal vertices are merged.

    Parameters
    ----------
    vertices : (N, 3) float64, metres
    faces : (M, 3) int64

    Returns
    -------
    (E, 2) int64, vertex numbers, ascending
    """
    corners = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    apex = faces[:, [2, 0, 1]].reshape(-1)
    start, end = corners.min(axis=1), corners.max(axis=1)
    order = np.argsort(start * len(vertices) + end, kind="stable")
    start, end = start[order], end[order]
    mask = _outline_mask(vertices, start, end, apex[order])
    return np.column_stack([start[mask], end[mask]])


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
    return np.concatenate([vertices[np.unique(edges)], along])
