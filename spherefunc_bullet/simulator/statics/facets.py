"""The facets of a body's convex hull: on which it can rest, and to which it rolls from the others.

A pose up to turns about the vertical is the direction that points down, a unit vector in the body's frame. Resting on a
facet, its outward normal points down, and the centre of mass is as high as the facet is far from it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull

from ...clouds.preparation import rotation_to_z
from ..mechanics import Pose, PoseSettings
from .body import Body

TURN_DEG = 35.0  # between neighbouring poses of one way to lie: a prism of eleven sides is round
SILL = 0.04  # of the height of the centre of mass: how much it may rise between them
TOUCH = 1e-6  # of the extent: by how much a weight may act beyond an edge through rounding
BUMP = 0.02  # of the extent: how much the centre of mass rises at most between neighbouring facets of a round bottom


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
    def faces(self) -> np.ndarray:
        """The number of the flat face of the hull that each facet is a part of, (F,)."""
        here, there = np.repeat(np.arange(len(self.heights)), 3), self.neighbors.ravel()
        coplanar = np.abs(self.normals[here] - self.normals[there]).max(axis=1) < TOUCH
        coplanar &= np.abs(self.heights[here] - self.heights[there]) < TOUCH
        return self._joined(here[coplanar], there[coplanar])

    @cached_property
    def face_areas(self) -> np.ndarray:
        """The area of each face, by its number."""
        a, b, c = (self.corners[self.triangles[:, k]] for k in range(3))
        return np.bincount(self.faces, weights=np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)

    @cached_property
    def rests_on(self) -> np.ndarray:
        """To which facet a body rolls from each, (F,); itself where it rests.

        It rolls over the edges of a whole face. Within it, every facet is as good as another: a weight that acts beyond
        one part of a square foot may act within the other part, and one that acts beyond the foot holds on neither.
        """
        rows = np.arange(len(self.heights))
        inner = self.faces[self.neighbors] == self.faces[:, None]
        beyond = np.where(inner, -np.inf, self.beyond)
        by_face = np.lexsort((-beyond.max(axis=1), self.faces))
        _, first = np.unique(self.faces[by_face], return_index=True)
        edge_of = by_face[first][self.faces]  # the facet at the edge of its face beyond which the weight acts farthest
        side = beyond[edge_of].argmax(axis=1)
        following = self.neighbors[edge_of, side]
        rolls = (beyond[edge_of, side] > TOUCH) & (self.heights[following] < self.heights - 1e-12)
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
            turn, before, after = (
                np.einsum("fi,fi->f", np.cross(a, b), along) for a, b in ((here, there), (here, arm), (arm, there))
            )
            between = (before * turn > 0) & (after * turn > 0)
            ends = np.maximum(self.heights, self.heights[self.neighbors[:, side]])
            heights[:, side] = np.where(between, np.linalg.norm(arm, axis=1), ends)
        return heights

    @cached_property
    def pose_numbers(self) -> np.ndarray:
        """The number of the way to lie that each facet leads to, (F,): facets between which it rolls at a touch."""
        one, other, rise, lower = self._steps
        alike = rise < SILL * lower
        return self._joined(one[alike], other[alike])[self.rests_on]

    @cached_property
    def bottoms(self) -> np.ndarray:
        """The number of the round bottom that each facet leads to, (F,), if it is one: what a mesh makes facets of.

        The bumps between facets of a round bottom are small against the whole object, however shallow it is.
        """
        one, other, rise, _ = self._steps
        return self._joined(one[rise < BUMP], other[rise < BUMP])[self.rests_on]

    @cached_property
    def _steps(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The pairs (E,) of resting facets that a small turn leads from and to, the rise on the way, the lower height.

        The rise is from the lower one: no chain of ledges leads from upright to lying.
        """
        here, there = np.repeat(np.arange(len(self.heights)), 3), self.neighbors.ravel()
        one, other = self.rests_on[here], self.rests_on[there]
        lower = np.minimum(self.heights[one], self.heights[other])
        near = np.einsum("ei,ei->e", self.normals[one], self.normals[other]) > np.cos(np.radians(TURN_DEG))
        return one[near], other[near], (self.sills.ravel() - lower)[near], lower[near]

    def _joined(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Return in which group each facet is, (F,), when pairs (E,) of them are of one group."""
        count = len(self.heights)
        links = coo_array((np.ones(len(one), bool), (one, other)), shape=(count, count))
        return connected_components(links, directed=False)[1]

    def lowest(self, number: int) -> int:
        """Return the facet of a way to lie on which the centre of mass is lowest, of equal ones the first."""
        of_pose = self.stable[self.pose_numbers[self.stable] == number]
        return int(of_pose[np.round(self.heights[of_pose], 6).argmin()])

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

    def about(self, shift: np.ndarray) -> Facets:
        """Return the facets of the same hull about a centre of mass that is shifted by (3,), in extents."""
        return replace(self, corners=self.corners - shift, heights=self.heights - self.normals @ shift)


def facets_of(body: Body) -> Facets:
    """Return the facets of a body's hull."""
    corners = (body.corners - body.center) / body.extent
    hull = ConvexHull(corners)
    return Facets(corners, hull.simplices, hull.neighbors, hull.equations[:, :3], -hull.equations[:, 3])


AWAY_DEG = 3.0  # from every facet it could rest on: a body that is still so far off is balanced, not at rest


def stable_poses(facets: Facets, settings: PoseSettings, counts: np.ndarray | None = None) -> tuple[Pose, ...]:
    """Return the poses that are likely enough, the likeliest first.

    Parameters
    ----------
    counts : (W,) float, optional
        Share of an engine's drops that ended in each way to lie; without it statics is the answer.
    """
    statics = np.bincount(facets.pose_numbers, weights=facets.solid_angles())
    shares = statics if counts is None else counts
    likely = [
        number
        for number in np.unique(facets.pose_numbers[facets.stable])
        if max(shares[number], statics[number]) >= settings.least
    ]
    poses = [
        Pose(
            rotation=turned_down(facets.normals[facets.lowest(number)]),
            probability=float(shares[number]),
            statics=float(statics[number]),
        )
        for number in likely
    ]
    return tuple(sorted(poses, key=lambda pose: (-round(pose.probability, 9), -round(pose.statics, 9))))


def share_of_rests(facets: Facets, down: np.ndarray) -> np.ndarray:
    """Return in which share of rests, directions (N, 3) that point down, a body lay in each way, (W,)."""
    pose_numbers = facets.pose_numbers[facets.nearest(down)] if len(down) else np.empty(0, np.int64)
    return np.bincount(pose_numbers, minlength=facets.pose_numbers.max() + 1) / max(1, len(down))


def at_rest(facets: Facets, down: np.ndarray) -> np.ndarray:
    """Return which directions (N, 3) that point down are those of a body that rests and is not balanced, (N,) bool.

    What is round may be held between two of its facets, by friction of rolling, hardly higher than on either.
    """
    nearest = facets.nearest(down)
    turn = np.einsum("ni,ni->n", down, facets.normals[nearest])
    rise = (down @ facets.corners.T).max(axis=1) - facets.heights[nearest]
    between = (turn > np.cos(np.radians(TURN_DEG / 2))) & (rise < SILL * facets.heights[nearest])
    return between | (turn > np.cos(np.radians(AWAY_DEG)))


def turned_down(down: np.ndarray) -> np.ndarray:
    """Return the shortest rotation (3, 3) after which a direction (3,) points down.

    Examples
    --------
    >>> turned_down(np.array([0.0, 0.0, -1.0])).tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    up = -np.asarray(down, float)
    if up[2] < -1 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    return rotation_to_z(up) + 0.0
