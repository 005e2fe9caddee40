"""Convex hulls of points on the ground, in compiled loops: loading SciPy's takes longer than most classifications."""

from __future__ import annotations

import numpy as np

from ..processes.compilation import lean_njit

STRAIGHT = 1e-15  # square metres: twice the area of a triangle whose corners are collinear up to rounding
DEPTH = 64  # parts that wait at most, since the smaller of two is next


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
        All points; sorted in place.
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
        parts[0], waiting = (0, end, farthest, a, b), 1
        while waiting > 0:
            waiting -= 1
            first, end, farthest, a, b = parts[waiting]
            if first < end:
                outer[count] = farthest
                count += 1
                middle, before = move_outside(points, rest, first, end, a, farthest)
                last, behind = move_outside(points, rest, middle, end, farthest, b)
                larger = waiting if 2 * middle > first + last else waiting + 1  # comes last, so that few wait
                parts[larger] = first, middle, before, a, farthest
                parts[2 * waiting + 1 - larger] = middle, last, behind, farthest, b
                waiting += 2
    return count


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
