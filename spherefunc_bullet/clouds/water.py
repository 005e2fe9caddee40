"""Water that an object holds: cells of space, flooded from outside along links that no surface crosses.

The link between the centres of two neighbours is cut exactly if a triangle crosses it, so walls have no thickness and
the volume is as unbiased as the midpoint rule; holes in walls drain what lies above them. The algorithm is the
priority-flood of digital elevation models in three dimensions (Barnes, Lehman and Mulla, "Priority-Flood", 2014).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .cloud import Cloud
from .links import cut_links, flood_links, label_links

CELLS = 250_000  # approximate number, with at most `MOST` along an extent
COARSE_CELLS = 60_000, 40_000  # the same for leaks: two grids, since the cell centres of one may meet a crack
CRACK = 0.002  # metres: a hole that is no wider is a seam between two parts of a mesh
GRAIN_CELLS = 48  # along an extent
MOST = 160
# Distances to the sixth neighbour: what is nearer to a point of a cloud is wall. Points at random leave gaps of a
# radius of up to 1.5 such distances, though the nearest neighbour is a third of one away. A lattice has gaps of half.
OF_CLOUDS = 1.7
SIXTH = 6
UNDER_WATER = 0.4  # share of the spheres over water that are below its level: 0.5 to 1 in cups, 0 to 0.3 with a slit
SPILLED_AT = 0.9  # of the capacity, to which a vessel is filled


@dataclass(frozen=True, eq=False)
class Water:
    """One body of water that an object holds, as cells."""

    origin: np.ndarray  # (3,) corner of the first cell, metres
    cell: float
    cells: np.ndarray  # (N, 3) int
    brim: int  # layers: height at which it overflows
    opening: np.ndarray  # (M, 2) int: columns of the uppermost layer that are open to the sky
    extra: float  # m3 between the cells and the surface, if walls have a thickness

    @property
    def volume(self) -> float:
        """Volume up to the brim, m3."""
        return len(self.cells) * self.cell**3 + self.extra

    @property
    def brim_height(self) -> float:
        """Height of the brim, metres."""
        return float(self.origin[2] + self.brim * self.cell)

    def middles(self) -> np.ndarray:
        """Return the centres (N, 3) of the cells, metres."""
        return self.origin + (self.cells + 0.5) * self.cell

    def levels(self, count: int = 10) -> tuple[tuple[float, float], ...]:
        """Return pairs of a volume in millilitres and the height of its surface in metres, up to the brim."""
        layers = np.bincount(self.cells[:, 2], minlength=self.brim)[: self.brim]
        filled = np.cumsum(layers) / max(1, layers.sum()) * self.volume * 1e6
        heights = self.origin[2] + (np.arange(self.brim) + 1) * self.cell
        first = int(np.argmax(layers > 0))
        volumes = np.linspace(0, filled[-1], count + 1)
        at = np.interp(volumes, np.append(0, filled[first:]), np.append(heights[first] - self.cell, heights[first:]))
        return tuple((float(volume), float(height)) for volume, height in zip(volumes, at, strict=True))

    def spill(self) -> tuple[float, float]:
        """Return the smallest tilt at which a vessel filled to nine tenths spills, and its heading, degrees.

        At a tilt it keeps what is below the horizontal plane through the lowest point of its rim.
        """
        middles = self.middles()
        water = middles[:: max(1, len(middles) // 4000)]
        rim = np.column_stack([self.origin[:2] + (self.opening + 0.5) * self.cell, np.full(len(self.opening), 1.0)])
        rim[:, 2] = self.brim_height
        headings = np.arange(24) * 2 * np.pi / 24
        tilts = np.array([first_spill(water, rim, heading, self.cell / 2) for heading in headings])
        first = int(tilts.argmin())
        return float(np.degrees(tilts[first])), float(np.degrees(headings[first]))


def first_spill(water: np.ndarray, rim: np.ndarray, heading: float, reach: float) -> float:
    """Return the tilt in radians from which on less than nine tenths are below the rim, by bisection."""
    low, high = 0.0, np.pi / 2
    side = np.array([np.cos(heading), np.sin(heading)])
    ahead, rim_ahead = water[:, :2] @ side, rim[:, :2] @ side + reach
    for _ in range(9):
        tilt = (low + high) / 2
        sine, cosine = np.sin(tilt), np.cos(tilt)
        edge = (rim[:, 2] * cosine - rim_ahead * sine).min()
        share = float(np.mean(water[:, 2] * cosine - ahead * sine <= edge))
        low, high = (tilt, high) if share >= SPILLED_AT else (low, tilt)
    return low


def wall_of(cloud: Cloud) -> float:
    """Return how near to a point of a cloud is wall, metres; 0 with a mesh, whose walls have no thickness."""
    return 0.0 if cloud.mesh is not None else OF_CLOUDS * (cloud.unfilled or cloud.to_neighbour(SIXTH))


def waters_of(cloud: Cloud, cells: int = CELLS) -> list[Water]:
    """Return the bodies of water that an object holds up to their brims, the largest first."""
    size = cloud.size
    cell = max(float(np.prod(np.maximum(size, 0.02 * size.max())) / cells) ** (1 / 3), float(size.max()) / MOST)
    cell = cell if cloud.mesh is not None else max(cell, cloud.spacing)
    wall = wall_of(cloud)
    margin = 2 + int(np.ceil(wall / cell))
    origin = cloud.bounds[0] - (margin + 0.013) * cell  # off the planes at round coordinates that models often have
    shape = tuple(np.ceil((cloud.bounds[1] - origin) / cell).astype(int) + margin)
    cuts, solid = np.zeros(shape, np.uint8), np.zeros(shape, np.bool_)
    if cloud.mesh is not None:
        triangles = cloud.mesh.vertices[cloud.mesh.faces]
        cut_links(np.ascontiguousarray((triangles - origin) / cell), cuts)
        return bodies_of(cuts, solid, origin, cell, wall)
    from .flooding import thicken

    thicken((cloud.points - origin) / cell, max(0.8, wall / cell), solid)
    return bodies_of(cuts, solid, origin, cell, wall)


def leaks(cloud: Cloud, centers: np.ndarray) -> bool:
    """Return whether water runs out of a vessel in which spheres stay, through a hole that may be too small for them.

    Parameters
    ----------
    cloud : Cloud
        Without a mesh, holes smaller than the distances between points are closed; see `OF_CLOUDS`.
    centers : (S, 3) float64
        Where spheres rest in it, metres.
    """
    for count in COARSE_CELLS:
        for water in waters_of(cloud, count)[:1]:
            if share_under_water(water.origin, water.cell, water.cells, centers) >= UNDER_WATER:
                return False
    if cloud.mesh is None:
        return True
    # Water also leaves through cracks between two parts of a mesh; grains do not.
    from .flooding import basin_of  # imports SciPy, which few objects need

    grains = basin_of(cloud.mesh.vertices, cloud.mesh.faces, CRACK / 2, GRAIN_CELLS)
    return share_under_water(grains.origin, grains.cell, np.argwhere(grains.held()), centers) < UNDER_WATER


def share_under_water(origin: np.ndarray, cell: float, cells: np.ndarray, centers: np.ndarray) -> float:
    """Return the share of the spheres over the cells (N, 3) of water that are below its level; 0 if there are none."""
    if not len(cells):
        return 0.0
    low, high = cells.min(axis=0), cells.max(axis=0)
    columns = np.zeros((high - low + 1)[:2], bool)
    columns[tuple((cells - low)[:, :2].T)] = True
    at = np.floor((centers - origin) / cell).astype(int) - low
    within = ((at[:, :2] >= 0) & (at[:, :2] < columns.shape)).all(axis=1)
    within[within] = columns[tuple(at[within][:, :2].T)]
    return float((at[within, 2] <= high[2] - low[2]).mean()) if within.any() else 0.0


def bodies_of(cuts: np.ndarray, solid: np.ndarray, origin: np.ndarray, cell: float, wall: float) -> list[Water]:
    """Return the bodies of water in the cells, the largest first, without tiny ones."""
    levels = np.full(cuts.shape, -1, np.int32)
    flood_links(cuts, solid, levels, np.full(cuts.size, -1, np.int64), np.full(cuts.shape[2], -1, np.int64))
    layers = np.arange(cuts.shape[2], dtype=np.int32)
    wet = levels > layers
    if not wet.any():
        return []
    labels = np.zeros(cuts.shape, np.int32)
    count = label_links(cuts, wet, labels, np.empty(int(wet.sum()), np.int64))
    sizes = np.bincount(labels.ravel(), minlength=count + 1)[1:]
    free = ~solid & (cuts & 4 == 0)
    sky = np.logical_and.accumulate(free[:, :, ::-1], axis=2)[:, :, ::-1]  # cells with nothing above them
    found = []
    for k in np.argsort(-sizes, kind="stable"):
        if sizes[k] >= max(20, 0.05 * sizes.max()):
            cells = np.argwhere(labels == k + 1)
            top = cells[cells[:, 2] == cells[:, 2].max()]
            opening = top[sky[tuple(top.T)]][:, :2]
            extra = wall_volume(cells, cell, wall) if wall else 0.0
            found.append(Water(origin, cell, cells, int(levels[tuple(cells[0])]), opening, extra))
    return found


def wall_volume(cells: np.ndarray, cell: float, wall: float) -> float:
    """Return the volume between the cells (N, 3) of a body of water and the surface, m3, for walls with a thickness."""
    low = cells.min(axis=0)
    block = np.zeros(cells.max(axis=0) - low + 3, bool)
    block[tuple((cells - low + 1).T)] = True
    faces = sum(int(np.count_nonzero(np.diff(block.astype(np.int8), axis=axis))) for axis in range(3))
    faces -= int(block.any(axis=2).sum())  # the free surface has no wall
    return 2 / 3 * faces * cell**2 * wall  # the steps on slopes count half as much again
