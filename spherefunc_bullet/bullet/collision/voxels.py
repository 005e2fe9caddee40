"""Occupied voxels, each represented by points of the cloud instead of a box.

On boxes, every slope would be stairs on which spheres stay. So a voxel with one flat surface, or with two as in a
board, is represented by one point of each surface; one in which a surface bends keeps its two outermost points.
"""

from __future__ import annotations

import numpy as np

from ...processes.compilation import njit

RIM = 0.4  # of a voxel's side: distance between the mean of its points and that of the points around it at a rim


def representatives(points: np.ndarray, voxel_size: float, tolerance: float) -> np.ndarray:
    """Return the points (R, 3), sorted, that represent the occupied voxels of a cloud.

    Parameters
    ----------
    points : (N, 3) float64
    voxel_size : float, unit of the points
    tolerance : float
        Largest distance of points from the plane of a surface that one of them represents.
    """
    points, starts, around = in_voxels(points, voxel_size)
    chosen = points[represent(points, starts, around, voxel_normals(points, starts), voxel_size, tolerance)]
    return chosen[np.lexsort(chosen.T[::-1])]


def in_voxels(points: np.ndarray, voxel_size: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the points sorted by voxel, the start of each voxel (V + 1,), and the mean of the points around (V, 3)."""
    low = points.min(axis=0)
    cells = np.floor((points - low) / voxel_size).astype(np.int64) + 1
    dims = cells.max(axis=0) + 2
    keys = (cells[:, 0] * dims[1] + cells[:, 1]) * dims[2] + cells[:, 2]
    order = np.lexsort((*points.T[::-1], keys))
    points, keys = points[order], keys[order]
    voxels, starts = np.unique(keys, return_index=True)
    sums, counts = np.add.reduceat(points, starts), np.diff(starts, append=len(points))
    around, members = np.zeros_like(sums), np.zeros(len(voxels))
    for shift in np.ndindex(3, 3, 3):
        key = voxels + (shift[0] - 1) * dims[1] * dims[2] + (shift[1] - 1) * dims[2] + shift[2] - 1
        at = np.minimum(np.searchsorted(voxels, key), len(voxels) - 1)
        hit = voxels[at] == key
        around[hit] += sums[at[hit]]
        members[hit] += counts[at[hit]]
    return points, np.append(starts, len(points)), around / members[:, None]


def voxel_normals(points: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Return the direction (V, 3) of the smallest spread of the points of each voxel."""
    counts = np.diff(starts)[:, None]
    means = np.add.reduceat(points, starts[:-1]) / counts
    offsets = points - np.repeat(means, counts[:, 0], axis=0)
    products = offsets[:, [0, 0, 0, 1, 1, 2]] * offsets[:, [0, 1, 2, 1, 2, 2]]
    sums = np.add.reduceat(products, starts[:-1])
    return np.linalg.eigh(sums[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3))[1][:, :, 0]


@njit(cache=True, error_model="numpy")
def represent(points, starts, around, normals, voxel_size, tolerance):
    """Return the mask of the chosen points.

    If the points of a voxel lie in one or two layers within the tolerance, each layer keeps the point nearest to its
    middle or, at a rim, the outermost one. Otherwise the voxel keeps the point farthest from the middle of its
    surroundings and the two that stand out most along the normal.
    """
    chosen = np.zeros(len(points), np.bool_)
    for v in range(len(starts) - 1):
        first, last = starts[v], starts[v + 1]
        inside, center = points[first:last], around[v]
        across = inside[:, 0] * normals[v, 0] + inside[:, 1] * normals[v, 1] + inside[:, 2] * normals[v, 2]
        layers, border = split(across, tolerance)
        if layers == 0:
            chosen[first + extreme(inside, across, -np.inf, center, True)] = True
            chosen[first + np.argmin(across)] = True
            chosen[first + np.argmax(across)] = True
            continue
        for layer in range(layers):
            sign = 1.0 if layer == 0 else -1.0
            limit = -np.inf if layers == 1 else sign * border
            mean = mean_beyond(inside, sign * across, limit)
            rim = np.sum((mean - center) ** 2) > (RIM * voxel_size) ** 2
            chosen[first + extreme(inside, sign * across, limit, center if rim else mean, rim)] = True
    return chosen


@njit(cache=True, error_model="numpy")
def split(across, tolerance):
    """Return the number of layers in which values lie, 0 if it is neither 1 nor 2, and a value between two layers."""
    low, high = across.min(), across.max()
    if high - low <= 2 * tolerance:
        return 1, low
    top, bottom = low, high
    for t in across:
        if t <= low + 2 * tolerance:
            top = max(top, t)
        else:
            bottom = min(bottom, t)
    if high - bottom <= 2 * tolerance and bottom - top > tolerance:
        return 2, (top + bottom) / 2
    return 0, low


@njit(cache=True, error_model="numpy")
def mean_beyond(points, across, limit):
    """Return the mean of the points whose value exceeds a limit."""
    mean, count = np.zeros(3), 0
    for i in range(len(points)):
        if across[i] > limit:
            mean += points[i]
            count += 1
    return mean / count


@njit(cache=True, error_model="numpy")
def extreme(points, across, limit, target, farthest):
    """Return the index of the point farthest from a target, or nearest to it, among those with values above a limit."""
    best, index = -np.inf, 0
    for i in range(len(points)):
        if across[i] > limit:
            distance = np.sum((points[i] - target) ** 2)
            if not farthest:
                distance = -distance
            if distance > best:
                best, index = distance, i
    return index
