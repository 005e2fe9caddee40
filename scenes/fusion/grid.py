"""Depth images as a truncated signed distance in blocks of voxels (Curless and Levoy 1996; Open3D's VoxelBlockGrid)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from spherefunc_bullet.errors import CheckedSettings, amount

from ..scans.depth_image import Intrinsics

if TYPE_CHECKING:
    from open3d.core import Tensor

POOL = 4  # pixels along the side of a window; narrower gaps are no evidence
LEAST_FILLED = 0.5  # of a window's pixels that have a depth
MARGIN = 0.03  # metres of depth within which a point is on the measured surface,
MARGIN_GROWTH = 0.006  # more with the square of the depth: three deviations of a Kinect (Nguyen et al. 2012)
UNKNOWN, HIDDEN, PRESENT, FREE = range(4)


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """A depth image in windows of a few pixels, with its camera."""

    nearest: np.ndarray  # (h, w) float32, least depth of each window, metres; NaN where too few pixels have depth
    farthest: np.ndarray  # (h, w) float32, likewise the largest depth
    intrinsics: Intrinsics
    T_world_camera: np.ndarray  # (4, 4)

    def verdicts(self, points: np.ndarray) -> np.ndarray:
        """Return UNKNOWN, HIDDEN, PRESENT or FREE for each point (N, 3) of the world, (N,) int8."""
        row, column, depth = self.pixels(points)
        inside = row >= 0
        row, column = np.where(inside, row, 0), np.where(inside, column, 0)
        nearest, farthest = self.nearest[row, column], self.farthest[row, column]
        margin = MARGIN + MARGIN_GROWTH * depth**2
        out = np.full(len(points), UNKNOWN, np.int8)
        known = inside & np.isfinite(nearest)
        out[known & (depth > farthest + margin)] = HIDDEN
        out[known & (depth <= farthest + margin) & (depth >= nearest - margin)] = PRESENT
        out[known & (depth < nearest - margin)] = FREE
        return out

    def pixels(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return row and column of the window of each point (N, 3), -1 outside the image, and the point's depth."""
        R, t = self.T_world_camera[:3, :3], self.T_world_camera[:3, 3]
        x, y, depth = ((points - t) @ R).T
        ahead = depth > 0.05
        scale = np.divide(1.0, depth, out=np.zeros_like(depth), where=ahead)
        camera = self.intrinsics
        column = np.floor((x * scale * camera.fx + camera.cx + 0.5) / POOL)
        row = np.floor((y * scale * camera.fy + camera.cy + 0.5) / POOL)
        height, width = self.nearest.shape
        inside = ahead & (row >= 0) & (column >= 0) & (row < height) & (column < width)
        return np.where(inside, row, -1).astype(int), np.where(inside, column, -1).astype(int), depth


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


BLOCK = 8  # voxels along a block's side
BLOCKS = 20_000  # initial capacity, which grows
NEARNESS_NOISE = 0.0019  # 1/m, deviation of a Kinect's inverse depth, the same at every depth (Nguyen et al. 2012)
AROUND = 0.04  # metres around an object's points that are forgotten with it


@dataclass(frozen=True, kw_only=True)
class FusionSettings(CheckedSettings):
    """How depth images are fused."""

    voxel_size: float = amount(0.01, least=0.002, most=0.1)  # metres
    truncation: float = amount(4.0, least=1)  # voxels on both sides of a surface that hold its distance
    farthest: float = amount(5.0, least=1, finite=False)  # metres: larger depth is left out
    # Pixels across which each depth image is smoothed within its noise; 1: no smoothing.
    smoothing: int = amount(9, least=1)
    least_weight: float = amount(0.5)  # a surface has to be seen in more images than this


class DistanceGrid:
    """The map: for each voxel near a surface its mean signed distance in all images so far."""

    def __init__(self, settings: FusionSettings):
        import open3d as o3d

        self.settings, core = settings, o3d.core
        self.blocks = o3d.t.geometry.VoxelBlockGrid(
            ("tsdf", "weight"), (core.float32, core.float32), (1, 1), settings.voxel_size, BLOCK, BLOCKS
        )

    def add(self, depth: np.ndarray, view: View):
        """Add a depth image (H, W) float, metres, NaN where nothing was measured.

        Blocks of the map that the image looks through are updated as well, so that removed objects fade. Where the map
        is free and the image shows a surface, only the image counts.
        """
        import open3d as o3d

        settings, core = self.settings, o3d.core
        image = o3d.t.geometry.Image(core.Tensor(np.nan_to_num(depth, nan=0.0).astype(np.float32)[..., None].copy()))
        # Pixel coordinates are truncated instead of rounded there, so that pixel centres are at halves.
        lens = view.intrinsics
        matrix = core.Tensor(np.array([[lens.fx, 0, lens.cx + 0.5], [0, lens.fy, lens.cy + 0.5], [0, 0, 1.0]]))
        extrinsic = core.Tensor(np.linalg.inv(view.T_world_camera))
        camera = (matrix, extrinsic, 1.0, settings.farthest, settings.truncation)
        near = self.blocks.compute_unique_block_coordinates(image, *camera)
        wide = (*camera[:-1], 2 * settings.truncation)
        self.forget_free(self.blocks.compute_unique_block_coordinates(image, *wide), view)
        seen = self.in_view(view)
        chosen = np.unique(np.concatenate([near.numpy(), seen]), axis=0) if len(seen) else near.numpy()
        self.blocks.integrate(core.Tensor(np.ascontiguousarray(chosen)), image, *camera)

    def points(self) -> np.ndarray:
        """Return the surface as points (N, 3) float64, metres, in the world's frame."""
        if not int(self.blocks.hashmap().size()):
            return np.zeros((0, 3))
        try:
            cloud = self.blocks.extract_point_cloud(self.settings.least_weight)
        except RuntimeError:  # Open3D 0.20 refuses to return an empty cloud
            return np.zeros((0, 3))
        return cloud.point.positions.numpy().astype(np.float64)

    def forget(self, points: np.ndarray, views: Sequence[View]):
        """Forget the map around the points (N, 3) of an object that is gone, except what views still show there."""
        import open3d as o3d
        from scipy.spatial import cKDTree

        side = BLOCK * self.settings.voxel_size
        around = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])
        cells = np.unique(np.floor(points / side).astype(np.int32), axis=0)
        keys = np.unique((cells[:, None] + around).reshape(-1, 3), axis=0).astype(np.int32)
        voxels, places = self.voxels(o3d.core.Tensor(keys))
        near = np.isfinite(cKDTree(points).query(voxels, distance_upper_bound=AROUND)[0])
        voxels, places = voxels[near], places[near]
        there = np.any([view.verdicts(voxels) == PRESENT for view in views], axis=0)
        self.values("weight")[places[~there]] = 0.0

    def forget_free(self, near: Tensor, view: View):
        """Forget voxels in blocks (M, 3) where the map is certainly free and a view shows a surface."""
        voxels, places = self.voxels(near)
        if not len(places):
            return
        tsdf, weight = self.values("tsdf"), self.values("weight")
        free = np.flatnonzero((weight[places] > 0) & (tsdf[places] > 0.99))
        row, column, depth = view.pixels(voxels[free])
        nearest, farthest = view.nearest[row, column], view.farthest[row, column]
        band = self.settings.truncation * self.settings.voxel_size
        # The window shows one surface, and the voxel is in or behind it: noise of single pixels forgets nothing. Free
        # voxels behind it are forgotten as well, or a second surface would appear where the new one's inside ends.
        shown = (row >= 0) & (farthest - nearest < band) & (depth > nearest)
        weight[places[free[shown]]] = 0.0

    def in_view(self, view: View) -> np.ndarray:
        """Return the blocks (M, 3) int32 of the map that a view may see."""
        import open3d as o3d

        table = self.blocks.hashmap()
        keys = table.key_tensor()[table.active_buf_indices().to(o3d.core.int64)].numpy()
        row, _, depth = view.pixels((keys + 0.5) * BLOCK * self.settings.voxel_size)
        return keys[(row >= 0) & (depth < self.settings.farthest)]

    def voxels(self, keys: Tensor) -> tuple[np.ndarray, np.ndarray]:
        """Return the voxels (N, 3), metres, of those blocks (M, 3) that the map has, and their indices (N,)."""
        table = self.blocks.hashmap()
        places, known = table.find(keys)
        coordinates, flat = self.blocks.voxel_coordinates_and_flattened_indices(places[known])
        return coordinates.numpy().astype(np.float64), flat.numpy().ravel()

    def values(self, name: str) -> np.ndarray:
        """Return an attribute of all voxels (N,) float32, readable and writable."""
        return self.blocks.attribute(name).numpy().reshape(-1)


def smoothed_depth(depth: np.ndarray, size: int) -> np.ndarray:
    """Return a depth image (H, W), metres, smoothed within its noise by a bilateral filter (Newcombe et al. 2011).

    Inverse depth is smoothed, whose noise is the same at every depth; NaN and edges are kept.
    """
    import open3d as o3d

    if size <= 1:
        return depth
    seen = np.isfinite(depth)
    nearness = np.divide(1.0, depth, out=np.zeros(depth.shape, np.float32), where=seen, casting="unsafe")
    image = o3d.t.geometry.Image(o3d.core.Tensor(nearness[..., None].copy()))
    even = image.filter_bilateral(size, 3 * NEARNESS_NOISE, size / 2).as_tensor().numpy()[..., 0]
    return np.divide(1.0, even, out=np.full(depth.shape, np.nan), where=seen & (even > 0))
