"""What the spheres have to beat: features that need no simulation.

If nearest neighbours on the bounding box do as well as the spheres, the physics adds nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from sklearn.metrics.pairwise import euclidean_distances

from spherefunc_bullet.learning.histogram import DIAMETERS, counted_cubes, counts_matrix, cube_keys
from spherefunc_bullet.settling.records import VOXEL, ObjectRecord

Distances = dict[float, np.ndarray]  # radius in metres -> (N, N) distances between objects


def baseline_distances(records: Sequence[ObjectRecord], radii: Sequence[float]) -> dict[str, Distances]:
    """Return every baseline's distances between objects, in cubes as large as those of the spheres."""
    occupied = {radius: [] for radius in radii}
    heights = {radius: [] for radius in radii}
    for record in records:
        points = voxel_centers(record)
        for radius in radii:
            side = DIAMETERS * 2 * radius
            occupied[radius].append(counted_cubes(points, side))
            heights[radius].append(height_map(points, side))
    return {
        "bounding_box": {radii[-1]: bounding_box_distances(records)},
        "occupancy": {radius: cube_distances(each) for radius, each in occupied.items()},
        "occupancy_sqrt": {radius: cube_distances(rooted(each)) for radius, each in occupied.items()},
        "height_map": {radius: cube_distances(each) for radius, each in heights.items()},
    }


def bounding_box_distances(records: Sequence[ObjectRecord]) -> np.ndarray:
    """Return distances between bounding boxes: sorted width and depth, and height, in metres."""
    sizes = np.array([record.size for record in records])
    return euclidean_distances(np.column_stack([np.sort(sizes[:, :2], axis=1), sizes[:, 2]]))


def cube_distances(counted: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Return distances (N, N) between objects given as cubes and values, 0 in all other cubes."""
    keys = np.unique(np.concatenate([keys for keys, _ in counted]))
    return euclidean_distances(counts_matrix(counted, keys))


def rooted(counted):
    """Return the square roots of counts."""
    return [(keys, np.sqrt(counts)) for keys, counts in counted]


def height_map(points: np.ndarray, side: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the top view of points (N, 3): the squares of the ground, as cubes on it, and the height over each."""
    keys, square = np.unique(cube_keys(points * [1, 1, 0], side), return_inverse=True)
    heights = np.zeros(len(keys))
    np.maximum.at(heights, square, points[:, 2])
    return keys, heights


def voxel_centers(record: ObjectRecord) -> np.ndarray:
    """Return the centres (V, 3) of an object's occupied voxels, metres."""
    return (record.voxels + 0.5) * VOXEL
