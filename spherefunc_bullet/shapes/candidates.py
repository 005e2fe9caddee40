"""The collision shapes that an object could be given: each way to make one from its mesh, and its name.

A way is called by its name and what it is made with: ``voxel 5mm``, ``vhacd 32``, ``coacd 0.05``.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec

import numpy as np

from ..bullet.collision.shape import collision_shape
from ..clouds.cloud import Cloud
from ..errors import InputError
from ..formats.units import format_length
from .solid import Solid, of_pieces, surface

VOXELS = (1 / 3, 2 / 3, 4 / 3)  # of the spheres' radius
VHACD = (8, 32, 64)  # hulls at most
RESOLUTION = 100_000  # voxels of V-HACD: what PyBullet's own `vhacd` takes
MISSING = "shape '{}' needs its package: pip install 'spherefunc-bullet[{}]'"
Make = Callable[[], Solid]


def candidates(cloud: Cloud, radius: float, coacd: tuple[float, ...] = ()) -> dict[str, Make]:
    """Return what makes each candidate of a cloud that carries a mesh, by name; dearer ones come first.

    Parameters
    ----------
    cloud : Cloud
    radius : float, metres
        Of the spheres that the shapes are for.
    coacd : floats
        CoACD's thresholds; each may take minutes.
    """
    makes: dict[str, Make] = {"mesh": partial(of_mesh, cloud)}
    for share in VOXELS:
        size = float(f"{share * radius:.1g}")
        makes[f"voxel {format_length(size)}"] = partial(of_cloud, cloud, radius, "voxel", size)
    makes["compound"] = partial(of_cloud, cloud, radius, "compound", None)
    if has_vhacd():
        makes |= {f"vhacd {hulls}": partial(of_vhacd, cloud, hulls) for hulls in VHACD}
    if coacd and find_spec("coacd") is None:  # said before what takes long
        raise InputError(MISSING.format("coacd", "coacd"))
    makes |= {f"coacd {threshold:g}": partial(of_coacd, cloud, threshold) for threshold in coacd}
    makes["hull"] = partial(of_hull, cloud)
    return makes


def has_vhacd() -> bool:
    """Return whether V-HACD is installed; without it everything else is compared."""
    return find_spec("vhacdx") is not None


def made(name: str, make: Make) -> Solid:
    """Return a candidate with the seconds that it took to make."""
    started = time.perf_counter()
    solid = make()
    seconds = time.perf_counter() - started
    return Solid(**{**vars(solid), "name": name, "build_seconds": seconds})


def of_mesh(cloud: Cloud) -> Solid:
    """Return the mesh itself, concave as it is."""
    if cloud.mesh is None:
        raise InputError(f"{cloud.name}: expected a mesh to make shapes of, got points")
    return surface("mesh", cloud.mesh.vertices, cloud.mesh.faces)


def of_cloud(cloud: Cloud, radius: float, kind: str, voxel_size: float | None) -> Solid:
    """Return the bullet backend's own shape of a kind."""
    shape = collision_shape(cloud, radius, kind, voxel_size)
    if shape.pieces is None:
        return surface(kind, shape.vertices * radius, shape.faces.astype(np.int64))
    return of_pieces(kind, [piece * radius for piece in shape.pieces])


def of_hull(cloud: Cloud) -> Solid:
    """Return the convex hull, which is what engines make of a mesh that nobody cut into pieces."""
    return of_pieces("hull", [of_mesh(cloud).vertices])


def of_vhacd(cloud: Cloud, hulls: int) -> Solid:
    """Return V-HACD's pieces, at most this many, each of at most 64 corners."""
    import vhacdx

    mesh = of_mesh(cloud)
    faces = np.ascontiguousarray(mesh.faces, np.uint32)
    limits = {"maxConvexHulls": hulls, "maxNumVerticesPerCH": 64}
    pieces = vhacdx.compute_vhacd(mesh.vertices, faces, asyncACD=False, resolution=RESOLUTION, **limits)
    return of_pieces("vhacd", [np.asarray(points) for points, _ in pieces])


def of_coacd(cloud: Cloud, threshold: float) -> Solid:
    """Return CoACD's pieces (Wei et al., "Approximate Convex Decomposition for 3D Meshes", 2022)."""
    import coacd

    mesh = of_mesh(cloud)
    coacd.set_log_level("off")
    pieces = coacd.run_coacd(coacd.Mesh(mesh.vertices, mesh.faces), threshold=threshold)
    return of_pieces("coacd", [np.asarray(corners) for corners, _ in pieces])
