"""Euclidean clusters: points that a chain of neighbours within a tolerance connects (PCL, paper §IV-C)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.clouds.outline import well_within
from spherefunc_bullet.processes.compilation import njit

from ..scans.cells import cells


def euclidean_clusters(points: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the cluster (N,) int64 of each point, numbered from 0 in the order of their first points.

    Parameters
    ----------
    points : (N, 3) float64, metres
    tolerance : float
        Largest distance between neighbours, metres.
    """
    if not len(points):
        return np.empty(0, np.int64)
    grid, roots = cells(points, tolerance), np.arange(len(points))
    connect(np.ascontiguousarray(points[grid.order]), tolerance, grid.keys, grid.start, roots)
    cluster_of = np.empty(len(points), np.int64)
    cluster_of[grid.order] = roots
    return renumbered(cluster_of)


def members_of(labels: np.ndarray) -> list[np.ndarray]:
    """Return the indices of the points (N,) that carry each label from 0 on, ascending."""
    order = np.argsort(labels, kind="stable")
    bounds = np.searchsorted(labels[order], np.arange(labels.max(initial=-1) + 2))
    return [order[first:last] for first, last in zip(bounds[:-1], bounds[1:], strict=True)]


def renumbered(cluster_of: np.ndarray) -> np.ndarray:
    """Return clusters (N,) int64, each below N, numbered from 0 in the order of their first points."""
    places, first = np.arange(len(cluster_of)), np.empty(len(cluster_of), np.int64)
    first[cluster_of[::-1]] = places[::-1]  # of several values for one place the last one stays
    first_of = first[cluster_of]
    return (np.cumsum(first_of == places) - 1)[first_of]


@njit(cache=True, error_model="numpy")
def connect(points, reach, keys, start, roots):
    """Give all points of a cluster one root.

    Parameters
    ----------
    points : (N, 3) float64, metres
        Sorted by the cell of a grid as wide as the reach.
    reach : float, metres
        Of neighbours.
    keys : (C,) int64
        Of the cells, ascending, as `cells` packs them.
    start : (C + 1,) int64
        The first point of each cell, and the number of all.
    roots : (N,) int64
        The index of each point, or a smaller one in its cluster; receives the smallest.
    """
    first = np.zeros((2, 3), np.int64)  # cell of each column that may be beside: keys ascend, so these only advance
    for cell in range(len(keys)):
        for dx in range(0, 2):
            for dy in range(-1, 2):
                key = keys[cell] + (dx << 42) + (dy << 21)
                while first[dx, dy + 1] < len(keys) and keys[first[dx, dy + 1]] < key - 1:
                    first[dx, dy + 1] += 1
                # The three cells along z follow one another.
                other = first[dx, dy + 1]
                while other < len(keys) and keys[other] <= key + 1:
                    if other >= cell:
                        connect_cells(points, reach, start, cell, other, roots)
                    other += 1
    for i in range(len(points)):
        roots[i] = root_of(roots, i)


@njit(cache=True, error_model="numpy")
def connect_cells(points, reach, start, a, b, roots):
    """Unite neighbours of two cells, which may be the same."""
    for i in range(start[a], start[a + 1]):
        one = root_of(roots, i)
        for j in range(max(start[b], i + 1), start[b + 1]):
            if roots[j] == one:  # most neighbours are united already
                continue
            dx, dy, dz = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1], points[i, 2] - points[j, 2]
            if dx * dx + dy * dy + dz * dz <= reach * reach:
                other = root_of(roots, j)
                roots[max(one, other)] = min(one, other)
                one = min(one, other)


@njit(cache=True, error_model="numpy")
def root_of(roots, i):
    """Return the root of a point, and shorten the path to it."""
    while roots[i] != i:
        roots[i] = roots[roots[i]]
        i = roots[i]
    return i


@dataclass(frozen=True, kw_only=True, eq=False)
class Box:
    """A box in the level frame: two faces level, four upright."""

    center: np.ndarray  # (3,) float64, metres
    size: np.ndarray  # (3,) float64, along its own x (the longer level side), y and z, metres
    yaw: float  # of its x from the frame's, counterclockwise seen from above, radians, -pi/2 to pi/2

    @property
    def axes(self) -> np.ndarray:
        """Its own unit vectors as rows, (3, 3)."""
        cosine, sine = np.cos(self.yaw), np.sin(self.yaw)
        return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])

    @property
    def corners(self) -> np.ndarray:
        """The corners (8, 3), the lower four first, each four around, metres."""
        signs = np.array([[x, y, z] for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        return self.center + signs * self.size / 2 @ self.axes

    def lowered(self, height: float) -> Box:
        """Return the box with its lower face at a height, metres, or unchanged if that is lower already."""
        top = self.center[2] + self.size[2] / 2
        bottom = min(self.center[2] - self.size[2] / 2, height)
        center, size = self.center.copy(), self.size.copy()
        center[2], size[2] = (top + bottom) / 2, top - bottom
        return Box(center=center, size=size, yaw=self.yaw)

    def to_own(self, points: np.ndarray) -> np.ndarray:
        """Return points (N, 3) of the level frame along the box's axes from its centre."""
        return (points - self.center) @ self.axes.T


def bounding_box(points: np.ndarray) -> Box:
    """Return the upright box of least footprint around points (N, 3) of the level frame, metres.

    One of its sides runs along an edge of the convex hull, as that of least area always does.
    """
    from scipy.spatial import ConvexHull, QhullError

    places = points[:, :2]
    places = places[~well_within(places)]
    try:
        outline = places[ConvexHull(places).vertices]
    except (QhullError, ValueError):  # in a line
        outline = places
    edges = np.roll(outline, -1, axis=0) - outline if len(outline) > 2 else np.eye(2)
    angles = np.unique(np.round(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2), 9))
    along = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    spans = [outline @ axes.T for axes in (along, across)]
    lows, highs = np.array([span.min(axis=0) for span in spans]), np.array([span.max(axis=0) for span in spans])
    best = int(np.argmin(np.round((highs - lows).prod(axis=0), 9)))
    low, high = lows[:, best], highs[:, best]
    middle, angle = (low + high) / 2, angles[best]
    bottom, top = points[:, 2].min(), points[:, 2].max()
    width, depth = high - low
    if depth > width:
        width, depth, angle = depth, width, angle - np.pi / 2 if angle > 0 else angle + np.pi / 2
    return Box(
        center=np.array([*(middle[0] * along[best] + middle[1] * across[best]), (bottom + top) / 2]),
        size=np.array([width, depth, top - bottom]),
        yaw=float(angle),
    )
