"""Boxes around objects: upright, and turned about the vertical as the object is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.clouds.corners import well_within

_MANY = 3_000  # points: of fewer, the hull is as quick


@dataclass(frozen=True, kw_only=True, eq=False)
class Box:
    """A box in the level frame: two faces level, four upright."""

    center: np.ndarray  # (3,) float64, metres
    size: np.ndarray  # (3,) float64, along its own x (the longer level side), y and z, metres
    yaw: float  # of its x from the frame's, counterclockwise seen from above, radians, -pi/2 to pi/2

    @property
    def axes(self) -> np.ndarray:
        """Its own unit vectors as rows, (3, 3)."""
        cosine, sine = np.cos(self.yaw), np.sin(self.yaw)
        return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])

    @property
    def corners(self) -> np.ndarray:
        """The corners (8, 3), the lower four first, each four around, metres."""
        signs = np.array([[x, y, z] for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        return self.center + signs * self.size / 2 @ self.axes

    def lowered(self, height: float) -> Box:
        """Return the box with its lower face at a height, metres, if it is not lower already."""
        top = self.center[2] + self.size[2] / 2
        bottom = min(self.center[2] - self.size[2] / 2, height)
        center, size = self.center.copy(), self.size.copy()
        center[2], size[2] = (top + bottom) / 2, top - bottom
        return Box(center=center, size=size, yaw=self.yaw)

    def to_own(self, points: np.ndarray) -> np.ndarray:
        """Return points (N, 3) of the level frame along the box's axes from its centre."""
        return (points - self.center) @ self.axes.T


def bounding_box(points: np.ndarray) -> Box:
    """Return the upright box of least footprint around points (N, 3) of the level frame, metres.

    One of its sides runs along an edge of the convex hull, as that of least area always does.
    """
    from scipy.spatial import ConvexHull, QhullError

    places = points[:, :2]
    if len(places) > _MANY:
        places = places[~well_within(places)]
    try:
        outline = places[ConvexHull(places).vertices]
    except (QhullError, ValueError):  # in a line
        outline = places
    edges = np.roll(outline, -1, axis=0) - outline if len(outline) > 2 else np.eye(2)
    angles = np.unique(np.round(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2), 9))
    along = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    spans = [(outline @ axis.T).min(axis=0) for axis in (along, across)]
    spans += [(outline @ axis.T).max(axis=0) for axis in (along, across)]
    areas = (spans[2] - spans[0]) * (spans[3] - spans[1])
    best = int(np.argmin(np.round(areas, 9)))
    low, high = (np.array([spans[k][best], spans[k + 1][best]]) for k in (0, 2))
    return turned_box(points, low, high, along[best], across[best], angles[best])


def turned_box(
    points: np.ndarray, low: np.ndarray, high: np.ndarray, along: np.ndarray, across: np.ndarray, angle: float
) -> Box:
    """Return the box from its footprint's lowest and highest corner (2,) along two axes (2,)."""
    middle = (low + high) / 2
    bottom, top = points[:, 2].min(), points[:, 2].max()
    width, depth = high - low
    if depth > width:
        width, depth, angle = depth, width, angle - np.pi / 2 if angle > 0 else angle + np.pi / 2
    return Box(
        center=np.array([*(middle[0] * along + middle[1] * across), (bottom + top) / 2]),
        size=np.array([width, depth, top - bottom]),
        yaw=float(angle),
    )
