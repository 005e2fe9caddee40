"""Uniform grids for neighbour search in the cloud and among the settled spheres.

Both cover the bounding box and are divided into vertical columns, because a sphere falls along one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .kernels import entry_jit, inline_jit
from .lanes import MOST_LANES
from .sorting import cell_index, sort_by_cell

MAX_CELLS = 40_000_000  # of either grid, 160 MB; a larger box gets larger cells, which cost time, not memory
BLOCK = 4  # spheres, as `near_of_four` tests
CACHE_LINE = 8  # numbers
NEAR, TOUCHING = np.uint8(1), np.uint8(2)  # of `SphereGrid.near_points`
STEPS = (0, -1, 1)  # to the surrounding cells, the own one first
SPACING_POINTS = 1000  # for the median distance between neighbours, whose error is then a few per cent


class PointGrid(NamedTuple):
    """The cloud, sorted by column and, within a column, by cell from the top down."""

    xyz: np.ndarray  # (N, 3) metres, in grid order; in memory all x, then all y, then all z
    start: np.ndarray  # (columns * nz + 1,) uint32, first point of each cell
    left: float  # of the grid, metres
    front: float
    top: float
    cell: float  # side, metres
    per_metre: float  # cells, 1 / cell: dividing costs four times as much as multiplying
    nx: int
    ny: int
    nz: int


class SphereGrid(NamedTuple):
    """The settled spheres, in columns two radii wide, each a chain of blocks that grows with the pile.

    A rolling sphere is on top of the pile, so a column is searched from its last block downwards, and only as long as
    lower blocks contain centres that are high enough.
    """

    centers: np.ndarray  # (capacity, 3) metres, in the order in which they settled
    # (nx * ny + block capacity, 4, BLOCK): the same centres by column, with all x, all y and all z in rows 1 to 3.
    # Unused entries are infinite, so that a block is searched without a test of how full it is. The first nx * ny
    # blocks are the last ones of the columns, in the order of the columns, since nearly all accesses go there. Row 0 is
    # the head of a block: the highest centre in the previous blocks of the column, metres, or -inf; the number of
    # centres in this block; the number of the previous block; and, in the last block, the highest centre of the column.
    blocks: np.ndarray
    used: np.ndarray  # (1,) uint32, blocks in use
    # (nx * ny * nz,) uint8: 0 if the cloud cannot affect a sphere centred in the cell, NEAR if it can, TOUCHING if it
    # can also end a fall; empty if unknown.
    near_points: np.ndarray
    left: float
    front: float
    bottom: float
    cell: float  # side, metres
    per_metre: float  # cells, 1 / cell: dividing costs four times as much as multiplying
    nx: int
    ny: int
    nz: int


def cell_side(extent: np.ndarray, side: float) -> float:
    """Return the cell side, at least ``side``, that keeps the grid within MAX_CELLS."""
    while np.prod(np.ceil(extent / side) + 3) > MAX_CELLS:
        side *= 1.3
    return side


def point_grid(points: np.ndarray, low: np.ndarray, high: np.ndarray, radius: float) -> PointGrid:
    """Sort a cloud (N, 3) within [low, high] into columns two radii wide, or one radius for large spheres.

    The points of a cell are sorted by x, y and z in small steps, so that the order of the cloud does not matter.
    """
    side = cell_side(high - low, max(radius, min(2 * radius, 0.02)))  # larger cells contain more points
    nx, ny, nz = (np.floor((high - low) / side).astype(int) + 1).tolist()
    steps = np.maximum((high - low) / 2**20, 1e-12)  # a million per axis, about a micrometre
    count, start, filled = len(points), np.zeros(nx * ny * nz + 1, np.uint32), np.empty(nx * ny * nz, np.uint32)
    cells, order, keys = np.empty(count, np.uint32), np.empty(count, np.uint32), np.empty(count, np.int64)
    xyz = np.empty(3 * count + MOST_LANES)[: 3 * count].reshape(3, count).T  # lanes read beyond the last point
    sort_by_cell(points, low, high[2], steps, 1 / side, nx, ny, nz, cells, filled, order, keys, start, xyz)
    return PointGrid(xyz, start, low[0], low[1], high[2], side, 1 / side, nx, ny, nz)


def point_spacing(points: PointGrid) -> float:
    """Return the median distance of about a thousand evenly chosen points from their nearest neighbours, metres."""
    count = len(points.xyz)
    chosen = np.arange(0, count, max(1, count // SPACING_POINTS))
    nearest = np.empty(len(chosen))
    find_nearest(points, chosen, nearest)
    return float(np.median(nearest))


@entry_jit
def find_nearest(points, chosen, nearest):
    """Write the distance of each chosen point from its nearest neighbour, at most the side of a cell.

    The cell of the point is searched first, since it usually contains the nearest neighbour.
    """
    for k in range(len(chosen)):
        x, y, z = points.xyz[chosen[k], 0], points.xyz[chosen[k], 1], points.xyz[chosen[k], 2]
        across, along, down = x - points.left, y - points.front, points.top - z
        best = points.cell * points.cell
        ix = cell_index(across, points.per_metre, points.nx)
        iy = cell_index(along, points.per_metre, points.ny)
        iz = cell_index(down, points.per_metre, points.nz)
        for step_x in STEPS:
            gap_x = gap_to(across, ix + step_x, points.cell, points.nx)
            for step_y in STEPS:
                gap_y = gap_to(along, iy + step_y, points.cell, points.ny)
                if gap_x * gap_x + gap_y * gap_y > best:
                    continue
                for step_z in STEPS:
                    gap_z = gap_to(down, iz + step_z, points.cell, points.nz)
                    if gap_x * gap_x + gap_y * gap_y + gap_z * gap_z > best:
                        continue
                    cell = ((ix + step_x) * points.ny + iy + step_y) * points.nz + iz + step_z
                    for i in range(points.start[cell], points.start[cell + 1]):
                        dx, dy, dz = points.xyz[i, 0] - x, points.xyz[i, 1] - y, points.xyz[i, 2] - z
                        if i != chosen[k]:
                            best = min(best, dx * dx + dy * dy + dz * dz)
        nearest[k] = math.sqrt(best)


@inline_jit
def gap_to(place, cell, side, count):
    """Return a lower bound of the distance of a place from a cell along one axis, metres; infinite outside the grid."""
    if cell < 0 or cell >= count:
        return math.inf
    return max(0.0, max(cell * side - place, place - (cell + 1) * side) - 1e-9)


def sphere_grid(
    points: PointGrid, low: np.ndarray, high: np.ndarray, radius: float, reach: float | None, capacity: int
) -> SphereGrid:
    """Return an empty grid for all places where a sphere can settle on a cloud within [low, high].

    ``reach`` is the largest distance at which the cloud affects a sphere, metres; None: do not compute where it does.
    """
    margin = 2 * radius
    extent = high - low + 2 * margin
    side = cell_side(extent, 2 * radius)
    nx, ny, nz = (np.floor(extent / side).astype(int) + 1).tolist()
    near = np.zeros((nx, ny, nz) if reach is not None else 0, np.uint8)
    if reach is not None:
        for within, mark in ((reach, NEAR), (radius, TOUCHING)):
            mark_near_points(points, near, low - margin, 1 / side, 1.0001 * within, mark)
    centers, blocks = sphere_rows(nx * ny, capacity)
    blocks[: nx * ny, 0], blocks[: nx * ny, 1:] = (-np.inf, 0, 0, -np.inf), np.inf
    used = np.full(1, nx * ny, np.uint32)
    frame = (*(low - margin).tolist(), side, 1 / side, nx, ny, nz)
    return SphereGrid(centers, blocks, used, near.ravel(), *frame)


def sphere_rows(columns: int, capacity: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the arrays of centres and blocks for a number of spheres."""
    numbers = (columns + capacity // BLOCK) * 4 * BLOCK
    room = np.empty(numbers + CACHE_LINE)
    skipped = -(room.ctypes.data // room.itemsize) % CACHE_LINE  # so that a block covers two cache lines, not three
    return np.empty((capacity, 3)), room[skipped : skipped + numbers].reshape(-1, 4, BLOCK)


@entry_jit
def mark_near_points(points, near, low, per_metre, reach, mark):
    """Write ``mark`` into the cells in which a centre can lie within ``reach`` of a point."""
    nx, ny, nz = near.shape
    for i in range(len(points.xyz)):
        x, y, z = points.xyz[i, 0] - low[0], points.xyz[i, 1] - low[1], points.xyz[i, 2] - low[2]
        last_a = cell_index(x + reach, per_metre, nx)
        last_b = cell_index(y + reach, per_metre, ny)
        last_c = cell_index(z + reach, per_metre, nz)
        for a in range(cell_index(x - reach, per_metre, nx), last_a + 1):
            for b in range(cell_index(y - reach, per_metre, ny), last_b + 1):
                for c in range(cell_index(z - reach, per_metre, nz), last_c + 1):
                    near[a, b, c] = mark


def enlarged(spheres: SphereGrid, capacity: int) -> SphereGrid:
    """Return a copy of the grid with room for more spheres."""
    room = sphere_rows(spheres.nx * spheres.ny, capacity)
    for new, old in zip(room, spheres, strict=False):
        new[: len(old)] = old
    return SphereGrid(*room, *spheres[len(room) :])


@inline_jit
def insert(spheres, x, y, z, spare):
    """Add a settled sphere to its column, which may need the ``spare`` block; return whether it did."""
    ix = cell_index(x - spheres.left, spheres.per_metre, spheres.nx)
    iy = cell_index(y - spheres.front, spheres.per_metre, spheres.ny)
    last = spheres.blocks[ix * spheres.ny + iy]
    is_full = last[0, 1] == BLOCK
    if is_full:
        for row in range(4):
            for k in range(BLOCK):
                spheres.blocks[spare, row, k] = last[row, k]
        last[0, 0], last[0, 1], last[0, 2] = last[0, 3], 0, spare
        last[1:] = np.inf
    k = int(last[0, 1])
    last[1, k], last[2, k], last[3, k] = x, y, z
    last[0, 1] = k + 1
    last[0, 3] = max(last[0, 3], z)
    return is_full


@inline_jit
def columns_around(grid, x, y, reach):
    """Return the first and last column of a grid within ``reach`` of (x, y), along x and along y."""
    return (
        cell_index(x - reach - grid.left, grid.per_metre, grid.nx),
        cell_index(x + reach - grid.left, grid.per_metre, grid.nx),
        cell_index(y - reach - grid.front, grid.per_metre, grid.ny),
        cell_index(y + reach - grid.front, grid.per_metre, grid.ny),
    )


@inline_jit
def may_touch_points(spheres, x, y, z):
    """Return whether a sphere with its centre at (x, y, z) can be near the cloud."""
    ix = int((x - spheres.left) * spheres.per_metre)
    iy = int((y - spheres.front) * spheres.per_metre)
    iz = int((z - spheres.bottom) * spheres.per_metre)
    if len(spheres.near_points) == 0 or min(ix, iy, iz) < 0 or ix >= spheres.nx or iy >= spheres.ny or iz >= spheres.nz:
        return True  # outside the grid nothing is known
    return 0 < spheres.near_points[(ix * spheres.ny + iy) * spheres.nz + iz]


@inline_jit
def falls_past_points(spheres, x, y, high, low):
    """Return whether the cloud is too far away to stop a sphere whose centre falls from ``high`` to ``low``."""
    ix = int((x - spheres.left) * spheres.per_metre)
    iy = int((y - spheres.front) * spheres.per_metre)
    iz = int((low - spheres.bottom) * spheres.per_metre)
    outside = x < spheres.left or y < spheres.front or low < spheres.bottom or ix >= spheres.nx or iy >= spheres.ny
    if outside or len(spheres.near_points) == 0:
        return False  # outside the grid nothing is known
    column = (ix * spheres.ny + iy) * spheres.nz
    above = min(spheres.nz, int((high - spheres.bottom) * spheres.per_metre) + 1)  # two radii over all points
    for cell in range(column + iz, column + above):
        if spheres.near_points[cell] == TOUCHING:
            return False
    return True
