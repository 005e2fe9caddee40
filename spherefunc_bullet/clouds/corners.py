"""The box around points, in one pass over rows of many points."""

from __future__ import annotations

import numpy as np

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
