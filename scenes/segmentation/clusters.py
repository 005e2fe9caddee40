"""Euclidean clusters: points that a chain of neighbours within a tolerance connects (PCL, paper §IV-C)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.clouds.outline import hull_corners
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


def members_of(labels: np.ndarray, least: int = 0) -> list[np.ndarray]:
    """Return the indices of the points (N,) that carry each label from 0 on, ascending, for at least some labels."""
    bounds = np.append(0, np.cumsum(np.bincount(labels[labels >= 0], minlength=least)))
    order = np.empty(bounds[-1], np.int64)
    sort_by_label(labels, bounds[:-1].copy(), order)
    return [order[first:last] for first, last in zip(bounds[:-1], bounds[1:], strict=True)]


@njit(cache=True, error_model="numpy")
def sort_by_label(labels, place, order):
    """Write the indices of the points (N,) label by label, from the place (L,) of each label on, which advances."""
    for i in range(len(labels)):
        if labels[i] >= 0:
            order[place[labels[i]]] = i
            place[labels[i]] += 1


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
    united = np.zeros(len(keys), np.bool_)  # whether the points of each cell are in one cluster
    for cell in range(len(keys)):
        united[cell] = connect_cells(points, reach, start, cell, cell, roots, False)
    for cell in range(len(keys)):
        for dx in range(0, 2):
            for dy in range(-1, 2):
                key = keys[cell] + (dx << 42) + (dy << 21)
                while first[dx, dy + 1] < len(keys) and keys[first[dx, dy + 1]] < key - 1:
                    first[dx, dy + 1] += 1
                # The three cells along z follow one another.
                other = first[dx, dy + 1]
                while other < len(keys) and keys[other] <= key + 1:
                    if other > cell:
                        connect_cells(points, reach, start, cell, other, roots, united[cell] and united[other])
                    other += 1
    for i in range(len(points)):
        roots[i] = root_of(roots, i)


@njit(cache=True, error_model="numpy")
def connect_cells(points, reach, start, a, b, roots, united):
    """Unite neighbours of two cells, which may be the same; return whether all points of the first are in one cluster.

    One pair of neighbours is enough if the points of each cell are ``united``.
    """
    whole, own = True, root_of(roots, start[a])
    if united and own == root_of(roots, start[b]):
        return whole
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
                if united:
                    return whole
    own = root_of(roots, start[a])
    for i in range(start[a], start[a + 1]):
        whole = whole and root_of(roots, i) == own
    return whole


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
    x, y, width, depth, angle = least_rectangle(hull_corners(points[:, :2]))
    bottom, top = points[:, 2].min(), points[:, 2].max()
    return Box(center=np.array([x, y, (bottom + top) / 2]), size=np.array([width, depth, top - bottom]), yaw=angle)


@njit(cache=True, error_model="numpy")
def least_rectangle(outline):
    """Return the rectangle of least area around a convex outline (K, 2), metres: middle, longer side, other side, yaw.

    Areas are compared, and angles taken, to nine digits, so that the last digits of the points decide nothing.
    """
    least, best = np.inf, (outline[0, 0], outline[0, 1], 0.0, 0.0, 0.0)
    for i in range(len(outline)):
        j = (i + 1) % len(outline)
        angle = math.atan2(outline[j, 1] - outline[i, 1], outline[j, 0] - outline[i, 0]) % (math.pi / 2)
        angle = round(angle, 9)
        cosine, sine = math.cos(angle), math.sin(angle)
        low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
        for k in range(len(outline)):
            x, y = outline[k, 0] * cosine + outline[k, 1] * sine, outline[k, 1] * cosine - outline[k, 0] * sine
            low_x, high_x, low_y, high_y = min(low_x, x), max(high_x, x), min(low_y, y), max(high_y, y)
        width, depth = high_x - low_x, high_y - low_y
        area = round(width * depth, 9)
        if area < least or (area == least and angle < best[4]):
            x, y = (low_x + high_x) / 2, (low_y + high_y) / 2
            least, best = area, (x * cosine - y * sine, x * sine + y * cosine, width, depth, angle)
    x, y, width, depth, angle = best
    if depth > width:
        width, depth, angle = depth, width, angle - math.pi / 2 if angle > 0 else angle + math.pi / 2
    return x, y, width, depth, angle
