"""Surfaces of objects, and how far apart two of them are along the vertical.

Between two meshes the distance is exact: it is least where a corner of one lies over a face of the other, or where two
edges cross in plan view. A cloud without a mesh becomes a small square about each point of a flat part; other points,
such as those of a rim, count by themselves. Its distances are as accurate as its points are dense.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.clouds.raycasting import raycasting_scene, rays_from

if TYPE_CHECKING:
    from open3d.t.geometry import RaycastingScene

NEIGHBORS = 16  # of a point, which give the slope of its surface; some may be on the far side of a wall
ASIDE = 0.4  # spacings from a plane: points that are farther are on another side
FLAT, WIDE = 0.03, 0.1  # shares of the variance across a patch, at most, and along its narrower side, at least
HALF_SIDE = 0.6  # spacings, of the squares: few gaps are left between unevenly spaced points
ASKEW = np.array([0.9e-6, 0.5e-6, 0.0])  # metres, so that edges exactly over each other, as of equal cups, do not cross
ROUNDS = 50  # at most, in which edges are lifted over those that they cross
BEYOND = 1.0  # metres above or below everything, where rays begin


@dataclass(frozen=True, eq=False)
class WorldSurface:
    """A surface in the world's frame, metres."""

    points: np.ndarray  # (P, 3) places on it: corners and samples
    vertices: np.ndarray  # (V, 3)
    faces: np.ndarray  # (F, 3) of vertices
    grain: float  # spacing of the points, metres, where there is nothing else; 0 where there is a mesh

    def __getstate__(self) -> dict[str, Any]:
        return {part.name: getattr(self, part.name) for part in fields(self)}  # a ray caster goes to no other process

    @cached_property
    def edges(self) -> np.ndarray:
        """The ends (E, 2, 3) of its edges that are not vertical; none where there is no mesh."""
        if self.grain > 0:
            return np.empty((0, 2, 3))
        pairs = np.unique(np.sort(self.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
        ends = self.vertices[pairs]
        return ends[np.linalg.norm(ends[:, 1, :2] - ends[:, 0, :2], axis=1) > 1e-9]

    @cached_property
    def bounds(self) -> np.ndarray:
        """Lowest and highest corner of its box, (2, 3)."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    @cached_property
    def height(self) -> float:
        """The height of its middle, metres."""
        return float(self.bounds[:, 2].mean())

    @cached_property
    def scene(self) -> RaycastingScene:
        """Its faces, for ray casting."""
        return raycasting_scene((self.vertices, self.faces), threads=1)

    def below(self, points: np.ndarray) -> np.ndarray:
        """Return its distance below points (N, 3), metres; infinite where it is not below."""
        return self._along(points, -1.0)

    def above(self, points: np.ndarray) -> np.ndarray:
        """Return its distance above points (N, 3), metres; infinite where it is not above."""
        return self._along(points, 1.0)

    def _along(self, points: np.ndarray, way: float) -> np.ndarray:
        return self.scene.cast_rays(rays_from(points, [0.0, 0.0, way]))["t_hit"].numpy().astype(float)

    def over(self, other: WorldSurface) -> np.ndarray:
        """Return those of its points (N, 3) that lie over or under the other's box."""
        low, high = other.bounds[:, :2]
        return self.points[((self.points[:, :2] >= low) & (self.points[:, :2] <= high)).all(axis=1)]


def surface_of(cloud: Cloud) -> WorldSurface:
    """Return the surface of a cloud: its mesh, or squares about its points."""
    if cloud.mesh is None:
        vertices, faces = squares_about(cloud)
        return WorldSurface(cloud.points, vertices, faces, cloud.spacing)
    used = cloud.mesh.vertices[np.unique(cloud.mesh.faces)]
    return WorldSurface(np.concatenate([used, cloud.points]), cloud.mesh.vertices, cloud.mesh.faces, 0.0)


def squares_about(cloud: Cloud) -> tuple[np.ndarray, np.ndarray]:
    """Return a square about each point where a cloud is flat, as vertices (V, 3) and faces (F, 3).

    The far side of a wall may be as near as the next point on this side. Therefore a second plane is fitted through
    those neighbours that are near the first.
    """
    spacing = cloud.spacing
    _, near = cloud.tree.query(cloud.points, k=min(NEIGHBORS, len(cloud.points)))
    arms = cloud.points[near] - cloud.points[:, None]
    _, axes = spread(arms, np.ones(near.shape, bool))
    side = np.abs(np.einsum("nki,ni->nk", arms, axes[:, :, 0])) < ASIDE * spacing
    variances, axes = spread(arms, side)
    shares = variances / np.maximum(variances.sum(axis=1, keepdims=True), 1e-30)
    flat = (shares[:, 0] < FLAT) & (shares[:, 1] > WIDE)
    sides = HALF_SIDE * spacing * axes[flat][:, :, 1:]
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    corners = cloud.points[flat][:, None] + np.einsum("nik,ck->nci", sides, signs)
    starts = 4 * np.arange(len(corners))[:, None, None]
    return corners.reshape(-1, 3), (starts + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)


def spread(arms: np.ndarray, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the variances (N, 3), ascending, and axes (N, 3, 3) of some of the arms (N, K, 3) to neighbours."""
    some = arms * which[..., None]
    off = (arms - (some.sum(axis=1) / which.sum(axis=1)[:, None])[:, None]) * which[..., None]
    return np.linalg.eigh(np.einsum("nki,nkj->nij", off, off))


def rise_over(upper: WorldSurface, lower: WorldSurface) -> float:
    """Return how far a surface has to rise, metres, so that no place of it is below one of the other.

    Negative where it may come down; minus infinity where neither is over the other.
    """
    from_above, from_below = upper.over(lower), lower.over(upper)
    top, foot = lower.bounds[1, 2] + BEYOND, upper.bounds[0, 2] - BEYOND
    highest = top - lower.below(np.column_stack([from_above[:, :2], np.full(len(from_above), top)]))
    lowest = foot + upper.above(np.column_stack([from_below[:, :2], np.full(len(from_below), foot)]))
    rise = max((highest - from_above[:, 2]).max(initial=-np.inf), (from_below[:, 2] - lowest).max(initial=-np.inf))
    return rise if rise == -np.inf else edges_over(upper, lower, float(rise))


def edges_over(upper: WorldSurface, lower: WorldSurface, rise: float) -> float:
    """Return how far a surface has to rise so that its edges pass over the other's too: at least ``rise``, metres.

    A vertical curtain hangs from each edge of the lower surface; an edge of the upper one that meets a curtain is too
    low.
    """
    passing, hanging = upper.edges + [0, 0, rise], lower.edges
    low = np.maximum(upper.bounds[0, :2], lower.bounds[0, :2])
    high = np.minimum(upper.bounds[1, :2], lower.bounds[1, :2])
    passing = passing[within(passing, low, high) & (passing[..., 2].min(axis=1) < lower.bounds[1, 2])]
    hanging = hanging[within(hanging, low, high)]
    if not len(passing) or not len(hanging):
        return rise
    depth = np.ptp(np.concatenate([passing, hanging])[..., 2]) + BEYOND
    scene = raycasting_scene(curtains(hanging, depth), threads=1)
    start, way = passing[:, 0] + ASKEW, passing[:, 1] - passing[:, 0]
    lifted = 0.0
    for _ in range(ROUNDS):
        met = scene.cast_rays(rays_from(start + [0, 0, lifted], way))
        at = met["t_hit"].numpy().astype(float)
        crossing = at <= 1
        if not crossing.any():
            break
        places = start[crossing] + at[crossing, None] * way[crossing]
        more = heights_on(hanging[met["primitive_ids"].numpy()[crossing] // 2], places) - places[:, 2]
        if more.max() <= lifted + 1e-6:
            break
        lifted = float(more.max())
    return rise + lifted


def within(edges: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return which edges (E, 2, 3) may pass over a rectangle, (E,) bool."""
    ends = edges[..., :2]
    return ((ends.max(axis=1) >= low) & (ends.min(axis=1) <= high)).all(axis=1)


def curtains(edges: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertical sheets below edges (E, 2, 3) as vertices and faces, two for each edge."""
    corners = np.concatenate([edges, edges - [0, 0, depth]], axis=1).reshape(-1, 3)
    return corners, (4 * np.arange(len(edges))[:, None, None] + np.array([[0, 1, 3], [0, 3, 2]])).reshape(-1, 3)


def heights_on(edges: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the heights of edges (N, 2, 3) at places (N, 3) in plan view, (N,) metres; minus infinity off the edge."""
    along = edges[:, 1] - edges[:, 0]
    share = ((places - edges[:, 0])[:, :2] * along[:, :2]).sum(axis=1) / (along[:, :2] ** 2).sum(axis=1)
    return np.where(np.abs(share - 0.5) < 0.501, edges[:, 0, 2] + share * along[:, 2], -np.inf)
