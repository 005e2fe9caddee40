"""Basins: where spheres stay in an object as water would; cells of their centres, flooded in order of height.

A centre stays in its cell if every way out rises. Walls are thickened by the radius of the sphere, so holes that no
sphere fits through are closed, and wider ones drain what lies above them. The algorithm is the priority-flood of
digital elevation models in three dimensions (Barnes, Lehman and Mulla, "Priority-Flood", 2014).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from ..processes.compilation import lean_njit, njit
from .links import flood_links
from .sampling import sample_surface

CELL = 0.2  # radii: resolves a rim of a third of the radius
MOST_CELLS = 96  # along the largest extent; larger objects have larger cells
SHRUNK = 0.95  # radii: size of the sphere that must not fit through a hole, since cells are not points
DENSE = 0.35  # of a cell or, if larger, of the shrunk radius: the largest gap between samples of the surface


@dataclass(frozen=True, eq=False)
class Basin:
    """The largest body of spheres that can stay in an object, as the cells of their centres."""

    origin: np.ndarray  # (3,) lower corner of the cells, in the units of the surface
    cell: float
    cells: np.ndarray  # (X, Y, Z) bool: a centre in them cannot leave without rising, up to the width of a cell
    fullness: float  # their number relative to that if the walls had no holes, 0 to 1

    def held(self) -> np.ndarray:
        """Return the cells (X, Y, Z) bool without the layer that was added around them."""
        return ndimage.binary_erosion(self.cells)

    def holds(self, centers: np.ndarray) -> np.ndarray:
        """Return whether each centre (N, 3) is in the basin, (N,) bool."""
        return self.known_of(self.cells, centers)

    def known_of(self, known: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return the values of cells (X, Y, Z) bool at points (N, 3); above the grid, those of the highest cells."""
        found = np.zeros(len(points), np.bool_)
        look_up(known, points, self.origin, self.cell, found)
        return found

    def share_below(self, height: float) -> float:
        """Return the share of the basin that lies below a height."""
        layers = self.cells.sum(axis=(0, 1))
        return float(layers[: max(0, round((height - self.origin[2]) / self.cell))].sum() / max(1, layers.sum()))

    def over(self, slack: float) -> np.ndarray:
        """Return the cells (X, Y, Z) bool of the basin, those above it, and all within a distance of these."""
        above = np.logical_or.accumulate(self.cells, axis=2)
        return ndimage.binary_dilation(above, iterations=max(1, round(slack / self.cell)))


def basin_of(vertices: np.ndarray, faces: np.ndarray, radius: float, most_cells: int = MOST_CELLS) -> Basin:
    """Return the basin of a surface for spheres of a radius; it has no cells if no sphere can stay.

    Parameters
    ----------
    vertices : (N, 3) float64, z up
    faces : (M, 3) int
    radius : float, in the units of the vertices
    most_cells : int
        Along the largest extent.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    reach = SHRUNK * radius
    cell = max(CELL * radius, float((high - low).max()) / most_cells)
    origin = low - reach - 2 * cell  # free all around
    shape = np.ceil((high + reach + 2 * cell - origin) / cell).astype(int)
    surface = sample_surface(vertices, faces, DENSE * max(cell, reach))
    solid = np.zeros(shape, np.bool_)
    thicken((surface - origin) / cell, reach / cell, solid)
    without_holes = np.logical_or.accumulate(solid[:, :, ::-1], axis=2)[:, :, ::-1]
    standing, most = standing_in(solid), standing_in(without_holes)
    bodies, count = ndimage.label(standing | most)
    if not count:
        return Basin(origin, cell, standing, 0.0)
    largest = bodies == 1 + np.bincount(bodies.ravel())[1:].argmax()
    held = standing & largest
    # Spheres at rest overlap slightly with the surface, so the cells around the basin count as well.
    return Basin(origin, cell, ndimage.binary_dilation(held), float(held.sum() / largest.sum()))


def standing_in(solid: np.ndarray) -> np.ndarray:
    """Return the cells (X, Y, Z) bool that are reached from outside and cannot be left without rising.

    The outermost cells are free.
    """
    levels = np.full(solid.shape, -1, np.int32)
    links = np.full(solid.size, -1, np.int64)
    flood_links(np.zeros(solid.shape, np.uint8), solid, levels, links, np.full(solid.shape[2], -1, np.int64))
    return levels > np.arange(solid.shape[2], dtype=np.int32)


@lean_njit(cache=True, error_model="numpy")
def look_up(known, points, origin, cell, found):
    """Write the values of cells at points; above the grid, those of the highest cells, and False beside it."""
    sizes = known.shape
    for n in range(len(points)):
        i = int(np.floor((points[n, 0] - origin[0]) / cell))
        j = int(np.floor((points[n, 1] - origin[1]) / cell))
        k = min(int(np.floor((points[n, 2] - origin[2]) / cell)), sizes[2] - 1)
        if 0 <= i < sizes[0] and 0 <= j < sizes[1] and k >= 0:
            found[n] = known[i, j, k]


@njit(cache=True, error_model="numpy")
def thicken(points, reach, solid):
    """Mark the cells whose centre is nearer than ``reach`` to a point, and those that contain one; all in cells."""
    squared = reach * reach
    sizes = solid.shape
    for n in range(len(points)):
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        solid[int(x), int(y), int(z)] = True
        for i in range(max(0, int(x - reach)), min(sizes[0], int(x + reach) + 1)):
            across = squared - (i + 0.5 - x) ** 2
            for j in range(max(0, int(y - reach)), min(sizes[1], int(y + reach) + 1)):
                left = across - (j + 0.5 - y) ** 2
                if left <= 0.0:
                    continue
                half = np.sqrt(left)
                for k in range(max(0, int(np.ceil(z - half - 0.5))), min(sizes[2], int(z + half - 0.5) + 1)):
                    solid[i, j, k] = True
