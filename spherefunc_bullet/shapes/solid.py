"""Solids: the shape of an object in an engine, either convex pieces, which are solid, or a surface of triangles."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ..formats.sources import joined_meshes
from ..processes.compilation import njit

THIN = 1e-4  # of the extent: thickness given to flat pieces, to which engines add a margin
MOST_CORNERS = 64  # of a convex piece: an engine visits all of them in every contact, and fewer would leave gaps
STL_HEAD, STL_FACE = 84, 50  # bytes of a binary STL


@dataclass(frozen=True, kw_only=True, eq=False)
class Solid:
    """A collision shape, metres, in the frame of the object's cloud."""

    name: str
    vertices: np.ndarray  # (N, 3) float64, of all hulls together, or of the surface
    faces: np.ndarray  # (M, 3) int64
    pieces: tuple[np.ndarray, ...] | None  # corners (K, 3) of convex pieces; None for a surface
    build_seconds: float = 0.0

    @property
    def bytes(self) -> int:
        """Its size as binary STL."""
        return STL_HEAD + STL_FACE * len(self.faces)

    def shifted(self, by: np.ndarray) -> Solid:
        """Return the shape moved by a vector (3,), metres."""
        pieces = None if self.pieces is None else tuple(piece + by for piece in self.pieces)
        return replace(self, vertices=self.vertices + by, pieces=pieces)

    @property
    def count(self) -> int:
        """Number of bodies that the engine tests for contact; 1 for a surface."""
        return 1 if self.pieces is None else len(self.pieces)


def surface(name: str, vertices: np.ndarray, faces: np.ndarray) -> Solid:
    """Return a surface of triangles, which may be concave."""
    return Solid(name=name, vertices=vertices, faces=faces, pieces=None)


def of_pieces(name: str, pieces: Iterable[np.ndarray]) -> Solid:
    """Return the convex hulls of several sets of points (K, 3)."""
    hulls = [hull_of(piece) for piece in pieces]
    vertices, faces = joined_meshes(hulls)
    return Solid(name=name, vertices=vertices, faces=faces, pieces=tuple(corners for corners, _ in hulls))


def hull_of(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners (K, 3) of a convex hull and its faces (F, 3), counterclockwise seen from outside."""
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):  # flat, or fewer than four points
        points = thickened(points)
        hull = ConvexHull(points, qhull_options="QJ")
    corners = np.sort(hull.vertices)
    number = np.zeros(len(points), np.int64)
    number[corners] = np.arange(len(corners))
    triangles = points[hull.simplices]
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inward = (across * hull.equations[:, :3]).sum(axis=1) < 0
    faces = number[hull.simplices]
    faces[inward] = faces[inward][:, ::-1]
    return points[corners], faces


def capped(points: np.ndarray, off: float = 0.0, most: int = MOST_CORNERS) -> np.ndarray:
    """Return at most ``most`` corners (K, 3) of a hull, each the farthest outside the hull of those already chosen.

    The hull of fewer corners lies within that of all, so it takes no free space. Corners that are outside by no more
    than ``off`` metres are dropped as well.
    """
    corners, _ = hull_of(points)
    span = np.vstack([np.eye(3), 1 - 2 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])])
    heights = corners @ span.T
    chosen = set(heights.argmin(axis=0).tolist()) | set(heights.argmax(axis=0).tolist())
    chosen |= set(range(4 if len(chosen) < 4 else 0))  # three corners of a slanted sliver may be extreme on all axes
    while len(chosen) < min(most, len(corners)):
        equations = ConvexHull(corners[sorted(chosen)], qhull_options="QJ").equations
        outside = (corners @ equations[:, :3].T + equations[:, 3]).max(axis=1)
        outside[sorted(chosen)] = 0
        if outside.max() <= off:
            break
        chosen.add(int(outside.argmax()))
    return corners[sorted(chosen)]


def thickened(points: np.ndarray) -> np.ndarray:
    """Return flat points doubled, moved slightly to both sides in the directions in which they have no extent."""
    middle = points - points.mean(axis=0)
    thin = THIN * max(float(np.abs(middle).max()), 1e-6)
    _, sizes, axes = np.linalg.svd(np.vstack([middle, np.zeros((3, 3))]), full_matrices=False)
    for size, axis in zip(sizes, axes, strict=True):
        if size <= thin * np.sqrt(len(middle)):
            points = np.vstack([points - thin * axis, points + thin * axis])
    return points


MOST = 6_000_000  # points; with more, they are farther apart


def dense_points(solid: Solid, gap: float) -> np.ndarray:
    """Return points (N, 3) on triangles, with their corners, in rows along the longest edges, at most ``gap`` apart."""
    corners = np.asarray(solid.vertices, dtype=np.float64)[solid.faces]
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    turn = (edges.argmax(axis=1)[:, None] + np.arange(3)) % 3
    corners = np.ascontiguousarray(np.take_along_axis(corners, turn[:, :, None], axis=1))
    longest = np.maximum(edges.max(axis=1), 1e-12)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    heights = np.linalg.norm(across, axis=1) / longest
    while (count := fill(corners, longest / gap, heights / gap, np.empty((0, 3)))) > MOST and gap < longest.max():
        gap *= 1.1 * np.sqrt(count / MOST)
    points = np.empty((count, 3))
    fill(corners, longest / gap, heights / gap, points)
    return points


@njit(cache=True, error_model="numpy")
def fill(corners, lengths, heights, out):
    """Write rows of points on triangles whose first edge is the longest; return their number.

    Lengths and heights are in units of the gap.
    """
    n = 0
    for t in range(len(corners)):
        rows = max(1, int(np.ceil(heights[t])))
        for j in range(rows + 1):
            up = j / rows
            steps = max(1 if j < rows else 0, int(np.ceil(lengths[t] * (1 - up))))
            for i in range(steps + 1):
                if n < len(out):
                    along = (1 - up) * i / max(1, steps)
                    for axis in range(3):
                        first = corners[t, 0, axis]
                        side, apex = corners[t, 1, axis] - first, corners[t, 2, axis] - first
                        out[n, axis] = first + along * side + up * apex
                n += 1
    return n
