"""The level that makes a seat or a table: found as the height at which most of an object lies open to the sky."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import ndimage

from .surfaces import ObjectSurface

BAND = 0.06  # metres of height that count as one level: cushions are not flat
SHARE = 0.12  # of the footprint's box, at least: less is no seat and no top
DEEPEST = 0.35  # of a level's height: parts that hang below a seat or a top end above that
LEFT_OVER = 0.12  # of a cut's cells that may still hold something at that height, such as legs
ALIKE = (0.6, 1.4)  # times a level's height: another level there would serve as well
ENOUGH = 0.5  # of its area
Where = Callable[[np.ndarray], np.ndarray]  # of places (N, 2), returns which are selected


@dataclass(frozen=True, eq=False)
class GroundGrid:
    """Square cells over the ground."""

    low: np.ndarray  # (2,) metres
    cell: float  # metres
    shape: tuple[int, int]

    def cells_of(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the cell of each point (N, 2 or 3); those outside go to the margin, which is empty."""
        index = np.floor((points[:, :2] - self.low) / self.cell).astype(int)
        return tuple(np.clip(index, 0, np.array(self.shape) - 1).T)

    def places(self, mask: np.ndarray) -> np.ndarray:
        """Return the middles (C, 2) of the cells of a mask."""
        return self.low + (np.argwhere(mask) + 0.5) * self.cell

    def tops(self, points: np.ndarray) -> np.ndarray:
        """Return the height of the highest point in each cell; -inf where there is none."""
        tops = np.full(self.shape, -np.inf)
        np.maximum.at(tops, self.cells_of(points), points[:, 2])
        return tops


def grid_over(surface: ObjectSurface) -> GroundGrid:
    """Return the cells that a surface covers, and a margin of two."""
    low, high = surface.bounds[:, :2]
    low = low - 2 * surface.cell
    shape = np.ceil((high - low) / surface.cell).astype(int) + 3
    return GroundGrid(low, surface.cell, tuple(shape.tolist()))


@dataclass(frozen=True, eq=False)
class LevelPart:
    """A level part of a surface, open to the sky."""

    grid: GroundGrid
    cells: np.ndarray  # (X, Y) bool, where it is, including its rounded edges and lower ledges
    flat: np.ndarray  # (X, Y) bool, where it is level
    height: float  # metres
    upper: float  # metres, the highest place that still belongs to it

    @property
    def area(self) -> float:
        """Square metres that are level."""
        return float(self.flat.sum()) * self.grid.cell**2

    @cached_property
    def box(self) -> np.ndarray:
        """Lowest and highest corner (2, 2) of the level cells."""
        places = self.grid.places(self.flat)
        return np.array([places.min(axis=0), places.max(axis=0)]) + [[-self.grid.cell / 2], [self.grid.cell / 2]]

    def over(self, points: np.ndarray) -> np.ndarray:
        """Return which points (N, 3) lie over or under it, and a cell around."""
        return ndimage.binary_dilation(self.cells)[self.grid.cells_of(points)]

    def is_left_in(self, surface: ObjectSurface) -> bool:
        """Return whether a changed surface has a level of about this height and at least half the area."""
        lowest, highest = np.array(ALIKE) * self.height
        other = find_level(surface, lowest, highest)
        return other is not None and other.area >= ENOUGH * self.area


def find_level(surface: ObjectSurface, lowest: float, highest: float) -> LevelPart | None:
    """Return the largest level between two heights, metres; None where none is large enough."""
    grid = grid_over(surface)
    tops = grid.tops(surface.centres)
    heights = np.sort(tops[(tops >= lowest) & (tops <= highest)])
    if not len(heights):
        return None
    counts = np.searchsorted(heights, heights + BAND, side="right") - np.arange(len(heights))
    start = heights[counts.argmax()]
    flat = (tops >= start) & (tops <= start + BAND)
    if flat.sum() * grid.cell**2 < SHARE * surface.size[0] * surface.size[1]:
        return None
    height = float(np.median(tops[flat]))
    parts, _ = ndimage.label((tops >= DEEPEST * height) & (tops <= start + BAND), structure=np.ones((3, 3)))
    cells = np.isin(parts, np.unique(parts[flat])) & (parts > 0)
    return LevelPart(grid, cells, flat, height, float(start + BAND))


def cut_away(surface: ObjectSurface, level: LevelPart, where: Where | None = None) -> ObjectSurface | None:
    """Return a surface without a level and the parts close below it, None where something always remains.

    Parts below about a third of the height stay: legs, shelves, the floor of a chest.

    Parameters
    ----------
    where : callable
        Returns which places (N, 2) are cut; by default the whole level is.
    """
    centres = surface.centres
    cut = np.ones(len(centres), bool) if where is None else where(centres[:, :2])
    cells = level.cells if where is None else level.cells & np.isfinite(level.grid.tops(centres[cut]))
    below = cut & level.over(centres) & (centres[:, 2] <= level.upper + 0.2 * BAND)
    for depth in np.linspace(0.06, 1 - DEEPEST, 12):
        gone = below & (centres[:, 2] >= (1 - depth) * level.height)
        tops = level.grid.tops(centres[cut & ~gone])[cells]
        left = (tops > DEEPEST * level.height) & (tops <= level.upper)
        if left.mean() <= LEFT_OVER:
            return surface.without(gone)
    return None


LEVELS = 40  # of an object's height
DEEP = 0.25  # of its height, at least: a saucer is no cup
WIDE = 0.05  # of the footprint's box, at least


@dataclass(frozen=True, eq=False)
class Cavity:
    """Where water stands in a cup."""

    grid: GroundGrid
    axis: np.ndarray  # (2,) its middle, metres
    heights: np.ndarray  # (L,) metres, where water stands, ascending
    areas: np.ndarray  # (L,) square metres of water at each
    reach: float  # metres from the axis to the farthest water
    floor: float  # metres

    @property
    def brim(self) -> float:
        """Height to which it can be filled, metres."""
        return float(self.heights[-1])

    @property
    def radii(self) -> np.ndarray:
        """Radius of a disc as large as the water at each height, (L,) metres."""
        return np.sqrt(self.areas / np.pi)

    @property
    def volume(self) -> float:
        """Cubic metres of water."""
        return float(self.areas.sum()) * (self.brim - self.floor) / len(self.areas)

    def distances(self, points: np.ndarray) -> np.ndarray:
        """Return the distances of points (N, 3) from the axis, (N,) metres."""
        return np.linalg.norm(points[:, :2] - self.axis, axis=1)

    def is_left_in(self, surface: ObjectSurface) -> bool:
        """Return whether a changed surface holds more than a third of this one's water."""
        other = find_cavity(surface)
        return other is not None and other.volume > self.volume / 3


def find_cavity(surface: ObjectSurface) -> Cavity | None:
    """Return the cavity of a surface; None where it is shallow or narrow, or leaks."""
    grid = grid_over(surface)
    tops = grid.tops(surface.centres)
    heights = (np.arange(LEVELS) + 0.5) / LEVELS * surface.size[2] + surface.bounds[0, 2]
    pools = [standing_water(tops, height) for height in heights]
    areas = np.array([pool.sum() for pool in pools]) * grid.cell**2
    holding = np.flatnonzero(areas > WIDE * surface.size[0] * surface.size[1])
    if len(holding) < DEEP * LEVELS:
        return None
    widest = pools[holding[areas[holding].argmax()]]
    places = grid.places(widest)
    axis = places.mean(axis=0)
    middle = np.linalg.norm(places - axis, axis=1) <= max(0.3 * np.sqrt(areas.max() / np.pi), grid.cell)
    floor = float(np.median(tops[widest][middle]))
    reach = float(np.linalg.norm(places - axis, axis=1).max()) + grid.cell
    return Cavity(grid, axis, heights[holding], areas[holding], reach, floor)


def standing_water(tops: np.ndarray, height: float) -> np.ndarray:
    """Return the cells (X, Y) bool in which water stands at a height: enclosed, and with a floor everywhere."""
    wall = tops >= height
    pools, _ = ndimage.label(ndimage.binary_fill_holes(wall) & ~wall)
    leaking = np.unique(pools[np.isneginf(tops)])
    return (pools > 0) & ~np.isin(pools, leaking)
