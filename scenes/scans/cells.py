"""Points sorted into cells of space; results do not depend on the order of the points.

Coordinates are rounded to whole steps before they are summed: sums of whole numbers are exact in any order.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from spherefunc_bullet.processes.compilation import njit

STEP = 1e-5  # metres, to which coordinates are rounded: a hundredth of a sensor's error
_BITS = 21  # of a cell's index along each axis
_OFFSET = 1 << (_BITS - 1)
_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))  # of axes
_DIGIT = 11  # bits that one pass of sorting looks at


@dataclass(frozen=True, eq=False)
class Cells:
    """Which cell of a cubic grid each point lies in; the occupied cells are in the order of their keys."""

    points: np.ndarray  # (N, 3) float64, metres
    side: float  # metres
    keys: np.ndarray  # (C,) int64, ascending
    cell_of: np.ndarray  # (N,) int64, the cell of each point
    counts: np.ndarray  # (C,) int64
    order: np.ndarray  # (N,) int64, the points cell by cell, as kernels walk through them

    @cached_property
    def start(self) -> np.ndarray:
        """Where each cell begins in that order, and the number of all points, (C + 1,) int64."""
        return np.concatenate([[0], np.cumsum(self.counts)])

    @cached_property
    def means(self) -> np.ndarray:
        """The mean (C, 3) of the points in each cell, metres."""
        sums = np.zeros((len(self.keys), 3))
        add_steps(np.ascontiguousarray(self.points), self.cell_of, sums)
        return sums / self.counts[:, None] * STEP

    @cached_property
    def indices(self) -> np.ndarray:
        """The cells (C, 3) int64 along x, y and z; 0 begins at the origin."""
        mask = (1 << _BITS) - 1
        return np.stack([self.keys >> 2 * _BITS, self.keys >> _BITS & mask, self.keys & mask], axis=1) - _OFFSET

    @property
    def interior(self) -> np.ndarray:
        """Which cells have others on all six sides, (C,) bool."""
        neighbours = [self.keys + step for axis in range(3) for step in (1 << axis * _BITS, -1 << axis * _BITS)]
        return np.all([np.isin(each, self.keys) for each in neighbours], axis=0)

    @cached_property
    def covariances(self) -> np.ndarray:
        """The covariance (C, 3, 3) of the points in each cell, square metres."""
        sums = np.zeros((len(self.keys), 9))
        add_products(np.ascontiguousarray(self.points), self.cell_of, self.indices * self.side, sums)
        sums /= self.counts[:, None]
        out = np.empty((len(self.keys), 3, 3))
        for place, (i, j) in enumerate(_PAIRS, start=3):
            out[:, i, j] = out[:, j, i] = sums[:, place] - sums[:, i] * sums[:, j]
        return out * (10 * STEP) ** 2


def cells(points: np.ndarray, side: float) -> Cells:
    """Sort points (N, 3) in metres into cubes of a side in metres."""
    count = len(points)
    sorting, order, keys = np.empty((2, count), np.int64), np.empty((2, count), np.int64), np.empty(count, np.int64)
    cell_of, counts = np.empty(count, np.int64), np.zeros(count, np.int64)
    used, row = sort_into_cells(np.ascontiguousarray(points), side, sorting, order, keys, cell_of, counts)
    return Cells(points, side, keys[:used].copy(), cell_of, counts[:used].copy(), order[row])


@njit(cache=True, error_model="numpy")
def sort_into_cells(points, side, sorting, order, keys, cell_of, counts):
    """Write the occupied cells of points (N, 3) in the order of their keys; return how many, and the points' row.

    Digit by digit from the last one on (Knuth, 5.2.5): a few passes over all points, however many there are.

    Parameters
    ----------
    sorting, order : (2, N) int64
        Room to sort in; one row of ``order`` receives the points, cell by cell.
    keys, counts : (N,) int64
        Receive the cells' keys and their numbers of points, 0 before.
    cell_of : (N,) int64
        Receives the cell of each point.
    """
    low, bits = pack_keys(points, side, sorting[0])
    for i in range(len(points)):
        order[0, i] = i
    row = 0
    ends = np.empty((1 << _DIGIT) + 1, np.int64)
    for shift in range(0, bits[0] + bits[1] + bits[2], _DIGIT):
        sort_by_digit(sorting[row], order[row], sorting[1 - row], order[1 - row], shift, ends)
        row = 1 - row
    used, last = 0, -1
    for i in range(len(points)):
        key = sorting[row, i]
        if key != last:
            x, y, z = key >> bits[1] + bits[2], (key >> bits[2]) & ((1 << bits[1]) - 1), key & ((1 << bits[2]) - 1)
            keys[used] = ((x + low[0]) << 2 * _BITS) | ((y + low[1]) << _BITS) | (z + low[2])
            used, last = used + 1, key
        cell_of[order[row, i]] = used - 1
        counts[used - 1] += 1
    return used, row


@njit(cache=True, error_model="numpy")
def add_steps(points, cell_of, sums):
    """Add to the sums (C, 3) of each cell its points (N, 3), rounded to whole steps."""
    for i in range(len(points)):
        for axis in range(3):
            sums[cell_of[i], axis] += np.rint(points[i, axis] / STEP)


@njit(cache=True, error_model="numpy")
def add_products(points, cell_of, corners, sums):
    """Add to the sums (C, 9) of each cell its points (N, 3) from the cell's corner (C, 3), then products of `_PAIRS`.

    In tenths of a millimetre: squares stay whole numbers that a float64 holds exactly.
    """
    for p in range(len(points)):
        cell = cell_of[p]
        x = np.rint((points[p, 0] - corners[cell, 0]) / (10 * STEP))
        y = np.rint((points[p, 1] - corners[cell, 1]) / (10 * STEP))
        z = np.rint((points[p, 2] - corners[cell, 2]) / (10 * STEP))
        for place, term in enumerate((x, y, z, x * x, x * y, x * z, y * y, y * z, z * z)):
            sums[cell, place] += term


@njit(cache=True, error_model="numpy")
def pack_keys(points, side, packed):
    """Write the cell of each point (N, 3) as one number; return the lowest cell (3,) and the bits of each axis (3,)."""
    low, bits = np.zeros(3, np.int64), np.zeros(3, np.int64)
    for axis in range(3):
        least, most = np.inf, -np.inf
        for i in range(len(points)):
            least, most = min(least, points[i, axis]), max(most, points[i, axis])
        if least <= most:
            low[axis] = np.int64(np.floor(least / side)) + _OFFSET
            while (np.int64(np.floor(most / side)) + _OFFSET - low[axis]) >> bits[axis] > 0:
                bits[axis] += 1
    for i in range(len(points)):
        x, y, z = np.floor(points[i, 0] / side), np.floor(points[i, 1] / side), np.floor(points[i, 2] / side)
        key = np.int64(x) + _OFFSET - low[0]
        key = (key << bits[1]) | (np.int64(y) + _OFFSET - low[1])
        packed[i] = (key << bits[2]) | (np.int64(z) + _OFFSET - low[2])
    return low, bits


@njit(cache=True, error_model="numpy")
def sort_by_digit(keys, order, sorted_keys, sorted_order, shift, ends):
    """Write keys (N,) and their order sorted by one digit, stably; ``ends`` is scratch memory."""
    ends[:] = 0
    for i in range(len(keys)):
        ends[((keys[i] >> shift) & ((1 << _DIGIT) - 1)) + 1] += 1
    for digit in range(1 << _DIGIT):
        ends[digit + 1] += ends[digit]
    for i in range(len(keys)):
        digit = (keys[i] >> shift) & ((1 << _DIGIT) - 1)
        place = ends[digit]
        ends[digit] += 1
        sorted_keys[place], sorted_order[place] = keys[i], order[i]


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
