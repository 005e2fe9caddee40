"""From a cloud to what spheres can collide with: ``voxel``, ``compound`` or ``mesh``.

A voxel as a box would turn every slope into stairs, on which spheres stand. So the occupied voxels are represented
by points of the cloud, and the surface between those is spanned by the alpha complex, which meets planes exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...clouds.cloud import MAX_GAP, MIN_POINTS, PITCH, Cloud
from ...errors import InputError

VOXEL = 0.4  # of the radius
FLAT = 0.02  # radii: how far a point may lie from the plane of those that stand for it
ALPHA = 0.58  # of the radius: what this ball cannot reach in a right angle, the sphere does not touch (2 - sqrt 2)
SLIVER = 0.01  # radii: width of the faces that stand for wires and single points
MAX_FACES = 12_000_000  # what the engine can hold in some 2 GiB


@dataclass(frozen=True, kw_only=True)
class CollisionShape:
    """What spheres collide with, in radii: triangles, or convex pieces."""

    name: str  # of the object
    kind: str
    vertices: np.ndarray  # (N, 3) float64
    faces: np.ndarray  # (M, 3) int32
    pieces: tuple[np.ndarray, ...] | None = None  # vertices (K, 3) of convex pieces; None where the faces are the shape
    columns: np.ndarray  # (C, 3) points of the surface, dense enough to say how high it is under a sphere
    voxel_size: float | None = None
    gap: float | None = None

    def facts(self, radius: float) -> dict:
        """Return what there is to know of the shape, lengths in metres."""
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
    """Return the faces of the mesh that a cloud samples."""
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
    """Return the points that the surface is spanned between, the voxels' size if there are any, and the gap, in radii.

    The gap is the largest distance from surface to point: the 5 mm that sampling promises, less in a scan that
    resolves more, more in one that resolves less.
    """
    from .voxels import representatives

    points = distinct(cloud) / radius
    spacing = Cloud(points, cloud.name).spacing
    if cloud.mesh is not None:  # of a thin wall the nearest sample may lie on the other side
        spacing = max(spacing, PITCH / radius)
    gap = max(min(MAX_GAP / radius, 3 * spacing), 1.25 * spacing)
    side = VOXEL if voxel_size is None else voxel_size / radius
    if voxel_size is None and side <= 1.5 * spacing:
        return points, None, gap
    return representatives(points, side, FLAT), side, side + gap


def distinct(cloud: Cloud) -> np.ndarray:
    """Return the points (N, 3) without repetitions, in the order of their coordinates, metres.

    Raises
    ------
    InputError
        If hardly any are left.
    """
    points = cloud.points[np.lexsort(cloud.points.T[::-1])]
    points = points[np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))]
    if len(points) < MIN_POINTS:
        raise InputError(
            f"{cloud.name}: expected at least {MIN_POINTS} different points, got {len(points)} among {len(cloud)}"
        )
    return points


def spanned(name: str, points: np.ndarray, alpha: float, gap: float) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (N, 3) and faces (M, 3) between points, with slivers where points lie alone or in a row."""
    from .triangulation import faces_between

    faces = require_room(name, faces_between(points, alpha, gap))
    return with_slivers(points, faces, gap)


def with_slivers(points: np.ndarray, faces: np.ndarray, gap: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points and faces with a sliver from each point without a face to its two nearest neighbours."""
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
    """Return the faces if the engine can hold them."""
    if len(faces) > MAX_FACES:
        raise InputError(
            f"{name}: expected a shape of at most {MAX_FACES:,} faces, got {len(faces):,}; use a larger radius"
        )
    return faces
