"""Water that an object holds: cells of space flooded from outside, linked where no surface lies between their middles.

A link between the middles of two neighbours is cut exactly where a triangle crosses it, so walls have no thickness of
their own and the volume is as unbiased as a midpoint rule; holes in walls let out what lies above them. The flood is
that of digital elevation models in three dimensions (Barnes, Lehman and Mulla, "Priority-Flood", 2014).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..processes.compilation import lean_njit
from .cloud import Cloud

CELLS = 250_000  # about so many, and never more than `MOST` along an extent
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
        kept = float(np.mean(water[:, 2] * cosine - ahead * sine <= edge))
        low, high = (tilt, high) if kept >= SPILLED_AT else (low, tilt)
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


@lean_njit(cache=True, error_model="numpy")
def cut_links(triangles, cuts):
    """Mark the links between middles of neighbours that triangles (T, 3, 3), in cells, cross: bits of x, y and z.

    The bit of an axis is kept in the lower of the two cells.
    """
    sizes = cuts.shape
    for t in range(len(triangles)):
        for axis in range(3):
            b, c = (axis + 1) % 3, (axis + 2) % 3
            p, q, r = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            area = (q[b] - p[b]) * (r[c] - p[c]) - (q[c] - p[c]) * (r[b] - p[b])
            if abs(area) < 1e-12:
                continue
            first_b = max(0, int(np.ceil(min(p[b], q[b], r[b]) - 0.5 - 1e-7)))
            last_b = min(sizes[b] - 1, int(np.floor(max(p[b], q[b], r[b]) - 0.5 + 1e-7)))
            first_c = max(0, int(np.ceil(min(p[c], q[c], r[c]) - 0.5 - 1e-7)))
            last_c = min(sizes[c] - 1, int(np.floor(max(p[c], q[c], r[c]) - 0.5 + 1e-7)))
            for i in range(first_b, last_b + 1):
                y = i + 0.5
                for j in range(first_c, last_c + 1):
                    z = j + 0.5
                    u = ((y - p[b]) * (r[c] - p[c]) - (z - p[c]) * (r[b] - p[b])) / area
                    v = ((q[b] - p[b]) * (z - p[c]) - (q[c] - p[c]) * (y - p[b])) / area
                    if u < -1e-6 or v < -1e-6 or u + v > 1 + 1e-6:
                        continue
                    along = p[axis] + u * (q[axis] - p[axis]) + v * (r[axis] - p[axis])
                    k = int(np.floor(along - 0.5))
                    if k < 0 or k >= sizes[axis]:
                        continue
                    if axis == 0:
                        cuts[k, i, j] |= 1
                    elif axis == 1:
                        cuts[j, k, i] |= 2
                    else:
                        cuts[i, j, k] |= 4


@lean_njit(cache=True, error_model="numpy")
def beyond(cuts, i, j, k, side):
    """Return the neighbour of a cell on one of its six sides, and whether the link to it is free."""
    axis, forward = side // 2, side % 2 == 1
    a, b, c = i, j, k
    step = 1 if forward else -1
    if axis == 0:
        a += step
    elif axis == 1:
        b += step
    else:
        c += step
    if a < 0 or b < 0 or c < 0 or a >= cuts.shape[0] or b >= cuts.shape[1] or c >= cuts.shape[2]:
        return a, b, c, False
    keeper = cuts[i, j, k] if forward else cuts[a, b, c]
    return a, b, c, (keeper >> axis) & 1 == 0


@lean_njit(cache=True, error_model="numpy")
def flood_links(cuts, solid, levels, links, heads):
    """Write the least height, in layers, over which each free cell is reached from the first one; -1 where it is not.

    The outermost cells are free, so that the first stands for all of them.

    Parameters
    ----------
    cuts : (X, Y, Z) uint8
        Links between cells that a surface crosses, see `cut_links`.
    solid : (X, Y, Z) bool
    levels : (X, Y, Z) int32
        All -1; receives the heights.
    links : (X * Y * Z,) int64
        Scratch, all -1: the next cell that waits at the same height.
    heads : (Z,) int64
        Scratch, all -1: the first cell that waits at each height.
    """
    nx, ny, nz = cuts.shape
    levels[0, 0, 0], heads[0] = 0, 0
    for level in range(nz):
        while heads[level] >= 0:
            cell = heads[level]
            heads[level] = links[cell]
            i, j, k = cell // (ny * nz), cell // nz % ny, cell % nz
            for side in range(6):
                a, b, c, free = beyond(cuts, i, j, k, side)
                if not free or solid[a, b, c] or levels[a, b, c] >= 0:
                    continue
                height = max(level, c)
                levels[a, b, c] = height
                neighbor = (a * ny + b) * nz + c
                links[neighbor], heads[height] = heads[height], neighbor


@lean_njit(cache=True, error_model="numpy")
def label_links(cuts, wet, labels, stack):
    """Number the bodies of wet cells that are linked, from 1; return how many there are."""
    nx, ny, nz = cuts.shape
    count = 0
    for start in range(wet.size):
        i, j, k = start // (ny * nz), start // nz % ny, start % nz
        if not wet[i, j, k] or labels[i, j, k] > 0:
            continue
        count += 1
        labels[i, j, k] = count
        stack[0], top = start, 1
        while top > 0:
            top -= 1
            cell = stack[top]
            i, j, k = cell // (ny * nz), cell // nz % ny, cell % nz
            for side in range(6):
                a, b, c, free = beyond(cuts, i, j, k, side)
                if free and wet[a, b, c] and labels[a, b, c] == 0:
                    labels[a, b, c] = count
                    stack[top] = (a * ny + b) * nz + c
                    top += 1
    return count
