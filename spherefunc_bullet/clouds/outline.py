"""Outlines: convex hulls of points on the ground, and the free borders and sharp edges of a mesh.

The hulls are compiled: loading SciPy's takes longer than most classifications.
"""

from __future__ import annotations

import numpy as np

from ..processes.compilation import lean_njit

STRAIGHT = 1e-15  # square metres: twice the area of a triangle whose corners are collinear up to rounding
DEPTH = 64  # parts that wait at most, since the smaller of two is next
_FLAT = np.cos(np.radians(30.0))  # two faces at a smaller angle belong to one smooth surface


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


def hull_corners(points: np.ndarray) -> np.ndarray:
    """Return the corners (K, 2) of the convex hull of points (N, 2), metres, counterclockwise; fewer than 3 for a line.

    The three corners of a triangle of less than `STRAIGHT` count as collinear.
    """
    points, outer = np.ascontiguousarray(points), np.empty(len(points) + 2, np.int64)
    outer = points[outer[: find_outer(points, np.arange(len(points)), np.empty((DEPTH, 5), np.int64), outer)]]
    outer = outer[np.lexsort((outer[:, 1], outer[:, 0]))]
    outer = outer[np.append(True, (outer[1:] != outer[:-1]).any(axis=1))]
    return outer[chain(outer, np.arange(len(outer)), STRAIGHT)]


@lean_njit(cache=True, error_model="numpy")
def find_outer(points, rest, parts, outer):
    """Write points (N, 2) that include all corners of their hull, and return their number (quickhull, Eddy 1977).

    Parameters
    ----------
    rest : (N,) int64
        All points; reordered in place.
    parts : (DEPTH, 5) int64
        Room for the parts that have points outside a line: the first and the end of these in ``rest``, the farthest of
        them, and the two ends of the line.
    outer : (N + 2,) int64
        Receives the points.
    """
    left = right = 0
    for i in range(len(points)):
        if (points[i, 0], points[i, 1]) < (points[left, 0], points[left, 1]):
            left = i
        if (points[i, 0], points[i, 1]) > (points[right, 0], points[right, 1]):
            right = i
    outer[0], outer[1], count = left, right, 2
    for a, b in ((left, right), (right, left)):
        end, farthest = move_outside(points, rest, 0, len(rest), a, b)
        write_part(parts, 0, 0, end, farthest, a, b)
        waiting = 1
        while waiting > 0:
            waiting -= 1
            part = parts[waiting]
            first, end, farthest, a, b = part[0], part[1], part[2], part[3], part[4]
            if first < end:
                outer[count] = farthest
                count += 1
                middle, before = move_outside(points, rest, first, end, a, farthest)
                last, behind = move_outside(points, rest, middle, end, farthest, b)
                larger = waiting if 2 * middle > first + last else waiting + 1  # comes last, so that few wait
                write_part(parts, larger, first, middle, before, a, farthest)
                write_part(parts, 2 * waiting + 1 - larger, middle, last, behind, farthest, b)
                waiting += 2
    return count


@lean_njit(cache=True, error_model="numpy")
def write_part(parts, row, first, end, farthest, a, b):
    """Write a row of the parts that wait; assigning a whole row would load numba's array functions."""
    parts[row, 0], parts[row, 1], parts[row, 2], parts[row, 3], parts[row, 4] = first, end, farthest, a, b


@lean_njit(cache=True, error_model="numpy")
def move_outside(points, rest, first, end, a, b):
    """Move those of some points that are to the right of a line from a to b to the front.

    Return their end, and the farthest one.
    """
    most, farthest = STRAIGHT, a
    for k in range(first, end):
        i = rest[k]
        outside = cross(points, b, a, i)
        if outside > STRAIGHT:
            rest[k], rest[first] = rest[first], i
            first += 1
            if outside > most:
                most, farthest = outside, i
    return first, farthest


def chain(points: np.ndarray, order: np.ndarray, slack: float = 0.0) -> np.ndarray:
    """Return the corners (K,) int64 of the convex hull of points (N, 2), given their order by x and then y.

    They are counterclockwise, from the first point on (Andrew's monotone chain, 1979).
    """
    hull = np.empty(2 * len(order) + 2, np.int64)
    return hull[: walk_around(np.ascontiguousarray(points), order, slack, hull)]


@lean_njit(cache=True, error_model="numpy")
def walk_around(points, order, slack, hull):
    """Write the corners of a hull, and return their number; see `chain`."""
    k = 0
    for turn in range(2):
        floor = k + 1
        for step in range(len(order)):
            i = order[step if turn == 0 else len(order) - 1 - step]
            while k > floor and cross(points, hull[k - 2], hull[k - 1], i) <= slack:
                k -= 1
            hull[k] = i
            k += 1
        k -= 1  # the other chain starts where this one ends
    return max(k, 1)


@lean_njit(cache=True, error_model="numpy")
def cross(points, a, b, c):
    """Return twice the area of a triangle of three of the points (N, 2), negative if it is clockwise."""
    ux, uy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    return ux * (points[c, 1] - points[a, 1]) - uy * (points[c, 0] - points[a, 0])
