"""Where a scan is sparser than the voxels that it is thinned to, points between neighbours make up for it."""

from __future__ import annotations

from functools import partial

import numpy as np

from .cells import cells
from .neighbors import NEIGHBORS, crowded

_SPARSE = 2.2  # voxels to the sixth neighbour: 1.4 on a surface that fills its voxels
_WIDEST = 0.08  # metres between neighbours: beyond, nothing says that there is a surface
_LOOKED_AT = 1_000  # points that tell whether a scan is sparse anywhere
_SOMEWHERE = 0.02  # of them


def filled(points: np.ndarray, side: float) -> np.ndarray:
    """Return a scan's points (N, 3) followed by those that fill the gaps (M, 3) between neighbours, metres.

    Fused scans are thinned to two or three centimetres and single views spread with distance, while tolerances and
    sizes are measured in voxels of one. What is added lies between two points that are among each other's six nearest:
    no surface grows beyond its edges. The order of the points does not matter.

    Parameters
    ----------
    points : (N, 3) float64, metres
    side : float
        Of the voxels that are to be filled, metres.
    """
    from scipy.spatial import cKDTree

    places = cells(points, side).means
    if len(places) <= NEIGHBORS:
        return points
    tree = cKDTree(places)
    some = places[:: max(1, len(places) // _LOOKED_AT)]
    if np.mean(tree.query(some, NEIGHBORS + 1)[0][:, -1] > _SPARSE * side) < _SOMEWHERE:
        return points
    alone = ~crowded(places, _SPARSE * side)
    nearest = partial(tree.query, k=NEIGHBORS + 1, distance_upper_bound=_WIDEST)
    own, beside = np.flatnonzero(alone), nearest(places[alone])[1]
    is_other = np.zeros(len(places) + 1, bool)  # the last one is that of no neighbour
    is_other[beside] = True
    others = np.flatnonzero(is_other[:-1] & ~alone)
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


def between(places: np.ndarray, pairs: np.ndarray, side: float) -> np.ndarray:
    """Return points (M, 3) a voxel's side apart between the two of each pair (P, 2) of places (N, 3)."""
    start, way = places[pairs[:, 0]], places[pairs[:, 1]] - places[pairs[:, 0]]
    steps = np.ceil(np.linalg.norm(way, axis=1) / side).astype(int)
    chosen = np.repeat(np.arange(len(pairs)), np.maximum(steps - 1, 0))
    ends = np.cumsum(np.maximum(steps - 1, 0))
    rank = np.arange(len(chosen)) - np.repeat(ends - np.maximum(steps - 1, 0), np.maximum(steps - 1, 0)) + 1
    return start[chosen] + way[chosen] * (rank / steps[chosen])[:, None]
