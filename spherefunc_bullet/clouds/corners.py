"""The box around points, their convex outline, and what lies well within it."""

from __future__ import annotations

import numpy as np

_STRAIGHT = 1e-15  # square metres: twice the area of a triangle whose corners are on one line but for rounding
_INSIDE = 1e-6  # square metres between a side and a point that is well within: rounding never reaches so far


def corners_of(points: np.ndarray) -> np.ndarray:
    """Return the lowest and the highest corner (2, 3) of the bounding box of points (N, 3), metres."""
    return np.array([[axis.min() for axis in points.T], [axis.max() for axis in points.T]])


def well_within(points: np.ndarray) -> np.ndarray:
    """Return which points (N, 2) lie within the farthest ones in eight directions, (N,) bool (Akl, Toussaint, 1978)."""
    x, y = points.T
    turning = (x, x + y, y, y - x)  # a quarter of a turn ahead each, then the same backwards
    ends = [int(np.argmax(way)) for way in turning] + [int(np.argmin(way)) for way in turning]
    within = np.ones(len(points), bool)
    for a, b in zip(ends, [*ends[1:], ends[0]], strict=True):
        if a != b:
            within &= (x[b] - x[a]) * (y - y[a]) - (y[b] - y[a]) * (x - x[a]) > _INSIDE
    return within


def convex_outline(points: np.ndarray) -> np.ndarray:
    """Return the corners (K, 2) of the convex hull of points (N, 2), metres, counterclockwise; fewer than 3 of a line.

    SciPy's hull has the same corners, and takes longer to load than most answers do.
    """
    ends = points[[np.argmin(points[:, 0]), np.argmax(points[:, 0])]]
    corners = np.array([ends[0], *beyond(points, *ends), ends[1], *beyond(points, *ends[::-1])])
    while len(corners) > 2:
        before, behind = np.roll(corners, 1, axis=0) - corners, np.roll(corners, -1, axis=0) - corners
        straight = np.flatnonzero(behind[:, 0] * before[:, 1] - behind[:, 1] * before[:, 0] <= _STRAIGHT)
        if not len(straight):
            break
        corners = np.delete(corners, straight[0], axis=0)  # one at a time: of two in one place the other is a corner
    return corners


def beyond(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> list[np.ndarray]:
    """Return the corners of the hull right of a line, from its start on, among points (N, 2) (quickhull, Eddy 1977)."""
    (x, y), (along_x, along_y) = points.T, end - start
    area = along_y * (x - start[0]) - along_x * (y - start[1])
    outside = area > _STRAIGHT
    if not outside.any():
        return []
    farthest = points[np.argmax(area)]
    left = points[outside]
    return [*beyond(left, start, farthest), farthest, *beyond(left, farthest, end)]
