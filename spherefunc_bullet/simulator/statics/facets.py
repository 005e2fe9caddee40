"""The facets of a body's convex hull: on which it can rest, and to which it rolls from the others.

A pose up to turns about the vertical is the direction that points down, a unit vector in the body's frame. Resting on a
facet, its outward normal points down, and the centre of mass is as high as the facet is far from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull

from .body import Body

TURN_DEG = 35.0  # between neighbouring poses of one way to lie: a prism of eleven sides is round
SILL = 0.04  # of the height of the centre of mass: how much it may rise between them
TOUCH = 1e-6  # of the extent: by how much a weight may act beyond an edge through rounding


@dataclass(frozen=True, eq=False)
class Facets:
    """The triangles of a hull, about the body's centre of mass, lengths in the body's largest extent."""

    corners: np.ndarray  # (V, 3)
    triangles: np.ndarray  # (F, 3) of corners
    neighbors: np.ndarray  # (F, 3) of facets; the one across the edge opposite each corner
    normals: np.ndarray  # (F, 3) outward
    heights: np.ndarray  # (F,) of the centre of mass when it rests on each

    @cached_property
    def beyond(self) -> np.ndarray:
        """How far the weight acts beyond each edge of the facet it rests on, (F, 3); below 0 within."""
        across = [self._outward(side) for side in range(3)]
        return np.stack([np.einsum("fi,fi->f", out, -start) for start, out in across], axis=1)

    def _outward(self, side: int) -> tuple[np.ndarray, np.ndarray]:
        """Return a point of the edge opposite a corner, and the unit vector in the facet that leaves it there."""
        start, end, apex = (self.corners[self.triangles[:, (side + k) % 3]] for k in (1, 2, 0))
        out = np.cross(end - start, self.normals)
        out *= np.sign(np.einsum("fi,fi->f", out, start - apex))[:, None]
        return start, out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-300)

    @cached_property
    def rests_on(self) -> np.ndarray:
        """To which facet a body rolls from each, (F,); itself where it rests."""
        rows = np.arange(len(self.heights))
        side = self.beyond.argmax(axis=1)
        following = self.neighbors[rows, side]
        rolls = (self.beyond[rows, side] > TOUCH) & (self.heights[following] < self.heights - 1e-12)
        target = np.where(rolls, following, rows)
        for _ in range(int(np.ceil(np.log2(len(rows) + 1)))):
            target = target[target]
        return target

    @cached_property
    def stable(self) -> np.ndarray:
        """The facets on which the body rests."""
        return np.unique(self.rests_on)

    @cached_property
    def sills(self) -> np.ndarray:
        """The height of the centre of mass on the way over each edge, (F, 3)."""
        heights = np.empty_like(self.beyond)
        for side in range(3):
            start, end = (self.corners[self.triangles[:, (side + k) % 3]] for k in (1, 2))
            along = end - start
            along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
            arm = start - np.einsum("fi,fi->f", start, along)[:, None] * along
            here, there = self.normals, self.normals[self.neighbors[:, side]]
            turn, before, after = (np.einsum("fi,fi->f", np.cross(a, b), along) for a, b in
                                   ((here, there), (here, arm), (arm, there)))
            between = (before * turn > 0) & (after * turn > 0)
            ends = np.maximum(self.heights, self.heights[self.neighbors[:, side]])
            heights[:, side] = np.where(between, np.linalg.norm(arm, axis=1), ends)
        return heights

    @cached_property
    def ways(self) -> np.ndarray:
        """The number of the way to lie that each facet leads to, (F,): facets between which it rolls at a touch."""
        here = np.repeat(np.arange(len(self.heights)), 3)
        there = self.neighbors.ravel()
        one, other = self.rests_on[here], self.rests_on[there]
        turn = np.einsum("ei,ei->e", self.normals[one], self.normals[other])
        lower = np.minimum(self.heights[one], self.heights[other])
        rise = self.sills.ravel() - lower  # from the lower one: no chain of ledges leads from upright to lying
        alike = (turn > np.cos(np.radians(TURN_DEG))) & (rise < SILL * lower)
        count = len(self.heights)
        links = coo_array((np.ones(alike.sum(), bool), (one[alike], other[alike])), shape=(count, count))
        return connected_components(links, directed=False)[1][self.rests_on]

    def lowest(self, way: int) -> int:
        """Return the facet of a way to lie on which the centre of mass is lowest, of equal ones the first."""
        own = self.stable[self.ways[self.stable] == way]
        return int(own[np.round(self.heights[own], 6).argmin()])

    def nearest(self, down: np.ndarray) -> np.ndarray:
        """Return the resting facet whose normal is nearest to each direction (N, 3) that points down."""
        return self.stable[(down @ self.normals[self.stable].T).argmax(axis=1)]

    def pierced(self, down: np.ndarray) -> np.ndarray:
        """Return the facet that each direction (N, 3) from the centre of mass goes through."""
        reach = self.heights / np.maximum(down @ self.normals.T, 1e-300)
        return np.where(down @ self.normals.T > 1e-12, reach, np.inf).argmin(axis=1)

    def solid_angles(self) -> np.ndarray:
        """Return the share of all directions from the centre of mass that each facet takes, (F,)."""
        a, b, c = (self.corners[self.triangles[:, k]] for k in range(3))
        la, lb, lc = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
        ab, bc, ca = (np.einsum("fi,fi->f", *pair) for pair in ((a, b), (b, c), (c, a)))
        volume = np.abs(np.einsum("fi,fi->f", a, np.cross(b, c)))
        return 2 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb) / (4 * np.pi)


def facets_of(body: Body) -> Facets:
    """Return the facets of a body's hull."""
    corners = (body.corners - body.center) / body.extent
    hull = ConvexHull(corners)
    return Facets(corners, hull.simplices, hull.neighbors, hull.equations[:, :3], -hull.equations[:, 3])
