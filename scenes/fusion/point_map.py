"""Depth images as points in voxels, and a small view of each image that tells what is free."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.errors import CheckedSettings, InputError, amount
from spherefunc_bullet.processes.compilation import njit

from ..scans.camera import Intrinsics
from ..scans.cells import cells
from ..segmentation.segmentation import LEFT_OVER

logger = logging.getLogger("spherefunc")
POOL = 4  # pixels along the side of a window; narrower gaps are no evidence
LEAST_FILLED = 0.5  # of a window's pixels that have a depth
MARGIN = 0.03  # metres of depth within which a point is on the measured surface,
MARGIN_GROWTH = 0.006  # more with the square of the depth: three deviations of a Kinect (Nguyen et al. 2012)
UNKNOWN, HIDDEN, PRESENT, FREE = range(4)
AGREED, USABLE = 0.95, 0.5  # agreement below which a message says so, and below which no object is looked for,
FEW = 3  # from how many images on that
OVERLAP = 1000  # or more voxels of the map could show
_AHEAD = 0.05  # metres before the camera, below which nothing is in its image
NEW = -4  # label of a voxel that no update has looked at; see `segmentation` for the others


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """A depth image in windows of a few pixels, with its camera."""

    nearest: np.ndarray  # (h, w) float32, least depth of each window, metres; NaN where too few pixels have depth
    farthest: np.ndarray  # (h, w) float32, likewise the largest depth
    intrinsics: Intrinsics
    T_world_camera: np.ndarray  # (4, 4)

    def verdicts(self, points: np.ndarray) -> np.ndarray:
        """Return UNKNOWN, HIDDEN, PRESENT or FREE for each point (N, 3) of the world, (N,) int8."""
        verdicts, camera = np.full(len(points), UNKNOWN, np.int8), self.intrinsics
        pinhole = camera.fx, camera.fy, camera.cx, camera.cy
        find_verdicts(points, self.T_world_camera, pinhole, self.nearest, self.farthest, verdicts)
        return verdicts


@njit(cache=True, error_model="numpy")
def find_verdicts(points, T, pinhole, nearest, farthest, verdicts):
    """Write the verdict of each point (N, 3), UNKNOWN before, by windows (h, w) of an image with a pose T (4, 4)."""
    fx, fy, cx, cy = pinhole
    for i in range(len(points)):
        x, y, z = points[i, 0] - T[0, 3], points[i, 1] - T[1, 3], points[i, 2] - T[2, 3]
        depth = x * T[0, 2] + y * T[1, 2] + z * T[2, 2]
        if depth <= _AHEAD:
            continue
        column = np.floor(((x * T[0, 0] + y * T[1, 0] + z * T[2, 0]) / depth * fx + cx + 0.5) / POOL)
        row = np.floor(((x * T[0, 1] + y * T[1, 1] + z * T[2, 1]) / depth * fy + cy + 0.5) / POOL)
        if not (0 <= row < nearest.shape[0] and 0 <= column < nearest.shape[1]):
            continue
        near, far = nearest[int(row), int(column)], farthest[int(row), int(column)]
        margin = MARGIN + MARGIN_GROWTH * depth * depth
        if np.isfinite(near):
            verdicts[i] = HIDDEN if depth > far + margin else FREE if depth < near - margin else PRESENT


def view_of(depth: np.ndarray, intrinsics: Intrinsics, T_world_camera: np.ndarray) -> View:
    """Return the view of a depth image (H, W) in metres, NaN where nothing was measured."""
    height, width = (side // POOL for side in depth.shape)
    windows = depth[: height * POOL, : width * POOL].reshape(height, POOL, width, POOL)
    seen = np.isfinite(windows)
    filled = seen.mean(axis=(1, 3)) >= LEAST_FILLED
    nearest = np.where(seen, windows, np.inf).min(axis=(1, 3))
    farthest = np.where(seen, windows, -np.inf).max(axis=(1, 3))
    return View(
        nearest=np.where(filled, nearest, np.nan).astype(np.float32),
        farthest=np.where(filled, farthest, np.nan).astype(np.float32),
        intrinsics=intrinsics,
        T_world_camera=T_world_camera,
    )


NEARNESS_NOISE = 0.0019  # 1/m, deviation of a Kinect's inverse depth, the same at every depth (Nguyen et al. 2012)
AROUND = 0.04  # metres around an object's points that are forgotten with it


@dataclass(frozen=True, kw_only=True)
class FusionSettings(CheckedSettings):
    """How depth images are fused."""

    voxel_size: float = amount(0.01, least=0.002, most=0.1)  # metres
    farthest: float = amount(5.0, least=1, finite=False)  # metres: larger depth is left out
    # Pixels across which each depth image is smoothed within its noise; below 3: no smoothing.
    smoothing: int = amount(9, least=1)
    # Deviation of poses along each axis, metres; 0: they stay as given.
    pose_error: float = amount(0.02, least=0, most=0.2)


class PointMap:
    """The map: in each voxel the mean of the points seen there, until more images see it free than see a surface.

    A truncated signed distance (Curless and Levoy 1996) makes walls thick that are thinner than its band and seen from
    both sides, as those of cups: the mean of both images pushes the two surfaces apart, a plate of 3 mm to 6 cm.
    """

    def __init__(self, settings: FusionSettings):
        self.settings = settings
        self.points = np.zeros((0, 3))  # (N, 3) float64, metres, in the world's frame: the mean in each voxel
        self.weights = np.zeros(0)  # (N,) float64, sum of the weights of the points seen there
        self.present = np.zeros(0)  # (N,) float64, images that show a surface there,
        self.free = np.zeros(0)  # and that look through it
        self.labels = np.zeros(0, np.int32)  # (N,) as the last update found them
        self.gone = np.zeros((0, 3))  # (K, 3) float64, metres: points, not of floor or walls, forgotten since then
        self.agreements: list[float] = []  # of the images, see `agreement`
        self.disagrees = False  # whether a message has said so

    @property
    def agreement(self) -> float | None:
        """Of the voxels that an image could show, the share where it shows a surface, and does not see free.

        The median over all images that show enough of the map of those before; None if none does.
        """
        return float(np.median(self.agreements)) if self.agreements else None

    def require_agreement(self):
        """Raise InputError if most images show another room than the map: thousands of pieces would be looked at."""
        if len(self.agreements) >= FEW and self.agreement < USABLE:
            came = f"got {self.agreement:.0%}; are poses, camera and depth scale right?"
            raise InputError(f"fusion: expected depth images that show at least {USABLE:.0%} of the map, {came}")

    def add(self, depth: np.ndarray, view: View):
        """Add a depth image (H, W) float, metres, NaN where nothing was measured."""
        verdicts = view.verdicts(self.points)
        shared, shown = np.count_nonzero(verdicts >= PRESENT), np.count_nonzero(verdicts == PRESENT)
        self.free += verdicts == FREE
        self.keep(self.free <= self.present)
        camera = (depth[..., None] * view.intrinsics.rays())[np.isfinite(depth)]
        seen = np.vstack([self.points, camera @ view.T_world_camera[:3, :3].T + view.T_world_camera[:3, 3]])
        weights = np.concatenate([self.weights, camera[:, 2] ** -4.0])  # noise of depth grows with its square
        voxels, known = cells(seen, self.settings.voxel_size), len(self.points)
        count = len(voxels.keys)
        sums = [np.bincount(voxels.cell_of, weights * along, count) for along in seen.T]
        weights = np.bincount(voxels.cell_of, weights, count)
        before, now = voxels.cell_of[:known], voxels.cell_of[known:]
        present = np.bincount(before, self.present, count) + (np.bincount(now, minlength=count) > 0)
        free, labels = np.bincount(before, self.free, count), np.full(count, NEW, np.int32)
        labels[before] = self.labels
        points = np.column_stack(sums) / weights[:, None]
        # At once, so that the map stays usable after Ctrl-C.
        self.points, self.weights, self.present, self.free, self.labels = points, weights, present, free, labels
        if shared >= OVERLAP:
            self.agreements.append(shown / shared)
        if not self.disagrees and len(self.agreements) >= FEW and self.agreement < AGREED:
            self.disagrees = True
            came = f"only {self.agreement:.0%} of the map that they could show, in the median"
            logger.warning("depth images show %s; are poses, camera and depth scale right? Cups are lost first", came)

    def forget(self, points: np.ndarray, views: Sequence[View]):
        """Forget the map around the points (N, 3) of an object that is gone, except what views still show there."""
        from scipy.spatial import cKDTree

        gone = np.isfinite(cKDTree(points).query(self.points, distance_upper_bound=AROUND)[0])
        there = [view.verdicts(self.points[gone]) == PRESENT for view in views]
        gone[gone] = ~np.any(there, axis=0)
        self.keep(~gone)

    def relabel(self, labels: np.ndarray, still_gone: np.ndarray | slice = slice(0)):
        """Set the label of each voxel (N,) int32, and keep some (K,) bool of the forgotten points; by default none."""
        self.labels, self.gone = labels, self.gone[still_gone]

    def keep(self, chosen: np.ndarray):
        """Keep some voxels (N,) bool, and forget the others."""
        self.gone = np.vstack([self.gone, self.points[~chosen & ((self.labels >= 0) | (self.labels == LEFT_OVER))]])
        columns = self.points, self.weights, self.present, self.free, self.labels
        self.points, self.weights, self.present, self.free, self.labels = (each[chosen] for each in columns)


def smoothed_depth(depth: np.ndarray, size: int) -> np.ndarray:
    """Return a depth image (H, W), metres, smoothed within its noise by a bilateral filter (Newcombe et al. 2011).

    Inverse depth is smoothed, whose noise is the same at every depth; NaN and edges are kept.
    """
    import open3d as o3d

    if size < 3:
        return depth
    seen = np.isfinite(depth)
    nearness = np.divide(1.0, depth, out=np.zeros(depth.shape, np.float32), where=seen, casting="unsafe")
    image = o3d.t.geometry.Image(o3d.core.Tensor(nearness[..., None].copy()))
    even = image.filter_bilateral(size, NEARNESS_NOISE, size / 2).as_tensor().numpy()[..., 0]
    return np.divide(1.0, even, out=np.full(depth.shape, np.nan), where=seen & (even > 0))
