"""What stands on a table top, and is an object of its own."""

from __future__ import annotations

import numpy as np

from .clusters import euclidean_clusters
from .patches import find_patches

_SIDE = 0.05  # metres, of the patches that show a table top
_LEVEL = np.cos(np.radians(15.0))
_BIN = 0.01  # metres, of the heights that are compared
_AREA = 0.12  # square metres: a table top, or a seat
_CLEAR = 0.015  # metres above the top at which another thing begins
_GAP = 0.05  # metres: what begins higher above the top does not stand on it
_INSIDE = 0.02  # metres: how far from the top's edge it stands; a chair's back rises from the edge
_SMALL = 0.4  # of the top's area: what is larger is part of the thing


def split_off(points: np.ndarray, found: np.ndarray, tolerance: float) -> np.ndarray:
    """Return clusters (N,) int32 in which what stands within a level top is parted from it.

    A cup on a table touches it, and clusters by distance alone hold both. A back rises from the edge of a seat, and
    stays with it.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    found : (N,) int32
        Clusters by distance.
    tolerance : float
        As for the clusters, metres.
    """
    found = found.copy()
    order = np.argsort(found, kind="stable")
    bounds = np.searchsorted(found[order], np.arange(found.max(initial=-1) + 2))
    new = found.max(initial=-1) + 1
    for k in range(len(bounds) - 1):
        members = order[bounds[k] : bounds[k + 1]]
        if len(members) * 1e-4 < _AREA / 4:  # voxels of a centimetre: too few for a top
            continue
        for part in standing_on(points[members], tolerance):
            found[members[part]] = new
            new += 1
    return found


def standing_on(points: np.ndarray, tolerance: float) -> list[np.ndarray]:
    """Return the indices of each thing that stands on a level top of one cluster's points (N, 3)."""
    parts = []
    taken = np.zeros(len(points), bool)
    for height in tops(points):
        above = np.flatnonzero((points[:, 2] > height + _CLEAR) & ~taken)
        top = points[np.abs(points[:, 2] - height) <= _CLEAR]
        if len(above) < 10 or len(top) < 10:
            continue
        clusters = euclidean_clusters(points[above], tolerance)
        for number in range(clusters.max() + 1):
            thing = above[clusters == number]
            if len(thing) >= 10 and stands_within(points[thing], top, height):
                parts.append(thing)
                taken[thing] = True
    return parts


def tops(points: np.ndarray) -> list[float]:
    """Return the heights of large level tops among points (N, 3), from the highest, metres."""
    patches = find_patches(points, _SIDE)
    level = patches[np.abs(patches.normals[:, 2]) > _LEVEL]
    if not len(level):
        return []
    lowest = np.floor(level.centers[:, 2].min() / _BIN)
    bins = (np.floor(level.centers[:, 2] / _BIN) - lowest).astype(int)
    area = np.convolve(np.bincount(bins, level.areas), np.ones(3), "same") if bins.max() >= 2 else np.array([])
    if not len(area):
        return [float(np.median(level.centers[:, 2]))] if level.areas.sum() >= _AREA else []
    heights = []
    while area.max() >= _AREA:
        peak = int(np.argmax(area))
        near = np.abs(bins - peak) <= 1
        heights.append(float(np.average(level.centers[near, 2], weights=level.areas[near])))
        area[max(0, peak - 4) : peak + 5] = 0
    return sorted(heights, reverse=True)


def stands_within(thing: np.ndarray, top: np.ndarray, height: float) -> bool:
    """Return whether a thing (T, 3) stands on a top (S, 3) at a height, away from its edges, and is smaller."""
    from scipy.spatial import ConvexHull, QhullError

    if thing[:, 2].min() > height + _GAP:
        return False
    foot = thing[thing[:, 2] < height + 2 * _GAP, :2]
    try:
        hull, own = ConvexHull(top[:, :2]), ConvexHull(thing[:, :2])
    except QhullError:
        return False
    outside = hull.equations[:, :2] @ foot.T + hull.equations[:, 2:]
    return bool(own.volume < _SMALL * hull.volume and outside.max() < -_INSIDE)


def top_below(points: np.ndarray, others: list[np.ndarray]) -> float:
    """Return the height of the level top that an object (N, 3) stands on, 0 for the floor, metres."""
    bottom = float(np.percentile(points[:, 2], 0.5))
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    best = 0.0
    for other in others:
        under = (other[:, :2] > low - _GAP).all(axis=1) & (other[:, :2] < high + _GAP).all(axis=1)
        near = under & (other[:, 2] < bottom + _CLEAR) & (other[:, 2] > bottom - _GAP)
        if near.sum() >= 10:
            best = max(best, float(np.median(other[near, 2])))
    return best
