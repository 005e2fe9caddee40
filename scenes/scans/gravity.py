"""Which way is up in a scan: from the planes that a room is built of, and from how sensors are held."""

from __future__ import annotations

import numpy as np

from spherefunc_bullet.errors import InputError

from .patches import TRIED, Patches

# Axes of a camera in the origin, forward and up: z forward and y down (PCL, Open3D, ROS), -z forward and y up (OpenGL),
# y forward and z up (a re-axed camera frame). Anything else is a world frame with z up.
CAMERA_FRAMES = (((0, 0, 1), (0, -1, 0)), ((0, 0, -1), (0, 1, 0)), ((0, 1, 0), (0, 0, 1)))
_WIDEST = np.cos(np.radians(50.0))  # depth cameras see less than 50 degrees off their axis
_SEEN = 0.995  # share of the points that the view must hold
_MOSTLY_SEEN = 0.95  # the same where pixels are evenly spread: some cameras see more, some scans were turned a little
_NEAREST = 0.1  # metres: no depth camera sees nearer, while a world frame's origin lies anywhere

TILT = np.cos(np.radians(65.0))  # the most that a sensor looks down or up
_ALIGNED = np.radians(7.0)  # patches whose normals differ by less face the same way
_FITTED = (8.0, 5.0, 4.0)  # degrees within which patches count as level or upright in a fit, from one to the next
_DISAGREES = 1.5  # degrees by which floor and everything else may differ before they are fitted together
_VERTICAL_SHARE = 0.5  # what a vertical patch counts beside a level one: it fixes gravity by one angle only
_FEWEST = 5  # level patches without which gravity is not seen
_LEAST = 0.03  # of all patches' area, for the same reason
# A camera's pixels are evenly spread over its image, so their number per window of the image varies little: 0.2 to 0.5
# of its mean on single views, 0.8 to 1.1 on views seen from a wrong place and on fused scans.
_WINDOW = 0.04  # of the distance: side of such a window
_EVEN = 0.6


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


def camera_frame(points: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the likely up (3,), and where the camera is (3,) if all points (N, 3) are seen from the origin.

    The up is of the camera and knows nothing of how it is tilted.
    """
    distance = np.linalg.norm(points, axis=1)
    for forward, up in CAMERA_FRAMES:
        along = points @ np.array(forward, float)
        seen = (along > _WIDEST * distance) & (along > _NEAREST)
        # A world frame with z up may happen to lie within the third view, so there the pixels have to prove it.
        sure = seen.mean() >= _SEEN and up != (0, 0, 1)
        if sure or (seen.mean() >= _MOSTLY_SEEN and is_even(points[seen], along[seen], forward)):
            return np.array(up, float), np.zeros(3)
    return np.array([0.0, 0.0, 1.0]), None


def is_even(points: np.ndarray, along: np.ndarray, forward: tuple[int, int, int]) -> bool:
    """Return whether points (N, 3), at distances (N,) forward, are as evenly spread as the pixels of a camera."""
    sideways = points[:, np.flatnonzero(np.array(forward) == 0)] / along[:, None]
    windows = np.floor(sideways / _WINDOW).astype(np.int64)
    counts = np.unique(windows, axis=0, return_counts=True)[1]
    return counts.std() < _EVEN * counts.mean()


def facing_normals(patches: Patches, up: np.ndarray, camera: np.ndarray | None) -> np.ndarray:
    """Return the normals (P, 3) turned to the camera, or, where it is unknown, upwards."""
    toward = np.broadcast_to(up, patches.centers.shape) if camera is None else camera - patches.centers
    side = np.sign((patches.normals * toward).sum(axis=1))
    return patches.normals * np.where(side == 0, 1, side)[:, None]


def seen_gravity(patches: Patches, up: np.ndarray, camera: np.ndarray | None) -> np.ndarray | None:
    """Return the direction (3,) that most of a scan's surfaces are level or upright to; None if none is level.

    Every patch's normal within 65 degrees of the likely up is tried. Level patches that face up vote for it by
    their area, upright ones by half of it: what looks like a floor in a view from above is a wall in one to the side,
    but only the true vertical fits floors, table tops and walls at once.

    Parameters
    ----------
    patches : Patches
    up : (3,) float64
        The likely up.
    camera : (3,) float64, optional
        Where it was seen from.
    """
    normals = facing_normals(patches, up, camera)
    leaning = normals @ up
    tried = np.flatnonzero(leaning > TILT)
    if len(tried) < _FEWEST:
        return None
    largest = tried[np.argsort(-patches.areas[tried] / (patches.thickness[tried] + 1e-3), kind="stable")[:TRIED]]
    score, level, level_area = votes(normals, patches.areas, normals[largest])
    best = int(np.argmax(score * (0.6 + 0.4 * leaning[largest])))
    if level[best] < _FEWEST or level_area[best] < _LEAST * patches.areas.sum():
        return None
    return refined_up(normals, patches.areas, normals[largest[best]])


def votes(normals: np.ndarray, areas: np.ndarray, tried: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the area (T,) that agrees with each tried up (T, 3), and number and area (T,) of its level patches."""
    cosine = tried @ normals.T
    level = cosine > np.cos(_ALIGNED)
    upright = np.abs(cosine) < np.sin(_ALIGNED)
    level_area = level @ areas
    return level_area + _VERTICAL_SHARE * (upright @ areas), level.sum(axis=1), level_area


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
        weights = areas * (_VERTICAL_SHARE * upright - level)
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
