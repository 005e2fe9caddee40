"""The surface that is seen from above: the highest point in each cell of a grid, metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from ..clouds.cloud import Cloud
from ..processes.compilation import njit

CELL = 0.01  # metres
COARSE = 2.0  # spacings of a cloud's points: the least side of a cell
ACROSS = 400  # cells at most


@dataclass(frozen=True, eq=False)
class Surface:
    """Cells with the height of what is highest in them."""

    origin: np.ndarray  # (2,) the corner of the first cell
    cell: float  # side
    heights: np.ndarray  # (X, Y), -inf where nothing is
    rough: float  # metres by which heights of neighbours may differ on a level surface, beyond its slope

    def middles(self, cells: np.ndarray) -> np.ndarray:
        """Return the middles (N, 2) of cells (N, 2), metres."""
        return self.origin + (cells + 0.5) * self.cell

    def blurred(self, mask: np.ndarray, cells: int) -> np.ndarray:
        """Return a mask without gaps narrower than so many cells."""
        return ndimage.binary_closing(np.pad(mask, cells), iterations=cells)[cells:-cells, cells:-cells]


def surface_of(cloud: Cloud, cell: float = CELL) -> Surface:
    """Return what is seen of a cloud from above.

    A mesh is sampled to 5 mm, so each cell that it covers has a point of it.
    """
    rough, least = 0.002, cell
    if cloud.mesh is None:
        spacing = cloud.spacing
        least, rough = max(cell, COARSE * spacing), 0.004 + 0.3 * spacing
    side = max(least, float(cloud.size[:2].max()) / ACROSS)
    origin = cloud.bounds[0, :2] - 2 * side
    shape = np.ceil((cloud.bounds[1, :2] - origin) / side).astype(int) + 2
    heights = np.full(shape, -np.inf)
    raise_to(cloud.points, origin, side, heights)
    return Surface(origin, side, heights, rough)


@njit(cache=True, error_model="numpy")
def raise_to(points, origin, side, heights):
    """Raise the height of each cell to its highest point."""
    for n in range(len(points)):
        i = int((points[n, 0] - origin[0]) / side)
        j = int((points[n, 1] - origin[1]) / side)
        if points[n, 2] > heights[i, j]:
            heights[i, j] = points[n, 2]
