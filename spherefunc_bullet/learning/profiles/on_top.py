"""What stands on a table: parts of its cloud that rise from its level, separated by gaps."""

from __future__ import annotations

import numpy as np

from ...clouds.cloud import Cloud
from ...settling.drops import DropsByRadius
from .columns import columns_of, fullest_level, largest_piece, near_pairs, pieces_of

CELL = 0.02  # metres: the side of the squares in which parts are separated
LEAST = 0.012  # metres above the level: what is no higher is of the level
SCATTERS = 4.0  # standard deviations of a sensor above the level: what is no higher is noise
NEAR = 0.01  # metres from the level: of these points the scatter is read
COMPANY = 4  # points about half a cell apart that one of a surface has near it at least
LARGEST = 0.3  # of the level's area: what is larger is a part of the furniture
SPARED = 0.02  # metres inside the level's outline: what stands along its edge is a rim or a wall


def objects_on_table(cloud: Cloud, drops: DropsByRadius) -> int:
    """Return how many objects stand on the level that carries most of the spheres that settled."""
    radius, centers = max(((radius, one.rests) for radius, one in drops.items()), key=lambda one: len(one[1]))
    if len(centers) < 3:
        return 0
    height, level = fullest_level(columns_of(np.asarray(centers, float), radius))
    piece = largest_piece(level)
    points = cloud.thinned(CELL / 2)
    points = points[piece.outline.inside(points[:, :2]) > SPARED]
    heights = points[:, 2] - (height - radius)
    above = points[heights > max(LEAST, SCATTERS * scatter_of(heights))]
    return count_parts(without_stray(above)[:, :2], LARGEST * piece.outline.area)


def without_stray(points: np.ndarray) -> np.ndarray:
    """Return the points (N, 3) that have others near, as those of a surface do."""
    others = np.bincount(np.concatenate(near_pairs(points, 1.25 * CELL)), minlength=len(points))
    return points[others >= COMPANY]


def scatter_of(heights: np.ndarray) -> float:
    """Return the standard deviation of the heights (N,) of a level's points about it, metres."""
    near = np.abs(heights[np.abs(heights) < NEAR])
    return 1.48 * float(np.median(near)) if len(near) else 0.0


def count_parts(places: np.ndarray, largest: float) -> int:
    """Return in how many parts places (N, 2) fall, of no more than so many square metres each."""
    if not len(places):
        return 0
    cells = np.unique(np.floor(places / CELL), axis=0)
    parts = pieces_of(len(cells), *near_pairs(cells, 1.5))  # side by side or corner to corner
    return int((np.bincount(parts) * CELL**2 <= largest).sum())
