"""Uniform grids that answer "what is near this sphere?" for the cloud and for the settled spheres.

Both are dense over the bounding box and cut into vertical columns, because a sphere falls along one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

MAX_CELLS = 40_000_000  # of either grid, 160 MB; a larger box gets larger cells, which cost time, not memory
EMPTY = -1
NEAR = 2.1  # radii: how far from a centre the cloud can matter within one step
MAX_NEIGHBOURS = 96  # spheres that fit within NEAR + 1 radii of a centre: 0.74 * 4.1**3 = 51 at the densest


class PointGrid(NamedTuple):
    """The cloud, sorted by column and, within a column, from the top down."""

    x: np.ndarray  # (N,) metres, in grid order
    y: np.ndarray  # (N,)
    z: np.ndarray  # (N,)
    start: np.ndarray  # (columns * nz + 1,) int32, first point of each cell
    left: float  # of the grid, metres
    front: float
    top: float
    cell: float  # side, metres
    nx: int
    ny: int
    nz: int


class SphereGrid(NamedTuple):
    """The settled spheres, as one linked list a cell; side two radii, so neighbours are one cell away."""

    centers: np.ndarray  # (capacity, 3) metres
    following: np.ndarray  # (capacity,) int32, next sphere of the same cell
    first: np.ndarray  # (nx * ny * nz,) int32
    highest: np.ndarray  # (nx * ny,) int32, highest occupied cell of each column
    near_points: np.ndarray  # (nx * ny * nz,) bool: may a sphere centred in this cell touch the cloud?
    left: float
    front: float
    bottom: float
    cell: float
    nx: int
    ny: int
    nz: int


def cell_side(extent: np.ndarray, side: float) -> float:
    """Return the cell side nearest to the wished one that keeps the grid within MAX_CELLS."""
    while np.prod(np.ceil(extent / side) + 3) > MAX_CELLS:
        side *= 1.3
    return side


def point_grid(points: np.ndarray, radius: float) -> PointGrid:
    """Sort a cloud (N, 3) into columns one radius wide."""
    low, high = points.min(axis=0), points.max(axis=0)
    side = cell_side(high - low, radius)
    nx, ny, nz = (np.floor((high - low) / side).astype(int) + 1).tolist()
    ix, iy = np.floor((points[:, :2] - low[:2]) / side).astype(np.int64).T
    iz = np.floor((high[2] - points[:, 2]) / side).astype(np.int64)
    cells = (ix * ny + iy) * nz + iz
    # By coordinates within a cell, so that the order of the cloud's points changes nothing.
    order = np.lexsort((points[:, 1], points[:, 0], -points[:, 2], cells))
    counts = np.bincount(cells, minlength=nx * ny * nz)
    start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    x, y, z = np.ascontiguousarray(points[order].T)
    return PointGrid(x, y, z, start, low[0], low[1], high[2], side, nx, ny, nz)


def sphere_grid(points: PointGrid, low: np.ndarray, high: np.ndarray, radius: float, capacity: int) -> SphereGrid:
    """Make an empty grid for every place where a sphere can settle on a cloud within [low, high]."""
    margin = 2 * radius
    extent = high - low + 2 * margin
    side = cell_side(extent, 2 * radius)
    nx, ny, nz = (np.floor(extent / side).astype(int) + 1).tolist()
    near = np.zeros((nx, ny, nz), dtype=np.bool_)
    mark_near_points(points, near, low - margin, side, NEAR * radius)
    return SphereGrid(
        np.empty((capacity, 3)),
        np.empty(capacity, np.int32),
        np.full(nx * ny * nz, EMPTY, np.int32),
        np.full(nx * ny, EMPTY, np.int32),
        near.ravel(),
        *(low - margin).tolist(),
        side,
        nx,
        ny,
        nz,
    )


@njit(cache=True)
def mark_near_points(points, near, low, side, reach):
    """Mark the cells in which a centre can lie within ``reach`` of a point."""
    nx, ny, nz = near.shape
    for i in range(points.x.size):
        x, y, z = points.x[i] - low[0], points.y[i] - low[1], points.z[i] - low[2]
        for a in range(max(0, int((x - reach) / side)), min(nx - 1, int((x + reach) / side)) + 1):
            for b in range(max(0, int((y - reach) / side)), min(ny - 1, int((y + reach) / side)) + 1):
                for c in range(max(0, int((z - reach) / side)), min(nz - 1, int((z + reach) / side)) + 1):
                    near[a, b, c] = True


def grown(spheres: SphereGrid, capacity: int) -> SphereGrid:
    """Return the grid with room for more spheres."""
    centers = np.empty((capacity, 3))
    following = np.empty(capacity, np.int32)
    count = len(spheres.following)
    centers[:count] = spheres.centers
    following[:count] = spheres.following
    return spheres._replace(centers=centers, following=following)


@njit(cache=True)
def cell_index(offset, side, count):
    """Return the cell that holds an offset from the grid's edge, or the nearest one."""
    return min(count - 1, max(0, int(offset / side)))


@njit(cache=True)
def insert(spheres, i, x, y, z):
    """Enter settled sphere ``i``."""
    spheres.centers[i, 0] = x
    spheres.centers[i, 1] = y
    spheres.centers[i, 2] = z
    ix = cell_index(x - spheres.left, spheres.cell, spheres.nx)
    iy = cell_index(y - spheres.front, spheres.cell, spheres.ny)
    iz = cell_index(z - spheres.bottom, spheres.cell, spheres.nz)
    column = ix * spheres.ny + iy
    cell = column * spheres.nz + iz
    spheres.following[i] = spheres.first[cell]
    spheres.first[cell] = i
    if iz > spheres.highest[column]:
        spheres.highest[column] = iz


@njit(cache=True)
def may_touch_points(spheres, x, y, z):
    """Tell whether a sphere centred here can be near the cloud at all."""
    ix = int((x - spheres.left) / spheres.cell)
    iy = int((y - spheres.front) / spheres.cell)
    iz = int((z - spheres.bottom) / spheres.cell)
    if ix < 0 or iy < 0 or iz < 0 or ix >= spheres.nx or iy >= spheres.ny or iz >= spheres.nz:
        return True  # outside the grid nothing is known
    return spheres.near_points[(ix * spheres.ny + iy) * spheres.nz + iz]


@njit(cache=True)
def gather(spheres, x, y, z, reach, neighbours):
    """Copy the centres of the settled spheres within ``reach`` of (x, y, z) to ``neighbours``; return how many."""
    count = 0
    first_y = cell_index(y - reach - spheres.front, spheres.cell, spheres.ny)
    last_y = cell_index(y + reach - spheres.front, spheres.cell, spheres.ny)
    low = cell_index(z - reach - spheres.bottom, spheres.cell, spheres.nz)
    top = cell_index(z + reach - spheres.bottom, spheres.cell, spheres.nz)
    for ix in range(
        cell_index(x - reach - spheres.left, spheres.cell, spheres.nx),
        cell_index(x + reach - spheres.left, spheres.cell, spheres.nx) + 1,
    ):
        for iy in range(first_y, last_y + 1):
            column = ix * spheres.ny + iy
            for iz in range(low, min(spheres.highest[column], top) + 1):
                i = spheres.first[column * spheres.nz + iz]
                while i != EMPTY:
                    cx, cy, cz = spheres.centers[i, 0], spheres.centers[i, 1], spheres.centers[i, 2]
                    i = spheres.following[i]
                    if (cx - x) ** 2 + (cy - y) ** 2 + (cz - z) ** 2 < reach * reach:
                        neighbours[count, 0], neighbours[count, 1], neighbours[count, 2] = cx, cy, cz
                        count += 1
    return count
