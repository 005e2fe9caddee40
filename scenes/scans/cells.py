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
_DIGIT = (6, 12)  # bits that one pass of sorting looks at, for few and for many points


@dataclass(frozen=True, eq=False)
class Cells:
    """Which cell of a cubic grid each point lies in; occupied ones are in the order of their keys, along x first."""

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
        add_steps(self.points, self.cell_of, sums)
        return sums / self.counts[:, None] * STEP

    @cached_property
    def indices(self) -> np.ndarray:
        """The cells (C, 3) int64 along x, y and z; 0 begins at the origin."""
        mask = (1 << _BITS) - 1
        return np.stack([self.keys >> 2 * _BITS, self.keys >> _BITS & mask, self.keys & mask], axis=1) - _OFFSET

    def along_x(self, low: float, high: float) -> slice:
        """Return the cells with points between two places along x, metres; others are at most a cell farther away."""
        first, end = (int(np.floor(x / self.side)) + _OFFSET << 2 * _BITS for x in (low, high + self.side))
        return slice(*np.searchsorted(self.keys, [first, end]))

    def points_in(self, chosen: np.ndarray) -> np.ndarray:
        """Return the points (M,) int64 of some cells (K,) int64, ascending."""
        counts = self.counts[chosen]
        ends = np.cumsum(counts)
        return np.sort(self.order[np.arange(counts.sum()) + np.repeat(self.start[chosen] - ends + counts, counts)])

    @property
    def interior(self) -> np.ndarray:
        """Which cells have others on all six sides, (C,) bool."""
        neighbours = [self.keys + step for axis in range(3) for step in (1 << axis * _BITS, -1 << axis * _BITS)]
        return np.all([np.isin(each, self.keys) for each in neighbours], axis=0)


def cells(points: np.ndarray, side: float) -> Cells:
    """Sort points (N, 3) in metres into cubes of a side in metres."""
    count, points = len(points), np.ascontiguousarray(points)
    sorting, order = np.empty((2, count), np.int64), np.empty(count, np.int64)
    keys, cell_of, counts = np.empty(count, np.int64), np.empty(count, np.int64), np.zeros(count, np.int64)
    used = sort_into_cells(points, side, sorting, order, keys, cell_of, counts)
    if used < 0:
        return far_apart_cells(points, side)
    return Cells(points, side, keys[:used].copy(), cell_of, counts[:used].copy(), order)


def far_apart_cells(points: np.ndarray, side: float) -> Cells:
    """Return the same as `cells`, several times slower, however far apart the points (N, 3) are."""
    x, y, z = np.floor(points / side).astype(np.int64).T + _OFFSET
    packed = x << 2 * _BITS | y << _BITS | z
    keys, cell_of, counts = np.unique(packed, return_inverse=True, return_counts=True)
    return Cells(points, side, keys, cell_of, counts, np.argsort(packed, kind="stable"))


@njit(cache=True, error_model="numpy")
def sort_into_cells(points, side, sorting, order, keys, cell_of, counts):
    """Write the occupied cells of points (N, 3) in the order of their keys, and return how many.

    Digit by digit from the last one on (Knuth, 5.2.5): a few passes over all points, however many there are. A cell and
    a point of it are sorted as one number; where these do not fit into 63 bits, -1 is returned.

    Parameters
    ----------
    sorting : (2, N) int64
        Room to sort in.
    order : (N,) int64
        Receives the points, cell by cell.
    keys, counts : (N,) int64
        Receive the cells' keys and their numbers of points, 0 before.
    cell_of : (N,) int64
        Receives the cell of each point.
    """
    low, bits = lowest_cell(points, side)
    own, point_bits = bits[0] + bits[1] + bits[2], bits_of(len(points))
    if own + point_bits > 63:
        return -1
    pack_keys(points, side, low, bits, point_bits, sorting[0])
    passes = -(-own // max(_DIGIT[0], min(point_bits, _DIGIT[1])))
    digit, row = -(-own // max(passes, 1)), 0
    ends = np.empty((1 << digit) + 1, np.int64)
    for turn in range(passes):
        sort_by_digit(sorting[row], sorting[1 - row], point_bits + turn * digit, ends)
        row = 1 - row
    used, last, low_y, low_z, low_point = 0, -1, (1 << bits[1]) - 1, (1 << bits[2]) - 1, (1 << point_bits) - 1
    for i in range(len(points)):
        key, point = sorting[row, i] >> point_bits, sorting[row, i] & low_point
        if key != last:
            x, y, z = key >> bits[1] + bits[2], (key >> bits[2]) & low_y, key & low_z
            keys[used] = ((x + low[0]) << 2 * _BITS) | ((y + low[1]) << _BITS) | (z + low[2])
            used, last = used + 1, key
        order[i], cell_of[point] = point, used - 1
        counts[used - 1] += 1
    return used


@njit(cache=True, error_model="numpy")
def add_steps(points, cell_of, sums):
    """Add to the sums (C, 3) of each cell its points (N, 3), rounded to whole steps."""
    for i in range(len(points)):
        for axis in range(3):
            sums[cell_of[i], axis] += np.rint(points[i, axis] / STEP)


@njit(cache=True, error_model="numpy")
def bits_of(number):
    """Return how many binary digits a number has, 0 for 0."""
    bits = 0
    while number >> bits > 0:
        bits += 1
    return bits


@njit(cache=True, error_model="numpy")
def lowest_cell(points, side):
    """Return the lowest cell (3,) of points (N, 3) along each axis, and the bits (3,) that number the others."""
    low, bits = np.zeros(3, np.int64), np.zeros(3, np.int64)
    if len(points) == 0:
        return low, bits
    (x0, y0, z0), (x1, y1, z1) = points[0], points[0]
    for i in range(1, len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        x0, x1 = x if x < x0 else x0, x if x > x1 else x1
        y0, y1 = y if y < y0 else y0, y if y > y1 else y1
        z0, z1 = z if z < z0 else z0, z if z > z1 else z1
    for axis, (least, most) in enumerate(((x0, x1), (y0, y1), (z0, z1))):
        low[axis] = np.int64(np.floor(least / side)) + _OFFSET
        bits[axis] = bits_of(np.int64(np.floor(most / side)) + _OFFSET - low[axis])
    return low, bits


@njit(cache=True, error_model="numpy")
def pack_keys(points, side, low, bits, point_bits, packed):
    """Write the cell of each point (N, 3), from the lowest (3,) on, and the point itself in the last bits."""
    for i in range(len(points)):
        x, y, z = np.floor(points[i, 0] / side), np.floor(points[i, 1] / side), np.floor(points[i, 2] / side)
        key = np.int64(x) + _OFFSET - low[0]
        key = (key << bits[1]) | (np.int64(y) + _OFFSET - low[1])
        key = (key << bits[2]) | (np.int64(z) + _OFFSET - low[2])
        packed[i] = (key << point_bits) | i


@njit(cache=True, error_model="numpy")
def sort_by_digit(numbers, sorted_numbers, shift, ends):
    """Write numbers (N,) sorted by one digit, stably; ``ends`` (D + 1,) is scratch memory for D digits."""
    ends[:] = 0
    mask = len(ends) - 2
    for number in numbers:
        ends[((number >> shift) & mask) + 1] += 1
    for digit in range(len(ends) - 1):
        ends[digit + 1] += ends[digit]
    for number in numbers:
        digit = (number >> shift) & mask
        sorted_numbers[ends[digit]] = number
        ends[digit] += 1
