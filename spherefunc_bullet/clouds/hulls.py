"""Convex hulls of many small sets of points, in compiled loops.

A single classification does without: for that, `outline` takes less time than loading these.
"""

from __future__ import annotations

import numpy as np

from ..processes.compilation import lean_njit
from .outline import STRAIGHT, well_within

_MANY = 1000  # points; with fewer, it is not worth finding those within the others


def hull_corners(points: np.ndarray, slack: float = STRAIGHT) -> np.ndarray:
    """Return the corners (K, 2) of the convex hull of points (N, 2), counterclockwise; fewer than 3 for a line.

    Parameters
    ----------
    points : (N, 2) float64, metres
    slack : float
        Twice the area, in square metres, of a triangle whose corners count as collinear.
    """
    outer = points if len(points) < _MANY else points[~well_within(points)]
    outer = outer[np.lexsort((outer[:, 1], outer[:, 0]))]
    outer = outer[np.append(True, (outer[1:] != outer[:-1]).any(axis=1))]
    return outer[chain(outer, np.arange(len(outer)), slack)]


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
