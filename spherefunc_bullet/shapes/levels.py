"""The carrying level of an object: how high it is seen from above, and how much of that a shape keeps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from ..places.regions import raise_to
from .solid import Solid, dense_points

CELLS = 160  # along the longer side of the footprint
AROUND = 0.012  # of the extent: heights so near belong to one level, and no less than LEAST
LEAST = 0.004  # metres
SAME = 0.006  # of the extent: a height so near is the same, between SAME_LEAST and SAME_MOST
SAME_LEAST, SAME_MOST = 0.002, 0.008  # metres


@dataclass(frozen=True, kw_only=True, eq=False)
class Level:
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
    return float((high - low)[:2].max()) / CELLS


def carrying_level(heights: np.ndarray, low: np.ndarray, high: np.ndarray) -> Level:
    """Return the level that most of a height map (X, Y) lies at."""
    near = max(LEAST, AROUND * float((high - low).max()))
    known = np.sort(heights[np.isfinite(heights)])
    ends = np.searchsorted(known, known + 2 * near, side="right")
    start = int(np.argmax(ends - np.arange(len(known))))
    middle = float(np.median(known[start : ends[start]]))
    cells = np.abs(heights - middle) <= near
    return Level(height=middle, area=float(cells.sum()) * cell_of(low, high) ** 2, cells=cells)


def level_kept(level: Level, heights: np.ndarray, other: np.ndarray, extent: float) -> tuple[float, float]:
    """Return the share of a level at which a shape's height map (X, Y) has the same height, and how much it is higher.

    The same is what one of the nine cells around has, so that edges do not count by how they fall onto the cells.
    """
    same = float(np.clip(SAME * extent, SAME_LEAST, SAME_MOST))
    lowest, top = ndimage.minimum_filter(other, 3), ndimage.maximum_filter(other, 3)
    kept = (lowest <= heights + same) & (top >= heights - same)
    both = level.cells & np.isfinite(other)
    higher = other[both] - heights[both]
    return float(kept[level.cells].mean()), float(np.median(higher)) if len(higher) else float("nan")
