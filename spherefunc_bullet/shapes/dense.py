"""Points all over a surface, quickly and without the even spacing that a cloud has."""

from __future__ import annotations

import numpy as np

from ..processes.compilation import njit

MOST = 6_000_000  # points; beyond, they lie farther apart


def dense_points(vertices: np.ndarray, faces: np.ndarray, gap: float) -> np.ndarray:
    """Return points (N, 3) on triangles, corners among them, in rows along the longest edges, at most ``gap`` apart."""
    corners = np.asarray(vertices, dtype=np.float64)[faces]
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    turn = (edges.argmax(axis=1)[:, None] + np.arange(3)) % 3
    corners = np.ascontiguousarray(np.take_along_axis(corners, turn[:, :, None], axis=1))
    longest = np.maximum(edges.max(axis=1), 1e-12)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    heights = np.linalg.norm(across, axis=1) / longest
    while (count := fill(corners, longest / gap, heights / gap, np.empty((0, 3)))) > MOST and gap < longest.max():
        gap *= 1.1 * np.sqrt(count / MOST)
    points = np.empty((count, 3))
    fill(corners, longest / gap, heights / gap, points)
    return points


@njit(cache=True, error_model="numpy")
def fill(corners, lengths, heights, out):
    """Write rows of points on each triangle, whose first edge is the longest; return how many there are.

    Lengths and heights in gaps.
    """
    n = 0
    for t in range(len(corners)):
        rows = max(1, int(np.ceil(heights[t])))
        for j in range(rows + 1):
            up = j / rows
            steps = max(1 if j < rows else 0, int(np.ceil(lengths[t] * (1 - up))))
            for i in range(steps + 1):
                if n < len(out):
                    along = (1 - up) * i / max(1, steps)
                    for axis in range(3):
                        first = corners[t, 0, axis]
                        side, apex = corners[t, 1, axis] - first, corners[t, 2, axis] - first
                        out[n, axis] = first + along * side + up * apex
                n += 1
    return n
