"""The floor as the paper finds it: the plane of most points, by RANSAC (§IV-C; Fischler and Bolles, 1981)."""

from __future__ import annotations

import numpy as np

from spherefunc_bullet.errors import InputError

from .cells import cells
from .gravity import axis_up, camera_frame
from .levelling import Levelling, level_transform

_TRIED = 500  # planes: of a scene that is a third floor, all but certain to hold one through three of its points
_NEAR = 0.02  # metres from the plane within which points agree with it
_VOXEL = 0.02  # metres: voxels in which near surfaces count no more than far ones


def level_by_ransac(points: np.ndarray, up: str = "auto", name: str = "scan", *, seed: int = 0) -> Levelling:
    """Take the plane of most points for the floor, whichever it is.

    Parameters
    ----------
    points : (N, 3) float64, metres, finite
    up : str
        ``auto``, or the axis or the vector that the plane's upper side faces.
    name : str
        What errors call the scan.
    seed : int
        Of the planes that are tried.

    Raises
    ------
    InputError
        If ``up`` is no direction, or no three points span a plane.
    """
    likely, camera = (axis_up(up), None) if up != "auto" else camera_frame(points)
    normal, height = largest_plane(cells(points, _VOXEL).means, np.random.default_rng(seed))
    if not np.isfinite(height):
        raise InputError(f"{name}: expected a scan of surfaces, found none; is it a line or a point?")
    side = 1.0 if normal @ likely >= 0 else -1.0
    transform = level_transform(side * normal, side * height)
    return Levelling(T_level_scan=transform, source="floor", floor_seen=True, noise=None, camera=camera)


def largest_plane(points: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, float]:
    """Return the normal (3,) and the height along it of the plane near most points (N, 3); NaN where there is none."""
    best, most = (np.array([0.0, 0.0, 1.0]), np.nan), 0
    for _ in range(_TRIED):
        a, b, c = points[rng.integers(len(points), size=3)]
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal)
        if length < 1e-9:
            continue
        near = np.abs(points @ (normal / length) - a @ (normal / length)) < _NEAR
        if near.sum() > most:
            best, most = fitted(points[near]), int(near.sum())
    return best


def fitted(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the normal (3,) and the height along it of the plane through points (N, 3), in least squares."""
    centre = points.mean(axis=0)
    normal = np.linalg.svd(points - centre, full_matrices=False)[2][-1] if len(points) > 2 else np.array([0, 0, 1.0])
    return normal, float(centre @ normal)
