"""Which points have others nearby, found by the cells of a grid as wide as the reach."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from spherefunc_bullet.processes.compilation import njit

from .cells import cells

NEIGHBORS = 6  # of a point within a surface
_NEAREST_FIRST = (4, 1, 3, 5, 7, 0, 2, 6, 8)  # columns of cells around one: most points have enough in the first few


def crowded(places: np.ndarray, reach: float) -> np.ndarray:
    """Return which places (N, 3) have as many others within a reach in metres as a point has neighbours, (N,) bool."""
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


@dataclass(frozen=True, eq=False)
class Near:
    """Points (N, 3) that others are asked to be near, metres, sorted once by cells as wide as the reach."""

    points: np.ndarray
    reach: float  # metres

    @cached_property
    def _sorted(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        grid = cells(self.points, self.reach)
        return np.ascontiguousarray(self.points[grid.order]), grid.keys, grid.start

    def to(self, places: np.ndarray) -> np.ndarray:
        """Return which places (M, 3) have one of the points nearer than the reach, (M,) bool."""
        own = cells(places, self.reach)
        near = np.zeros(len(places), np.bool_)
        look_around(places[own.order], own.keys, own.start, *self._sorted, self.reach * self.reach, near)
        out = np.empty(len(places), bool)
        out[own.order] = near
        return out


@njit(cache=True, error_model="numpy")
def advance(columns, key, keys):
    """Move the first cell of each column around one of a key, and that after the last: like the keys, they ascend.

    Parameters
    ----------
    columns : (9, 2) int64
        Receives them; 0 before the first key.
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
