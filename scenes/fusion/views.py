"""What one depth image says of points of the map: seen, hidden, or that their place is free now."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..scans.depth_image import Intrinsics

POOL = 4  # pixels along the side of a window; what is narrower than one is no evidence
LEAST_FILLED = 0.5  # of a window's pixels that have a depth
MARGIN = 0.03  # metres of depth within which a point lies on what is measured,
MARGIN_GROWTH = 0.006  # more with the square of the depth: three deviations of a Kinect (Nguyen et al. 2012)
UNKNOWN, HIDDEN, PRESENT, FREE = range(4)


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """A depth image in windows of a few pixels, with its camera."""

    nearest: np.ndarray  # (h, w) float32, least depth of each window, metres; NaN where too few pixels have one
    farthest: np.ndarray  # (h, w) float32, likewise the largest
    intrinsics: Intrinsics
    T_world_camera: np.ndarray  # (4, 4)

    def verdicts(self, points: np.ndarray) -> np.ndarray:
        """Return UNKNOWN, HIDDEN, PRESENT or FREE for each point (N, 3) of the world, (N,) int8."""
        row, column, depth = self.pixels(points)
        inside = row >= 0
        row, column = np.where(inside, row, 0), np.where(inside, column, 0)
        nearest, farthest = self.nearest[row, column], self.farthest[row, column]
        margin = margin_at(depth)
        out = np.full(len(points), UNKNOWN, np.int8)
        known = inside & np.isfinite(nearest)
        out[known & (depth > farthest + margin)] = HIDDEN
        out[known & (depth <= farthest + margin) & (depth >= nearest - margin)] = PRESENT
        out[known & (depth < nearest - margin)] = FREE
        return out

    def pixels(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the row and column of the window that each point (N, 3) falls in, -1 outside, and its depth."""
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


def margin_at(depth: np.ndarray) -> np.ndarray:
    """Return how far a point at a depth may be off what is measured, and still lies on it, metres."""
    return MARGIN + MARGIN_GROWTH * depth**2


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
