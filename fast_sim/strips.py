"""Drops on a large object in independent strips: faster, and on several cores.

Some thousand spheres are dropped together. The object is divided into strips across its length. The spheres that stay
in their own strip are dropped there, neighbours one after another, so that the data of one are still in the cache for
the next. Those that would leave their strip are dropped after them, in strips along the object, and the remaining ones
last. Only its own path decides whether a sphere leaves its strip, so the number of cores changes the time and nothing
else.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import NamedTuple

import numpy as np

from .dropping import drop_one
from .grid import PointGrid, SphereGrid, insert
from .kernels import entry_jit
from .nearby import Neighbourhood
from .rolling import ASTRAY, SETTLED

LARGE = 2000  # smallest number of columns of an object for which strips pay off
SHARE = 0.5  # spheres dropped together, per column: few of them come near each other
PACE = 2.0  # if less than 1 / PACE of them settle, fewer are dropped together
OF_ALL = 1 / 8  # largest share of the drops so far that are dropped together
WIDE = 100  # columns of a strip; an object with more than a quarter of it is divided into at least two
TILE = 12  # radii: side of the squares that are filled one after another
EVERYWHERE = (-np.inf, np.inf, -np.inf, np.inf)


class DropEnds(NamedTuple):
    """The results of spheres that were dropped together."""

    centers: np.ndarray  # (M, 3) final positions, metres
    outcomes: np.ndarray  # (M,) int8
    touching: np.ndarray  # (M,) bool: whether they touch the object itself


@entry_jit
def drop_in_strip(points, spheres, nearby, columns, order, radius, shape, low, high, spares, ends, outcomes, touching):
    """Drop a sphere down each of the columns (M, 2) listed in ``order``, and add those that settle to the grid.

    Parameters
    ----------
    points, spheres, nearby, columns, radius, shape, low, high
        See `drop_spheres`; ``nearby`` contains the bounds of the strip.
    order : (K,) int64
        Indices of the columns.
    spares : (M,) uint32
        A spare block for the sphere of each column; set to 0 if it was used.
    ends, outcomes, touching
        See `DropEnds`; receive the results, with the outcome `ASTRAY` for spheres that would leave the strip.
    """
    for k in order:
        x, y = columns[k, 0], columns[k, 1]
        x, y, z, outcome, on_object = drop_one(points, spheres, nearby, x, y, radius, shape, low, high)
        ends[k, 0], ends[k, 1], ends[k, 2] = x, y, z
        outcomes[k], touching[k] = outcome, on_object
        if outcome == SETTLED and insert(spheres, x, y, z, spares[k]):
            spares[k] = 0


class Strips:
    """The strips of an object, with scratch arrays for each core and spare blocks."""

    def __init__(self, spheres: SphereGrid, radius: float, nearbies: Sequence[Neighbourhood]):
        self.radius, self.low = radius, np.array([spheres.left, spheres.front])
        # A sphere reads up to 3.3 radii from where its neighbourhood was searched, and whole columns there; it settles
        # within 1.3 radii. With this margin inside their strips, no two spheres access the same column.
        self.margin = 2 * radius + spheres.cell
        self.most, self.settling = int(SHARE * spheres.nx * spheres.ny), 1.0
        self.spares = np.empty(0, np.uint32)
        self.nearbies, self.threads = nearbies, ThreadPoolExecutor(len(nearbies))  # threads start with the first task
        along_x = strip_cuts(spheres.left, spheres.cell, spheres.nx)
        along_y = strip_cuts(spheres.front, spheres.cell, spheres.ny)
        cuts = [(0, along_x), (1, along_y)] if len(along_x) >= len(along_y) else [(1, along_y), (0, along_x)]
        self.rounds = [*cuts, (0, np.empty(0))]  # axis and positions of the cuts in each round; none in the last

    def drop(self, points: PointGrid, spheres: SphereGrid, columns: np.ndarray, *how: object) -> DropEnds:
        """Drop a sphere down each of the columns (M, 2); ``how`` are the radius, the shape and the bounding box."""
        ends = DropEnds(np.empty((len(columns), 3)), np.empty(len(columns), np.int8), np.empty(len(columns), np.bool_))
        self.reserve_spares(spheres, len(columns))
        left = self.tile_order(columns)
        for axis, cuts in self.rounds:
            strips = np.searchsorted(cuts, columns[left, axis])
            orders = [left[strips == strip] for strip in range(len(cuts) + 1)]
            fill = partial(self.fill, points, spheres, columns, how, ends, self.bounds(axis, cuts), orders)
            others = [self.threads.submit(fill, core) for core in range(1, min(len(self.nearbies), len(orders)))]
            fill(0)
            for other in others:
                other.result()
            left = left[ends.outcomes[left] == ASTRAY]
        self.settling = (ends.outcomes == SETTLED).mean() if len(columns) else 1.0
        return ends

    def together(self, drops: int) -> int:
        """Return the number of spheres to drop together after a number of drops.

        Near the end of a run, when few settle, the number is small, since the run can only end after all of them.
        """
        return int(min(drops * OF_ALL, self.most * min(1.0, PACE * self.settling)))

    def bounds(self, axis: int, cuts: np.ndarray) -> np.ndarray:
        """Return the bounds of each strip, left, right, front and back (S, 4), metres."""
        bounds = np.tile(EVERYWHERE, (len(cuts) + 1, 1))
        bounds[1:, 2 * axis], bounds[:-1, 2 * axis + 1] = cuts + self.margin, cuts - self.margin
        return bounds

    def fill(
        self,
        points: PointGrid,
        spheres: SphereGrid,
        columns: np.ndarray,
        how: Sequence[object],
        ends: DropEnds,
        bounds: np.ndarray,
        orders: Sequence[np.ndarray],
        core: int,
    ):
        """Drop the spheres of all strips of one core."""
        nearby, cores = self.nearbies[core], len(self.nearbies)
        for strip in range(core, len(orders), cores):
            nearby.strip[:] = bounds[strip]
            drop_in_strip(points, spheres, nearby, columns, orders[strip], *how, self.spares, *ends)

    def reserve_spares(self, spheres: SphereGrid, count: int):
        """Reserve a block for each of a number of spheres, reusing blocks that were not needed."""
        free = self.spares[self.spares > 0]
        new = np.arange(spheres.used[0], spheres.used[0] + max(0, count - len(free)), dtype=np.uint32)
        spheres.used[0] += len(new)
        self.spares = np.concatenate([free, new])

    def tile_order(self, columns: np.ndarray) -> np.ndarray:
        """Return an order (M,) of columns (M, 2) that goes through the tiles back and forth."""
        across, along = ((columns - self.low) / (TILE * self.radius)).astype(np.int64).T
        rows = along.max(initial=0) + 1
        tiles = across * rows + np.where(across % 2, rows - 1 - along, along)
        return np.argsort(tiles.astype(np.min_scalar_type(tiles.max(initial=0))), kind="stable")


def strip_cuts(start: float, cell: float, count: int) -> np.ndarray:
    """Return the positions at which ``count`` columns along an axis are divided into strips, metres."""
    strips = max(count // WIDE, 2 if count > WIDE // 4 else 1)
    return start + cell * count / strips * np.arange(1, strips)
