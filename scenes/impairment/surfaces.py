"""The surface of an object as its file has it: triangles in any order, open or closed, of any winding, or points alone.

Half of the models that people make are not watertight, so nothing here depends on an inside. Before a part of a surface
is removed, long triangles are halved until each piece is small enough to be wholly inside or outside of that part.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import trimesh

from spherefunc_bullet.clouds.cloud import Cloud, placed
from spherefunc_bullet.clouds.outline import merge_vertices

CELLS = 48  # across the longer side of a footprint
PIECE = 0.7  # of a cell, the longest edge of a piece: then the piece over a cell's middle has its centre in the cell
SPACINGS = 2.5  # of a cloud's points to a cell, so that few cells of a surface have no point


@dataclass(frozen=True, eq=False)
class ObjectSurface:
    """An object in metres, z up: triangles, or points where there are none."""

    triangles: np.ndarray = field(default_factory=lambda: np.empty((0, 3, 3)))  # (T, 3, 3)
    points: np.ndarray | None = None  # (N, 3), of a cloud

    @property
    def is_cloud(self) -> bool:
        """Whether it has points alone."""
        return self.points is not None

    @cached_property
    def vertices(self) -> np.ndarray:
        """All corners, or the points, (N, 3)."""
        return self.points if self.is_cloud else self.triangles.reshape(-1, 3)

    @cached_property
    def bounds(self) -> np.ndarray:
        """Lowest and highest corner, (2, 3)."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def size(self) -> np.ndarray:
        """Extents, (3,)."""
        return self.bounds[1] - self.bounds[0]

    @cached_property
    def cell(self) -> float:
        """Side of the cells in which levels and cavities are searched, metres."""
        side = max(self.size[:2].max() / CELLS, 1e-4)
        return max(side, SPACINGS * Cloud(self.points).spacing) if self.is_cloud else side

    @cached_property
    def _halved(self) -> tuple[np.ndarray, np.ndarray]:
        return halved(self.triangles, PIECE * self.cell)

    @property
    def pieces(self) -> np.ndarray:
        """The triangles in pieces smaller than a cell, (P, 3, 3)."""
        return self._halved[0]

    @property
    def owners(self) -> np.ndarray:
        """The triangle that each piece is part of, (P,)."""
        return self._halved[1]

    @cached_property
    def centres(self) -> np.ndarray:
        """The centre of each piece (P, 3), or the points."""
        return self.points if self.is_cloud else sum(self.pieces[:, k] for k in range(3)) / 3

    def without(self, gone: np.ndarray) -> ObjectSurface:
        """Return the surface without some of its pieces, (P,) bool; triangles that lose no piece stay whole."""
        if self.is_cloud:
            return ObjectSurface(points=self.points[~gone])
        touched = np.zeros(len(self.triangles), bool)
        touched[self.owners[gone]] = True
        return ObjectSurface(np.concatenate([self.triangles[~touched], self.pieces[touched[self.owners] & ~gone]]))

    def only(self, kept: np.ndarray) -> ObjectSurface:
        """Return some of the pieces alone, (P,) bool."""
        return ObjectSurface(points=self.points[kept]) if self.is_cloud else ObjectSurface(self.pieces[kept])

    def joined(self, other: ObjectSurface) -> ObjectSurface:
        """Return both surfaces as one."""
        if self.is_cloud:
            return ObjectSurface(points=np.concatenate([self.points, other.points]))
        return ObjectSurface(np.concatenate([self.triangles, other.triangles]))

    def mapped(self, change: Callable[[np.ndarray], np.ndarray]) -> ObjectSurface:
        """Return the surface with a function of points (N, 3) applied to each corner."""
        moved = change(self.vertices)
        return ObjectSurface(points=moved) if self.is_cloud else ObjectSurface(moved.reshape(-1, 3, 3))

    def standing(self) -> ObjectSurface:
        """Return it moved to the ground, its bounding box centred on the z axis."""
        return self.mapped(placed)

    def sampled(self, count: int, seed: int) -> ObjectSurface:
        """Return points at random on the triangles, evenly by area; a cloud as it is."""
        if self.is_cloud:
            return self
        triangles = trimesh.Trimesh(*self.mesh(), process=False)
        return ObjectSurface(points=trimesh.sample.sample_surface(triangles, count, seed=seed)[0])

    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Return vertices (N, 3) and faces (M, 3), equal corners merged; a cloud has no faces."""
        if self.is_cloud:
            return self.points, np.empty((0, 3), np.int64)
        return merge_vertices(self.vertices, np.arange(len(self.vertices)).reshape(-1, 3))


def surface_of(cloud: Cloud) -> ObjectSurface:
    """Return the surface of a cloud's mesh, or of its points where it has none."""
    if cloud.mesh is None:
        return ObjectSurface(points=cloud.points)
    return ObjectSurface(cloud.mesh.vertices[cloud.mesh.faces])


def halved(triangles: np.ndarray, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """Return triangles (P, 3, 3) halved across their longest edge until none is longer, and whose each was (P,).

    Halves of slivers are fewer than quarters would be.
    """
    done, owners, left, whose = [], [], triangles, np.arange(len(triangles))
    while len(left):
        edges = np.stack([distances(left[:, k], left[:, (k + 1) % 3]) for k in range(3)])
        small = edges.max(axis=0) <= longest
        done.append(left[small])
        owners.append(whose[small])
        large = np.flatnonzero(~small)
        corners, whose, first = left.reshape(-1, 3), whose[large], edges[:, large].argmax(axis=0)
        a, b, c = (corners[3 * large + (first + step) % 3] for step in range(3))
        middle = (a + b) / 2
        left = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        whose = np.concatenate([whose, whose])
    return (np.concatenate(done), np.concatenate(owners)) if done else (triangles, np.arange(len(triangles)))


def distances(places: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the distance of each place (N, 3) from its partner; by columns, which is faster than by rows."""
    squares = (places - others) ** 2
    return np.sqrt(squares[:, 0] + squares[:, 1] + squares[:, 2])
