"""Collision shapes of clouds: ``voxel``, ``compound`` or ``mesh``.

Voxels as boxes would turn every slope into stairs, on which spheres stay. So each occupied voxel is represented by
points of the cloud, and an alpha shape spans the surface between them, which reproduces planes exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...clouds.cloud import MAX_GAP, MIN_POINTS, PITCH, Cloud
from ...errors import InputError

VOXEL = 0.4  # of the radius
FLAT = 0.02  # radii: largest distance of a point from the plane of the points that represent it
ALPHA = 0.58  # of the radius: the sphere does not touch what this ball cannot reach in a right angle (2 - sqrt 2)
SLIVER = 0.01  # radii: width of the faces for wires and single points
MAX_FACES = 12_000_000  # the engine can hold these in some 2 GiB


@dataclass(frozen=True, kw_only=True)
class CollisionShape:
    """The shape that spheres collide with, in radii: triangles or convex pieces."""

    name: str  # of the object
    kind: str
    vertices: np.ndarray  # (N, 3) float64
    faces: np.ndarray  # (M, 3) int32
    pieces: tuple[np.ndarray, ...] | None = None  # vertices (K, 3) of convex pieces; None if the faces are the shape
    columns: np.ndarray  # (C, 3) points of the surface, dense enough to find its height under a sphere
    voxel_size: float | None = None
    gap: float | None = None

    def facts(self, radius: float) -> dict:
        """Return a description of the shape for the provenance, with lengths in metres."""
        facts = {"kind": self.kind, "faces": len(self.faces)}
        if self.pieces is not None:
            facts["pieces"] = len(self.pieces)
        for name in ("voxel_size", "gap"):
            value = getattr(self, name)
            facts[name] = None if value is None else value * radius
        return facts


def collision_shape(cloud: Cloud, radius: float, kind: str, voxel_size: float | None = None) -> CollisionShape:
    """Return the collision shape of a cloud for spheres of a radius.

    Parameters
    ----------
    cloud : Cloud
    radius : float, metres
    kind : {"voxel", "compound", "mesh"}
    voxel_size : float, metres, optional

    Raises
    ------
    InputError
        If the shape needs a mesh and there is none, or is too large for the engine.
    """
    if kind == "mesh":
        return of_mesh(cloud, radius)
    points, voxel_size, gap = thinned(cloud, radius, voxel_size)
    vertices, faces = spanned(cloud.name, points, gap if kind == "compound" else min(gap, ALPHA), gap)
    pieces = None
    if kind == "compound":
        from .pieces import convex_pieces

        pieces = tuple(convex_pieces(vertices, faces, FLAT, gap))
    return CollisionShape(
        name=cloud.name,
        kind=kind,
        vertices=vertices,
        faces=faces,
        pieces=pieces,
        columns=np.concatenate([vertices, vertices[faces].mean(axis=1)]),
        voxel_size=voxel_size,
        gap=gap,
    )


def of_mesh(cloud: Cloud, radius: float) -> CollisionShape:
    """Return the mesh that a cloud samples as a collision shape."""
    if cloud.mesh is None:
        raise InputError(f"{cloud.name}: shape 'mesh': expected an object that came as a mesh, got points; use voxel")
    return CollisionShape(
        name=cloud.name,
        kind="mesh",
        vertices=cloud.mesh.vertices / radius,
        faces=require_room(cloud.name, cloud.mesh.faces.astype(np.int32)),
        columns=cloud.points / radius,
    )


def thinned(cloud: Cloud, radius: float, voxel_size: float | None) -> tuple[np.ndarray, float | None, float]:
    """Return the points between which the surface is spanned, the voxel size (None without) and the gap, in radii.

    The gap is the largest distance from the surface to a point: the 5 mm that sampling guarantees, less for finer
    scans, more for coarser ones.
    """
    from .voxels import representatives

    points = distinct(cloud) / radius
    spacing = Cloud(points, cloud.name).spacing
    if cloud.mesh is not None:  # the nearest sample may lie on the other side of a thin wall
        spacing = max(spacing, PITCH / radius)
    gap = max(min(MAX_GAP / radius, 3 * spacing), 1.25 * spacing)
    side = VOXEL if voxel_size is None else voxel_size / radius
    if voxel_size is None and side <= 1.5 * spacing:
        return points, None, gap
    return representatives(points, side, FLAT), side, side + gap


def distinct(cloud: Cloud) -> np.ndarray:
    """Return the points (N, 3) without duplicates, sorted by coordinates, metres.

    Raises
    ------
    InputError
        If too few are left.
    """
    points = cloud.points[np.lexsort(cloud.points.T[::-1])]
    points = points[np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))]
    if len(points) < MIN_POINTS:
        raise InputError(
            f"{cloud.name}: expected at least {MIN_POINTS} different points, got {len(points)} among {len(cloud)}"
        )
    return points


def spanned(name: str, points: np.ndarray, alpha: float, gap: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices (N, 3) and faces (M, 3) between points, with slivers at single points and rows of points."""
    from .triangulation import faces_between

    faces = require_room(name, faces_between(points, alpha, gap))
    return with_slivers(points, faces, gap)


def with_slivers(points: np.ndarray, faces: np.ndarray, gap: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points and faces, with slivers added between each point without a face and its two nearest neighbours."""
    bare = np.setdiff1d(np.arange(len(points)), faces)
    if not len(bare):
        return points, faces
    from scipy.spatial import cKDTree

    distances, near = cKDTree(points).query(points[bare], k=3)
    widths = points[bare] + [0, 0, -SLIVER], points[bare] + [SLIVER, 0, 0]
    third = len(points) + np.arange(2 * len(bare)).reshape(2, -1)
    slivers = [np.column_stack([bare, third[0], third[1]])]
    for k in (1, 2):
        linked = distances[:, k] <= 2 * gap
        slivers += [np.column_stack([bare, near[:, k], corner])[linked] for corner in third]
    return np.concatenate([points, *widths]), np.concatenate([faces, *slivers]).astype(np.int32)


def require_room(name: str, faces: np.ndarray) -> np.ndarray:
    """Return the faces, or raise InputError if there are too many for the engine."""
    if len(faces) > MAX_FACES:
        raise InputError(
            f"{name}: expected a shape of at most {MAX_FACES:,} faces, got {len(faces):,}; use a larger radius"
        )
    return faces
