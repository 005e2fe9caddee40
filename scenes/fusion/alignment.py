"""Poses aligned with the map before an image is fused, since poses that are a centimetre off make thin objects thick.

The points of the image are moved onto flat pieces of the map, point to plane (Chen and Medioni 1991), by Gauss-Newton
with Tukey's weights. The given pose is a measurement, too, so that a view of a single wall does not slide along it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..scans.cells import cells
from ..scans.gravity import Patches, patches_of_size
from ..scans.spread import cell_moments
from .point_map import NEARNESS_NOISE, UNKNOWN, View

TURN = 25.0  # degrees that a pose may be off for each metre of its error: 0.5 for 2 cm
_SIDE = 0.15  # metres, of the flat pieces
_CUBE = 0.05  # metres: points of the image within a cube count as one, or else what is near would decide alone
_DEVIATION = 0.05  # metres, of a cube's distance from its piece: much, since errors of neighbours are alike
_REACH, _TUKEY = 7, 3.5  # times the error of the pose: distance of a piece's middle, and that counts at first,
_TIGHTER, _TIGHTEST = 0.6, 0.03  # the latter's factor after each round, and metres in the end
_ROUNDS = 10
_STILL = 1e-4  # metres and radians, the step after which no more are made


def aligned(view: View, depth: np.ndarray, points: np.ndarray, error: float) -> View:
    """Return a view with its pose aligned with a map.

    Parameters
    ----------
    view : View
        Of the image, in its given pose.
    depth : (H, W) float, metres, NaN where nothing was measured
    points : (N, 3) float64, metres
        Of the map, in the world's frame.
    error : float
        Deviation of given poses along each axis, metres; without one, or without a map, poses stay.
    """
    pieces = patches_of_size(cell_moments(points[view.verdicts(points) != UNKNOWN], _SIDE), _SIDE)
    if not error or not len(pieces):
        return view
    seen = np.isfinite(depth)
    camera = cells(view.intrinsics.rays()[seen] * depth[seen][:, None], _CUBE).means
    return replace(view, T_world_camera=aligned_pose(view.T_world_camera, camera, pieces, error))


def aligned_pose(T_given: np.ndarray, points: np.ndarray, pieces: Patches, error: float) -> np.ndarray:
    """Return the pose (4, 4) near a given one in which points (N, 3) of the camera's frame lie on pieces of a map."""
    from scipy.spatial import cKDTree
    from scipy.spatial.transform import Rotation

    tree, T, moved = cKDTree(pieces.centers), T_given.copy(), np.zeros(6)  # a turn, radians, and a shift, metres
    prior = np.diag([np.radians(TURN * error) ** -2] * 3 + [error**-2] * 3)
    deviations = np.hypot(_DEVIATION, 3 * NEARNESS_NOISE * points[:, 2] ** 2)
    for done in range(_ROUNDS):
        placed = points @ T[:3, :3].T + T[:3, 3]
        distances, nearest = tree.query(placed, distance_upper_bound=_REACH * error)
        near = np.flatnonzero(np.isfinite(distances))
        normals = pieces.normals[nearest[near]]
        off = ((placed[near] - pieces.centers[nearest[near]]) * normals).sum(axis=1)
        limit = max(_TUKEY * error * _TIGHTER**done, _TIGHTEST)
        weights = np.maximum(1 - np.square(off / limit), 0) ** 2 / deviations[near] ** 2
        jacobian = np.hstack([np.cross(placed[near] - T[:3, 3], normals), normals])
        weighted = (jacobian * weights[:, None]).T
        step = -np.linalg.solve(weighted @ jacobian + prior, weighted @ off + prior @ moved)
        moved += step
        T[:3, :3] = Rotation.from_rotvec(step[:3]).as_matrix() @ T[:3, :3]
        T[:3, 3] += step[3:]
        if np.abs(step).max() < _STILL:
            break
    return T
