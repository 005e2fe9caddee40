"""A depth sensor's scatter taken off a surface: points moved onto planes through their neighbours (PCL: MLS)."""

from __future__ import annotations

import numpy as np

from spherefunc_bullet.processes.compilation import njit

from ..scans.cells import cells
from ..scans.neighbors import advance

RADIUS = 0.02  # metres, of the neighbourhood, half of a cup's; wider planes cut its bend; who is near counts more
PASSES = 2
FINE = 0.004  # metres, side of the voxels that the points are thinned to; clouds of whole models are no finer


def smoothed(points: np.ndarray) -> np.ndarray:
    """Return the thinned points (M, 3), each moved along the normal onto the plane through its neighbours, metres.

    Parameters
    ----------
    points : (N, 3) float64, metres
    """
    thinned = cells(points, FINE)
    places, counts = thinned.means, thinned.counts.astype(float)
    for _ in range(PASSES):
        grid = cells(places, RADIUS)
        moved = np.empty_like(places)
        project(np.ascontiguousarray(places[grid.order]), counts[grid.order], grid.keys, grid.start, RADIUS, moved)
        places[grid.order] = moved
    return places


@njit(cache=True, error_model="numpy")
def project(points, counts, keys, start, radius, moved):
    """Move points onto the weighted planes through their neighbours.

    Parameters
    ----------
    points : (N, 3) float64, metres
        Sorted by the cell of a grid as wide as the radius.
    counts : (N,) float64
        How much each point counts.
    keys : (C,) int64
        Of the cells, ascending, as `cells` packs them.
    start : (C + 1,) int64
        The first point of each cell, and the number of all.
    radius : float
        Metres.
    moved : (N, 3) float64, metres
        Receives the points.
    """
    columns = np.zeros((9, 2), np.int64)
    for cell in range(len(keys)):
        advance(columns, keys[cell], keys)
        for i in range(start[cell], start[cell + 1]):
            mean, spread = moments(points, counts, start, columns, radius, i)
            normal = np.linalg.eigh(spread)[1][:, 0]
            moved[i] = points[i] + np.dot(mean, normal) * normal


@njit(cache=True, error_model="numpy")
def moments(points, counts, start, columns, radius, i):
    """Return the weighted mean (3,) of a point's neighbours, relative to it, and their covariance (3, 3)."""
    total, x, y, z = 0.0, 0.0, 0.0, 0.0
    xx, xy, xz, yy, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for column in range(9):
        for j in range(start[columns[column, 0]], start[columns[column, 1]]):
            a, b, c = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
            nearness = 1.0 - (a * a + b * b + c * c) / (radius * radius)
            if nearness > 0:
                weight = counts[j] * nearness * nearness
                total, x, y, z = total + weight, x + weight * a, y + weight * b, z + weight * c
                xx, xy, xz = xx + weight * a * a, xy + weight * a * b, xz + weight * a * c
                yy, yz, zz = yy + weight * b * b, yz + weight * b * c, zz + weight * c * c
    mean = np.array([x, y, z]) / total
    spread = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) / total
    return mean, spread - np.outer(mean, mean)
