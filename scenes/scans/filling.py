"""Where a scan is sparser than the voxels that it is thinned to, points between neighbours make up for it."""

from __future__ import annotations

from functools import partial

import numpy as np
from numba import njit

from .cells import cells

_NEIGHBORS = 6  # of a point within a surface
_SPARSE = 2.2  # voxels to the sixth neighbour: 1.4 on a surface that fills its voxels
_WIDEST = 0.08  # metres between neighbours: beyond, nothing says that there is a surface
_LOOKED_AT = 1_000  # points that tell whether a scan is sparse anywhere
_SOMEWHERE = 0.02  # of them


def filled(points: np.ndarray, side: float) -> np.ndarray:
    """Return a scan's points (N, 3) followed by those that fill the gaps (M, 3) between neighbours, metres.

    Fused scans are thinned to two or three centimetres and single views spread with distance, while tolerances and
    sizes are told in voxels of one. What is added lies between two points that are among each other's six nearest, so
    no surface grows beyond its edges. The order of the points does not matter.

    Parameters
    ----------
    points : (N, 3) float64, metres
    side : float
        Of the voxels that are to be filled, metres.
    """
    from scipy.spatial import cKDTree

    places = cells(points, side).means
    if len(places) <= _NEIGHBORS:
        return points
    tree = cKDTree(places)
    some = places[:: max(1, len(places) // _LOOKED_AT)]
    if np.mean(tree.query(some, _NEIGHBORS + 1)[0][:, -1] > _SPARSE * side) < _SOMEWHERE:
        return points
    alone = ~crowded(places, _SPARSE * side)
    nearest = partial(tree.query, k=_NEIGHBORS + 1, distance_upper_bound=_WIDEST)
    own, beside = np.flatnonzero(alone), nearest(places[alone])[1]
    others = np.setdiff1d(beside[beside < len(places)], own)
    asked, neighbors = np.append(own, others), np.vstack([beside, nearest(places[others])[1]])
    return np.vstack([points, between(places, mutual_pairs(asked, neighbors, alone), side)])


def mutual_pairs(asked: np.ndarray, neighbors: np.ndarray, alone: np.ndarray) -> np.ndarray:
    """Return the pairs (P, 2) of points that are each other's neighbours, at least one of which stands alone.

    Parameters
    ----------
    asked : (A,) int64
        Of N points those that stand alone, and their neighbours.
    neighbors : (A, K + 1) int64
        Of each of these and its neighbours, itself first; N where there are no more.
    alone : (N,) bool
    """
    count = len(alone)
    first = np.repeat(asked, neighbors.shape[1] - 1)
    second = neighbors[:, 1:].ravel()
    known = second < count
    keys = np.sort((np.minimum(first, second) * (count + 1) + np.maximum(first, second))[known])
    keys = keys[1:][keys[1:] == keys[:-1]]
    pairs = np.column_stack([keys // (count + 1), keys % (count + 1)])
    return pairs[alone[pairs[:, 0]] | alone[pairs[:, 1]]]


def crowded(places: np.ndarray, reach: float) -> np.ndarray:
    """Return which places (N, 3) have as many others within a reach in metres as a point has neighbours, (N,) bool."""
    grid = cells(places, reach)
    enough = np.zeros(len(places), np.bool_)
    count_around(np.ascontiguousarray(places[grid.order]), grid.keys, grid.start, reach * reach, enough)
    out = np.empty(len(places), bool)
    out[grid.order] = enough
    return out


@njit(cache=True, error_model="numpy")
def count_around(points, keys, start, square, enough):
    """Mark the points that have enough others within a reach.

    Parameters
    ----------
    points : (N, 3) float64, metres
        Sorted by the cell of a grid as wide as the reach.
    keys : (C,) int64
        Of the cells, ascending, as `cells` packs them.
    start : (C + 1,) int64
        The first point of each cell, and the number of all.
    square : float
        Of the reach, square metres.
    enough : (N,) bool
        Receives them.
    """
    columns = np.empty((9, 2), np.int64)
    for cell in range(len(keys)):
        for column in range(9):  # the three cells along z follow one another
            key = keys[cell] + ((column // 3 - 1) << 42) + ((column % 3 - 1) << 21)
            columns[column, 0] = start[np.searchsorted(keys, key - 1)]
            columns[column, 1] = start[np.searchsorted(keys, key + 2)]
        for i in range(start[cell], start[cell + 1]):
            count = -1  # itself
            for column in range(9):
                for j in range(columns[column, 0], columns[column, 1]):
                    x, y, z = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1], points[i, 2] - points[j, 2]
                    count += x * x + y * y + z * z <= square
                if count >= _NEIGHBORS:
                    break
            enough[i] = count >= _NEIGHBORS


def between(places: np.ndarray, pairs: np.ndarray, side: float) -> np.ndarray:
    """Return points (M, 3) a voxel's side apart between the two of each pair (P, 2) of places (N, 3)."""
    start, way = places[pairs[:, 0]], places[pairs[:, 1]] - places[pairs[:, 0]]
    steps = np.ceil(np.linalg.norm(way, axis=1) / side).astype(int)
    chosen = np.repeat(np.arange(len(pairs)), np.maximum(steps - 1, 0))
    ends = np.cumsum(np.maximum(steps - 1, 0))
    rank = np.arange(len(chosen)) - np.repeat(ends - np.maximum(steps - 1, 0), np.maximum(steps - 1, 0)) + 1
    return start[chosen] + way[chosen] * (rank / steps[chosen])[:, None]
