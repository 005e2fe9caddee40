"""Which way is up in a scan: from flat pieces of its surfaces, most of which are level or upright in a room."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from spherefunc_bullet.errors import InputError, one_line
from spherefunc_bullet.processes.compilation import njit

from ..settings import SCAN
from .spread import CellMoments, cell_moments, spread_of


@dataclass(frozen=True, eq=False)
class Patches:
    """Flat pieces of surface, each about as large as a cell of its grid."""

    centers: np.ndarray  # (P, 3) float64, metres
    normals: np.ndarray  # (P, 3) float64, unit vectors, of either sign
    areas: np.ndarray  # (P,) float64, square metres, about
    thickness: np.ndarray  # (P,) float64, standard deviation across the surface, metres

    def __getitem__(self, chosen: np.ndarray) -> Patches:
        return Patches(self.centers[chosen], self.normals[chosen], self.areas[chosen], self.thickness[chosen])

    def __len__(self) -> int:
        return len(self.centers)


def find_patches(points: np.ndarray) -> Patches:
    """Return the flat pieces of a scan (N, 3), metres, of three sizes.

    With noise of a few centimetres, as a Kinect's at four metres, only large patches have a reliable normal. Each
    counts a third of its area, so that a surface that is flat in all sizes counts once.
    """
    moments = [cell_moments(points, SCAN.patch_sides[0])]
    moments += [moments[0].merged(side) for side in SCAN.patch_sides[1:]]
    sizes = [patches_of_size(each, side) for each, side in zip(moments, SCAN.patch_sides, strict=True)]
    names = ("centers", "normals", "areas", "thickness")
    return Patches(*(np.concatenate([getattr(size, name) for size in sizes]) for name in names))


def patches_of_size(moments: CellMoments, side: float) -> Patches:
    """Return the flat pieces of cells of one side, metres."""
    moments = moments.of_many(SCAN.patch_points)
    spread, normals = spread_of(moments.covariances)
    spread = np.sqrt(np.maximum(spread, 0))
    flat = (spread[:, 0] < SCAN.patch_thickness * spread[:, 1]) & (spread[:, 1] > 0.1 * side)
    # A square of side a spreads by a / sqrt(12) along each of its axes.
    areas = np.minimum(12 * spread[:, 1] * spread[:, 2], 1.5 * side**2) / len(SCAN.patch_sides)
    return Patches(moments.means[flat], normals[flat], areas[flat], spread[flat, 0])


# Axes of a camera in the origin, forward and up: z forward and y down (PCL, Open3D, ROS), -z forward and y up (OpenGL).
# Anything else is a frame with z up.
CAMERA_FRAMES = (((0, 0, 1), (0, -1, 0)), ((0, 0, -1), (0, 1, 0)))


def axis_up(up: str | ArrayLike) -> np.ndarray:
    """Return the unit vector (3,) of an axis such as ``z`` or ``-y``, of ``x,y,z`` in numbers, or of a vector (3,).

    Raises
    ------
    InputError
        If it is neither.
    """
    try:
        if isinstance(up, str) and up.removeprefix("-") in ("x", "y", "z"):
            return (-1.0 if up[0] == "-" else 1.0) * np.eye(3)["xyz".index(up[-1])]
        vector = np.array(up.split(",") if isinstance(up, str) else up, float)
        length = np.linalg.norm(vector)
        if vector.shape == (3,) and np.isfinite(length) and length > 0:
            return vector / length
    except (TypeError, ValueError):
        pass
    raise InputError(f'up="{one_line(up):.200}": expected auto, x, y, z, -x, -y, -z, or a vector such as 0,-0.9,-0.4')


def up_vector(up: str | ArrayLike) -> np.ndarray | None:
    """Return the unit vector (3,) that `axis_up` makes of a direction; None for ``auto``."""
    return None if isinstance(up, str) and up == "auto" else axis_up(up)


def camera_frame(points: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the likely up (3,), and where the camera is (3,) if all points (N, 3) are seen from the origin.

    The up is of the camera and knows nothing of how it is tilted.
    """
    ahead = np.cos(np.radians(SCAN.half_view_deg)) * np.linalg.norm(points, axis=1)
    for forward, up in CAMERA_FRAMES:
        if np.mean(points @ np.array(forward, float) > ahead) >= SCAN.in_view:
            return np.array(up, float), np.zeros(3)
    return np.array([0.0, 0.0, 1.0]), None


def facing_normals(patches: Patches, up: np.ndarray, camera: np.ndarray | None) -> np.ndarray:
    """Return the normals (P, 3) turned to the camera, or, where it is unknown, upwards."""
    toward = np.broadcast_to(up, patches.centers.shape) if camera is None else camera - patches.centers
    side = np.sign((patches.normals * toward).sum(axis=1))
    return patches.normals * np.where(side == 0, 1, side)[:, None]


def seen_gravity(patches: Patches, up: np.ndarray, camera: np.ndarray | None) -> np.ndarray | None:
    """Return the direction (3,) to which most of a scan's surfaces are level or upright; None if no surface is level.

    The normal of every patch within 65 degrees of the likely up is tried. Level patches that face up and upright ones
    vote for it by their area. A wall may look like a floor in a tilted view, but only the true vertical fits floors,
    table tops and walls at once.

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
    tried = np.flatnonzero(leaning > np.cos(np.radians(SCAN.steepest_view_deg)))
    if not len(tried):
        return None
    largest = tried[np.argsort(-patches.areas[tried] / (patches.thickness[tried] + 1e-3), kind="stable")[: SCAN.tried]]
    agreeing = np.empty(len(largest))
    add_agreeing(normals, patches.areas, largest, np.cos(SCAN.aligned), np.sin(SCAN.aligned), agreeing)
    best = int(np.argmax(agreeing * (0.6 + 0.4 * leaning[largest])))
    return refined_up(normals, patches.areas, normals[largest[best]])


@njit(cache=True, error_model="numpy")
def add_agreeing(normals, areas, tried, cosine, sine, agreeing):
    """Write the area (T,) to whose normals each tried one of all normals (P, 3) is nearly equal, or at right angles."""
    for k in range(len(tried)):
        x, y, z, area = normals[tried[k], 0], normals[tried[k], 1], normals[tried[k], 2], 0.0
        for i in range(len(normals)):
            along = x * normals[i, 0] + y * normals[i, 1] + z * normals[i, 2]
            if along > cosine or abs(along) < sine:
                area += areas[i]
        agreeing[k] = area


def refined_up(normals: np.ndarray, areas: np.ndarray, up: np.ndarray, floor: np.ndarray | None = None) -> np.ndarray:
    """Return the up (3,) near another that fits level and upright normals best, in least squares by area.

    A plane through a floor's points is more accurate than its patches, unless the floor is small, far or noisy: then
    tops and walls are better. So it counts as one patch of its area.

    Parameters
    ----------
    normals : (P, 3) float64, unit vectors, of either sign
    areas : (P,) float64, square metres
    up : (3,) float64
    floor : (3,) float64, optional
        The normal of a floor as long as the square root of its area in metres.
    """
    floor = np.zeros(3) if floor is None else floor
    for degrees in SCAN.fitted_deg:
        cosine = np.abs(normals @ up)
        level, upright = cosine > np.cos(np.radians(degrees)), cosine < np.sin(np.radians(degrees))
        weights = areas * (upright.astype(float) - level)
        spread = (normals * weights[:, None]).T @ normals - np.outer(floor, floor)
        fitted = np.linalg.eigh(spread)[1][:, 0]
        up = fitted * np.sign(fitted @ up)
    return up
