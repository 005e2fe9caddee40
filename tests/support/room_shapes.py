"""A small room whose objects are known: floor, two walls, a table with a mug on it, a stool and a box."""

from __future__ import annotations

import numpy as np
from clouds import level, mug, post, sheet
from scipy.spatial.transform import Rotation

NAMES = ("table", "stool", "box", "mug")


def moved(points: np.ndarray, x: float, y: float, z: float = 0.0) -> np.ndarray:
    return points + [x, y, z]


def square_table(width: float, depth: float, height: float) -> np.ndarray:
    """Return a level top on four legs."""
    feet = [(sx * (width / 2 - 0.04), sy * (depth / 2 - 0.04)) for sx in (-1, 1) for sy in (-1, 1)]
    return np.vstack([level(width, depth, height), *(post(x, y, height) for x, y in feet)])


def box(width: float, depth: float, height: float) -> np.ndarray:
    """Return the four sides and the top of a box."""
    w, d = width / 2, depth / 2
    sides = [([-w, -d, 0], [width, 0, 0]), ([-w, d, 0], [width, 0, 0]), ([-w, -d, 0], [0, depth, 0])]
    sides.append(([w, -d, 0], [0, depth, 0]))
    return np.vstack([level(width, depth, height), *(sheet(at, along, [0, 0, height]) for at, along in sides)])


def room_parts() -> list[np.ndarray]:
    """Return the points of the objects, in the order of NAMES, metres, z up, the floor at 0."""
    return [
        moved(square_table(1.2, 0.8, 0.72), 0.0, 0.0),
        moved(square_table(0.36, 0.36, 0.45), 1.2, 0.3),
        moved(box(0.3, 0.5, 0.4), -1.2, 0.5),
        moved(mug().points, 0.2, 0.1, 0.72),
    ]


def room(*, walls: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (N, 3) of the room, and what each is of: an object's number, -1 floor, -2 wall."""
    parts = [*room_parts(), level(4.0, 3.0, 0.0)[::4]]
    truth = [0, 1, 2, 3, -1]
    if walls:
        parts += [sheet([-2, 1.5, 0], [4, 0, 0], [0, 0, 2.2])[::4], sheet([-2, -1.5, 0], [0, 3, 0], [0, 0, 2.2])[::4]]
        truth += [-2, -2]
    return np.vstack(parts), np.repeat(truth, [len(part) for part in parts])


def as_camera_sees(points: np.ndarray, *, tilt_deg: float = 35.0, height: float = 1.6) -> np.ndarray:
    """Return the points in the frame of a camera in front of the room that looks down: z forward, y down."""
    seen = points - [0.0, -3.2, height]
    down = Rotation.from_euler("x", tilt_deg, degrees=True).apply(seen)  # the camera's own level axes
    return np.column_stack([down[:, 0], -down[:, 2], down[:, 1]])


def in_view(points: np.ndarray) -> np.ndarray:
    """Return the points in a camera's frame that it can have in its picture."""
    return points[(points[:, 2] > 0.3) & (np.abs(points[:, :2]) < 0.7 * points[:, 2:]).all(axis=1)]
