"""Views of one object from near by, as people take them of table tops and chairs: cut by the image, near and fine."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .furnishing import SMALL, VirtualRoom
from .kinect import KINECT, Kinect, Surfaces, look_at, photograph
from .scans import CLEARANCE, WALL_CLEARANCE, VirtualScan

_NEAR, _FAR = (0.6, 1.3), (1.3, 2.3)  # metres from the camera to small and to large objects
_DOWN_DEG = (18.0, 55.0)  # that it looks down by
_ASIDE = 0.4  # metres that it looks past the object's middle, as much as that
_TRIED = 12  # places of the camera
_LOWEST = 0.4  # metres above the floor


def close_ups(
    room: VirtualRoom, count: int, noise: float, seed: int, sensor: Kinect = KINECT
) -> Iterator[VirtualScan]:
    """Yield so many single views of a room, each of one of its objects from near by; the same numbers, the same views.

    Parameters
    ----------
    room : VirtualRoom
    count : int
    noise : float
        Times a Kinect's.
    seed : int
    sensor : Kinect
        Whose noise is that.
    """
    rng = np.random.default_rng([seed, int(room.name.rpartition("_")[2]), count])
    surfaces, kinect = Surfaces(room.meshes()), sensor.noisy(noise)
    for _ in range(count if room.objects else 0):
        pose = pose_near(room, surfaces, rng)
        if pose is not None:
            points, labels = photograph(surfaces, pose, kinect, rng).points()
            if len(points):
                yield VirtualScan(room, points, labels, (pose,))


def pose_near(room: VirtualRoom, surfaces: Surfaces, rng: np.random.Generator) -> np.ndarray | None:
    """Return the pose (4, 4) of a camera that sees one of a room's objects from near by; None if none has room."""
    points = room.objects[rng.integers(len(room.objects))].points
    low, high = points.min(axis=0), points.max(axis=0)
    near, far = _NEAR if (high - low).max() <= SMALL else _FAR
    for _ in range(_TRIED):
        target = (low + high) / 2 + np.append(rng.uniform(-_ASIDE, _ASIDE, 2) * near / far, 0.0)
        around, down, distance = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(*_DOWN_DEG)), rng.uniform(near, far)
        way = np.array([np.cos(around) * np.cos(down), np.sin(around) * np.cos(down), np.sin(down)])
        eye = target + distance * way
        inside = (eye[:2] > WALL_CLEARANCE).all() and (eye[:2] < room.size[:2] - WALL_CLEARANCE).all()
        if inside and eye[2] > _LOWEST and surfaces.clearance(eye[None])[0] >= CLEARANCE:
            return look_at(eye, target)
    return None
