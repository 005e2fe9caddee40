"""The cavity that makes a cup: where water would stand, found by filling the height map level by level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from .levels import Grid, grid_over
from .surfaces import Surface

LEVELS = 40  # of an object's height
DEEP = 0.25  # of its height, at least: a saucer is no cup
WIDE = 0.05  # of the footprint's box, at least


@dataclass(frozen=True, eq=False)
class Cavity:
    """Where water stands in a cup."""

    grid: Grid
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
        """Return how far points (N, 3) are from the axis, (N,) metres."""
        return np.linalg.norm(points[:, :2] - self.axis, axis=1)


def find_cavity(surface: Surface) -> Cavity | None:
    """Return the cavity of a surface; None where it is shallow, narrow, or water runs out below."""
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


def still_holds(surface: Surface, cavity: Cavity) -> bool:
    """Return whether a surface holds a third of the water that the cup held."""
    other = find_cavity(surface)
    return other is not None and other.volume > cavity.volume / 3
