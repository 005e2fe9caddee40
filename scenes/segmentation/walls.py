"""Walls and ceiling: large planes that bound a room, and are not objects."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..scans.patches import Patches
from ..settings import SCAN, SEGMENTATION


@dataclass(frozen=True, kw_only=True, eq=False)
class Wall:
    """An upright plane, and how far it reaches."""

    normal: np.ndarray  # (2,) level unit vector into the room
    offset: float  # metres: normal @ xy on the plane
    span: tuple[float, float]  # metres along the wall, from and to
    thickness: float  # metres off the plane at which a point still belongs to it

    def along(self, points: np.ndarray) -> np.ndarray:
        """Return places (N,) of points (N, 3) along the wall, metres."""
        return points[:, :2] @ np.array([-self.normal[1], self.normal[0]])

    def ahead(self, points: np.ndarray) -> np.ndarray:
        """Return distances (N,) of points (N, 3) into the room, metres, negative behind the wall."""
        return points[:, :2] @ self.normal - self.offset

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Return which points (N, 3) belong to the wall or lie behind it, (N,) bool."""
        along = self.along(points)
        beside = (along > self.span[0] - SEGMENTATION.wall_margin) & (along < self.span[1] + SEGMENTATION.wall_margin)
        return beside & (self.ahead(points) < self.thickness)


def ceiling_height(patches: Patches) -> float:
    """Return the height above which there is ceiling, metres; infinity if none is seen."""
    level = patches[np.abs(patches.normals[:, 2]) > np.cos(SCAN.aligned)]
    high = level.centers[:, 2] > SEGMENTATION.high
    if level.areas[high].sum() < SEGMENTATION.wall_area:
        return np.inf
    return float(np.median(level.centers[high, 2])) - SEGMENTATION.wall_thickness


def find_walls(points: np.ndarray, patches: Patches) -> list[Wall]:
    """Return the walls of a room, the largest first.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
        The thinned scan.
    patches : Patches
        Of the same points.
    """
    left = patches[np.abs(patches.normals[:, 2]) < np.sin(SCAN.aligned)]
    walls = []
    while len(left) >= 3:
        plane, inside = largest_plane(left)
        if left.areas[inside].sum() < SEGMENTATION.wall_area:
            break
        wall = bounding_wall(points, plane, left[inside])
        if wall is not None:
            walls.append(wall)
        left = left[~inside]
    return walls


def largest_plane(patches: Patches) -> tuple[tuple[np.ndarray, float], np.ndarray]:
    """Return normal (2,) and offset of the upright plane of most area, and which patches lie in it (P,) bool."""
    normals = patches.normals[:, :2] / np.linalg.norm(patches.normals[:, :2], axis=1)[:, None]
    places = patches.centers[:, :2]
    tried = np.argsort(-patches.areas, kind="stable")[:: max(1, len(patches) // SCAN.tried)]
    aligned = np.abs(normals[tried] @ normals.T) > np.cos(SCAN.aligned)
    offsets = (normals[tried] * places[tried]).sum(axis=1)
    near = np.abs(normals[tried] @ places.T - offsets[:, None]) < SEGMENTATION.wall_thickness
    best = int(np.argmax((aligned & near) @ patches.areas))
    inside = aligned[best] & near[best]
    centre = np.average(places[inside], axis=0, weights=patches.areas[inside])
    normal = normals[tried[best]]
    if inside.sum() >= 3:
        normal = np.linalg.eigh(np.cov(places[inside].T, aweights=patches.areas[inside]))[1][:, 0]
    return (normal, float(normal @ centre)), inside


def bounding_wall(points: np.ndarray, plane: tuple[np.ndarray, float], patches: Patches) -> Wall | None:
    """Return the wall that a plane with its patches is, or None if it is an object's side."""
    normal, offset = plane
    into = 1.0 if np.median(points[:, :2] @ normal) >= offset else -1.0
    thickness = SEGMENTATION.wall_thickness
    wall = Wall(normal=into * normal, offset=into * offset, span=(0.0, 0.0), thickness=thickness)
    low, high = np.percentile(wall.along(patches.centers), [2, 98])
    spread = 1.4826 * np.median(np.abs(wall.ahead(patches.centers))) + np.median(patches.thickness)
    wall = replace(wall, span=(float(low), float(high)), thickness=float(np.clip(3 * spread, thickness, 2 * thickness)))
    along, ahead = wall.along(points), wall.ahead(points)
    on_wall = (along > low) & (along < high) & (np.abs(ahead) < wall.thickness)
    width, top = high - low, np.percentile(points[on_wall, 2], 98) if on_wall.any() else 0.0
    if width < SEGMENTATION.wall_width or top < SEGMENTATION.wall_top:
        return None
    beside = (along > low - SEGMENTATION.wall_margin) & (along < high + SEGMENTATION.wall_margin)
    behind = np.mean(ahead[beside] < -2 * thickness)
    return wall if behind < SCAN.stray else None
