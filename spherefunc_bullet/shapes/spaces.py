"""The free space of an object on a grid: its capacity, and where a sphere can go; and its carrying level.

The free space follows from the cells near a surface, so it can be computed for meshes with holes, for sheets and for
convex pieces. The carrying level follows from the heights of an object seen from above.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy import ndimage

from ..clouds.flooding import standing_in, thicken
from ..places.regions import raise_to
from .solid import Solid, dense_points

CELLS = 112  # along the largest extent
MARGIN = 6  # cells around
WALL = 0.9  # cells: half the thickness of walls for water; thinner walls would leak
NARROW, WIDE = 0.018, 0.04  # of the extent: radii; the narrow sphere must still pass where the wide one passed
LEAKY = 0.5  # of the capacity: if a shape holds less water, it is tested with grains
SHUT = 1.0  # volumes of the narrow sphere: an opening that has lost more is closed


@dataclass(frozen=True, kw_only=True, eq=False)
class VoxelGrid:
    """Cubic cells around an object."""

    low: np.ndarray  # (3,) lower corner, metres
    cell: float
    shape: tuple[int, int, int]

    def free_space(self, solid: Solid) -> FreeSpace:
        """Return the free space around a shape, of which parts outside the grid are ignored."""
        points = (dense_points(solid, 0.5 * self.cell) - self.low) / self.cell
        return FreeSpace(grid=self, points=points[((points > 0) & (points < self.shape)).all(axis=1)])

    def near(self, points: np.ndarray, reach: float) -> np.ndarray:
        """Return the cells (X, Y, Z) bool whose middle is within a reach, in cells, of some points (N, 3)."""
        marked = np.zeros(self.shape, np.bool_)
        thicken(points, reach, marked)
        return marked


def grid_around(low: np.ndarray, high: np.ndarray) -> VoxelGrid:
    """Return the grid around a bounding box."""
    cell = float((high - low).max()) / CELLS
    shape = np.ceil((high - low) / cell).astype(int) + 2 * MARGIN
    return VoxelGrid(low=low - MARGIN * cell, cell=cell, shape=tuple(shape.tolist()))


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeSpace:
    """The free space around one shape."""

    grid: VoxelGrid
    points: np.ndarray  # (N, 3) of the surface, in cells
    known: dict[float, np.ndarray] = field(default_factory=dict, repr=False)  # what was reached, see there

    @cached_property
    def standing(self) -> np.ndarray:
        """The cells (X, Y, Z) bool that water cannot leave without rising, with walls two cells thick."""
        return standing_in(self.grid.near(self.points, WALL))

    @cached_property
    def basin(self) -> np.ndarray:
        """The largest body of water among them."""
        return largest(self.standing)

    @cached_property
    def capacity(self) -> float:
        """The volume of that body to the brim, m3, extrapolated from two wall thicknesses to none.

        Thicker walls leave less room; where they hold more, the thin ones have gaps, and nothing is extrapolated.
        """
        thin = int(self.basin.sum())
        thick = int(largest(standing_in(self.grid.near(self.points, 2 * WALL))).sum())
        return (2 * thin - thick if 0 < thick < thin else thin) * self.grid.cell**3

    def standing_of(self, reach: float) -> np.ndarray:
        """Return the cells (X, Y, Z) bool that grains of a radius, in cells, cannot leave without rising."""
        return standing_in(self.grid.near(self.points, reach))

    def reached(self, share: float) -> np.ndarray:
        """Return the cells (X, Y, Z) bool that the centre of a sphere can reach from the sides or from above.

        Its radius is a share of the extent. Nothing passes below the ground.
        """
        if share not in self.known:
            blocked = self.grid.near(self.points, share * CELLS)
            blocked[:, :, :MARGIN] = True
            free, _ = ndimage.label(~blocked)
            self.known[share] = free == free[0, 0, -1]
        return self.known[share]


def largest(cells: np.ndarray) -> np.ndarray:
    """Return the largest connected part of some cells (X, Y, Z) bool."""
    parts, count = ndimage.label(cells)
    return parts == 1 + np.bincount(parts.ravel())[1:].argmax() if count else cells


def closed_openings(reached: np.ndarray, still: np.ndarray) -> int:
    """Return the number of openings that a shape closes.

    A bulging wall takes a thin layer of the free space, which erosion by one cell removes; a wall across an opening
    takes a layer as thick as the sphere.

    Parameters
    ----------
    reached, still : (X, Y, Z) bool
        Cells that the wide sphere reached in the object, and those that the narrow sphere reaches in the shape.
    """
    parts, _ = ndimage.label(ndimage.binary_erosion(reached & ~still))
    sphere = 4 / 3 * np.pi * (NARROW * CELLS) ** 3
    return int((np.bincount(parts.ravel())[1:] > SHUT * sphere).sum())


def held_share(item: FreeSpace, shape: FreeSpace, reach: float) -> tuple[float, bool]:
    """Return the share of the water in an object that a shape holds too, and whether the shape leaks and holds grains.

    Parameters
    ----------
    reach : float, cells
        Radius of the grains that are tested if water runs out: voxel shapes have gaps that no sphere falls into.
    """
    water = float((shape.standing & item.basin).sum() / max(1, item.basin.sum()))
    if water > LEAKY or reach <= WALL:
        return water, False
    whole = largest(item.standing_of(reach))
    grains = float((shape.standing_of(reach) & whole).sum() / max(1, whole.sum()))
    return (grains, True) if grains > water + LEAKY else (water, False)


def is_filled(basin: np.ndarray, seen: np.ndarray, reached: np.ndarray) -> bool:
    """Return whether a sphere no longer reaches most of the water in an object.

    Parameters
    ----------
    basin : (X, Y, Z) bool
        Cells of the water.
    seen, reached : (X, Y, Z) bool
        Cells that the centre of a sphere reaches in the object, and in the shape.
    """
    return bool(2 * (basin & reached).sum() < (basin & seen).sum())


MAP_CELLS = 160  # along the longer side of the footprint
AROUND = 0.012  # of the extent, but at least LEAST: range of the heights of one level
LEAST = 0.004  # metres
SAME = 0.006  # of the extent, between SAME_LEAST and SAME_MOST: tolerance of equal heights
SAME_LEAST, SAME_MOST = 0.002, 0.008  # metres


@dataclass(frozen=True, kw_only=True, eq=False)
class CarryingLevel:
    """The level that carries most, seen from above."""

    height: float  # metres above the ground
    area: float  # m2
    cells: np.ndarray  # (X, Y) bool


def height_map(solid: Solid, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the height (X, Y) of a shape in each cell of a footprint; minus infinity in empty cells."""
    cell = cell_of(low, high)
    shape = np.ceil((high - low)[:2] / cell).astype(int) + 1
    points = dense_points(solid, 0.6 * cell)
    heights = np.full(shape, -np.inf)
    raise_to(points, low[:2], cell, heights)
    return heights


def cell_of(low: np.ndarray, high: np.ndarray) -> float:
    """Return the side of the cells of a footprint, metres."""
    return float((high - low)[:2].max()) / MAP_CELLS


def carrying_level(heights: np.ndarray, low: np.ndarray, high: np.ndarray) -> CarryingLevel:
    """Return the level that contains most of a height map (X, Y)."""
    near = max(LEAST, AROUND * float((high - low).max()))
    known = np.sort(heights[np.isfinite(heights)])
    ends = np.searchsorted(known, known + 2 * near, side="right")
    start = int(np.argmax(ends - np.arange(len(known))))
    middle = float(np.median(known[start : ends[start]]))
    cells = np.abs(heights - middle) <= near
    return CarryingLevel(height=middle, area=float(cells.sum()) * cell_of(low, high) ** 2, cells=cells)


def level_kept(level: CarryingLevel, heights: np.ndarray, other: np.ndarray, extent: float) -> tuple[float, float]:
    """Return the share of a level where the height map (X, Y) of a shape agrees, and by how much the shape is higher.

    A cell agrees if one of the nine cells around it does, so that the position of edges within cells does not matter.
    """
    same = float(np.clip(SAME * extent, SAME_LEAST, SAME_MOST))
    lowest, top = ndimage.minimum_filter(other, 3), ndimage.maximum_filter(other, 3)
    covered = (lowest <= heights + same) & (top >= heights - same)
    both = level.cells & np.isfinite(other)
    higher = other[both] - heights[both]
    return float(covered[level.cells].mean()), float(np.median(higher)) if len(higher) else float("nan")
