"""The ground below a surface, as squares seen from above."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..settings import SCAN


@dataclass(frozen=True, kw_only=True, eq=False)
class GroundSquares:
    """A part of the ground, as squares of `SCAN.cell`."""

    corner: np.ndarray  # (2,) int64, square of the mask's first element
    mask: np.ndarray  # (X, Y) bool

    @property
    def range_x(self) -> tuple[float, float]:
        """The least and the largest x, metres."""
        return self.corner[0] * SCAN.cell, (self.corner[0] + self.mask.shape[0]) * SCAN.cell

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Return which points (N, 3) lie above or below it, (N,) bool."""
        x, y = (np.floor(points[:, k] / SCAN.cell).astype(np.int64) - self.corner[k] for k in range(2))
        known = (x >= 0) & (x < self.mask.shape[0]) & (y >= 0) & (y < self.mask.shape[1])
        inside = np.zeros(len(points), bool)
        inside[known] = self.mask[x[known], y[known]]
        return inside

    def grown(self, distance: float) -> GroundSquares:
        """Return it with all squares within a distance in metres."""
        from scipy.ndimage import distance_transform_edt

        return GroundSquares(corner=self.corner, mask=distance_transform_edt(~self.mask) * SCAN.cell <= distance)

    def shrunk(self, distance: float) -> GroundSquares:
        """Return it without the squares within a distance in metres of its edge."""
        from scipy.ndimage import distance_transform_edt

        return GroundSquares(corner=self.corner, mask=distance_transform_edt(self.mask) * SCAN.cell > distance)
