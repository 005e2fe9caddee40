"""The ground below a surface, as squares seen from above."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.processes.compilation import njit

from ..settings import SCAN


@dataclass(frozen=True, kw_only=True, eq=False)
class GroundSquares:
    """A part of the ground, as squares of `SCAN.cell`."""

    corner: np.ndarray  # (2,) int64, square of the mask's first element
    mask: np.ndarray  # (X, Y) bool

    @property
    def x_range(self) -> tuple[float, float]:
        """Between which places along x the mask lies, metres."""
        return self.corner[0] * SCAN.cell, (self.corner[0] + len(self.mask)) * SCAN.cell

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Return which points (N, 3) lie above or below it, (N,) bool."""
        inside = np.empty(len(points), bool)
        find_inside(points, self.corner, self.mask, SCAN.cell, inside)
        return inside

    def grown(self, distance: float) -> GroundSquares:
        """Return it with all squares within a distance in metres."""
        from scipy.ndimage import distance_transform_edt

        return GroundSquares(corner=self.corner, mask=distance_transform_edt(~self.mask) * SCAN.cell <= distance)

    def shrunk(self, distance: float) -> GroundSquares:
        """Return it without the squares within a distance in metres of its edge."""
        from scipy.ndimage import distance_transform_edt

        return GroundSquares(corner=self.corner, mask=distance_transform_edt(self.mask) * SCAN.cell > distance)


@njit(cache=True, error_model="numpy")
def find_inside(points, corner, mask, side, inside):
    """Write which points (N, 3) lie in the squares of a mask (X, Y), (N,) bool; see `GroundSquares`."""
    for i in range(len(points)):
        x, y = int(np.floor(points[i, 0] / side)) - corner[0], int(np.floor(points[i, 1] / side)) - corner[1]
        inside[i] = 0 <= x < mask.shape[0] and 0 <= y < mask.shape[1] and mask[x, y]
