"""An object seen from above: the height of the highest place over each square of the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.settling.records import VOXEL, ObjectRecord

NOTHING = -np.inf  # height where the object has no point


@dataclass(frozen=True, kw_only=True, eq=False)
class TopView:
    """Heights over square cells of the ground; what is higher hides what lies below it."""

    heights: np.ndarray  # (X, Y) float, metres above the ground; NOTHING beside the object
    cell: float  # metres

    def cells(self, length: float) -> int:
        """Return how many cells a length in metres takes, at least one."""
        return max(1, round(length / self.cell))

    def quarter_turned(self) -> TopView:
        """Return the view after a quarter turn of the object."""
        return TopView(heights=np.rot90(self.heights), cell=self.cell)

    def turned(self, degrees: float, cell: float, margin: float = 0.0) -> TopView:
        """Return the view after a turn about the vertical, in cells as large as these or larger.

        Parameters
        ----------
        cell : float
            Side of a square, metres.
        margin : float
            Free ground that is added on all sides, metres.
        """
        cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        turn = np.array([[cosine, sine], [-sine, cosine]])
        corners = np.array([(x, y) for x in (0, self.heights.shape[0]) for y in (0, self.heights.shape[1])]) @ turn
        low, high = corners.min(axis=0) * self.cell - margin, corners.max(axis=0) * self.cell + margin
        seen = self.heights > NOTHING
        places = ((np.argwhere(seen) + 0.5) @ turn) * self.cell
        heights = np.full(np.ceil((high - low) / cell).astype(int) + 1, NOTHING)
        np.maximum.at(heights, tuple(np.floor((places - low) / cell).astype(int).T), self.heights[seen])
        return TopView(heights=heights, cell=cell)


def top_view(record: ObjectRecord, below: float = np.inf) -> TopView:
    """Return an object's top view in cells of a voxel, a cell of free ground around it.

    Parameters
    ----------
    below : float
        Only what is lower than this is looked at, metres.
    """
    squares = record.voxels[:, :2].astype(int) - record.voxels[:, :2].min(axis=0) + 1
    heights = np.full(squares.max(axis=0) + 2, NOTHING)
    middles = (record.voxels[:, 2] + 0.5) * VOXEL
    kept = middles < below
    np.maximum.at(heights, tuple(squares[kept].T), middles[kept])
    return TopView(heights=heights, cell=VOXEL)
