"""An object as a rigid body: mass, centre of mass, and the convex hull on which it rests."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError, cKDTree

from ...clouds.cloud import Cloud
from ...clouds.thinning import one_per_cell
from ...errors import InputError, explaining
from ..mechanics import Material

CORNERS = 300  # largest number of corners of a hull; more would change results by less than a degree
THIN = 1e-4  # of the largest extent: thinner objects have no hull
PATCH = 0.01  # metres: side of the square that a point of a cloud represents
LOOSE = 0.02  # metres or, if larger, of the largest extent: distance between loose parts; a smaller gap may be a joint


@dataclass(frozen=True, eq=False)
class Body:
    """One rigid body in its cloud's frame."""

    name: str
    mass: float  # kg
    center: np.ndarray  # (3,) of mass, metres
    inertia: np.ndarray  # (3, 3) about the centre, kg m2
    corners: np.ndarray  # (V, 3) of the convex hull, metres
    notes: tuple[str, ...]

    @property
    def extent(self) -> float:
        """The largest extent of its bounding box, metres."""
        return float(np.ptp(self.corners, axis=0).max())

    def turned(self, rotation: np.ndarray) -> Body:
        """Return the body rotated (3, 3) about the origin."""
        inertia = rotation @ self.inertia @ rotation.T
        return replace(self, center=rotation @ self.center, inertia=inertia, corners=self.corners @ rotation.T)

    def loaded(self, load: float, place: np.ndarray) -> Body:
        """Return the body with a load in kg fixed at a point (3,), metres."""
        mass = self.mass + load
        center = (self.mass * self.center + load * np.asarray(place)) / mass
        inertia = self.inertia + steiner(self.mass, self.center - center) + steiner(load, place - center)
        return replace(self, mass=mass, center=center, inertia=inertia)


def body_of(cloud: Cloud, matter: Material) -> Body:
    """Return an object as a rigid body, with its mass spread evenly over its surface.

    The weight of a solid would act elsewhere, but models of objects are mostly shells, and often open ones.

    Raises
    ------
    InputError
        If it is flat, since a sheet has no hull.
    """
    triangles, notes = surface_of(cloud), []
    if triangles is None:
        points = cloud.thinned(PATCH)
        weights = np.full(len(points), PATCH**2)
        center = weights @ points / weights.sum()
        arms = points - center
        spread = np.einsum("t,ti,tj->ij", weights, arms, arms)
        notes.append("a cloud alone: what the sensor did not see has no weight")
    else:
        weights, center, spread = moments_of_triangles(triangles)
    corners = hull_corners(cloud.points if cloud.mesh is None else cloud.mesh.vertices, cloud.name)
    area = float(weights.sum())
    mass = matter.area_density * area if matter.mass is None else matter.mass
    if (parts := loose_parts(cloud)) > 1:
        notes.append(f"{parts} loose parts, taken as one rigid body")
    inertia = mass / area * (np.trace(spread) * np.eye(3) - spread)
    return Body(cloud.name, mass, center, inertia, corners, tuple(notes))


def surface_of(cloud: Cloud) -> np.ndarray | None:
    """Return the triangles (T, 3, 3) of a cloud's mesh; None if it has no mesh."""
    return None if cloud.mesh is None else cloud.mesh.vertices[cloud.mesh.faces]


def moments_of_triangles(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return areas (T,), centre (3,), and the second moment of area about it (3, 3)."""
    edges = triangles[:, 1:] - triangles[:, :1]
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
    center = areas @ triangles.mean(axis=1) / areas.sum()
    arms = triangles - center
    sums = arms.sum(axis=1)
    corners = np.einsum("t,tki,tkj->ij", areas, arms, arms)
    return areas, center, (corners + np.einsum("t,ti,tj->ij", areas, sums, sums)) / 12


def steiner(mass: float, arm: np.ndarray) -> np.ndarray:
    """Return the inertia (3, 3) of a mass at the end of an arm (3,)."""
    return mass * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))


def hull_corners(points: np.ndarray, name: str) -> np.ndarray:
    """Return the corners (V, 3) of the convex hull of points (N, 3); of many, `CORNERS` that are well apart.

    Raises
    ------
    InputError
        If the points are flat.
    """
    extent = np.ptp(points, axis=0).max()
    thickness = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[-1] / np.sqrt(len(points))
    if thickness < THIN * extent:
        raise InputError(f"{name}: expected a body, got a flat sheet, which has no thickness to lie on")
    with explaining(f"{name}: expected a body with a convex hull, got points that have none", QhullError):
        hull = ConvexHull(points)
    corners = points[np.sort(hull.vertices)]
    return corners if len(corners) <= CORNERS else corners[spread_out(corners, CORNERS)]


def spread_out(points: np.ndarray, count: int) -> np.ndarray:
    """Return the indices, ascending, of ``count`` points (N, 3), each chosen as the farthest from the previous ones."""
    chosen = [int(np.linalg.norm(points - points.mean(axis=0), axis=1).argmax())]
    distances = np.full(len(points), np.inf)
    for _ in range(count - 1):
        distances = np.minimum(distances, np.linalg.norm(points - points[chosen[-1]], axis=1))
        chosen.append(int(distances.argmax()))
    return np.sort(chosen)


def loose_parts(cloud: Cloud) -> int:
    """Return the number of separate parts of an object's surface."""
    apart = max(LOOSE, LOOSE * float(cloud.size.max()))
    cells = np.floor(one_per_cell(cloud.points, apart, cloud.bounds) * (1 / apart))
    pairs = cKDTree(cells).query_pairs(1.8, output_type="ndarray")  # a cell and the 26 around it
    return int(connected(len(cells), *pairs.T).max()) + 1


def connected(count: int, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the number of the group, from 0, of each of ``count`` items, (N,), given linked pairs (E,) of them."""
    links = coo_array((np.ones(len(one), bool), (one, other)), shape=(count, count))
    return connected_components(links, directed=False)[1]
