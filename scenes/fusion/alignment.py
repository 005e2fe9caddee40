"""Poses aligned with the map before an image is fused, since poses that are a centimetre off make thin objects thick.

The points of the image are moved onto flat pieces of the map, point to plane (Chen and Medioni 1991), by Gauss-Newton
with Tukey's weights. The given pose is a measurement, too, so that a view of a single wall does not slide along it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..scans.gravity import Patches, patches_of_size
from ..scans.spread import cell_moments
from .point_map import NEARNESS_NOISE, View

TURN = 25.0  # degrees that a pose may be off for each metre of its error: 0.5 for 2 cm
_SIDE = 0.10  # metres, of the flat pieces,
_REACH = 0.15  # and from a point to the middle of one
_MAP_POINTS, _IMAGE_POINTS = 300_000, 5_000  # at most, evenly chosen
_LEAST = 200  # points near pieces of the map, below which the given pose stays
_INDEPENDENT = 300  # points whose errors count as independent: noise, calibration and matches are alike for many
_SURFACE = 0.01  # metres, deviation of a piece of the map
_TUKEY = (0.10, 0.6, 0.03)  # metres of distance that counts at first, its factor after each round, and in the end
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
        Of the map, in the world's frame, in the order of their cells.
    error : float
        Deviation of given poses along each axis, metres; without one, or without a map, poses stay.
    """
    some = points[:: len(points) // _MAP_POINTS + 1]
    in_view = some[view.pixels(some)[0] >= 0]
    if not error or len(in_view) < _LEAST:
        return view
    seen = np.isfinite(depth)
    rays = view.intrinsics.rays()[seen]
    step = len(rays) // _IMAGE_POINTS + 1
    pieces = patches_of_size(cell_moments(in_view, _SIDE), _SIDE)
    camera = rays[::step] * depth[seen][::step, None]
    return replace(view, T_world_camera=aligned_pose(view.T_world_camera, camera, pieces, error))


def aligned_pose(T_given: np.ndarray, points: np.ndarray, pieces: Patches, error: float) -> np.ndarray:
    """Return the pose (4, 4) near a given one in which points (N, 3) of the camera's frame lie on pieces of a map."""
    from scipy.spatial import cKDTree
    from scipy.spatial.transform import Rotation

    if not len(pieces):
        return T_given
    tree, T, moved = cKDTree(pieces.centers), T_given.copy(), np.zeros(6)  # a turn, radians, and a shift, metres
    prior = np.diag([np.radians(TURN * error) ** -2] * 3 + [error**-2] * 3)
    deviations = np.hypot(_SURFACE, 3 * NEARNESS_NOISE * points[:, 2] ** 2)
    for done in range(_ROUNDS):
        placed = points @ T[:3, :3].T + T[:3, 3]
        distances, nearest = tree.query(placed, distance_upper_bound=_REACH)
        near = np.flatnonzero(np.isfinite(distances))
        if len(near) < _LEAST:
            return T_given
        normals = pieces.normals[nearest[near]]
        off = ((placed[near] - pieces.centers[nearest[near]]) * normals).sum(axis=1)
        weights = np.maximum(1 - np.square(off / max(_TUKEY[0] * _TUKEY[1] ** done, _TUKEY[2])), 0) ** 2
        weights *= min(1.0, _INDEPENDENT / max(np.count_nonzero(weights), 1)) / deviations[near] ** 2
        jacobian = np.hstack([np.cross(placed[near] - T[:3, 3], normals), normals])
        weighted = (jacobian * weights[:, None]).T
        step = -np.linalg.solve(weighted @ jacobian + prior, weighted @ off + prior @ moved)
        moved += step
        T[:3, :3] = Rotation.from_rotvec(step[:3]).as_matrix() @ T[:3, :3]
        T[:3, 3] += step[3:]
        if np.abs(step).max() < _STILL:
            break
    return T
