"""Objects that stand askew, since the floor or the sensor's gravity is a little off: turned to stand level.

An object comes to rest on the facet of its hull that its weight acts through; where its feet were not seen, its own
level surfaces say what is level. Either is believed only where it makes the object's heights fall together more than
they do as it stands, so that what is level already stays as it is, bit for bit.
"""

from __future__ import annotations

import numpy as np

from ...clouds.cloud import Cloud, Mesh, centre_on_ground

ASKEW_DEG = 10.0  # at most
LEVEL_DEG = 0.5  # below, it counts as level
SAFE = 0.01  # of the extent: how far its weight acts within its feet
DIRECTIONS = np.arange(64) * 2 * np.pi / 64  # in which feet reach beyond it: a circle's chords are a thousandth short
COLUMNS = 64  # across the footprint, of each of which the lowest point may be a foot
SOME = 4000  # points whose heights are looked at
BINS = 100  # of the largest extent
FEET = (12, 0.002)  # points at least, within so much of the extent: where an object surely rests on what it has
SHARPER = (1.1, 1.3)  # times as much together must heights fall: on feet that are not sure, by its surfaces alone
STEPS = (2.5, 0.5)  # degrees


def levelled(cloud: Cloud) -> Cloud:
    """Return an object that stands level, turned by at most ten degrees, or itself where it does as it is."""
    if stands_on_feet(cloud):
        return cloud
    rotation = upright_rotation(cloud)
    return cloud if rotation is None else turned_cloud(cloud, rotation)


def stands_on_feet(cloud: Cloud) -> bool:
    """Return whether points within half a degree of the ground surround an object's middle."""
    points, extent = cloud.points, float(cloud.size.max())
    feet = points[points[:, 2] < cloud.bounds[0, 2] + np.tan(np.radians(LEVEL_DEG)) * extent, :2]
    return reach_around(feet, cloud) > SAFE * extent


def reach_around(feet: np.ndarray, cloud: Cloud) -> float:
    """Return how far feet (N, 2) reach beyond an object's middle where they reach least, metres."""
    around = np.stack([np.cos(DIRECTIONS), np.sin(DIRECTIONS)])
    return float(((feet - cloud.points[:, :2].mean(axis=0)) @ around).max(axis=0).min())


def upright_rotation(cloud: Cloud) -> np.ndarray | None:
    """Return the rotation (3, 3) that makes an object level, None where there is none that does."""
    some = cloud.points[:: max(1, len(cloud) // SOME)]
    extent = float(cloud.size.max())
    before = sharpness(some, np.array([0.0, 0.0, 1.0]), extent)
    foot = resting_direction(cloud)
    if foot is not None and (
        sharpness(some, foot, extent) > SHARPER[0] * before or surely_rests(cloud.points @ foot, cloud, extent)
    ):
        return rotation_to_z(foot)
    best = sharpest(some, extent)
    if best[2] < np.cos(np.radians(ASKEW_DEG - STEPS[1])):  # it leans farther than is looked at
        return None
    return rotation_to_z(best) if sharpness(some, best, extent) > SHARPER[1] * before else None


def resting_direction(cloud: Cloud) -> np.ndarray | None:
    """Return the direction (3,) that points up when an object has come to rest; None beyond ten degrees."""
    from scipy.spatial import ConvexHull, QhullError  # takes longer to load than most answers

    low = lowest_of_columns(cloud)
    middle = cloud.points[:: max(1, len(cloud) // SOME)].mean(axis=0)
    try:
        hull = ConvexHull(np.vstack([low, middle + [0, 0, cloud.size[2]]]))
    except QhullError:
        return None
    normals, heights = hull.equations[:, :3], -(hull.equations[:, :3] @ middle + hull.equations[:, 3])
    down = np.array([0.0, 0.0, -1.0])
    for _ in range(20):
        toward = normals @ down
        facet = int(np.where(toward > 1e-9, heights / np.maximum(toward, 1e-9), np.inf).argmin())
        if normals[facet] @ down > 1 - 1e-9:
            break
        down = normals[facet]
    return -down if -down[2] > np.cos(np.radians(ASKEW_DEG + LEVEL_DEG)) else None


def surely_rests(heights: np.ndarray, cloud: Cloud, extent: float) -> bool:
    """Return whether enough points lie on the ground by their heights (N,), around an object's middle."""
    feet = cloud.points[heights < heights.min() + FEET[1] * extent, :2]
    return len(feet) >= FEET[0] and reach_around(feet, cloud) > SAFE * extent


def lowest_of_columns(cloud: Cloud) -> np.ndarray:
    """Return the lowest point of each column over the ground, (C, 3)."""
    low, side = cloud.bounds[0, :2], max(float(cloud.size[:2].max()), 1e-9) / COLUMNS
    column = np.floor((cloud.points[:, :2] - low) / side).astype(np.int64) @ [COLUMNS + 1, 1]
    lowest = np.full((COLUMNS + 1) ** 2, np.inf)
    np.minimum.at(lowest, column, cloud.points[:, 2])
    return cloud.points[cloud.points[:, 2] == lowest[column]]


def sharpness(points: np.ndarray, up: np.ndarray, extent: float) -> float:
    """Return how much the heights of points (N, 3) along a direction fall together, as share of pairs."""
    heights = points @ up
    counts = np.bincount(np.floor((heights - heights.min()) / (extent / BINS)).astype(np.int64)) / len(points)
    return float((np.convolve(counts, [1, 1]) ** 2).sum())


def sharpest(points: np.ndarray, extent: float) -> np.ndarray:
    """Return the direction (3,) within ten degrees of z along which heights fall together most."""
    best, reach = np.zeros(2), ASKEW_DEG
    for step in STEPS:
        offsets = np.arange(-reach, reach + step / 2, step)
        trials = best + np.array([(a, b) for a in offsets for b in offsets if np.hypot(a, b) <= reach])
        values = [sharpness(points, direction(trial), extent) for trial in trials]
        best, reach = trials[int(np.argmax(values))], step
    return direction(best)


def direction(tilt_deg: np.ndarray) -> np.ndarray:
    """Return the unit vector (3,) tilted from z by an angle along x and y, degrees."""
    vector = np.array([*np.tan(np.radians(tilt_deg)), 1.0])
    return vector / np.linalg.norm(vector)


def rotation_to_z(up: np.ndarray) -> np.ndarray:
    """Return the least rotation (3, 3) that takes a unit vector (3,) near z to z."""
    x, y, z = up
    share = 1 / (1 + z)
    return np.array([[1 - x * x * share, -x * y * share, -x], [-x * y * share, 1 - y * y * share, -y], [x, y, z]])


def turned_cloud(cloud: Cloud, rotation: np.ndarray) -> Cloud:
    """Return a cloud and its mesh rotated (3, 3) and put on the ground."""
    points = cloud.points @ rotation.T
    shift = centre_on_ground(points)
    mesh = cloud.mesh and Mesh(cloud.mesh.vertices @ rotation.T - shift, cloud.mesh.faces)
    return Cloud(points - shift, cloud.name, mesh)
