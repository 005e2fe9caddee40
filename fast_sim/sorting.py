"""Sorting of points by the cells of a grid, in an order that does not depend on their original order."""

from __future__ import annotations

import math

import numpy as np

from .kernels import entry_jit, inline_jit

ONE = np.uint32(1)
INSERTED = np.uint32(40)  # largest number of points of a cell that are sorted by insertion


@inline_jit
def cell_index(offset, per_metre, count):
    """Return the cell that contains an offset from the edge of the grid, or the nearest one."""
    return min(count - 1, max(0, int(offset * per_metre)))


@inline_jit
def count_cells(points, low, top, per_metre, nx, ny, nz, cells, filled, start):
    """Write the cell of each point, and twice the number of points in all cells before each cell."""
    for i in range(len(points)):
        ix = cell_index(points[i, 0] - low[0], per_metre, nx)
        iy = cell_index(points[i, 1] - low[1], per_metre, ny)
        cells[i] = (ix * ny + iy) * nz + cell_index(top - points[i, 2], per_metre, nz)
        start[cells[i] + ONE] += ONE
    for cell in range(nx * ny * nz):
        filled[cell] = start[cell]
        start[cell + 1] += start[cell]


@inline_jit
def sort_many(keys, order, first, end):
    """Sort rows of points by their keys, equal ones by the rows themselves (Shell, 1959)."""
    gap = (end - first) // 2
    while gap > 0:
        for i in range(first + gap, end):
            key, row, j = keys[i], order[i], i
            while j >= first + gap and (keys[j - gap] > key or (keys[j - gap] == key and order[j - gap] > row)):
                keys[j], order[j] = keys[j - gap], order[j - gap]
                j -= gap
            keys[j], order[j] = key, row
        gap = 1 if gap == 2 else gap * 5 // 11


@entry_jit
def sort_by_cell(points, low, top, steps, per_metre, nx, ny, nz, cells, filled, order, keys, start, xyz):
    """Write the start of each cell and the sorted points into the last two arguments; those before are scratch.

    Most cells contain few points, which are sorted by insertion without a second pass.
    """
    count_cells(points, low, top, per_metre, nx, ny, nz, cells, filled, start)
    for i in range(len(points)):
        x = np.int64(math.floor((points[i, 0] - low[0]) / steps[0]))
        y = np.int64(math.floor((points[i, 1] - low[1]) / steps[1]))
        z = np.int64(math.floor((points[i, 2] - low[2]) / steps[2]))
        key, cell = (x << 42) | (y << 21) | z, cells[i]
        first, j = start[cell], filled[cell]
        filled[cell] += ONE
        if start[cell + ONE] - first <= INSERTED:
            while j > first and keys[j - ONE] > key:
                order[j], keys[j] = order[j - ONE], keys[j - ONE]
                j -= ONE
        order[j], keys[j] = i, key
    for cell in range(len(filled)):
        if start[cell + 1] - start[cell] > INSERTED:
            sort_many(keys, order, np.int64(start[cell]), np.int64(start[cell + 1]))
    for i in range(len(points)):
        p = order[i]
        xyz[i, 0], xyz[i, 1], xyz[i, 2] = points[p, 0], points[p, 1], points[p, 2]
