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

    def turned(self) -> TopView:
        """Return the view after a quarter turn of the object."""
        return TopView(heights=np.rot90(self.heights), cell=self.cell)


def top_view(
    record: ObjectRecord, cell: float, *, degrees: float = 0.0, margin: float = 0.0, below: float = np.inf
) -> TopView:
    """Return an object's top view.

    Parameters
    ----------
    cell : float
        Side of a square, metres, not less than `VOXEL`.
    degrees : float
        By which the object is turned about the vertical before.
    margin : float
        Free ground that is added on all sides, metres; one cell at least.
    below : float
        Only what is lower than this is looked at, metres.
    """
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    points = (record.voxels + 0.5) * VOXEL
    places, tops = points[:, :2] @ np.array([[cosine, sine], [-sine, cosine]]), points[:, 2]
    squares, border = np.floor(places / cell + 1e-9).astype(int), max(1, round(margin / cell))
    squares += border - squares.min(axis=0)
    heights = np.full(squares.max(axis=0) + border + 1, NOTHING)
    kept = tops < below
    np.maximum.at(heights, tuple(squares[kept].T), tops[kept])
    return TopView(heights=heights, cell=cell)
