"""Where a sphere starts: just above whatever lies under its column (paper, §III-A).

Nobody needs to watch it fall through empty air.
"""

from __future__ import annotations

import numpy as np
from numba import njit

CELL = 2.0  # side of a cell in radii: as far as a column reaches
MAX_CELLS = 4_000_000  # above, cells are larger


class Columns:
    """Points and settled spheres, by where they lie seen from above.

    Parameters
    ----------
    points : (N, 3) float64, radii
        Dense enough that a sphere that lowers itself onto them is hardly lower than on their surface.
    low, high : (2,) float64, radii
        The footprint.
    """

    def __init__(self, points: np.ndarray, low: np.ndarray, high: np.ndarray):
        extent = high[:2] - low[:2] + 2 * CELL
        self.cell = max(CELL, float(np.sqrt(extent.prod() / MAX_CELLS)))
        self.low = low[:2] - CELL
        self.dims = np.floor(extent / self.cell).astype(np.int64) + 1
        cells = self.cells(points)
        order = np.argsort(cells, kind="stable")
        self.points = np.ascontiguousarray(points[order])
        self.starts = np.searchsorted(cells[order], np.arange(self.dims.prod() + 1))
        self.centers = np.empty((256, 3))
        self.head = np.full(self.dims.prod(), -1, np.int64)
        self.follower = np.empty(256, np.int64)
        self.count = 0

    def cells(self, points: np.ndarray) -> np.ndarray:
        """Return the number of the cell of each point; outside the footprint that of the nearest one."""
        ij = np.clip(np.floor((points[:, :2] - self.low) / self.cell).astype(np.int64), 0, self.dims - 1)
        return ij[:, 0] * self.dims[1] + ij[:, 1]

    def add(self, center: np.ndarray):
        """Take in a settled sphere."""
        if self.count == len(self.centers):
            self.centers = np.concatenate([self.centers, np.empty_like(self.centers)])
            self.follower = np.concatenate([self.follower, np.empty_like(self.follower)])
        cell = self.cells(center[None])[0]
        self.centers[self.count] = center
        self.follower[self.count] = self.head[cell]
        self.head[cell] = self.count
        self.count += 1

    def height(self, x: float, y: float) -> float:
        """Return the height of a sphere's centre that comes down a column and touches, or -inf on empty ground."""
        return column_height(
            x, y, self.low, self.cell, self.dims, self.points, self.starts, self.centers, self.head, self.follower
        )


@njit(cache=True, error_model="numpy")
def column_height(x, y, low, side, dims, points, starts, centers, head, follower):
    """Return the height at which a sphere of radius 1 coming down touches a point or a sphere."""
    best = -np.inf
    i, j = int((x - low[0]) / side), int((y - low[1]) / side)
    for ci in range(max(i - 1, 0), min(i + 2, dims[0])):
        for cj in range(max(j - 1, 0), min(j + 2, dims[1])):
            cell = ci * dims[1] + cj
            for k in range(starts[cell], starts[cell + 1]):
                best = max(best, above(points[k, 0] - x, points[k, 1] - y, points[k, 2], 1.0))
            k = head[cell]
            while k >= 0:
                best = max(best, above(centers[k, 0] - x, centers[k, 1] - y, centers[k, 2], 4.0))
                k = follower[k]
    return best


@njit(cache=True, error_model="numpy")
def above(dx, dy, z, squared):
    """Return the height at which a centre is at a distance, given squared, from a point beside its column."""
    d = dx * dx + dy * dy
    return z + np.sqrt(squared - d) if d < squared else -np.inf
