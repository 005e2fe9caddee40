"""Pools of spheres dropped on a whole scene, and the level surfaces that carry them, also where no sphere can fall.

The paper drops spheres on objects. On a scene they find what carries and what holds, before objects are known.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from spherefunc_bullet.clouds.cloud import MIN_POINTS, Cloud, corners_of
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.processes.tasks import run_tasks
from spherefunc_bullet.simulator import DropSettings, Simulator, drop_on, isolated, make_simulator

from ..scans.cells import Cells, cells
from ..segmentation.clusters import euclidean_clusters, members_of
from ..settings import POOL, SCAN
from .ground_squares import GroundSquares


def resting_places(points: np.ndarray, simulator: str | Simulator, radius: float, *, seed: int = 0) -> np.ndarray:
    """Return the centres (S, 3), metres, of spheres that rest on a scene.

    Several runs of few spheres are made, so that they lie apart, and spheres that rest on others are left out.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
        Of the scene above its ground z = 0, without the ground itself.
    simulator : str or Simulator
    radius : float
        Metres.
    seed : int

    Raises
    ------
    InputError
        If the simulator cannot handle the scene.
    """
    points = points[points[:, 2] > 0]
    if len(points) < MIN_POINTS or np.ptp(corners_of(points), axis=0).max() < radius:
        return np.empty((0, 3))
    scene, simulator = Cloud(points, "scene"), make_simulator(simulator)
    count = max(int(POOL.density * np.prod(scene.size[:2]) / radius**2), POOL.min_spheres)
    settings = DropSettings(radius=radius, miss_limit=count, max_drops=count, even_columns=True)
    tasks = [(scene, simulator, settings, seed + run) for run in range(POOL.runs)]
    found = []
    for _, outcome in run_tasks(centers_on, tasks, ["scene"] * POOL.runs, isolate=isolated(simulator)):
        if isinstance(outcome, InputError):
            raise outcome
        found.append(outcome)
    return np.vstack(found)


def centers_on(scene: Cloud, simulator: Simulator, settings: DropSettings, seed: int) -> np.ndarray:
    """Return the centres (S, 3) of the spheres of one run that rest on the scene itself, metres."""
    result = drop_on(scene, simulator, settings, seed)
    return result.centers[result.on_object]


@dataclass(frozen=True, kw_only=True, eq=False)
class Pool:
    """Spheres that rest together, and the surface below them."""

    centers: np.ndarray  # (S, 3) float64, metres, level frame
    squares: np.ndarray  # (K, 2) int64, of the surface seen from above, in steps of `SCAN.cell`
    heights: np.ndarray  # (K,) float64, metres, of each square

    @cached_property
    def height(self) -> float:
        """Height of the surface, metres."""
        return float(np.median(self.heights))

    @property
    def area(self) -> float:
        """Area of the visible surface, square metres."""
        return len(self.squares) * SCAN.cell**2

    @cached_property
    def footprint(self) -> GroundSquares:
        """The ground below the surface, with gaps closed that are at most as wide as a neck."""
        from scipy.ndimage import binary_fill_holes

        border = int(np.ceil((POOL.neck + POOL.back_reach) / SCAN.cell)) + 2
        corner = self.squares.min(axis=0) - border
        mask = np.zeros(self.squares.max(axis=0) - corner + border + 1, bool)
        mask[tuple((self.squares - corner).T)] = True
        closed = GroundSquares(corner=corner, mask=mask).grown(POOL.neck).shrunk(POOL.neck)
        return GroundSquares(corner=corner, mask=binary_fill_holes(closed.mask | mask))

    @property
    def is_table(self) -> bool:
        """Whether it is too large and too high for a seat; then objects that rise from it are not parts of it."""
        return self.area >= POOL.table_area and self.height >= POOL.table_height


def level_pools(voxels: Cells, centers: np.ndarray, radius: float) -> list[Pool]:
    """Return the pools of spheres of a radius in metres, the largest surface first.

    Spheres are in one pool if a chain of neighbours at one height connects them. A surface may continue below something
    else, as a seat does under a table, so it is followed through the points, not through the spheres.

    Parameters
    ----------
    voxels : Cells
        Of the scene's points, level frame; their means are followed.
    centers : (S, 3) float64, metres
        Where spheres rest.
    """
    feet = centers - [0, 0, radius]
    stretched = feet / [POOL.linked * radius, POOL.linked * radius, POOL.slab]
    pools = [
        pool
        for members in members_of(euclidean_clusters(stretched, 1.0))
        if len(members) >= POOL.min_rests
        for pool in pools_at(voxels, centers[members], feet[members])
    ]
    return sorted(pools, key=lambda pool: (-pool.area, pool.height))


def pools_at(voxels: Cells, centers: np.ndarray, feet: np.ndarray) -> list[Pool]:
    """Return the pools of a chain of spheres (S, 3) with their lowest points (S, 3): one for each surface."""
    low, high = np.percentile(feet[:, 2], [10, 90]) + [-POOL.slab, POOL.slab]
    squares, heights = level_squares(near_feet(voxels, feet), low, high)
    if not len(squares):
        return []
    surface_of = euclidean_clusters(np.column_stack([squares * SCAN.cell, np.zeros(len(squares))]), POOL.apart)
    support = surface_under(feet, squares, surface_of)
    return [
        Pool(centers=centers[support == k], squares=squares[members], heights=heights[members])
        for k, members in enumerate(members_of(surface_of))
        if np.count_nonzero(support == k) >= POOL.min_rests and len(members) * SCAN.cell**2 >= POOL.seen_area
    ]


def near_feet(voxels: Cells, feet: np.ndarray) -> np.ndarray:
    """Return the means (M, 3) of the voxels that lie within a metre around spheres' feet (S, 3)."""
    reach = [1, 1, POOL.slab + POOL.upright]
    low, high = feet.min(axis=0) - reach, feet.max(axis=0) + reach
    points = voxels.means[voxels.along_x(low[0], high[0])]
    inside = np.ones(len(points), bool)
    for column, least, most in zip(points.T, low, high, strict=True):  # which is much quicker than rows of three
        inside &= (column >= least) & (column <= most)
    return points[inside]


def level_squares(points: np.ndarray, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the squares (K, 2) with points (N, 3) between two heights that are not part of a wall, and their heights.

    A square with many points above and below the band is upright, unless most points are in the band.
    """
    if not len(points):
        return np.empty((0, 2), np.int64), np.empty(0)
    columns = cells(points * [1, 1, 0], SCAN.cell)
    inside = (points[:, 2] >= low) & (points[:, 2] <= high)
    count = np.bincount(columns.cell_of, inside, len(columns.keys))
    near = (points[:, 2] > low - POOL.upright) & (points[:, 2] < high + POOL.upright)
    others = np.bincount(columns.cell_of, near & ~inside, len(columns.keys))
    level = (count > 0) & (others < 1.5 * count + 2)
    upper = inside.copy()
    upper[inside] = upper_face(points[inside])
    count = np.bincount(columns.cell_of, upper, len(columns.keys))
    mean = np.bincount(columns.cell_of, points[:, 2] * upper, len(columns.keys)) / np.maximum(count, 1)
    return columns.indices[level, :2], mean[level]


def upper_face(points: np.ndarray) -> np.ndarray:
    """Return which points (N, 3) of a nearly level surface are on its upper face, (N,) bool.

    All are, unless the scan shows a board from both sides: then most columns have nothing in the middle between their
    highest and lowest points, where a sensor's noise has most.
    """
    columns = cells(points * [1, 1, 0], SCAN.cell)
    low, high = np.full(len(columns.keys), np.inf), np.full(len(columns.keys), -np.inf)
    np.minimum.at(low, columns.cell_of, points[:, 2])
    np.maximum.at(high, columns.cell_of, points[:, 2])
    middle, half = (low + high)[columns.cell_of] / 2, (high - low)[columns.cell_of] / 2
    between = np.bincount(columns.cell_of, np.abs(points[:, 2] - middle) < half / 2, len(columns.keys))
    thick = (high - low > SCAN.cell / 2) & (columns.counts >= 4)
    hollow = thick & (between == 0)
    if np.count_nonzero(hollow) <= np.count_nonzero(thick) / 2:
        return np.ones(len(points), bool)
    return ~hollow[columns.cell_of] | (points[:, 2] > middle)


def surface_under(feet: np.ndarray, squares: np.ndarray, surface_of: np.ndarray) -> np.ndarray:
    """Return the surface (S,) under each sphere's foot (S, 3), -1 where there is none."""
    from scipy.spatial import cKDTree

    distance, nearest = cKDTree((squares + 0.5) * SCAN.cell).query(feet[:, :2])
    return np.where(distance < 2 * SCAN.cell, surface_of[nearest], -1)


def parted_at_necks(pool: Pool, centers: np.ndarray, radius: float) -> list[Pool]:
    """Return the parts of a pool that only necks connect, such as a seat and a table of its height that it touches.

    Parameters
    ----------
    pool : Pool
    centers : (S, 3) float64, metres
        Of all spheres, also those of other pools, since of two pools on one surface one may have been left out.
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
