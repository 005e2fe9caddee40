"""What the spheres have to beat: features that need no simulation.

If nearest neighbours on the bounding box do as well as the spheres, the physics adds nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from sklearn.metrics.pairwise import euclidean_distances

from spherefunc_bullet.histogram import DIAMETERS, CubeHistogram
from spherefunc_bullet.simulation import VOXEL, ObjectRecord

Distances = dict[float, np.ndarray]  # radius in metres -> (N, N) distances between objects


def baseline_distances(records: Sequence[ObjectRecord], radii: Sequence[float]) -> dict[str, Distances]:
    """Return every baseline's distances between objects, in cubes as large as those of the spheres."""
    return {
        "bounding_box": {radii[-1]: bounding_box_distances(records)},
        "occupancy": {radius: occupancy_distances(records, radius, "raw") for radius in radii},
        "occupancy_sqrt": {radius: occupancy_distances(records, radius, "sqrt") for radius in radii},
        "height_map": {radius: height_map_distances(records, radius) for radius in radii},
    }


def bounding_box_distances(records: Sequence[ObjectRecord]) -> np.ndarray:
    """Return distances between bounding boxes: sorted width and depth, and height, in metres."""
    sizes = np.array([record.size for record in records])
    return euclidean_distances(np.column_stack([np.sort(sizes[:, :2], axis=1), sizes[:, 2]]))


def occupancy_distances(records: Sequence[ObjectRecord], radius: float, counts: str) -> np.ndarray:
    """Return distances between histograms of the cloud itself, thinned to 5 mm, in the spheres' cubes."""
    histogram = CubeHistogram(radius, counts=counts)
    return euclidean_distances(histogram.fit_transform([voxel_centers(record) for record in records]))


def height_map_distances(records: Sequence[ObjectRecord], radius: float) -> np.ndarray:
    """Return distances between top views: the height over each square as large as a cube's face, 0 beside."""
    side = DIAMETERS * 2 * radius
    maps = [height_map(record, side) for record in records]
    squares = {square: column for column, square in enumerate(sorted(set().union(*maps)))}
    heights = np.zeros((len(maps), len(squares)))
    for row, each in enumerate(maps):
        heights[row, [squares[square] for square in each]] = list(each.values())
    return euclidean_distances(heights)


def height_map(record: ObjectRecord, side: float) -> dict[tuple[int, int], float]:
    """Return the greatest height in metres over each square (ix, iy) of the ground."""
    points = voxel_centers(record)
    squares = np.floor(points[:, :2] / side + 0.5).astype(int)
    names, index = np.unique(squares, axis=0, return_inverse=True)
    heights = np.zeros(len(names))
    np.maximum.at(heights, index.ravel(), points[:, 2])
    return dict(zip(map(tuple, names.tolist()), heights.tolist(), strict=True))


def voxel_centers(record: ObjectRecord) -> np.ndarray:
    """Return the centres (V, 3) of an object's occupied voxels, metres."""
    return (record.voxels + 0.5) * VOXEL
