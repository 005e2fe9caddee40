"""The box around points, in one pass over rows of many points, and which points are well within an outline."""

from __future__ import annotations

import numpy as np

_INSIDE = 1e-6  # square metres between a side and a point that is well within: rounding never reaches so far

ABREAST = 64  # points side by side in a row, which are compared as many at once as the processor can


def corners_of(points: np.ndarray) -> np.ndarray:
    """Return the lowest and the highest corner (2, 3) of the bounding box of points (N, 3), metres."""
    whole = len(points) // ABREAST * ABREAST
    if not whole:
        return np.array([points.min(axis=0), points.max(axis=0)])
    rows, rest = points[:whole].reshape(-1, 3 * ABREAST), points[whole:]
    low = np.concatenate([rows.min(axis=0).reshape(-1, 3), rest])
    high = np.concatenate([rows.max(axis=0).reshape(-1, 3), rest])
    return np.array([low.min(axis=0), high.max(axis=0)])


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
