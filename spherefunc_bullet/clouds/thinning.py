"""Greedy thinning: points are processed in order, and each is kept unless a kept one is too near.

Only points of the same plane count as near, so both sides of a thin wall keep their points.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..processes.compilation import njit
from .bricks import stands_above, stands_for, thin_in_bricks, top_in_bricks
from .orientation import corners_of

_MIX = np.int64(-7046029254386353131)  # 2**64 / golden ratio: spreads consecutive keys over the table
MAX_CELLS = 20_000_000  # of a grid, 80 MB; larger or emptier grids are replaced by a hash table
CELLS_A_POINT = 64
NO_POINTS = np.empty((0, 3))
_OFFSET = np.int64(1 << 20)  # makes cell numbers positive; 21 bits per axis suffice for 100 m in cells of 0.1 mm


class Planes(NamedTuple):
    """The planes of points to be thinned, in the order of the points."""

    normals: np.ndarray  # (R, 3) unit normal of each run of points in one plane; 0 for points in no plane
    ends: np.ndarray  # (R,) int64, number of points up to the end of each run
    aside: float  # metres: a kept point farther from the plane of a point is not too near


def empty_bricks(cells: np.ndarray, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the arrays of an empty grid with a number of cells (3,), with room for a number of points.

    Returns
    -------
    bricks : (X, Y, Z) uint32
        The number of each brick, from 1; 0 if it does not exist yet.
    contents : ((B + 1) * 64,) uint32
        The content of each cell of each brick, 0 if empty; brick 0 stays empty. Unused parts take no memory.
    """
    bricks = np.zeros((cells.astype(np.int64) + 3) // 4, np.uint32)
    return bricks, np.zeros(64 * (min(points, bricks.size) + 1), np.uint32)


@njit(cache=True)
def _slot(i, j, k, table, shift):
    """Return the slot of a cell in the open-addressed hash table, or the free slot for it, and its key.

    A row of the table contains the key of a cell and its last point, next to each other in one cache line.
    """
    key = ((i + _OFFSET) << 42) | ((j + _OFFSET) << 21) | (k + _OFFSET)
    mask = len(table) - 1
    slot = np.int64(np.uint64(key * _MIX) >> np.uint64(shift))
    while table[slot, 0] != key and table[slot, 0] != -1:
        slot = (slot + 1) & mask
    return slot, key


@njit(cache=True)
def _near_in_chain(points, other, follower, x, y, z, squared, normal, aside):
    """Return whether one of the kept points of a cell, a linked list, can replace (x, y, z)."""
    while other >= 0:
        dx, dy, dz = points[other, 0] - x, points[other, 1] - y, points[other, 2] - z
        if stands_for(dx, dy, dz, squared, normal, aside):
            return True
        other = follower[other]
    return False


@njit(cache=True)
def _has_kept_point_near(points, p, scale, table, follower, shift, normal, aside):
    """Return whether a kept point that can replace point ``p`` is nearer to it than half a cell.

    Cells are two distances wide, so that the ball around a point touches at most two along each axis: its own and the
    nearer neighbour.
    """
    x, y, z = points[p, 0], points[p, 1], points[p, 2]
    squared = 0.25 / (scale * scale)
    i0 = np.int64(math.floor(x * scale - 0.5))
    j0 = np.int64(math.floor(y * scale - 0.5))
    k0 = np.int64(math.floor(z * scale - 0.5))
    for k in range(k0, k0 + 2):
        for j in range(j0, j0 + 2):
            for i in range(i0, i0 + 2):
                slot, _ = _slot(i, j, k, table, shift)
                last = table[slot, 1]  # -1 in a free slot
                if _near_in_chain(points, last, follower, x, y, z, squared, normal, aside):
                    return True
    return False


@njit(cache=True)
def _thin(points, distance, normals, ends, aside, bits):
    """Return the mask of the kept points."""
    keep = np.zeros(len(points), dtype=np.bool_)
    table = np.full((1 << bits, 2), -1, dtype=np.int64)
    follower = np.full(len(points), -1, dtype=np.int32)
    scale = 0.5 / distance
    shift = 64 - bits
    plane = 0
    for p in range(len(points)):
        while p >= ends[plane]:
            plane += 1
        if _has_kept_point_near(points, p, scale, table, follower, shift, normals[plane], aside):
            continue
        x, y, z = points[p, 0] * scale, points[p, 1] * scale, points[p, 2] * scale
        i, j, k = np.int64(math.floor(x)), np.int64(math.floor(y)), np.int64(math.floor(z))
        slot, key = _slot(i, j, k, table, shift)
        table[slot, 0] = key
        follower[p] = table[slot, 1]
        table[slot, 1] = p
        keep[p] = True
    return keep


def thin(
    points: np.ndarray,
    distance: float,
    backwards: np.ndarray = NO_POINTS,
    planes: Planes | None = None,
    bounds: np.ndarray | None = None,
) -> np.ndarray:
    """Return the points that greedy thinning keeps, in their order.

    Parameters
    ----------
    points : (N, 3) float64, metres
        Earlier points take precedence over later ones.
    distance : float, metres
        No two kept points of one plane are nearer to each other; every dropped point is nearer to a kept one.
    backwards : (M, 3) float64, metres
        Points that follow the others, in reverse order.
    planes : Planes, optional
        Of all points; by default they lie in none.
    bounds : (2, 3) float64, metres, optional
        Corners of a box around all points, if known; rounding may leave points outside.

    Returns
    -------
    (K, 3) float64, metres
    """
    points, distance = np.ascontiguousarray(points, dtype=np.float64), float(distance)
    if bounds is None:
        bounds = corners_of(np.concatenate([corners_of(part) for part in (points, backwards) if len(part)]))
    low, high = bounds
    cells = np.floor((high - low) * (0.5 / distance)) + 3
    count = len(points) + len(backwards)
    planes = planes or Planes(np.zeros((1, 3)), np.array([count]), 0.0)
    if np.prod(cells) <= min(MAX_CELLS, CELLS_A_POINT * count):
        kept = np.empty((count + 1, 4))
        grid = empty_bricks(cells, count)
        count = thin_in_bricks(points, backwards, low, distance, *planes, *grid, kept, kept.view(np.int64))
        return kept[1 : count + 1, :3].copy()
    points = np.concatenate([points, backwards[::-1]])
    bits = max(8, (2 * len(points)).bit_length())  # half of the table stays free, so that every search terminates
    return points[_thin(points, distance, *planes, bits)]


def one_per_cell(points: np.ndarray, side: float, bounds: np.ndarray) -> np.ndarray:
    """Return one of the points (N, 3) in each cube of a side in metres, (M, 3), independent of their order.

    It is the highest one in its column: spheres come from above, and meet the upper side of a thin board. ``bounds``
    (2, 3) are the corners of a box around the points, metres.
    """
    low, high = bounds
    low, cells = np.floor(low / side) - 1, np.floor(high / side) - np.floor(low / side) + 3
    if np.prod(cells) <= min(MAX_CELLS, CELLS_A_POINT * len(points)):
        grid = empty_bricks(cells, len(points))
        top = np.empty((len(points) + 1, 3))
        return top[: top_in_bricks(points, 1 / side, low.astype(np.int64), *grid, top)]
    bits = max(4, math.ceil(math.log2(max(len(points), 1))) + 1)
    return points[_top_of_cells(points, 1 / side, bits)]


@njit(cache=True)
def _top_of_cells(points, per_metre, bits):
    """Return the index of the point of each cell (M,) that `top_in_bricks` keeps, cells in order of appearance."""
    table = np.full((1 << bits, 2), -1, dtype=np.int64)
    shift = 64 - bits
    slots, count = np.empty(len(points), np.int64), 0
    for p in range(len(points)):
        x, y, z = points[p]
        i, j, k = math.floor(x * per_metre), math.floor(y * per_metre), math.floor(z * per_metre)
        slot, key = _slot(np.int64(i), np.int64(j), np.int64(k), table, shift)
        other = table[slot, 1]
        if other < 0:
            table[slot, 0], table[slot, 1] = key, p
            slots[count] = slot
            count += 1
        elif stands_above((x, y, z), (points[other, 0], points[other, 1], points[other, 2]), per_metre):
            table[slot, 1] = p
    return table[slots[:count], 1]
