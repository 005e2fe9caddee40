"""What belongs to a pool, cut out of the scene: its surface, what it stands on, and what rises from its edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..segmentation.clusters import euclidean_clusters, members_of
from ..settings import POOL, SCAN
from .surfaces import Pool


@dataclass(frozen=True, kw_only=True, eq=False)
class GroundSquares:
    """A part of the ground, as squares of `SCAN.cell`."""

    corner: np.ndarray  # (2,) int64, square of the mask's first element
    mask: np.ndarray  # (X, Y) bool

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


def footprint_of(pool: Pool) -> GroundSquares:
    """Return the ground below a pool's surface, gaps closed that are no wider than a neck."""
    from scipy.ndimage import binary_fill_holes

    border = int(np.ceil((POOL.neck + POOL.back_reach) / SCAN.cell)) + 2
    corner = pool.squares.min(axis=0) - border
    mask = np.zeros(pool.squares.max(axis=0) - corner + border + 1, bool)
    mask[tuple((pool.squares - corner).T)] = True
    closed = GroundSquares(corner=corner, mask=mask).grown(POOL.neck).shrunk(POOL.neck)
    return GroundSquares(corner=corner, mask=binary_fill_holes(closed.mask | mask))


def cut_out(points: np.ndarray, pool: Pool, gap: float) -> np.ndarray:
    """Return which points may be a pool's object, (N,) bool: what rises from its edge too, unless it is a table's.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
        Of the scene without ground and walls.
    pool : Pool
    gap : float
        Metres above the surface at which a back begins at the latest.
    """
    ground = footprint_of(pool)
    bare = ground.grown(2 * SCAN.cell).holds(points) & (points[:, 2] < pool.height + POOL.slab)
    if pool.is_table:
        return bare
    free = ~bare & (points[:, 2] >= pool.height + POOL.slab) & (points[:, 2] < POOL.highest)
    rising, middle = np.flatnonzero(ground.grown(POOL.back_reach).holds(points) & free), ground.shrunk(POOL.back_reach)
    for members in members_of(euclidean_clusters(points[rising], POOL.slab)):
        if is_back(points[rising[members]], pool, middle, gap):
            bare[rising[members]] = True
    return bare


def is_back(part: np.ndarray, pool: Pool, middle: GroundSquares, gap: float) -> bool:
    """Return whether what rises (P, 3) around a pool is a back or an arm, and not an object that stands on it."""
    if part[:, 2].min() > pool.height + gap:
        return False
    squares = np.unique(np.floor(part[:, :2] / SCAN.cell).astype(np.int64), axis=0)
    return bool(len(squares) * SCAN.cell**2 < POOL.back_area * pool.area + 0.02 and middle.holds(part).mean() < 0.5)
