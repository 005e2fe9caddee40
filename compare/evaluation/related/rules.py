"""Rules on height, area and flatness, after Stark and Bowyer's generic recognition through function.

L. Stark and K. Bowyer, "Achieving generalized object recognition through reasoning about association of function to
structure", PAMI 13(10), 1991 (the paper's [3]): a chair is whatever provides a sittable surface, found by primitives
such as dimensions, orientation, proximity to the ground and clearance, each with a range. M. Sutton, L. Stark and K.
Bowyer, "GRUFF-3: generalizing the domain of a function-based recognition system", Pattern Recognition 27(12), 1994,
adds dishes and the primitive of enclosure.

Their systems reason about the faces of solid models and grade each range between 0 and 1. Here the object is seen from
above, so clearance is guaranteed: nothing is above a visible surface. A range is met or not. The ranges are those of
people and of furniture as it is sold; they were set before any model was looked at, and nothing is fitted to labels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from spherefunc_bullet.scenes.impairment.levels import standing_water
from spherefunc_bullet.settling.records import VOXEL, ObjectRecord

NOTHING = -np.inf  # height where the object has no point


@dataclass(frozen=True, kw_only=True, eq=False)
class TopView:
    """The largest height over each square cell of the ground."""

    heights: np.ndarray  # (X, Y) float, metres above the ground; NOTHING off the object
    cell: float  # metres

    def cells(self, length: float) -> int:
        """Return the number of cells along a length in metres, at least one."""
        return max(1, round(length / self.cell))

    def quarter_turned(self) -> TopView:
        """Return the view after a quarter turn of the object."""
        return TopView(heights=np.rot90(self.heights), cell=self.cell)

    def turned(self, degrees: float, cell: float, margin: float = 0.0) -> TopView:
        """Return the view after a turn about the vertical, in cells as large as these or larger.

        Parameters
        ----------
        cell : float
            Side of a square, metres.
        margin : float
            Free ground that is added on all sides, metres.
        """
        cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        turn = np.array([[cosine, sine], [-sine, cosine]])
        corners = np.array([(x, y) for x in (0, self.heights.shape[0]) for y in (0, self.heights.shape[1])]) @ turn
        low, high = corners.min(axis=0) * self.cell - margin, corners.max(axis=0) * self.cell + margin
        seen = self.heights > NOTHING
        places = ((np.argwhere(seen) + 0.5) @ turn) * self.cell
        heights = np.full(np.ceil((high - low) / cell).astype(int) + 1, NOTHING)
        np.maximum.at(heights, tuple(np.floor((places - low) / cell).astype(int).T), self.heights[seen])
        return TopView(heights=heights, cell=cell)


def top_view(record: ObjectRecord, below: float = np.inf) -> TopView:
    """Return an object's top view in cells of a voxel, a cell of free ground around it.

    Parameters
    ----------
    below : float
        Only parts that are lower are seen, metres.
    """
    voxels = record.voxels
    squares = voxels[:, :2].astype(int) - voxels[:, :2].min(axis=0) + 1
    heights = np.full(squares.max(axis=0) + 2, NOTHING)
    middles = (voxels[:, 2] + 0.5) * VOXEL
    lower = middles < below
    np.maximum.at(heights, tuple(squares[lower].T), middles[lower])
    return TopView(heights=heights, cell=VOXEL)


SQUARE = 0.01  # metres, a cell of the top view of furniture
STEP = 0.01  # metres between the heights at which a level surface is sought


@dataclass(frozen=True, kw_only=True)
class SurfaceRule:
    """A level surface with nothing over it."""

    lowest: float  # metres above the ground
    highest: float  # metres above the ground
    uneven: float  # metres between its highest and its lowest point
    disc: float  # metres, diameter of a disc that fits on it
    area: float  # square metres, in one piece


# Seats: 35 to 55 cm, from a low sofa to an office chair raised to its end (EN 1335: 40 to 51 cm). A person needs a
# disc of 30 cm, the size of a plain stool. Cushions are up to 5 cm hollow.
SITTABLE = SurfaceRule(lowest=0.35, highest=0.55, uneven=0.05, disc=0.30, area=0.07)
# Tables: 60 to 80 cm, from a side table to a desk (EN 527: 65 to 85 cm raised; dining tables 72 to 78 cm). One place
# setting takes 60 x 40 cm, so a disc of 40 cm and 0.24 m2. Objects stay on a surface that is level to 2 cm.
TABLE = SurfaceRule(lowest=0.60, highest=0.80, uneven=0.02, disc=0.40, area=0.24)
# Cups: an espresso's 50 ml to a litre of beer; up to a wine glass's 25 cm; a hand spans 12 cm. Shallower than 3 cm, or
# than half of its width, it is a plate or a bowl.
TALLEST, GRIP = 0.25, 0.12  # metres, of the object, and its narrower width
SMALLEST, LARGEST = 50e-6, 1e-3  # cubic metres of water
DEEPEST, PROPORTION = 0.03, 0.5  # metres of water, and depth over width, at least


def functions_by_rules(record: ObjectRecord) -> frozenset[str]:
    """Return which of the functions cup, sittable and table an object has by the rules."""
    view = top_view(record)
    coarse = view.turned(0.0, SQUARE, margin=SQUARE)
    met = {
        "cup": holds_water(view, record.size),
        "sittable": has_surface(coarse, SITTABLE),
        "table": has_surface(coarse, TABLE),
    }
    return frozenset(function for function, yes in met.items() if yes)


def has_surface(view: TopView, rule: SurfaceRule) -> bool:
    """Return whether an object has a surface between two heights that is as level and as large as a rule requires."""
    for lowest in np.arange(rule.lowest, rule.highest - rule.uneven / 2, STEP):
        level = (view.heights >= lowest) & (view.heights <= min(lowest + rule.uneven, rule.highest))
        if level.sum() * view.cell**2 < rule.area:
            continue
        pieces, count = ndimage.label(level)
        areas = np.bincount(pieces.ravel(), minlength=count + 1) * view.cell**2
        # The distance to the middle of the nearest cell outside, whose edge is half a cell nearer.
        within = ndimage.distance_transform_edt(level) - 0.5
        if ((within * view.cell >= rule.disc / 2 - view.cell / 2) & (areas[pieces] >= rule.area)).any():
            return True
    return False


def holds_water(view: TopView, size: np.ndarray) -> bool:
    """Return whether an object of a size (3,), metres, has a hollow for water, and a hand can grasp it."""
    if size[2] > TALLEST or size[:2].min() > GRIP:
        return False
    depths = water_depths(view)
    pools, count = ndimage.label(depths > 0)
    for pool in range(1, count + 1):
        inside = depths[pools == pool]
        volume, depth = inside.sum() * view.cell**2, inside.max()
        width = 2 * np.sqrt(inside.size * view.cell**2 / np.pi)
        if SMALLEST <= volume <= LARGEST and depth >= max(DEEPEST, PROPORTION * width):
            return True
    return False


def water_depths(view: TopView) -> np.ndarray:
    """Return the depth of water over each cell (X, Y), metres, when all hollows of an object are full.

    Water stands at a height where the surface encloses it, unless it meets a place without a floor. Gaps narrower than
    three cells are taken for gaps between points.
    """
    surface = closed(view.heights)
    depths = np.zeros_like(surface)
    for height in np.arange(VOXEL / 2, max(surface.max(), VOXEL), VOXEL):
        depths[standing_water(surface, height)] += VOXEL
    return depths


def closed(heights: np.ndarray) -> np.ndarray:
    """Return heights (X, Y) with gaps narrower than three cells filled, as low as what is around them."""
    floor = heights > NOTHING
    gaps = ndimage.binary_closing(floor, np.ones((3, 3))) & ~floor
    around = ndimage.minimum_filter(np.where(floor, heights, np.inf), 3)
    return np.where(gaps, around, heights)
