"""Surroundings of a proposal in its scan: what rises behind it, lies above and below it, or continues beyond its edge.

Spheres fall on the proposal as if it stood alone. Only the scene shows whether its level continues beyond the cut, is
free on three sides, carries something, or has a wall behind it or a top above it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..scans.cells import Cells, cells
from ..settings import POOL, RECOGNITION, SCAN
from .directions import SEEN_NEAR, look_around_level, polar, tangents

NAMES = (
    "long", "wide", "high",  # metres, of its box
    "level", "over_level", "level_area", "level_share",  # height over the support; what is above; m2; of its footprint
    "backed", "backed_aside", "closed_below", "hollow_below", "begins",  # by its own points
    "carries", "covered",  # by others' points over it, shares of the level
    "goes_on", "beside", "walled_near", "walled_far", "lower_near", "ground_near", "unseen_near",  # of all directions
    "highest_near", "highest_far",  # metres above the level, of points around it
    "from_wall",  # metres, at most 1
)  # fmt: skip


@dataclass(frozen=True, kw_only=True, eq=False)
class ScanSurroundings:
    """A scene whose parts' surroundings are read."""

    points: np.ndarray  # (N, 3) float64, metres, level frame; floor and walls too
    is_wall: np.ndarray  # (N,) bool

    def of(self, members: np.ndarray, size: np.ndarray, support: float) -> np.ndarray:
        """Return the surroundings of some points of the scene (K, 3), by NAMES (S,).

        Parameters
        ----------
        size : (3,) float64, metres
            Of the box around them.
        support : float
            The height that they stand on, metres.
        """
        voxels = self._voxels[next(side for least, side in RECOGNITION.voxels if size.max() >= least)]
        mine = cells(members, voxels.side)
        level = level_of(mine.means, voxels.side)
        low, high = mine.means.min(axis=0), mine.means.max(axis=0)
        first, last = low - RECOGNITION.far_level - SCAN.cell, high + RECOGNITION.far_level + SCAN.cell
        reached, y_range = voxels.along_x(first[0], last[0]), np.array([first[1], last[1]])
        around = around_level(voxels.means[reached], voxels.keys[reached], mine.keys, level, support, y_range)
        shape = own_shape(mine.means, level, support)
        wall = np.hypot(*(self._walls - level.middle).T).min(initial=np.inf) - level.edge.mean()
        return np.array([
            *size[:2], high[2] - low[2], level.height - support, high[2] - level.height, level.area, level.share,
            *shape, low[2] - support, *around, min(float(wall), 1.0),
        ])  # fmt: skip

    @cached_property
    def _voxels(self) -> dict[float, Cells]:
        return {side: cells(self.points, side) for _, side in RECOGNITION.voxels}

    @cached_property
    def _walls(self) -> np.ndarray:
        return cells(self.points[self.is_wall] * [1, 1, 0], SCAN.cell).means[:, :2]


@dataclass(frozen=True, kw_only=True, eq=False)
class ProposalLevel:
    """The height at which most of a proposal's columns end, and its extent seen from above."""

    height: float  # metres
    middle: np.ndarray  # (2,) metres
    edge: np.ndarray  # (D,) metres from the middle to the edge, in each direction
    area: float  # square metres
    share: float  # of the proposal's columns
    lowest: np.ndarray  # (C,) metres, where each column begins
    square: float  # metres, side of the columns

    def covered(self, points: np.ndarray) -> float:
        """Return the area above or below points (N, 3), as a share of the level's."""
        return len(cells(points * [1, 1, 0], self.square).keys) * self.square**2 / max(self.area, self.square**2)


def level_of(voxels: np.ndarray, side: float) -> ProposalLevel:
    """Return the level of a proposal's voxels (C, 3) of a side in metres."""
    square = RECOGNITION.square * side
    columns = cells(voxels * [1, 1, 0], square)
    tops, lowest = np.full(len(columns.keys), -np.inf), np.full(len(columns.keys), np.inf)
    np.maximum.at(tops, columns.cell_of, voxels[:, 2])
    np.minimum.at(lowest, columns.cell_of, voxels[:, 2])
    tops.sort()
    counts = np.searchsorted(tops, tops + 2 * SCAN.cell, side="right") - np.arange(len(tops))
    best = int(np.argmax(counts))
    height = float(np.median(tops[best : best + counts[best]]))
    slab = voxels[np.abs(voxels[:, 2] - height) <= POOL.slab]
    flat = cells(slab * [1, 1, 0], square).means[:, :2]
    middle = flat.mean(axis=0)
    way, far = polar(flat, middle)
    edge = np.zeros(POOL.directions)
    np.maximum.at(edge, way, far)
    return ProposalLevel(
        height=height,
        middle=middle,
        edge=np.where(edge > 0, edge, far.mean()) + square / 2,
        area=len(flat) * square**2,
        share=len(flat) / len(columns.keys),
        lowest=lowest,
        square=square,
    )


def own_shape(voxels: np.ndarray, level: ProposalLevel, support: float) -> list[float]:
    """Return how a proposal's own voxels (C, 3) rise above its level and close the space below it.

    These are the shares of directions in which they rise, how one-sided these are, the share of directions closed by
    sides, and the share of columns with nothing below.
    """
    way, far = polar(voxels[:, :2], level.middle)
    backs = np.unique(way[voxels[:, 2] > level.height + RECOGNITION.rises])
    angles = backs * (2 * np.pi / POOL.directions)
    aside = float(np.hypot(np.cos(angles).mean(), np.sin(angles).mean())) if len(backs) else 0.0
    rise = level.height - support
    between = (voxels[:, 2] > support + 0.25 * rise) & (voxels[:, 2] < support + 0.7 * rise)
    closed = share_of_directions(way[between & (far > 0.6 * level.edge[way])])
    return [len(backs) / POOL.directions, aside, closed, float(np.mean(level.lowest > support + 0.5 * rise))]


def around_level(
    means: np.ndarray, keys: np.ndarray, own: np.ndarray, level: ProposalLevel, support: float, y_range: np.ndarray
) -> list[float]:
    """Return the quantities of other voxels of the scene above and around a level, from `carries` on.

    See `directions.look_around_level` for the arguments.
    """
    noted, over = np.zeros((7, POOL.directions), bool), np.empty(len(means), np.int64)
    heights = np.empty((2, len(means)))
    limits = RECOGNITION.near_level, RECOGNITION.far_level, RECOGNITION.rises, POOL.slab, SCAN.cell
    where = level.middle, level.edge, level.height, support
    inside, *counts = look_around_level(means, keys, own, y_range, *where, limits, tangents(), noted, over, *heights)
    others = means[over[:inside]]
    above = others[:, 2] - level.height
    highest = [
        percentile(values[:count], 0.95) if count else support - level.height
        for values, count in zip(heights, counts, strict=True)
    ]
    shares = noted.sum(axis=1) / POOL.directions
    return [
        level.covered(others[(above > SCAN.cell) & (above < RECOGNITION.standing_on)]),
        level.covered(others[above > RECOGNITION.rises]),
        *shares[:SEEN_NEAR].tolist(),
        1 - shares[SEEN_NEAR],
        *highest,
    ]


def percentile(values: np.ndarray, share: float) -> float:
    """Return the value (N,) below which a share of all lies, as numpy's does, in a fifth of its time."""
    rank, part = divmod(share * (len(values) - 1), 1)
    low, high = np.sort(values)[[int(rank), min(int(rank) + 1, len(values) - 1)]].tolist()
    return low + (high - low) * part if part < 0.5 else high - (high - low) * (1 - part)


def share_of_directions(ways: np.ndarray) -> float:
    """Return the share of all directions that occur among some (N,)."""
    return np.count_nonzero(np.bincount(ways, minlength=POOL.directions)) / POOL.directions


def surroundings_alone(points: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return the surroundings, by NAMES, of an object's points (N, 3) in a box of a size (3,) that stands alone."""
    return ScanSurroundings(points=points, is_wall=np.zeros(len(points), bool)).of(points, size, 0.0)
