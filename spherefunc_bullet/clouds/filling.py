"""Sparse clouds of one object: the triangles between neighbouring points are filled, so that spheres do not fall through."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from .cloud import Cloud, placed
from .thinning import one_per_cell

PITCH = 0.004  # metres between points that fill
DENSE = 0.005  # metres: side of the cubes of which a dense cloud's hold several points each
ALONE = 0.82  # of the points, from which on nearly each has a cube of its own: a mesh's samples are 0.7
MANY = 60_000  # points, which are not sparse on any object that one asks about; scattered by noise rather
NEIGHBORS = 8
WIDEST = 0.08  # metres between neighbours: beyond, nothing says that there is a surface
LONGEST = 2.5  # times the middle distance of a point's neighbours


def filled(cloud: Cloud) -> Cloud:
    """Return a cloud whose gaps between neighbouring points are filled, itself where it is dense or has a mesh.

    What is added lies within triangles of points that are among each other's nearest, so that no surface grows beyond
    its edges. The order of the points does not matter.
    """
    if cloud.mesh is not None or len(cloud) > MANY or len(cloud.thinned(DENSE)) < ALONE * len(cloud):
        return cloud
    more = between(cloud.points)
    if not len(more):
        return cloud
    points = np.concatenate([cloud.points, one_per_cell(more, PITCH, np.array([more.min(axis=0), more.max(axis=0)]))])
    return Cloud(placed(points), cloud.name)


def between(points: np.ndarray) -> np.ndarray:
    """Return points (M, 3) within the triangles of neighbouring points (N, 3), metres."""
    triangles = points[neighbouring(points)]
    longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1, initial=0)
    steps = np.ceil(longest / PITCH).astype(int)
    parts = [np.empty((0, 3))]
    for count in np.unique(steps[steps > 1]).tolist():
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
        inside = i + j <= count
        weights = np.stack([i[inside], j[inside], count - i[inside] - j[inside]], axis=1) / count
        parts.append(np.einsum("wc,tcx->twx", weights, triangles[steps == count]).reshape(-1, 3))
    return np.concatenate(parts)


def neighbouring(points: np.ndarray) -> np.ndarray:
    """Return the triangles (T, 3) of points (N, 3) of which each is among the nearest of the two others."""
    count = len(points)
    distances, near = cKDTree(points).query(points, min(NEIGHBORS + 1, count), distance_upper_bound=WIDEST)
    far = distances > LONGEST * np.median(np.where(np.isfinite(distances), distances, WIDEST)[:, 1:], axis=1)[:, None]
    first, second = np.repeat(np.arange(count), near.shape[1]), np.where(far, count, near).ravel()
    known = (second < count) & (first != second)
    keys = np.sort(first[known] * count + second[known])
    mutual = np.intersect1d(keys, second[known] * count + first[known], assume_unique=True)
    pairs = np.column_stack([mutual // count, mutual % count])
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]  # sorted
    starts = np.searchsorted(pairs[:, 0], np.arange(count + 1))
    own = starts[pairs[:, 0] + 1] - np.arange(len(pairs)) - 1  # pairs of the same first point that come after
    one = np.repeat(np.arange(len(pairs)), own)
    other = one + 1 + np.arange(len(one)) - np.repeat(np.cumsum(own) - own, own)
    third = np.searchsorted(mutual, pairs[one, 1] * count + pairs[other, 1]).clip(max=max(len(mutual) - 1, 0))
    closed = mutual[third] == pairs[one, 1] * count + pairs[other, 1] if len(mutual) else np.zeros(0, bool)
    return np.column_stack([pairs[one, 0], pairs[one, 1], pairs[other, 1]])[closed]
