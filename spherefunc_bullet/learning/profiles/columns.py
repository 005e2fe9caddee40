"""Columns of settled spheres, independent of the heading and the place of the object.

There is no grid. A column is all spheres above and below one sphere, and lengths across the ground are those of a
convex outline, so that turning or moving the object changes no more than the last digits. Objects on a table are parts
of its cloud that rise from its level, separated by gaps.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...clouds.cloud import Cloud
from ...settling.drops import DropsByRadius

_MANY = 60  # points; with fewer, it is not worth finding those within the others
_INSIDE = 1e-6  # square metres between a side and a point well inside; rounding errors are smaller
OVERLAP = 1.5  # radii: spheres whose axes are nearer are above one another; side by side they are two radii apart


@dataclass(frozen=True, kw_only=True, eq=False)
class Outline:
    """The convex outline of spheres on the ground, including their own width."""

    corners: np.ndarray  # (H, 2) float, counterclockwise, metres, of the centres
    radius: float  # of the spheres, metres

    @cached_property
    def area(self) -> float:
        """The area within the outline, square metres."""
        perimeter = float(np.hypot(*edges_of(self.corners).T).sum())
        return enclosed_area(self.corners) + perimeter * self.radius + np.pi * self.radius**2

    @cached_property
    def width(self) -> float:
        """The smallest distance between two parallel lines with all spheres between them, metres."""
        return float(self.depths(self.corners).max(axis=1).min()) + 2 * self.radius

    def inside(self, points: np.ndarray) -> np.ndarray:
        """Return how far points (N, 2) are inside the outline of the centres (N,), metres; negative outside."""
        if len(self.corners) < 3:
            return np.full(len(points), -np.inf)
        return self.depths(points).min(axis=0)

    def depths(self, points: np.ndarray) -> np.ndarray:
        """Return how far points (N, 2) are inside each side of the outline (H, N), metres."""
        if len(self.corners) < 2:
            return np.zeros((len(self.corners), len(points)))
        edges = edges_of(self.corners)
        inward = np.column_stack([-edges[:, 1], edges[:, 0]]) / np.hypot(*edges.T)[:, None]
        return np.einsum("hnk,hk->hn", points[None] - self.corners[:, None], inward)


def outline_of(points: np.ndarray, radius: float) -> Outline:
    """Return the convex outline of at least one centre (N, 2), metres."""
    outer = points if len(points) < _MANY else points[~well_within(points)]
    ordered = outer[np.lexsort((outer[:, 1], outer[:, 0]))]
    ordered = ordered[np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1))]
    if len(ordered) > 1:
        back = ordered[::-1]
        ordered = np.concatenate([ordered[half_hull(ordered)[:-1]], back[half_hull(back)[:-1]]])
    return Outline(corners=ordered, radius=radius)


def well_within(points: np.ndarray) -> np.ndarray:
    """Return which points (N, 2) lie inside the octagon of the extreme ones, (N,) bool (Akl and Toussaint, 1978)."""
    x, y = np.ascontiguousarray(points.T)
    turning = (x, x + y, y, y - x)  # four of the eight directions; the others are their opposites
    ends = [int(np.argmax(way)) for way in turning] + [int(np.argmin(way)) for way in turning]
    within = np.ones(len(points), bool)
    for a, b in zip(ends, [*ends[1:], ends[0]], strict=True):
        if a != b:
            within &= (y - y[a]) * (x[b] - x[a]) - (x - x[a]) * (y[b] - y[a]) > _INSIDE
    within[ends] = False  # also where all are one point
    return within


def half_hull(ordered: np.ndarray) -> list[int]:
    """Return the indices of the points on one half of the convex hull of ordered points (N, 2) (Andrew, 1979).

    In plain Python: for a few hundred points that takes less time than loading a compiled kernel.
    """
    x, y = ordered.T.tolist()
    chain: list[int] = []
    for i in range(len(x)):
        while len(chain) > 1:
            a, b = chain[-2:]
            if (x[b] - x[a]) * (y[i] - y[a]) - (y[b] - y[a]) * (x[i] - x[a]) > 0:
                break
            chain.pop()
        chain.append(i)
    return chain


def edges_of(corners: np.ndarray) -> np.ndarray:
    """Return the edges (H, 2) of a polygon, each from a corner to the next, metres."""
    return np.concatenate([corners[1:], corners[:1]]) - corners


def enclosed_area(corners: np.ndarray) -> float:
    """Return the area of a polygon (H, 2), square metres."""
    x, y = (corners - corners[0]).T
    next_x, next_y = np.append(x[1:], x[0]), np.append(y[1:], y[0])
    return 0.5 * abs(float(np.sum(x * next_y - y * next_x)))


@dataclass(frozen=True, kw_only=True, eq=False)
class SphereColumns:
    """Spheres, and the column in which each of them is."""

    centers: np.ndarray  # (S, 3) float, metres
    radius: float  # metres
    weights: np.ndarray  # (S,) float, share of its column that each sphere is; they sum to the number of columns
    tops: np.ndarray  # (S,) float, height of the centre of the highest sphere in the column, metres
    bottoms: np.ndarray  # (S,) float, height of the centre of the lowest sphere, metres

    def __len__(self) -> int:
        return len(self.centers)

    @property
    def depths(self) -> np.ndarray:
        """The depth of spheres in each column (S,), metres; one diameter for one layer."""
        return self.tops - self.bottoms + 2 * self.radius

    def kept(self, which: np.ndarray) -> SphereColumns:
        """Return the columns of some spheres (S,) bool; the same object for all of them, as its outline is cached."""
        if which.all():
            return self
        arrays = {name: getattr(self, name)[which] for name in ("centers", "weights", "tops", "bottoms")}
        return SphereColumns(**arrays, radius=self.radius)

    def mean(self, values: np.ndarray) -> float:
        """Return the mean of values (S,) over columns."""
        return float((values * self.weights).sum() / self.weights.sum())  # np.average without its checks

    def spread(self, values: np.ndarray) -> float:
        """Return the standard deviation of values (S,) over columns."""
        return float(np.sqrt(max(self.mean(values**2) - self.mean(values) ** 2, 0.0)))

    def quantiles(self, values: np.ndarray, shares: tuple[float, ...]) -> list[float]:
        """Return the quantiles of values (S,) over columns, at these shares."""
        order = np.argsort(values, kind="stable")
        below = np.cumsum(self.weights[order])
        at = np.searchsorted(below, np.array(shares) * below[-1] * (1 - 1e-9))
        return values[order][at].tolist()

    @cached_property
    def outline(self) -> Outline:
        """The convex outline of the spheres on the ground."""
        return outline_of(self.centers[:, :2], self.radius)


def columns_of(centers: np.ndarray, radius: float) -> SphereColumns:
    """Return the columns of at least one settled sphere (S, 3), metres."""
    z = centers[:, 2]
    tops, bottoms, neighbours = z.copy(), z.copy(), np.ones(len(z))
    first, second = near_pairs(centers[:, :2], OVERLAP * radius)
    for here, there in ((first, second), (second, first)):
        np.maximum.at(tops, here, z[there])
        np.minimum.at(bottoms, here, z[there])
        np.add.at(neighbours, here, 1)
    return SphereColumns(centers=centers, radius=radius, weights=1 / neighbours, tops=tops, bottoms=bottoms)


def near_pairs(points: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of all pairs of points (N, D) within a distance, metres.

    Only pairs whose first coordinates are that near are compared, which are few for the hundreds of spheres on an
    object.
    """
    order = np.argsort(points[:, 0], kind="stable")
    along = points[order, 0]
    reached = np.searchsorted(along, along + distance * (1 + 1e-9), "right")
    counts = reached - np.arange(len(order)) - 1
    first = np.repeat(np.arange(len(order)), counts)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    first, second = order[first], order[second]
    squares = sum((points[first, axis] - points[second, axis]) ** 2 for axis in range(points.shape[1]))
    near = squares <= distance * distance
    return first[near], second[near]


def pieces_of(count: int, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the number (N,), from 0, of the connected component of each of ``count`` items, given linked pairs.

    Each item takes the lowest number that it is linked to until nothing changes.
    """
    lowest = np.arange(count)
    while True:
        linked = lowest.copy()
        np.minimum.at(linked, first, lowest[second])
        np.minimum.at(linked, second, lowest[first])
        linked = linked[linked]
        if np.array_equal(linked, lowest):
            return np.unique(lowest, return_inverse=True)[1]
        lowest = linked


def fullest_level(columns: SphereColumns) -> tuple[float, SphereColumns]:
    """Return the height at which most columns begin, within one radius, and these columns."""
    order = np.argsort(columns.bottoms, kind="stable")
    heights, total = columns.bottoms[order], np.concatenate([[0], np.cumsum(columns.weights[order])])
    low = np.searchsorted(heights, heights - columns.radius * (1 + 1e-9))
    high = np.searchsorted(heights, heights + columns.radius * (1 + 1e-9))
    carried = np.round(total[high] - total[low], 9)  # the order of equal heights decides the last digits
    best = heights[np.flatnonzero(carried == carried.max())[-1]]
    level = columns.kept(np.abs(columns.bottoms - best) <= columns.radius * (1 + 1e-9))
    return level.mean(level.bottoms), level


def largest_piece(level: SphereColumns) -> SphereColumns:
    """Return the columns of the largest connected piece of a level.

    Few spheres on a large plate do not touch, so spheres are linked up to twice their mean spacing.
    """
    spacing = np.sqrt(level.outline.area / len(level))
    links = near_pairs(level.centers[:, :2], 2 * max(spacing, 1.5 * level.radius))
    pieces = pieces_of(len(level), *links)
    carried = np.round(np.bincount(pieces, level.weights), 9)
    equal = np.flatnonzero(carried == carried.max())
    # Of equal pieces the one with the largest area, whatever their order.
    return max((level.kept(pieces == piece) for piece in equal), key=lambda piece: piece.outline.area)


CELL = 0.02  # metres, side of the squares in which parts are separated
LEAST = 0.012  # metres above the level; points below belong to the level
SCATTERS = 4.0  # standard deviations of the sensor above the level; points below are noise
NEAR = 0.01  # metres from the level, within which the scatter of points is measured
COMPANY = 4  # least number of neighbours, about half a cell apart, of a point on a surface
LARGEST = 0.3  # share of the level's area; larger parts belong to the furniture
SPARED = 0.02  # metres inside the level's outline; objects nearer to it are a rim or a wall


def objects_on_table(cloud: Cloud, drops: DropsByRadius) -> int:
    """Return how many objects stand on the level that carries most of the spheres that settled."""
    radius = max(drops, key=lambda radius: len(drops[radius].rests))
    centers = drops[radius].rests
    if len(centers) < 3:
        return 0
    height, level = fullest_level(columns_of(np.asarray(centers, float), radius))
    piece = largest_piece(level)
    points = cloud.thinned(CELL / 2)
    points = points[piece.outline.inside(points[:, :2]) > SPARED]
    heights = points[:, 2] - (height - radius)
    above = points[heights > max(LEAST, SCATTERS * scatter_of(heights))]
    neighbours = np.bincount(np.concatenate(near_pairs(above, 1.25 * CELL)), minlength=len(above))
    return count_parts(above[neighbours >= COMPANY, :2], LARGEST * piece.outline.area)


def scatter_of(heights: np.ndarray) -> float:
    """Return the standard deviation of the heights (N,) of a level's points about it, metres."""
    near = np.abs(heights[np.abs(heights) < NEAR])
    return 1.48 * float(np.median(near)) if len(near) else 0.0


def count_parts(places: np.ndarray, largest: float) -> int:
    """Return the number of connected parts of places (N, 2) that are no larger than this, square metres."""
    if not len(places):
        return 0
    cells = np.unique(np.floor(places / CELL), axis=0)
    parts = pieces_of(len(cells), *near_pairs(cells, 1.5))  # side by side or corner to corner
    return int((np.bincount(parts) * CELL**2 <= largest).sum())
