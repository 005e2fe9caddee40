"""Where a scan is sparser than the voxels that it is thinned to, points between neighbours make up for it."""

from __future__ import annotations

import numpy as np

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
    distances, neighbors = tree.query(places, _NEIGHBORS + 1, distance_upper_bound=_WIDEST)
    return np.vstack([points, between(places, mutual_pairs(distances, neighbors, _SPARSE * side), side)])


def mutual_pairs(distances: np.ndarray, neighbors: np.ndarray, sparse: float) -> np.ndarray:
    """Return the pairs (P, 2) of points that are each other's neighbours, at least one where neighbours are far.

    Parameters
    ----------
    distances, neighbors : (N, K + 1) float64 and int64
        Of each point and its neighbours, itself first; infinite and N where there are no more.
    sparse : float
        Metres to the last neighbour from which on a point counts as standing alone.
    """
    count = len(distances)
    first = np.repeat(np.arange(count), neighbors.shape[1] - 1)
    second = neighbors[:, 1:].ravel()
    known = second < count
    keys = np.sort((np.minimum(first, second) * (count + 1) + np.maximum(first, second))[known])
    keys = keys[1:][keys[1:] == keys[:-1]]
    pairs = np.column_stack([keys // (count + 1), keys % (count + 1)])
    alone = distances[:, -1] > sparse
    return pairs[alone[pairs].any(axis=1)]


def between(places: np.ndarray, pairs: np.ndarray, side: float) -> np.ndarray:
    """Return points (M, 3) a voxel's side apart between the two of each pair (P, 2) of places (N, 3)."""
    start, way = places[pairs[:, 0]], places[pairs[:, 1]] - places[pairs[:, 0]]
    steps = np.ceil(np.linalg.norm(way, axis=1) / side).astype(int)
    chosen = np.repeat(np.arange(len(pairs)), np.maximum(steps - 1, 0))
    ends = np.cumsum(np.maximum(steps - 1, 0))
    rank = np.arange(len(chosen)) - np.repeat(ends - np.maximum(steps - 1, 0), np.maximum(steps - 1, 0)) + 1
    return start[chosen] + way[chosen] * (rank / steps[chosen])[:, None]
