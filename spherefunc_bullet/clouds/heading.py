"""The heading of an object on the ground: along the narrowest rectangle around its footprint, so that turning it
about the vertical changes nothing of where spheres are dropped.
"""

from __future__ import annotations

import numpy as np

from .cloud import Cloud, Mesh
from .corners import convex_outline, well_within

SQUARE = 0.005  # radians off an axis that count as along it: such an object stays as it is, bit for bit
EDGES = 24  # of the outline, the longest: one of them lies along the narrowest rectangle, or it hardly matters which
LONGER = 1.02  # times the other side, so that the longer one is known


def heading(cloud: Cloud) -> float:
    """Return the angle, radians, by which a cloud is to be turned about z so that its footprint lies along the axes.

    The longer side comes to lie along x, and of both ways round the one with more of it beyond the middle.
    """
    return cloud.cached("heading", lambda: heading_of(cloud.points[:, :2]))


def heading_of(places: np.ndarray) -> float:
    """Return the angle for places (N, 2), metres; see `heading`."""
    corners = convex_outline(places[~well_within(places)])
    if len(corners) < 3:  # a line or a point
        return 0.0
    edges = np.roll(corners, -1, axis=0) - corners
    edges = edges[np.argsort(-np.hypot(*edges.T), kind="stable")[:EDGES]]
    angles = np.unique(np.round(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2), 6))
    axes = np.column_stack([np.cos(angles), np.sin(angles)])
    along, across = corners @ axes.T, corners @ np.column_stack([-axes[:, 1], axes[:, 0]]).T
    areas = np.ptp(along, axis=0) * np.ptp(across, axis=0)
    best = int(np.flatnonzero(areas <= areas.min() * (1 + 1e-6))[0])
    if np.ptp(along[:, best]) * LONGER < np.ptp(across[:, best]):
        return float(np.pi / 2 - angles[best])
    return float(-angles[best])


def turned(points: np.ndarray, angle: float) -> np.ndarray:
    """Return points (N, 3), or places on the ground (N, 2), turned about z by an angle, radians."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = points[:, 0], points[:, 1]
    return np.column_stack([cosine * x - sine * y, sine * x + cosine * y, points[:, 2:]])


def headed(cloud: Cloud) -> tuple[Cloud, float]:
    """Return a cloud turned to its heading, and by which angle; the cloud itself where it lies along the axes."""
    angle = heading(cloud)
    if abs(angle) < SQUARE or abs(abs(angle) - np.pi / 2) < SQUARE:
        return cloud, 0.0
    return cloud.cached("headed", lambda: turned_cloud(cloud, angle)), angle


def turned_cloud(cloud: Cloud, angle: float) -> Cloud:
    """Return a cloud, and its mesh, turned about z by an angle, radians."""
    mesh = cloud.mesh and Mesh(turned(cloud.mesh.vertices, angle), cloud.mesh.faces)
    return Cloud(turned(cloud.points, angle), cloud.name, mesh)
