"""Camera poses where none are given: Open3D's odometry of depth images, each against the one before."""

from __future__ import annotations

import numpy as np

from spherefunc_bullet.errors import InputError

from ..scans.depth_image import Intrinsics

LEAST_FITNESS = 0.3  # of the pixels that must agree
LARGEST_STEP = 0.3  # metres between two images: more is no motion of a camera that keeps its view
LARGEST_TURN = 30.0  # degrees
_ROUNDS = (20, 10, 5)  # of each scale, from the coarsest


def motion(
    depth: np.ndarray, before: np.ndarray, camera: Intrinsics, name: str, *, farthest: float = 5.0
) -> np.ndarray:
    """Return T_before_now (4, 4) of a camera between two depth images (H, W), metres, NaN where nothing was measured.

    By the distances from points to planes (Open3D's `rgbd_odometry_multi_scale`); colour is not used.

    Raises
    ------
    InputError
        If the images do not tell: little overlap, a fast motion, or a single plane in view.
    """
    import open3d as o3d

    odometry, core = o3d.t.pipelines.odometry, o3d.core
    matrix = core.Tensor(np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1.0]]))
    try:
        result = odometry.rgbd_odometry_multi_scale(
            rgbd(depth), rgbd(before), matrix, core.Tensor(np.eye(4)), 1.0, farthest,
            [odometry.OdometryConvergenceCriteria(rounds) for rounds in _ROUNDS], odometry.Method.PointToPlane,
        )  # fmt: skip
    except RuntimeError as error:  # equations without a solution
        raise lost(name, "the images have no unique motion") from error
    T = result.transformation.numpy()
    if not np.isfinite(T).all() or result.fitness < LEAST_FITNESS:
        raise lost(name, f"{100 * result.fitness:.0f} % of the pixels agree")
    step = np.linalg.norm(T[:3, 3])
    turn = np.degrees(np.arccos(np.clip((np.trace(T[:3, :3]) - 1) / 2, -1, 1)))
    if step > LARGEST_STEP or turn > LARGEST_TURN:
        raise lost(name, f"a motion of {step:.2f} m and {turn:.0f} degrees from one image to the next")
    return T


def rgbd(depth: np.ndarray):
    """Return a depth image (H, W) as odometry takes it; its colours are nothing."""
    import open3d as o3d

    image = np.nan_to_num(depth, nan=0.0).astype(np.float32)[..., None].copy()
    empty = np.zeros((*depth.shape, 3), np.float32)
    return o3d.t.geometry.RGBDImage(*(o3d.t.geometry.Image(o3d.core.Tensor(array)) for array in (empty, image)))


class OdometryLost(InputError):
    """Two images do not tell how the camera moved; what comes after has no place in the map."""


def lost(name: str, why: str) -> OdometryLost:
    """Return the error of odometry that is lost."""
    return OdometryLost(f"{name}: odometry is lost, {why}; give poses, or images that overlap more")
