"""Which way is up in a scan: from the planes that a room is built of, and from how sensors are held."""

from __future__ import annotations

import numpy as np

from spherefunc_bullet.errors import InputError

from .patches import Patches

# Axes of a camera in the origin, forward and up: z forward and y down (PCL, Open3D, ROS), -z forward and y up (OpenGL).
# Anything else is a frame with z up.
CAMERA_FRAMES = (((0, 0, 1), (0, -1, 0)), ((0, 0, -1), (0, 1, 0)))
_WIDEST = np.cos(np.radians(50.0))  # depth cameras see less than 50 degrees off their axis
_SEEN = 0.995  # share of the points that the view must hold

_TILT = np.cos(np.radians(65.0))  # the most that a sensor looks down or up
_ALIGNED = np.radians(7.0)  # patches whose normals differ by less face the same way
_FITTED = (8.0, 5.0, 4.0)  # degrees within which patches count as level or upright in a fit, from one to the next
_DISAGREES = 1.5  # degrees by which floor and everything else may differ before they are fitted together
_TRIED = 600  # patches whose normals are tried as up
_FEWEST = 5  # level patches without which gravity is not seen


def axis_up(up: str) -> np.ndarray:
    """Return the unit vector (3,) of an axis such as ``z`` or ``-y``, or of ``x,y,z`` in numbers.

    Raises
    ------
    InputError
        If it is neither.
    """
    sign, axis = (-1.0, up[1:]) if up.startswith("-") and "," not in up else (1.0, up)
    if axis in ("x", "y", "z"):
        return sign * np.eye(3)["xyz".index(axis)]
    try:
        vector = np.array([float(number) for number in up.split(",")])
        length = np.linalg.norm(vector)
        if vector.shape == (3,) and np.isfinite(length) and length > 0:
            return vector / length
    except ValueError:
        pass
    raise InputError(f'up="{up}": expected auto, x, y, z, -x, -y, -z, or three numbers such as 0,-0.9,-0.4')


def likely_up(points: np.ndarray) -> np.ndarray:
    """Return the up (3,) of the camera in whose view from the origin all points (N, 3) lie, however tilted; else z."""
    distance = np.linalg.norm(points, axis=1)
    for forward, up in CAMERA_FRAMES:
        if np.mean(points @ np.array(forward, float) > _WIDEST * distance) >= _SEEN:
            return np.array(up, float)
    return np.array([0.0, 0.0, 1.0])


def upward_normals(patches: Patches, up: np.ndarray) -> np.ndarray:
    """Return the normals (P, 3) turned upwards."""
    return patches.normals * np.where(patches.normals @ up < 0, -1, 1)[:, None]


def seen_gravity(patches: Patches, up: np.ndarray) -> np.ndarray | None:
    """Return the direction (3,) that most of a scan's surfaces are level or upright to; None if none is level.

    Every patch's normal within 65 degrees of the likely up is tried. Level patches vote for it by their area, upright
    ones too: what looks like a floor in a view from above is a wall in one to the side, but only the true
    vertical fits floors, table tops and walls at once.

    Parameters
    ----------
    patches : Patches
    up : (3,) float64
        The likely up.
    """
    normals = upward_normals(patches, up)
    leaning = normals @ up
    tried = np.flatnonzero(leaning > _TILT)
    if len(tried) < _FEWEST:
        return None
    largest = tried[np.argsort(-patches.areas[tried] / (patches.thickness[tried] + 1e-3), kind="stable")[:_TRIED]]
    score, level = votes(normals, patches.areas, normals[largest])
    best = int(np.argmax(score * (0.6 + 0.4 * leaning[largest])))
    return refined_up(normals, patches.areas, normals[largest[best]]) if level[best] >= _FEWEST else None


def votes(normals: np.ndarray, areas: np.ndarray, tried: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the area (T,) that agrees with each tried up (T, 3), and the number (T,) of its level patches."""
    cosine = tried @ normals.T
    level = cosine > np.cos(_ALIGNED)
    upright = np.abs(cosine) < np.sin(_ALIGNED)
    return (level | upright) @ areas, level.sum(axis=1)


def refined_up(normals: np.ndarray, areas: np.ndarray, up: np.ndarray, floor: np.ndarray | None = None) -> np.ndarray:
    """Return the up (3,) near another that level normals lie along and upright ones across, in least squares by area.

    Parameters
    ----------
    normals : (P, 3) float64, unit vectors, of either sign
    areas : (P,) float64, square metres
    up : (3,) float64
    floor : (3,) float64, optional
        The normal of a floor as long as the square root of its area in metres.
    """
    floor = np.zeros(3) if floor is None else floor
    for degrees in _FITTED:
        cosine = np.abs(normals @ up)
        level, upright = cosine > np.cos(np.radians(degrees)), cosine < np.sin(np.radians(degrees))
        if level.sum() < _FEWEST:
            break
        weights = areas * (upright.astype(float) - level)
        spread = (normals * weights[:, None]).T @ normals - np.outer(floor, floor)
        fitted = np.linalg.eigh(spread)[1][:, 0]
        up = fitted * np.sign(fitted @ up)
    return up


def joint_up(patches: Patches, seen: np.ndarray, floor: np.ndarray, floor_area: float) -> np.ndarray:
    """Return the up (3,) that fits a floor, other level surfaces and walls together.

    A plane through a floor's points is truer than its patches, unless the floor is small, far or thick: then tops and
    walls tell better. Level normals are to lie along the up, upright ones across it, in least squares by area.

    Parameters
    ----------
    patches : Patches
    seen : (3,) float64
        The up that most surfaces agree with.
    floor : (3,) float64
        The normal of the plane through the floor's points.
    floor_area : float
        What the floor counts, square metres.
    """
    if seen @ floor > np.cos(np.radians(_DISAGREES)):
        return floor
    return refined_up(patches.normals, patches.areas, seen, floor * np.sqrt(floor_area))
