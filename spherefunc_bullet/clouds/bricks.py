"""A sparse grid of cells, in bricks of 4 x 4 x 4 cells, which exist only if they contain points.

Points lie on surfaces, so most bricks do not exist, and the cells around a point are close to each other in memory; a
plain grid would spend most of its time on memory that is touched for the first time.
"""

from __future__ import annotations

import math

import numpy as np

from ..processes.compilation import lean_njit

COLUMNS = 2  # along each side of a cell
ONE, SIDE, LINE, CELLS = np.uint32(1), np.uint32(2), np.uint32(4), np.uint32(6)  # exponents of two: 2, 4, 16 and 64
INSIDE = np.uint32(3)  # the bits of a cell's position within its brick, along one axis


@lean_njit(forceinline=True)
def within(i, j, k):
    """Return the index of a cell within its brick."""
    return ((i & INSIDE) << LINE) + ((j & INSIDE) << SIDE) + (k & INSIDE)


@lean_njit(forceinline=True)
def place_of(bricks, used, i, j, k):
    """Return the index of a cell in ``contents`` and the number of bricks plus one; a missing brick is created."""
    brick = bricks[i >> SIDE, j >> SIDE, k >> SIDE]
    if brick == 0:
        brick = bricks[i >> SIDE, j >> SIDE, k >> SIDE] = used
        used += ONE
    return (brick << CELLS) + within(i, j, k), used


@lean_njit(forceinline=True)
def stands_for(dx, dy, dz, squared, normal, aside):
    """Return whether a kept point at an offset from another is near it and near its plane, so can replace it."""
    across = abs(dx * normal[0] + dy * normal[1] + dz * normal[2])
    return (dx * dx + dy * dy + dz * dz < squared) & (across <= aside)


@lean_njit(forceinline=True)
def near_in_chain(kept, links, other, x, y, z, squared, normal, aside):
    """Return whether one of the kept points of a cell, a linked list, can replace (x, y, z)."""
    while other > 0:
        dx, dy, dz = kept[other, 0] - x, kept[other, 1] - y, kept[other, 2] - z
        if stands_for(dx, dy, dz, squared, normal, aside):
            return True
        other = np.uint32(links[other, 3])
    return False


@lean_njit(forceinline=True)
def own_cell(offset):
    """Return the cell at an offset in cells; one spare cell precedes the grid."""
    return np.uint32(int(offset) + 1)


@lean_njit(forceinline=True)
def neighbour_brick(offset, offset_in_brick):
    """Return the neighbour of the cell at an offset that is nearer to it."""
    return np.uint32(np.uint32(2 * int(offset + 0.5) + 1) - offset_in_brick)


@lean_njit(forceinline=True)
def has_kept_point_near(bricks, contents, kept, links, x, y, z, across, along, up, squared, normal, aside):
    """Return whether a kept point can replace (x, y, z), at an offset (across, along, up) in cells.

    Cells are two distances wide, so that the ball around a point touches at most two along each axis. The cell of the
    point is searched first, since most points that are too near are there.
    """
    i, j, k = own_cell(across), own_cell(along), own_cell(up)
    for a in (i, neighbour_brick(across, i)):
        for b in (j, neighbour_brick(along, j)):
            for c in (k, neighbour_brick(up, k)):
                last = contents[(bricks[a >> SIDE, b >> SIDE, c >> SIDE] << CELLS) + within(a, b, c)]
                if near_in_chain(kept, links, last, x, y, z, squared, normal, aside):
                    return True
    return False


@lean_njit(cache=True)
def thin_in_bricks(points, backwards, low, distance, normals, ends, aside, bricks, contents, kept, links):
    """Write the points that greedy thinning keeps; return their number.

    Parameters
    ----------
    points, backwards : (N, 3) and (M, 3) float64
        Metres, not below ``low``; the second ones follow the first in reverse order.
    normals, ends, aside
        See `thinning.Planes`.
    bricks, contents
        See `empty_bricks`; with a spare cell on each side. A cell contains its last point.
    kept, links : (N + M + 1, 4) float64 and the same memory as int64
        Receives the kept points from row 1, each with the number of the previous one in its cell.
    """
    used = count = ONE
    plane = 0
    scale = 0.5 / distance
    squared = 0.25 / (scale * scale)
    for p in range(len(points) + len(backwards)):
        point = points[p] if p < len(points) else backwards[len(points) + len(backwards) - 1 - p]
        while p >= ends[plane]:
            plane += 1
        x, y, z = point[0], point[1], point[2]
        across, along, up = (x - low[0]) * scale, (y - low[1]) * scale, (z - low[2]) * scale
        normal = normals[plane]
        if has_kept_point_near(bricks, contents, kept, links, x, y, z, across, along, up, squared, normal, aside):
            continue
        place, used = place_of(bricks, used, own_cell(across), own_cell(along), own_cell(up))
        kept[count, 0], kept[count, 1], kept[count, 2] = x, y, z
        links[count, 3], contents[place] = contents[place], count
        count += ONE
    return count - ONE


@lean_njit(forceinline=True)
def stands_above(point, other, per_metre):
    """Return whether a point of a cell is preferred to another: the highest one in the first column with points.

    Columns, and points of equal height, are ordered by x, then y. The highest point of the whole cell would turn slopes
    into steps.
    """
    per_metre *= COLUMNS
    (x, y, z), (tx, ty, tz) = point, other
    i, j, ti, tj = np.floor(x * per_metre), np.floor(y * per_metre), np.floor(tx * per_metre), np.floor(ty * per_metre)
    before = (x < tx) | ((x == tx) & (y < ty))
    return (i < ti) | ((i == ti) & ((j < tj) | ((j == tj) & ((z > tz) | ((z == tz) & before)))))


@lean_njit(cache=True)
def top_in_bricks(points, per_metre, low, bricks, contents, top):
    """Write the point of each cell that `stands_above` the others, cells in order of appearance; return their number.

    There are no branches, since the processor cannot predict whether a cell is new or a point is kept: the row after
    the last one is infinite and loses against every point.

    Parameters
    ----------
    low : (3,) int64
        The first cell of the grid.
    bricks, contents
        See `empty_bricks`; a cell contains the number of its row, from 1.
    top : (N + 1, 3) float64
        Receives the points.
    """
    used, count = ONE, np.uint32(0)
    top[0, 0], top[0, 1], top[0, 2] = np.inf, 0.0, 0.0  # assigning a whole row would load numba's array functions
    for p in range(len(points)):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        i = np.uint32(int(math.floor(x * per_metre)) - low[0])
        j = np.uint32(int(math.floor(y * per_metre)) - low[1])
        k = np.uint32(int(math.floor(z * per_metre)) - low[2])
        place, used = place_of(bricks, used, i, j, k)
        is_new = contents[place] == 0
        row = np.uint32(count if is_new else contents[place] - ONE)
        contents[place] = row + ONE
        count += np.uint32(is_new)
        top[count, 0], top[count, 1], top[count, 2] = np.inf, 0.0, 0.0
        tx, ty, tz = top[row, 0], top[row, 1], top[row, 2]
        is_over = stands_above((x, y, z), (tx, ty, tz), per_metre)
        top[row, 0] = x if is_over else tx
        top[row, 1] = y if is_over else ty
        top[row, 2] = z if is_over else tz
    return count
