"""Water that an object holds: cells of space flooded from outside, linked where no surface lies between their middles.

A link between the middles of two neighbours is cut exactly where a triangle crosses it, so walls have no thickness of
their own and the volume is as unbiased as a midpoint rule; holes in walls let out what lies above them. The flood is
that of digital elevation models in three dimensions (Barnes, Lehman and Mulla, "Priority-Flood", 2014).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .cloud import Cloud
from .links import cut_links, flood_links, label_links

CELLS = 250_000  # about this many, and never more than `MOST` along an extent
COARSE_CELLS = 60_000, 40_000  # of the floods that look for leaks: by the other, where the middles of one meet a crack
CRACK = 0.002  # metres: a hole that is no wider is a seam between two parts of a mesh
GRAIN_CELLS = 48  # along an extent
MOST = 160
OF_CLOUDS = 1.0  # spacings: what is nearer to a point of a cloud than that is wall
UNDER_WATER = 0.4  # of the spheres over water that lie below its level: cups have 0.5 to 1, those with a slit 0 to 0.3
SPILLED_AT = 0.9  # of the capacity: what a vessel is filled with


@dataclass(frozen=True, eq=False)
class Water:
    """One body of water that an object holds, as cells."""

    origin: np.ndarray  # (3,) corner of the first cell, metres
    cell: float
    cells: np.ndarray  # (N, 3) int
    brim: int  # layers: where it begins to run over
    opening: np.ndarray  # (M, 2) int: columns of the uppermost layer that are open to the sky
    extra: float  # m3 between the cells and the surface, where walls have a thickness of their own

    @property
    def volume(self) -> float:
        """To the brim, m3."""
        return len(self.cells) * self.cell**3 + self.extra

    @property
    def brim_height(self) -> float:
        """Metres."""
        return float(self.origin[2] + self.brim * self.cell)

    def middles(self) -> np.ndarray:
        """Return the middles (N, 3) of the cells, metres."""
        return self.origin + (self.cells + 0.5) * self.cell

    def levels(self, count: int = 10) -> tuple[tuple[float, float], ...]:
        """Return pairs of millilitres and the height in metres at which they stand, up to the brim."""
        layers = np.bincount(self.cells[:, 2], minlength=self.brim)[: self.brim]
        filled = np.cumsum(layers) / max(1, layers.sum()) * self.volume * 1e6
        heights = self.origin[2] + (np.arange(self.brim) + 1) * self.cell
        first = int(np.argmax(layers > 0))
        volumes = np.linspace(0, filled[-1], count + 1)
        at = np.interp(volumes, np.append(0, filled[first:]), np.append(heights[first] - self.cell, heights[first:]))
        return tuple((float(volume), float(height)) for volume, height in zip(volumes, at, strict=True))

    def spill(self, directions: int = 24) -> tuple[float, float]:
        """Return the least tilt at which a vessel filled to nine tenths spills, and the heading of that side, degrees.

        What it keeps at a tilt is what lies below the horizontal plane through the lowest point of its rim.
        """
        middles = self.middles()
        water = middles[:: max(1, len(middles) // 4000)]
        rim = np.column_stack([self.origin[:2] + (self.opening + 0.5) * self.cell, np.full(len(self.opening), 1.0)])
        rim[:, 2] = self.brim_height
        headings = np.arange(directions) * 2 * np.pi / directions
        tilts = np.array([first_spill(water, rim, heading, self.cell / 2) for heading in headings])
        first = int(tilts.argmin())
        return float(np.degrees(tilts[first])), float(np.degrees(headings[first]))


def first_spill(water: np.ndarray, rim: np.ndarray, heading: float, reach: float) -> float:
    """Return the tilt in radians at which less than nine tenths lie below the rim, by halving."""
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


def waters_of(cloud: Cloud, cells: int = CELLS) -> list[Water]:
    """Return the bodies of water that a cloud's object holds up to their brims, the largest first."""
    size = cloud.size
    cell = max(float(np.prod(np.maximum(size, 0.02 * size.max())) / cells) ** (1 / 3), float(size.max()) / MOST)
    cell = cell if cloud.mesh is not None else max(cell, cloud.spacing)
    origin = cloud.bounds[0] - 2.013 * cell  # off the planes that models like to have
    shape = tuple(np.ceil((cloud.bounds[1] - origin) / cell).astype(int) + 2)
    cuts, solid = np.zeros(shape, np.uint8), np.zeros(shape, np.bool_)
    if cloud.mesh is not None:
        triangles = cloud.mesh.vertices[cloud.mesh.faces]
        cut_links(np.ascontiguousarray((triangles - origin) / cell), cuts)
    else:
        from .flooding import thicken

        thicken((cloud.points - origin) / cell, max(0.8, OF_CLOUDS * cloud.spacing / cell), solid)
    return bodies_of(cuts, solid, origin, cell, 0.0 if cloud.mesh is not None else OF_CLOUDS * cloud.spacing)


def leaks(cloud: Cloud, centers: np.ndarray) -> bool:
    """Return whether water runs out from among spheres that stay in a vessel, through a hole too small for them.

    Asked of meshes alone: points do not show a hole that is smaller than their spacing.

    Parameters
    ----------
    cloud : Cloud
        With a mesh.
    centers : (S, 3) float64
        Where spheres rest in it, metres.
    """
    for count in COARSE_CELLS:
        for water in waters_of(cloud, count)[:1]:
            if share_under_water(water.origin, water.cell, water.cells, centers) >= UNDER_WATER:
                return False
    # Water leaves through a crack between two parts of a mesh as well; grains do not.
    from .flooding import basin_of  # and SciPy with it: few objects come so far

    grains = basin_of(cloud.mesh.vertices, cloud.mesh.faces, CRACK / 2, GRAIN_CELLS)
    return share_under_water(grains.origin, grains.cell, np.argwhere(grains.held()), centers) < UNDER_WATER


def share_under_water(origin: np.ndarray, cell: float, cells: np.ndarray, centers: np.ndarray) -> float:
    """Return the share of the spheres over the cells (N, 3) of some water that lie below its level; 0 of none."""
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
    """Return the bodies of water among cells."""
    levels = np.full(cuts.shape, -1, np.int32)
    flood_links(cuts, solid, levels, np.full(cuts.size, -1, np.int64), np.full(cuts.shape[2], -1, np.int64))
    layers = np.arange(cuts.shape[2], dtype=np.int32)
    wet = levels > layers
    if not wet.any():
        return []
    labels = np.zeros(cuts.shape, np.int32)
    count = label_links(cuts, wet, labels, np.empty(int(wet.sum()), np.int64))
    sizes = np.bincount(labels.ravel(), minlength=count + 1)[1:]
    sky = sky_above(cuts, solid)
    large = [k for k in np.argsort(-sizes, kind="stable") if sizes[k] >= max(20, 0.05 * sizes.max())]
    found = [water_of(labels == k + 1, levels, sky, origin, cell) for k in large]
    return [with_walls(water, wall) for water in found]


def water_of(cells: np.ndarray, levels: np.ndarray, sky: np.ndarray, origin: np.ndarray, cell: float) -> Water:
    """Return one body."""
    where = np.argwhere(cells)
    brim = int(levels[tuple(where[0])])
    top = where[where[:, 2] == where[:, 2].max()]
    return Water(origin, cell, where, brim, top[sky[tuple(top.T)]][:, :2], 0.0)


def with_walls(water: Water, wall: float) -> Water:
    """Return a body with half of the wall that its cells leave out, where walls have a thickness."""
    if not wall:
        return water
    shape = water.cells.max(axis=0) - water.cells.min(axis=0) + 3
    block = np.zeros(shape, bool)
    block[tuple((water.cells - water.cells.min(axis=0) + 1).T)] = True
    faces = sum(int(np.count_nonzero(np.diff(block.astype(np.int8), axis=axis))) for axis in range(3))
    faces -= int(block.any(axis=2).sum())  # the free surface has no wall
    return replace(water, extra=2 / 3 * faces * water.cell**2 * wall)  # steps count slopes by half as much again


def sky_above(cuts: np.ndarray, solid: np.ndarray) -> np.ndarray:
    """Return the cells (X, Y, Z) bool that nothing lies above."""
    free = ~solid & (cuts & 4 == 0)
    return np.logical_and.accumulate(free[:, :, ::-1], axis=2)[:, :, ::-1]
