"""Points sorted into cells of space, in ways that do not depend on the order in which they come.

Coordinates are rounded to whole steps before they are summed: sums of whole numbers are exact in any order.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

STEP = 1e-5  # metres: what coordinates are rounded to; a sensor is off by a hundred times as much
_BITS = 21  # of a cell's index along each axis
_OFFSET = 1 << (_BITS - 1)


@dataclass(frozen=True, eq=False)
class Cells:
    """Which cell of a cubic grid each point lies in; the occupied cells are in the order of their keys."""

    points: np.ndarray  # (N, 3) float64, metres
    side: float  # metres
    keys: np.ndarray  # (C,) int64, ascending
    cell_of: np.ndarray  # (N,) int64, the cell of each point
    counts: np.ndarray  # (C,) int64

    @cached_property
    def order(self) -> np.ndarray:
        """The points (N,) int64 cell by cell, as kernels walk through them."""
        return np.argsort(self.cell_of, kind="stable")

    @cached_property
    def start(self) -> np.ndarray:
        """Where each cell begins in that order, and the number of all points, (C + 1,) int64."""
        return np.concatenate([[0], np.cumsum(self.counts)])

    @cached_property
    def means(self) -> np.ndarray:
        """The mean (C, 3) of the points in each cell, metres."""
        sums = [np.bincount(self.cell_of, steps, len(self.keys)) for steps in np.rint(self.points.T / STEP)]
        return np.column_stack(sums) / self.counts[:, None] * STEP

    @cached_property
    def indices(self) -> np.ndarray:
        """The cells (C, 3) int64 along x, y and z; 0 begins at the origin."""
        mask = (1 << _BITS) - 1
        return np.stack([self.keys >> 2 * _BITS, self.keys >> _BITS & mask, self.keys & mask], axis=1) - _OFFSET

    @cached_property
    def covariances(self) -> np.ndarray:
        """The covariance (C, 3, 3) of the points in each cell, square metres."""
        # Tenths of a millimetre from the cell's corner: squares stay whole numbers that a float64 holds exactly.
        corner = self.indices[self.cell_of] * self.side
        offset = np.rint((self.points - corner) / (10 * STEP)).T
        mean = np.stack([np.bincount(self.cell_of, steps, len(self.keys)) / self.counts for steps in offset])
        out = np.empty((len(self.keys), 3, 3))
        for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
            product = np.bincount(self.cell_of, offset[i] * offset[j], len(self.keys)) / self.counts
            out[:, i, j] = out[:, j, i] = product - mean[i] * mean[j]
        return out * (10 * STEP) ** 2


def cells(points: np.ndarray, side: float) -> Cells:
    """Sort points (N, 3) in metres into cubes of a side in metres."""
    index = np.floor(points / side).astype(np.int64) + _OFFSET
    packed = (index[:, 0] << 2 * _BITS) | (index[:, 1] << _BITS) | index[:, 2]
    keys, cell_of, counts = np.unique(packed, return_inverse=True, return_counts=True)
    return Cells(points, side, keys, cell_of.ravel(), counts)
