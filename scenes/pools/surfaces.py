"""What carries a pool: the level surface that spheres rest on, also where nothing can fall on it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..scans.cells import cells
from ..segmentation.clusters import euclidean_clusters, members_of
from ..settings import POOL, SCAN


@dataclass(frozen=True, kw_only=True, eq=False)
class Pool:
    """Spheres that rest together, and the surface below them."""

    centers: np.ndarray  # (S, 3) float64, metres, level frame
    squares: np.ndarray  # (K, 2) int64, of the surface seen from above, in steps of `SCAN.cell`
    heights: np.ndarray  # (K,) float64, metres, of each square

    @cached_property
    def height(self) -> float:
        """Of the surface, metres."""
        return float(np.median(self.heights))

    @property
    def area(self) -> float:
        """Of the surface that is seen, square metres."""
        return len(self.squares) * SCAN.cell**2

    @property
    def is_table(self) -> bool:
        """Whether it is too large and too high for a seat: nothing that rises from it is its own."""
        return self.area >= POOL.table_area and self.height >= POOL.table_height


def level_pools(points: np.ndarray, centers: np.ndarray, radius: float) -> list[Pool]:
    """Return the pools of spheres of a radius in metres, the largest surface first.

    Spheres are of one pool where a chain of neighbours of one height connects them. Surfaces reach on below what is
    above them, as a seat does under a table: they are followed through the points, not through the spheres.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    centers : (S, 3) float64, metres
        Where spheres rest.
    """
    feet = centers - [0, 0, radius]
    stretched = feet / [POOL.linked * radius, POOL.linked * radius, POOL.slab]
    pools = [
        pool
        for members in members_of(euclidean_clusters(stretched, 1.0))
        if len(members) >= POOL.min_rests
        for pool in pools_at(points, centers[members], feet[members])
    ]
    return sorted(pools, key=lambda pool: (-pool.area, pool.height))


def pools_at(points: np.ndarray, centers: np.ndarray, feet: np.ndarray) -> list[Pool]:
    """Return the pools that a chain of spheres (S, 3), whose feet are given as well, is: one for each surface."""
    low, high = np.percentile(feet[:, 2], [10, 90]) + [-POOL.slab, POOL.slab]
    squares, heights = level_squares(points[near_feet(points, feet)], low, high)
    if not len(squares):
        return []
    surface_of = euclidean_clusters(np.column_stack([squares * SCAN.cell, np.zeros(len(squares))]), POOL.apart)
    support = surface_under(feet, squares, surface_of)
    return [
        Pool(centers=centers[support == k], squares=squares[members], heights=heights[members])
        for k, members in enumerate(members_of(surface_of))
        if np.count_nonzero(support == k) >= POOL.min_rests and len(members) * SCAN.cell**2 >= POOL.seen_area
    ]


def near_feet(points: np.ndarray, feet: np.ndarray) -> np.ndarray:
    """Return which points (N, 3) lie within a metre around spheres' feet (S, 3), (N,) bool."""
    reach = [1, 1, POOL.slab + POOL.upright]
    low, high = feet.min(axis=0) - reach, feet.max(axis=0) + reach
    inside = np.ones(len(points), bool)
    for column, least, most in zip(points.T, low, high, strict=True):  # which is much quicker than rows of three
        inside &= (column >= least) & (column <= most)
    return inside


def level_squares(points: np.ndarray, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the squares (K, 2) that hold points (N, 3) between two heights and are no part of a wall; their heights.

    A square whose points reach far above and below is upright, unless the band's own points are most of them.
    """
    if not len(points):
        return np.empty((0, 2), np.int64), np.empty(0)
    columns = cells(points * [1, 1, 0], SCAN.cell)
    inside = (points[:, 2] >= low) & (points[:, 2] <= high)
    count = np.bincount(columns.cell_of, inside, len(columns.keys))
    near = (points[:, 2] > low - POOL.upright) & (points[:, 2] < high + POOL.upright)
    others = np.bincount(columns.cell_of, near & ~inside, len(columns.keys))
    mean = np.bincount(columns.cell_of, points[:, 2] * inside, len(columns.keys)) / np.maximum(count, 1)
    level = (count > 0) & (others < 1.5 * count + 2)
    return columns.indices[level, :2], mean[level]


def surface_under(feet: np.ndarray, squares: np.ndarray, surface_of: np.ndarray) -> np.ndarray:
    """Return the surface (S,) under each sphere's foot (S, 3), -1 where there is none."""
    from scipy.spatial import cKDTree

    distance, nearest = cKDTree((squares + 0.5) * SCAN.cell).query(feet[:, :2])
    return np.where(distance < 2 * SCAN.cell, surface_of[nearest], -1)


def parted_at_necks(pool: Pool, centers: np.ndarray, radius: float) -> list[Pool]:
    """Return the parts of a pool that only necks connect, as a seat and a table of its height that it touches.

    Parameters
    ----------
    pool : Pool
    centers : (S, 3) float64, metres
        Where spheres rest, also those of other pools: of two on one surface one was left out.
    radius : float
        Of the spheres, metres.
    """
    from scipy.ndimage import binary_fill_holes, distance_transform_edt, label

    corner = pool.squares.min(axis=0) - 1
    mask = np.zeros(pool.squares.max(axis=0) - corner + 2, bool)
    squares = tuple((pool.squares - corner).T)
    mask[squares] = True
    broad = distance_transform_edt(binary_fill_holes(mask)) * SCAN.cell > POOL.neck / 2
    parts, count = label(broad)
    if count < 2:
        return []
    nearest = distance_transform_edt(~broad, return_distances=False, return_indices=True)
    part_of = parts[tuple(nearest)][squares]
    large = [k for k in range(1, count + 1) if np.count_nonzero(part_of == k) * SCAN.cell**2 >= POOL.part_area]
    if len(large) < 2:
        return []
    feet = centers - [0, 0, radius]
    on_it = np.where(np.abs(feet[:, 2] - pool.height) < 2 * POOL.slab, surface_under(feet, pool.squares, part_of), -1)
    return [
        Pool(centers=centers[on_it == k], squares=pool.squares[part_of == k], heights=pool.heights[part_of == k])
        for k in large
        if np.count_nonzero(on_it == k) >= POOL.min_rests
    ]
