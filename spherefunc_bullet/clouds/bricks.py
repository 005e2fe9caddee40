"""A dense grid of cells, in bricks of 4 x 4 x 4 of which there are only those that hold points.

Points lie on surfaces, so most bricks are none, and the cells around a point are near each other in memory: most of the
time of a plain grid goes into memory that is touched for the first time.
"""

from __future__ import annotations

import math

import numpy as np

from ..processes.compilation import lean_njit

COLUMNS = 2  # along each side of a cell
ONE, SIDE, LINE, CELLS = np.uint32(1), np.uint32(2), np.uint32(4), np.uint32(6)  # as powers of two: 2, 4, 16 and 64
INSIDE = np.uint32(3)  # the bits of a cell's place within its brick, along one axis


@lean_njit(forceinline=True)
def within(i, j, k):
    """Return the place of a cell within its brick."""
    return ((i & INSIDE) << LINE) + ((j & INSIDE) << SIDE) + (k & INSIDE)


@lean_njit(forceinline=True)
def place_of(bricks, used, i, j, k):
    """Return the place of a cell, its brick made if there is none, and how many bricks there are, the empty one too."""
    brick = bricks[i >> SIDE, j >> SIDE, k >> SIDE]
    if brick == 0:
        brick = bricks[i >> SIDE, j >> SIDE, k >> SIDE] = used
        used += ONE
    return (brick << CELLS) + within(i, j, k), used


@lean_njit(forceinline=True)
def stands_for(dx, dy, dz, squared, normal, aside):
    """Return whether a kept point so far from another is near it, and in its plane, or no farther beside it."""
    across = abs(dx * normal[0] + dy * normal[1] + dz * normal[2])
    return (dx * dx + dy * dy + dz * dz < squared) & (across <= aside)


@lean_njit(forceinline=True)
def near_in_chain(kept, links, other, x, y, z, squared, normal, aside):
    """Return whether a kept point of a cell stands for (x, y, z); each is followed by the one it links to."""
    while other > 0:
        dx, dy, dz = kept[other, 0] - x, kept[other, 1] - y, kept[other, 2] - z
        if stands_for(dx, dy, dz, squared, normal, aside):
            return True
        other = np.uint32(links[other, 3])
    return False


@lean_njit(forceinline=True)
def own_cell(offset):
    """Return the cell of an offset in cells from the first whole one, before which there is one to spare."""
    return np.uint32(int(offset) + 1)


@lean_njit(forceinline=True)
def neighbour_brick(offset, offset_in_brick):
    """Return the cell next to the own one of an offset on whose side it lies."""
    return np.uint32(np.uint32(2 * int(offset + 0.5) + 1) - offset_in_brick)


@lean_njit(forceinline=True)
def has_kept_point_near(bricks, contents, kept, links, x, y, z, across, along, up, squared, normal, aside):
    """Return whether a kept point stands for (x, y, z), which lies this many cells from the grid's first whole one.

    Cells are two distances wide, so that the ball around a point touches at most two along each axis. The point's own
    one is looked at first, since what is too near mostly is there.
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
    """Write the points that greedy thinning keeps; return how many.

    Parameters
    ----------
    points, backwards : (N, 3) and (M, 3) float64
        From ``low`` on, metres; after the first ones come the others, the last one first.
    normals, ends, aside
        See `thinning.Planes`.
    bricks, contents
        As `empty_bricks` makes them, with a cell to spare on each side; a cell holds its last point.
    kept, links : (N + M + 1, 4) float64 and the same as int64
        Receives the kept points from row 1, each with the number of the one before it in its cell.
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
    """Return whether a point of a cell is kept rather than another: the highest in the first column that has points.

    Columns are ordered in x, then y, points of one height too. The highest of the whole cell makes steps of a slope.
    """
    per_metre *= COLUMNS
    (x, y, z), (tx, ty, tz) = point, other
    i, j, ti, tj = np.floor(x * per_metre), np.floor(y * per_metre), np.floor(tx * per_metre), np.floor(ty * per_metre)
    before = (x < tx) | ((x == tx) & (y < ty))
    return (i < ti) | ((i == ti) & ((j < tj) | ((j == tj) & ((z > tz) | ((z == tz) & before)))))


@lean_njit(cache=True)
def top_in_bricks(points, per_metre, low, bricks, contents, top):
    """Write of points (N, 3) the one of each cell that `stands_above` others, in the order of cells; return how many.

    Without questions, since whether a cell is new, or a point kept, cannot be foreseen: the row after the last one
    comes after all points.

    Parameters
    ----------
    low : (3,) int64
        The first cell of the grid.
    bricks, contents
        As `empty_bricks` makes them; a cell holds the number of its row, from 1.
    top : (N + 1, 3) float64
        Receives them.
    """
    used, count = ONE, np.uint32(0)
    top[0, 0], top[0, 1], top[0, 2] = np.inf, 0.0, 0.0  # a row at once would load numba's functions of arrays
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
