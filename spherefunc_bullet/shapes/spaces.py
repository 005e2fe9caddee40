"""The free space of an object on a grid: how much stands in it, and where a sphere can go; and its carrying level.

Both follow from the cells near a surface, so a mesh with holes, a sheet and a pile of convex pieces are alike to them.
The level is how high an object is seen from above, and how much of that a shape keeps.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import ndimage

from ..clouds.flooding import standing_in, thicken
from ..places.regions import raise_to
from .solid import Solid, dense_points

CELLS = 112  # along the largest extent
MARGIN = 6  # cells around
WALL = 0.9  # cells: half a wall's thickness where water stands; thinner ones would leak
NARROW, WIDE = 0.018, 0.04  # of the extent: what a sphere of the second went through, one of the first still has to
LEAKY = 0.5  # of the capacity: where less water stands, grains are asked about
SHUT = 1.0  # spheres of the narrow size: the space that has to be lost for an opening to be closed


@dataclass(frozen=True, kw_only=True, eq=False)
class VoxelGrid:
    """Cubic cells around an object."""

    low: np.ndarray  # (3,) lower corner, metres
    cell: float
    shape: tuple[int, int, int]

    def cells(self, solid: Solid) -> np.ndarray:
        """Return dense points (N, 3) of a shape's surface, in cells; those that lie outside are left out."""
        points = (dense_points(solid.vertices, solid.faces, 0.5 * self.cell) - self.low) / self.cell
        return points[((points > 0) & (points < self.shape)).all(axis=1)]

    def near(self, points: np.ndarray, reach: float) -> np.ndarray:
        """Return the cells (X, Y, Z) bool whose middle is within reach, in cells, of some points (N, 3)."""
        marked = np.zeros(self.shape, np.bool_)
        thicken(points, reach, marked)
        return marked


def grid_around(low: np.ndarray, high: np.ndarray) -> VoxelGrid:
    """Return the grid of a box."""
    cell = float((high - low).max()) / CELLS
    shape = np.ceil((high - low) / cell).astype(int) + 2 * MARGIN
    return VoxelGrid(low=low - MARGIN * cell, cell=cell, shape=tuple(shape.tolist()))


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeSpace:
    """What is free around one shape."""

    grid: VoxelGrid
    points: np.ndarray  # (N, 3) of the surface, in cells

    @cached_property
    def standing(self) -> np.ndarray:
        """The cells (X, Y, Z) bool that water cannot leave without rising, of walls two cells thick."""
        return standing_in(self.grid.near(self.points, WALL))

    @cached_property
    def basin(self) -> np.ndarray:
        """The largest body of water among them."""
        return largest(self.standing)

    @cached_property
    def capacity(self) -> float:
        """The volume of that body to the brim, m3: what two wall thicknesses would leave is drawn out to none."""
        thin = int(self.basin.sum())
        thick = int(largest(standing_in(self.grid.near(self.points, 2 * WALL))).sum())
        return (2 * thin - thick if thick else thin) * self.grid.cell**3

    def standing_of(self, reach: float) -> np.ndarray:
        """Return the cells (X, Y, Z) bool in which grains of a radius, in cells, stand: finer holes let none out."""
        return standing_in(self.grid.near(self.points, reach))

    def reached(self, share: float) -> np.ndarray:
        """Return the cells (X, Y, Z) bool that the middle of a sphere comes to from the sides or from above.

        Its radius is a share of the extent. Nothing passes below the ground.
        """
        blocked = self.grid.near(self.points, share * CELLS)
        blocked[:, :, :MARGIN] = True
        free, _ = ndimage.label(~blocked)
        outside = free[0, 0, -1]
        return free == outside


def largest(cells: np.ndarray) -> np.ndarray:
    """Return the largest connected part of some cells (X, Y, Z) bool."""
    parts, count = ndimage.label(cells)
    return parts == 1 + np.bincount(parts.ravel())[1:].argmax() if count else cells


def closed(reached: np.ndarray, still: np.ndarray) -> int:
    """Return how many openings are closed.

    A bulging wall takes a thin layer of the free space, a wall across an opening one of two radii of the sphere: what
    does not survive erosion by a cell is left out.

    Parameters
    ----------
    reached, still : (X, Y, Z) bool
        Where a sphere of the wide size came to in the object, and one of the narrow size in the shape.
    """
    parts, _ = ndimage.label(ndimage.binary_erosion(reached & ~still))
    sphere = 4 / 3 * np.pi * (NARROW * CELLS) ** 3
    return int((np.bincount(parts.ravel())[1:] > SHUT * sphere).sum())


def held_share(item: FreeSpace, shape: FreeSpace, reach: float) -> tuple[float, bool]:
    """Return the share of what stands in an object that stands in a shape too, and whether water runs out of that.

    Parameters
    ----------
    reach : float, cells
        Of the grains that are asked about where water runs out: shapes of voxels have gaps that no sphere falls into.
    """
    water = float((shape.standing & item.basin).sum() / max(1, item.basin.sum()))
    if water > LEAKY or reach <= WALL:
        return water, False
    whole = largest(item.standing_of(reach))
    grains = float((shape.standing_of(reach) & whole).sum() / max(1, whole.sum()))
    return (grains, True) if grains > water + LEAKY else (water, False)


def is_filled(basin: np.ndarray, seen: np.ndarray, reached: np.ndarray) -> bool:
    """Return whether a sphere no longer comes to most of where water stands in an object.

    Parameters
    ----------
    basin : (X, Y, Z) bool
        Where water stands.
    seen, reached : (X, Y, Z) bool
        Where the middle of a sphere comes to in the object, and in the shape.
    """
    return bool(2 * (basin & reached).sum() < (basin & seen).sum())


def space_of(grid: VoxelGrid, solid: Solid) -> FreeSpace:
    """Return the free space around a shape."""
    return FreeSpace(grid=grid, points=grid.cells(solid))


MAP_CELLS = 160  # along the longer side of the footprint
AROUND = 0.012  # of the extent: heights so near belong to one level, and no less than LEAST
LEAST = 0.004  # metres
SAME = 0.006  # of the extent: a height so near is the same, between SAME_LEAST and SAME_MOST
SAME_LEAST, SAME_MOST = 0.002, 0.008  # metres


@dataclass(frozen=True, kw_only=True, eq=False)
class CarryingLevel:
    """The level that carries most, seen from above."""

    height: float  # metres over the ground
    area: float  # m2
    cells: np.ndarray  # (X, Y) bool


def height_map(solid: Solid, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the height (X, Y) of a shape over each cell of a footprint, minus infinity where there is none."""
    cell = cell_of(low, high)
    shape = np.ceil((high - low)[:2] / cell).astype(int) + 1
    points = dense_points(solid.vertices, solid.faces, 0.6 * cell)
    heights = np.full(shape, -np.inf)
    raise_to(points, low[:2], cell, heights)
    return heights


def cell_of(low: np.ndarray, high: np.ndarray) -> float:
    """Return the side of a cell of a footprint, metres."""
    return float((high - low)[:2].max()) / MAP_CELLS


def carrying_level(heights: np.ndarray, low: np.ndarray, high: np.ndarray) -> CarryingLevel:
    """Return the level that most of a height map (X, Y) lies at."""
    near = max(LEAST, AROUND * float((high - low).max()))
    known = np.sort(heights[np.isfinite(heights)])
    ends = np.searchsorted(known, known + 2 * near, side="right")
    start = int(np.argmax(ends - np.arange(len(known))))
    middle = float(np.median(known[start : ends[start]]))
    cells = np.abs(heights - middle) <= near
    return CarryingLevel(height=middle, area=float(cells.sum()) * cell_of(low, high) ** 2, cells=cells)


def level_kept(level: CarryingLevel, heights: np.ndarray, other: np.ndarray, extent: float) -> tuple[float, float]:
    """Return the share of a level at which a shape's height map (X, Y) has the same height, and how much it is higher.

    The same is what one of the nine cells around has, so that edges do not count by how they fall onto the cells.
    """
    same = float(np.clip(SAME * extent, SAME_LEAST, SAME_MOST))
    lowest, top = ndimage.minimum_filter(other, 3), ndimage.maximum_filter(other, 3)
    covered = (lowest <= heights + same) & (top >= heights - same)
    both = level.cells & np.isfinite(other)
    higher = other[both] - heights[both]
    return float(covered[level.cells].mean()), float(np.median(higher)) if len(higher) else float("nan")
