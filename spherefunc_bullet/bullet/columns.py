"""Start heights: a sphere starts just above whatever lies under its column (paper, §III-A).

The fall through empty air is not simulated.
"""

from __future__ import annotations

import numpy as np

from ..processes.compilation import njit

CELL = 2.0  # radii: side of a cell of settled spheres, equal to the reach of a column
FINE = 0.5  # radii: side of a cell of points, of which there are thousands below a large sphere
MAX_CELLS = 4_000_000  # with more, cells are larger


class ColumnIndex:
    """Points and settled spheres, sorted into cells of the ground plane.

    Parameters
    ----------
    points : (N, 3) float64, radii
        Dense enough that a sphere lowered onto them is hardly lower than one on their surface.
    low, high : (2,) float64, radii
        The footprint.
    """

    def __init__(self, points: np.ndarray, low: np.ndarray, high: np.ndarray):
        extent = high[:2] - low[:2] + 2 * CELL
        self.cell = max(CELL, float(np.sqrt(extent.prod() / MAX_CELLS)))
        self.fine = max(FINE, float(np.sqrt(extent.prod() / MAX_CELLS)))
        self.low = low[:2] - CELL
        self.dims, self.fine_dims = (np.floor(extent / side).astype(np.int64) + 1 for side in (self.cell, self.fine))
        self.points, self.starts = in_cells(points, self.low, self.fine, self.fine_dims)
        self.centers = np.empty((256, 3))
        self.head = np.full(self.dims.prod(), -1, np.int64)
        self.follower = np.empty(256, np.int64)
        self.count = 0

    def add(self, center: np.ndarray):
        """Add a settled sphere."""
        if self.count == len(self.centers):
            self.centers = np.concatenate([self.centers, np.empty_like(self.centers)])
            self.follower = np.concatenate([self.follower, np.empty_like(self.follower)])
        cell = cell_of(center[0], center[1], self.low, self.cell, self.dims)
        self.centers[self.count] = center
        self.follower[self.count] = self.head[cell]
        self.head[cell] = self.count
        self.count += 1

    def height(self, x: float, y: float) -> float:
        """Return the height of the centre of a sphere at its first contact in a column; -inf above empty ground."""
        on_points = height_on_points(x, y, self.low, self.fine, self.fine_dims, self.points, self.starts)
        on_spheres = height_on_spheres(x, y, self.low, self.cell, self.dims, self.centers, self.head, self.follower)
        return max(on_points, on_spheres)

    def clear(self, center: np.ndarray, distance: float) -> bool:
        """Return whether no point is nearer to a centre (3,) than a distance."""
        return is_clear(center, distance, self.low, self.fine, self.fine_dims, self.points, self.starts)


@njit(cache=True, error_model="numpy")
def cell_of(x, y, low, side, dims):
    """Return the number of the cell that contains (x, y), or of the nearest one outside the footprint."""
    i = min(max(np.int64(np.floor((x - low[0]) / side)), 0), dims[0] - 1)
    j = min(max(np.int64(np.floor((y - low[1]) / side)), 0), dims[1] - 1)
    return i * dims[1] + j


@njit(cache=True, error_model="numpy")
def in_cells(points, low, side, dims):
    """Return the points sorted by cell (N, 3), keeping their order within one, and the start of each cell (C + 1,)."""
    starts = np.zeros(dims[0] * dims[1] + 1, np.int64)
    cells = np.empty(len(points), np.int64)
    for p in range(len(points)):
        cells[p] = cell_of(points[p, 0], points[p, 1], low, side, dims)
        starts[cells[p] + 1] += 1
    for cell in range(1, len(starts)):
        starts[cell] += starts[cell - 1]
    free, placed = starts.copy(), np.empty((len(points), 3))
    for p in range(len(points)):
        row = free[cells[p]]
        free[cells[p]] += 1
        placed[row, 0], placed[row, 1], placed[row, 2] = points[p, 0], points[p, 1], points[p, 2]
    return placed, starts


@njit(cache=True, error_model="numpy")
def cells_around(x, y, reach, low, side, dims):
    """Return the ranges of cells along both axes that are within reach of (x, y): first, end, first, end."""
    i, i_end = np.int64((x - reach - low[0]) / side), np.int64((x + reach - low[0]) / side) + 1
    j, j_end = np.int64((y - reach - low[1]) / side), np.int64((y + reach - low[1]) / side) + 1
    return max(i, 0), min(i_end, dims[0]), max(j, 0), min(j_end, dims[1])


@njit(cache=True, error_model="numpy")
def height_on_points(x, y, low, side, dims, points, starts):
    """Return the height at which a falling sphere of radius 1 first touches a point."""
    best = -np.inf
    i, i_end, j, j_end = cells_around(x, y, 1.0, low, side, dims)
    for ci in range(i, i_end):  # the cells of a row are stored one after the other
        for k in range(starts[ci * dims[1] + j], starts[ci * dims[1] + j_end] if j < j_end else 0):
            best = max(best, above(points[k, 0] - x, points[k, 1] - y, points[k, 2], 1.0))
    return best


@njit(cache=True, error_model="numpy")
def height_on_spheres(x, y, low, side, dims, centers, head, follower):
    """Return the height at which a falling sphere of radius 1 first touches a settled one."""
    best = -np.inf
    i, i_end, j, j_end = cells_around(x, y, 2.0, low, side, dims)
    for ci in range(i, i_end):
        for cj in range(j, j_end):
            k = head[ci * dims[1] + cj]
            while k >= 0:
                best = max(best, above(centers[k, 0] - x, centers[k, 1] - y, centers[k, 2], 4.0))
                k = follower[k]
    return best


@njit(cache=True, error_model="numpy")
def above(dx, dy, z, squared):
    """Return the height at which a centre is at a distance, given squared, from a point (dx, dy) off its column."""
    d = dx * dx + dy * dy
    return z + np.sqrt(squared - d) if d < squared else -np.inf


@njit(cache=True, error_model="numpy")
def is_clear(center, distance, low, side, dims, points, starts):
    """Return whether no point is nearer to a centre than a distance."""
    x, y, z = center
    i, i_end, j, j_end = cells_around(x, y, distance, low, side, dims)
    for ci in range(i, i_end):
        for k in range(starts[ci * dims[1] + j], starts[ci * dims[1] + j_end] if j < j_end else 0):
            dx, dy, dz = points[k, 0] - x, points[k, 1] - y, points[k, 2] - z
            if dx * dx + dy * dy + dz * dz < distance * distance:
                return False
    return True
