"""Features by which objects are classified: settled spheres, and baselines that need no simulation.

If nearest neighbours on the bounding box do as well as the spheres, the physics adds nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np
from joblib import Parallel, delayed
from sklearn.metrics.pairwise import euclidean_distances

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.console import progress
from spherefunc_bullet.learning.histogram import Counts, counted_cubes, counts_matrix, cube_keys, histogram_of
from spherefunc_bullet.learning.method import DIAMETERS, Method
from spherefunc_bullet.settling.records import VOXEL, ObjectRecord

SPHERES = "spheres"
MANY = 50  # objects: for fewer, other processes take longer to start than they save
Answer = TypeVar("Answer")
Distances = dict[float, np.ndarray]  # radius in metres -> (N, N) distances between objects


def sphere_distances(simulated: Simulated, radii: Sequence[float], method: Method) -> Distances:
    """Return the distances between all objects' sphere histograms at each radius."""
    distances = {}
    for radius in radii:
        centers = [record.centers(radius) for record in simulated.records]
        distances[radius] = euclidean_distances(histogram_of(method, radius).fit_transform(centers))
    return distances


def distances_again(
    simulated: Simulated, twice: Mapping[int, ObjectRecord], radii: Sequence[float], method: Method
) -> Distances:
    """Return the distances (R, N) from other runs on some objects to the first runs on all."""
    distances = {}
    for radius in radii:
        histogram = histogram_of(method, radius)
        learnt = histogram.fit_transform([record.centers(radius) for record in simulated.records])
        features = histogram.transform([record.centers(radius) for record in twice.values()])
        distances[radius] = euclidean_distances(features, learnt)
    return distances


def of_each(function: Callable[[ObjectRecord], Answer], records: Sequence[ObjectRecord]) -> list[Answer]:
    """Return a function of each object without its spheres, which may be many; on all cores for many objects."""
    bare = (replace(record, settled={}) for record in records)
    parallel = Parallel(n_jobs=-1 if len(records) >= MANY else 1, return_as="generator")
    return list(progress(parallel(delayed(function)(record) for record in bare), len(records), "looking at shapes"))


def baseline_distances(records: Sequence[ObjectRecord], radii: Sequence[float]) -> dict[str, Distances]:
    """Return every baseline's distances between objects, in cubes as large as those of the spheres."""
    sides = [DIAMETERS * 2 * radius for radius in radii]
    read = dict(
        zip(radii, zip(*of_each(partial(cubes_and_heights_at, sides=sides), records), strict=True), strict=True)
    )
    occupied = {radius: [cubes for cubes, _ in pairs] for radius, pairs in read.items()}
    heights = {radius: [squares for _, squares in pairs] for radius, pairs in read.items()}
    rooted = {radius: [(keys, np.sqrt(counts)) for keys, counts in cubes] for radius, cubes in occupied.items()}
    values = {"occupancy": occupied, "occupancy_sqrt": rooted, "height_map": heights}
    return {"bounding_box": {radii[-1]: bounding_box_distances(records)}} | {
        name: {radius: cube_distances(cubes) for radius, cubes in by_radius.items()}
        for name, by_radius in values.items()
    }


def bounding_box_distances(records: Sequence[ObjectRecord]) -> np.ndarray:
    """Return distances between bounding boxes by their shorter and longer level side and their height, in metres."""
    sizes = np.array([record.size for record in records]).reshape(-1, 3)
    return euclidean_distances(np.column_stack([np.sort(sizes[:, :2], axis=1), sizes[:, 2]]))


def cube_distances(objects: Sequence[Counts]) -> np.ndarray:
    """Return distances (N, N) between objects, each given as cubes and their values, 0 in all other cubes."""
    keys = np.unique(np.concatenate([keys for keys, _ in objects]))
    return euclidean_distances(counts_matrix(objects, keys))


def cubes_and_heights_at(record: ObjectRecord, sides: Sequence[float]) -> list[tuple[Counts, Counts]]:
    """Return an object's cubes and heights at several sides of cubes."""
    points = voxel_centers(record)
    return [cubes_and_heights(points, side) for side in sides]


def cubes_and_heights(points: np.ndarray, side: float) -> tuple[Counts, Counts]:
    """Return the number of an object's voxels with centres (V, 3) in each cube, and their top view.

    The top view is the squares of the ground, as cubes on it, and the height over each.
    """
    squares, places = np.unique(cube_keys(points * [1, 1, 0], side), return_inverse=True)
    heights = np.zeros(len(squares))
    np.maximum.at(heights, places, points[:, 2])
    return counted_cubes(points, side), (squares, heights)


def voxel_centers(record: ObjectRecord) -> np.ndarray:
    """Return the centres (V, 3) of an object's occupied voxels, metres."""
    return (record.voxels + 0.5) * VOXEL
