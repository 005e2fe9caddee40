"""Points all over a surface, quickly and without the even spacing that a cloud has."""

from __future__ import annotations

import numpy as np

from ..processes.compilation import njit

MOST = 6_000_000  # points; beyond, they lie farther apart


def dense_points(vertices: np.ndarray, faces: np.ndarray, gap: float) -> np.ndarray:
    """Return points (N, 3) on triangles, corners among them, neighbours at most ``gap`` apart along each edge."""
    corners = np.ascontiguousarray(vertices[faces], dtype=np.float64)
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    steps = np.maximum(1, np.ceil(edges / gap))
    many = ((steps + 1) * (steps + 2) / 2).sum()
    if many > MOST:
        steps = np.maximum(1, np.ceil(steps * np.sqrt(MOST / many)))
    steps = steps.astype(np.int64)
    return fill(corners, steps, np.empty((int(((steps + 1) * (steps + 2) // 2).sum()), 3)))


@njit(cache=True, error_model="numpy")
def fill(corners, steps, out):
    """Write a triangular lattice on each triangle."""
    n = 0
    for t in range(len(corners)):
        for i in range(steps[t] + 1):
            for j in range(steps[t] + 1 - i):
                a, b = i / steps[t], j / steps[t]
                for axis in range(3):
                    first = corners[t, 0, axis]
                    out[n, axis] = first + a * (corners[t, 1, axis] - first) + b * (corners[t, 2, axis] - first)
                n += 1
    return out
