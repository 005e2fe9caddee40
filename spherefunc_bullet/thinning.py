"""Greedy thinning: points in order, each kept unless a kept one is too near."""

from __future__ import annotations

import numpy as np
from numba import njit

_MIX = np.int64(-7046029254386353131)  # 2**64 / golden ratio: spreads consecutive keys over the table
_OFFSET = np.int64(1 << 20)  # makes cell numbers positive; 21 bits an axis hold 100 m at 0.1 mm


@njit(cache=True)
def _cell_key(i, j, k):
    return ((i + _OFFSET) << 42) | ((j + _OFFSET) << 21) | (k + _OFFSET)


@njit(cache=True)
def _slot(key, keys, shift):
    """Return the slot of a cell in the open-addressed table, or the free one where it belongs."""
    mask = len(keys) - 1
    slot = np.int64(np.uint64(key * _MIX) >> np.uint64(shift))
    while keys[slot] != key and keys[slot] != -1:
        slot = (slot + 1) & mask
    return slot


@njit(cache=True)
def _is_near(points, point, first, follower, squared):
    """Return whether a kept point of one cell, a chain from ``first``, is nearer than the distance."""
    other = first
    while other >= 0:
        dx = points[other, 0] - points[point, 0]
        dy = points[other, 1] - points[point, 1]
        dz = points[other, 2] - points[point, 2]
        if dx * dx + dy * dy + dz * dz < squared:
            return True
        other = follower[other]
    return False


@njit(cache=True)
def _thin(points, distance, bits):
    """Return the mask of the kept points.

    Cells are two distances wide, so that the ball around a point touches at most two along each axis.
    """
    keep = np.zeros(len(points), dtype=np.bool_)
    keys = np.full(1 << bits, -1, dtype=np.int64)
    heads = np.full(1 << bits, -1, dtype=np.int64)
    follower = np.full(len(points), -1, dtype=np.int64)
    scale = 0.5 / distance
    squared = distance * distance
    shift = 64 - bits
    for p in range(len(points)):
        x, y, z = points[p, 0] * scale, points[p, 1] * scale, points[p, 2] * scale
        # The half-cell on whose side the point lies decides which neighbour its ball can touch.
        i0, j0, k0 = np.int64(np.floor(x - 0.5)), np.int64(np.floor(y - 0.5)), np.int64(np.floor(z - 0.5))
        near = False
        for i in range(i0, i0 + 2):
            for j in range(j0, j0 + 2):
                for k in range(k0, k0 + 2):
                    if not near:
                        slot = _slot(_cell_key(i, j, k), keys, shift)
                        near = keys[slot] != -1 and _is_near(points, p, heads[slot], follower, squared)
        if near:
            continue
        key = _cell_key(np.int64(np.floor(x)), np.int64(np.floor(y)), np.int64(np.floor(z)))
        slot = _slot(key, keys, shift)
        keys[slot] = key
        follower[p] = heads[slot]
        heads[slot] = p
        keep[p] = True
    return keep


def thin(points: np.ndarray, distance: float) -> np.ndarray:
    """Return the points that greedy thinning keeps, in their order.

    Parameters
    ----------
    points : (N, 3) float64, metres
        Earlier points win over later ones.
    distance : float, metres
        No two kept points are nearer to each other; no dropped point is as far from all kept ones.

    Returns
    -------
    (K, 3) float64, metres
    """
    bits = max(8, int(2 * max(len(points), 1)).bit_length())
    return points[_thin(np.ascontiguousarray(points, dtype=np.float64), float(distance), bits)]
