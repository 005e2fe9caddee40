"""Polygons cut into triangles."""

from __future__ import annotations

import numpy as np

from . import FormatError


def fan_triangles(counts: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the triangles of polygons, each a fan around its first corner (exact for convex ones).

    Parameters
    ----------
    counts : (P,) int
        Corners of each polygon, at least 1; those of 1 or 2, which some programs write, have no surface.
    corners : (sum of counts,) int
        The polygons' vertex numbers, one after the other.

    Returns
    -------
    (M, 3) int64

    Examples
    --------
    >>> fan_triangles(np.array([3, 4]), np.array([0, 1, 2, 3, 4, 5, 6]))
    array([[0, 1, 2],
           [3, 4, 5],
           [3, 5, 6]])
    """
    counts, corners = np.asarray(counts, dtype=np.int64), np.asarray(corners, dtype=np.int64)
    if len(counts) and counts.min() < 1:
        raise FormatError(f"expected faces of 3 corners or more, got one of {counts.min()}; is it damaged?")
    fans = np.maximum(counts - 2, 0)
    first = np.repeat(np.cumsum(counts) - counts, fans)
    step = np.arange(len(first)) - np.repeat(np.cumsum(fans) - fans, fans)
    return np.column_stack([corners[first], corners[first + step + 1], corners[first + step + 2]]).reshape(-1, 3)
