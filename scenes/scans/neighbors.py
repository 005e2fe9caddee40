"""Which points are near others, found in grids of cells; results do not depend on the order of the points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from spherefunc_bullet.processes.compilation import njit

from .cells import STEP, cells

NEIGHBORS = 6  # of a point within a surface
_NEAREST_FIRST = (4, 1, 3, 5, 7, 0, 2, 6, 8)  # columns of cells around one; the first few are enough for most points


def crowded(places: np.ndarray, reach: float) -> np.ndarray:
    """Return which places (N, 3) have at least `NEIGHBORS` others within a reach in metres, (N,) bool."""
    grid = cells(places, reach)
    enough = np.zeros(len(places), np.bool_)
    count_around(np.ascontiguousarray(places[grid.order]), grid.keys, grid.start, reach * reach, enough)
    out = np.empty(len(places), bool)
    out[grid.order] = enough
    return out


@njit(cache=True, error_model="numpy")
def count_around(points, keys, start, square, enough):
    """Mark the points that have enough others within a reach.

    Parameters
    ----------
    points : (N, 3) float64, metres
        Sorted by the cell of a grid as wide as the reach.
    keys : (C,) int64
        Of the cells, ascending, as `cells` packs them.
    start : (C + 1,) int64
        The first point of each cell, and the number of all.
    square : float
        Of the reach, square metres.
    enough : (N,) bool
        Receives them.
    """
    columns = np.zeros((9, 2), np.int64)
    for cell in range(len(keys)):
        advance(columns, keys[cell], keys)
        for i in range(start[cell], start[cell + 1]):
            count = -1  # itself
            for column in _NEAREST_FIRST:
                for j in range(start[columns[column, 0]], start[columns[column, 1]]):
                    x, y, z = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1], points[i, 2] - points[j, 2]
                    count += x * x + y * y + z * z <= square
                if count >= NEIGHBORS:
                    break
            enough[i] = count >= NEIGHBORS


def nearest_others(places: np.ndarray, asked: np.ndarray, reach: float) -> np.ndarray:
    """Return the nearest `NEIGHBORS` of places (N, 3) around some of them (A,), (A, NEIGHBORS) int64.

    N stands where there are fewer nearer than the reach in metres.
    """
    grid, count = cells(places, reach), len(places)
    rows, nearest = np.full(count, -1), np.full((len(asked), NEIGHBORS), count)
    rows[asked] = np.arange(len(asked))
    sorted_places = np.ascontiguousarray(places[grid.order])
    list_nearest(sorted_places, rows[grid.order], grid.keys, grid.start, reach, nearest)
    return np.append(grid.order, count)[nearest]


@njit(cache=True, error_model="numpy")
def list_nearest(points, rows, keys, start, reach, nearest):
    """Write the nearest others of some points.

    Parameters
    ----------
    points : (N, 3) float64, metres
        Sorted by the cell of a grid as wide as the reach.
    rows : (N,) int64
        In which row the neighbours of each point are written, or -1.
    keys : (C,) int64
        Of the cells, ascending, as `cells` packs them.
    start : (C + 1,) int64
        The first point of each cell, and the number of all.
    reach : float
        Metres.
    nearest : (A, K) int64, N
        Receives them, in the order of their distance.
    """
    columns, squares = np.zeros((9, 2), np.int64), np.empty(nearest.shape[1])
    last = len(squares) - 1
    for cell in range(len(keys)):
        advance(columns, keys[cell], keys)
        for i in range(start[cell], start[cell + 1]):
            if rows[i] < 0:
                continue
            squares[:] = reach * reach
            for column in _NEAREST_FIRST:
                across = gap_to_column(points[i, 0], column // 3 - 1, reach)
                along = gap_to_column(points[i, 1], column % 3 - 1, reach)
                if across * across + along * along >= squares[last]:
                    continue
                for j in range(start[columns[column, 0]], start[columns[column, 1]]):
                    x, y, z = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1], points[i, 2] - points[j, 2]
                    distance = x * x + y * y + z * z
                    if distance >= squares[last] or i == j:
                        continue
                    k = last
                    while k > 0 and squares[k - 1] > distance:
                        squares[k], nearest[rows[i], k] = squares[k - 1], nearest[rows[i], k - 1]
                        k -= 1
                    squares[k], nearest[rows[i], k] = distance, j


@njit(cache=True, error_model="numpy")
def gap_to_column(place, step, side):
    """Return at least how far a place is, along one axis, from the cell a step of -1, 0 or 1 beside its own, metres."""
    inside = place - np.floor(place / side) * side
    return max(0.0, (inside if step < 0 else side - inside) - STEP) if step != 0 else 0.0


@dataclass(frozen=True, eq=False)
class NearPoints:
    """Points (N, 3), metres, sorted once, to find which other points are near them."""

    points: np.ndarray
    reach: float  # metres

    @cached_property
    def _sorted(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        grid = cells(self.points, self.reach)
        return np.ascontiguousarray(self.points[grid.order]), grid.keys, grid.start

    def to(self, places: np.ndarray) -> np.ndarray:
        """Return which places (M, 3) have one of the points nearer than the reach, (M,) bool."""
        grid, near, out = cells(places, self.reach), np.zeros(len(places), np.bool_), np.empty(len(places), bool)
        look_around(places[grid.order], grid.keys, grid.start, *self._sorted, self.reach * self.reach, near)
        out[grid.order] = near
        return out


@njit(cache=True, error_model="numpy")
def advance(columns, key, keys):
    """Move the first and the end cell of each column around the cell of a key forward; keys have to ascend.

    Parameters
    ----------
    columns : (9, 2) int64
        First and end cells, 0 before the first key.
    keys : (C,) int64
        Of the cells, ascending, as `cells` packs them.
    """
    for column in range(9):  # the three cells along z follow one another
        middle = key + ((column // 3 - 1) << 42) + ((column % 3 - 1) << 21)
        for end, bound in enumerate((middle - 1, middle + 2)):
            while columns[column, end] < len(keys) and keys[columns[column, end]] < bound:
                columns[column, end] += 1


@njit(cache=True, error_model="numpy")
def look_around(places, own_keys, own_start, points, keys, start, square, near):
    """Mark the places that have a point within a reach.

    Parameters
    ----------
    places, points : (N, 3) and (M, 3) float64, metres
        Each sorted by the cell of a grid as wide as the reach.
    own_keys, keys : (C,) and (D,) int64
        Of the cells of both, ascending, as `cells` packs them.
    own_start, start : (C + 1,) and (D + 1,) int64
        The first point of each cell, and the number of all.
    square : float
        Of the reach, square metres.
    near : (N,) bool, False
        Receives them.
    """
    columns = np.zeros((9, 2), np.int64)
    for cell in range(len(own_keys)):
        advance(columns, own_keys[cell], keys)
        for i in range(own_start[cell], own_start[cell + 1]):
            for column in _NEAREST_FIRST:
                for j in range(start[columns[column, 0]], start[columns[column, 1]]):
                    x, y, z = places[i, 0] - points[j, 0], places[i, 1] - points[j, 1], places[i, 2] - points[j, 2]
                    if x * x + y * y + z * z < square:
                        near[i] = True
                        break
                if near[i]:
                    break
