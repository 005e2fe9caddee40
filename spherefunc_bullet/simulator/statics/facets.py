"""The facets of a body's convex hull: those on which it can rest, and those to which it rolls from the others.

A pose, up to a rotation about the vertical, is given by the direction that points down, a unit vector in the body's
frame. If a body rests on a facet, the outward normal of the facet points down, and the height of the centre of mass is
its distance from the facet.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull

from ...clouds.preparation import rotation_to_z
from ..mechanics import Pose, PoseSettings
from .body import Body, connected

TURN_DEG = 35.0  # largest angle between neighbouring facets of one pose: a prism with eleven sides counts as round
SILL = 0.04  # of the height of the centre of mass: largest rise between them
TOUCH = 1e-6  # of the extent: tolerance for a weight that acts beyond an edge due to rounding
AWAY_DEG = 3.0  # smallest angle from all facets on which a body could rest at which it is balanced, not at rest
BUMP = 0.02  # of the extent: largest rise of the centre of mass between neighbouring facets of a round bottom


@dataclass(frozen=True, eq=False)
class Facets:
    """The triangles of a hull, about the body's centre of mass, with lengths in units of the body's largest extent."""

    corners: np.ndarray  # (V, 3)
    triangles: np.ndarray  # (F, 3) of corners
    neighbors: np.ndarray  # (F, 3) of facets; the one across the edge opposite each corner
    normals: np.ndarray  # (F, 3) outward
    heights: np.ndarray  # (F,) of the centre of mass when the body rests on each facet

    @cached_property
    def beyond(self) -> np.ndarray:
        """How far the weight acts beyond each edge of the facet on which the body rests, (F, 3); negative inside."""
        beyond = np.empty(self.triangles.shape)
        for side in range(3):
            start, end, apex = (self.corners[self.triangles[:, (side + k) % 3]] for k in (1, 2, 0))
            out = np.cross(end - start, self.normals)  # in the facet, across the edge opposite the apex
            out *= np.sign(np.einsum("fi,fi->f", out, start - apex))[:, None]
            out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-300)
            beyond[:, side] = np.einsum("fi,fi->f", out, -start)
        return beyond

    @cached_property
    def faces(self) -> np.ndarray:
        """The number of the flat face of the hull that contains each facet, (F,)."""
        here, there = np.repeat(np.arange(len(self.heights)), 3), self.neighbors.ravel()
        coplanar = np.abs(self.normals[here] - self.normals[there]).max(axis=1) < TOUCH
        coplanar &= np.abs(self.heights[here] - self.heights[there]) < TOUCH
        return connected(len(self.heights), here[coplanar], there[coplanar])

    @cached_property
    def face_areas(self) -> np.ndarray:
        """The area of each face, by its number."""
        a, b, c = (self.corners[self.triangles[:, k]] for k in range(3))
        return np.bincount(self.faces, weights=np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)

    @cached_property
    def rests_on(self) -> np.ndarray:
        """The facet to which a body rolls from each facet, (F,); the facet itself if the body rests on it.

        A body rolls over the edges of a whole face, not over those between its facets: a weight that acts beyond one
        half of a square foot may act within the other half, and one beyond the foot is held by neither.
        """
        rows = np.arange(len(self.heights))
        inner = self.faces[self.neighbors] == self.faces[:, None]
        beyond = np.where(inner, -np.inf, self.beyond)
        by_face = np.lexsort((-beyond.max(axis=1), self.faces))
        _, first = np.unique(self.faces[by_face], return_index=True)
        edge_of = by_face[first][
            self.faces
        ]  # the facet of each face with the edge beyond which the weight acts farthest
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
        """The largest height of the centre of mass when the body rolls over each edge, (F, 3)."""
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
        """The number of the pose to which each facet leads, (F,); a body rolls easily within a pose."""
        one, other, rise, lower = self._steps
        alike = rise < SILL * lower
        return connected(len(self.heights), one[alike], other[alike])[self.rests_on]

    @cached_property
    def bottoms(self) -> np.ndarray:
        """The number of the round bottom to which each facet leads, (F,), if it is one that a mesh approximates.

        The bumps between the facets of a round bottom are small compared to the object, however shallow it is.
        """
        one, other, rise, _ = self._steps
        return connected(len(self.heights), one[rise < BUMP], other[rise < BUMP])[self.rests_on]

    @cached_property
    def _steps(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The pairs (E,) of resting facets connected by a small rotation, the rise on the way, and the lower height.

        The rise is relative to the lower facet, so that no chain of ledges leads from upright to lying.
        """
        here, there = np.repeat(np.arange(len(self.heights)), 3), self.neighbors.ravel()
        one, other = self.rests_on[here], self.rests_on[there]
        lower = np.minimum(self.heights[one], self.heights[other])
        near = np.einsum("ei,ei->e", self.normals[one], self.normals[other]) > np.cos(np.radians(TURN_DEG))
        return one[near], other[near], (self.sills.ravel() - lower)[near], lower[near]

    def lowest(self, number: int) -> int:
        """Return the facet of a pose with the lowest centre of mass, the first of equal ones."""
        of_pose = self.stable[self.pose_numbers[self.stable] == number]
        return int(of_pose[np.round(self.heights[of_pose], 6).argmin()])

    def nearest(self, down: np.ndarray) -> np.ndarray:
        """Return the resting facet whose normal is nearest to each downward direction (N, 3)."""
        return self.stable[(down @ self.normals[self.stable].T).argmax(axis=1)]

    def pierced(self, down: np.ndarray) -> np.ndarray:
        """Return the facet that a ray from the centre of mass in each direction (N, 3) hits."""
        reach = self.heights / np.maximum(down @ self.normals.T, 1e-300)
        return np.where(down @ self.normals.T > 1e-12, reach, np.inf).argmin(axis=1)

    def solid_angles(self) -> np.ndarray:
        """Return the share of the full solid angle that each facet covers, seen from the centre of mass, (F,)."""
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


def stable_poses(facets: Facets, settings: PoseSettings, counts: np.ndarray | None = None) -> tuple[Pose, ...]:
    """Return the poses that are likely enough, the most probable first.

    Parameters
    ----------
    counts : (W,) float, optional
        Share of an engine's drops that ended in each pose; by default the probabilities are those of statics.
    """
    statics = np.bincount(facets.pose_numbers, weights=facets.solid_angles())
    shares, poses = statics if counts is None else counts, []
    for number in np.unique(facets.pose_numbers[facets.stable]):
        if max(shares[number], statics[number]) >= settings.least:
            rotation = turned_down(facets.normals[facets.lowest(number)])
            poses.append(Pose(rotation=rotation, probability=float(shares[number]), statics=float(statics[number])))
    return tuple(sorted(poses, key=lambda pose: (-round(pose.probability, 9), -round(pose.statics, 9))))


def share_of_rests(facets: Facets, down: np.ndarray) -> np.ndarray:
    """Return the share (W,) of downward directions (N, 3) of a body at rest that belongs to each pose."""
    pose_numbers = facets.pose_numbers[facets.nearest(down)] if len(down) else np.empty(0, np.int64)
    return np.bincount(pose_numbers, minlength=facets.pose_numbers.max() + 1) / max(1, len(down))


def at_rest(facets: Facets, down: np.ndarray) -> np.ndarray:
    """Return whether a body with each downward direction (N, 3) rests, and is not just balanced, (N,) bool.

    Rolling friction may hold a round body between two of its facets, hardly higher than on either.
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
