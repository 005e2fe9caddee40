"""Candidates: the collision shapes that can be made from the mesh of an object.

The name of a candidate contains its parameter: ``voxel 5mm``, ``vhacd 32``, ``coacd 0.05``.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from importlib.util import find_spec

import numpy as np

from ..bullet.collision.shape import collision_shape
from ..clouds.cloud import Cloud
from ..errors import InputError, explaining, require_amount
from ..formats.units import format_length
from .solid import MOST_CORNERS, Solid, of_pieces, surface

VOXELS = (1 / 3, 2 / 3, 4 / 3)  # of the radius of the spheres
VHACD = (8, 32, 64)  # largest number of hulls
RESOLUTION = 100_000  # voxels of V-HACD, as in PyBullet's own `vhacd`
THRESHOLDS = (0.01, 1.0)  # of CoACD, as its authors state; it ends the process above, and never ends itself at 0
MISSING = "shape '{}' needs its package: pip install 'spherefunc-bullet[{}]'"
Make = Callable[[], Solid]


def candidates(cloud: Cloud, radius: float, coacd: float | Sequence[float] = ()) -> dict[str, Make]:
    """Return functions that make the candidates for a cloud with a mesh, by name, the more expensive ones first.

    Parameters
    ----------
    cloud : Cloud
    radius : float, metres
        Of the spheres for which the shapes are made.
    coacd : float or floats
        Thresholds of CoACD, 0.01 to 1; each may take minutes.

    Raises
    ------
    InputError
        If CoACD is not installed, or a threshold is out of its range.
    """
    makes: dict[str, Make] = {"mesh": partial(of_mesh, cloud)}
    for share in VOXELS:
        size = float(f"{share * radius:.1g}")
        makes[f"voxel {format_length(size)}"] = partial(of_cloud, cloud, radius, "voxel", size)
    makes["compound"] = partial(of_cloud, cloud, radius, "compound", None)
    if has_vhacd():
        makes |= {f"vhacd {hulls}": partial(of_vhacd, cloud, hulls) for hulls in VHACD}
    thresholds = np.atleast_1d(coacd).tolist()
    if thresholds and find_spec("coacd") is None:  # reported before the slow work
        raise InputError(MISSING.format("coacd", "coacd"))
    for threshold in thresholds:
        require_amount("coacd", threshold, least=THRESHOLDS[0], most=THRESHOLDS[1])
        makes[f"coacd {threshold:g}"] = partial(of_coacd, cloud, threshold)
    makes["hull"] = partial(of_hull, cloud)
    return makes


def has_vhacd() -> bool:
    """Return whether V-HACD is installed; without it the other shapes are compared."""
    return find_spec("vhacdx") is not None


def make_solid(name: str, make: Make) -> Solid:
    """Make a candidate and return it with its name and the seconds that it took."""
    started = time.perf_counter()
    solid = make()
    return replace(solid, name=name, build_seconds=time.perf_counter() - started)


def of_mesh(cloud: Cloud) -> Solid:
    """Return the mesh itself, which may be concave."""
    if cloud.mesh is None:
        raise InputError(f"{cloud.name}: expected a mesh to make shapes of, got points")
    return surface("mesh", cloud.mesh.vertices, cloud.mesh.faces)


def of_cloud(cloud: Cloud, radius: float, kind: str, voxel_size: float | None) -> Solid:
    """Return one of the bullet backend's own shapes."""
    shape = collision_shape(cloud, radius, kind, voxel_size)
    if shape.pieces is None:
        return surface(kind, shape.vertices * radius, shape.faces.astype(np.int64))
    return of_pieces(kind, [piece * radius for piece in shape.pieces])


def of_hull(cloud: Cloud) -> Solid:
    """Return the convex hull, which engines use for a mesh that is not decomposed."""
    return of_pieces("hull", [of_mesh(cloud).vertices])


def of_vhacd(cloud: Cloud, hulls: int) -> Solid:
    """Return the pieces of V-HACD, at most ``hulls``."""
    mesh = of_mesh(cloud)
    return of_pieces("vhacd", vhacd_pieces(mesh.vertices, mesh.faces, hulls))


def vhacd_pieces(vertices: np.ndarray, faces: np.ndarray, hulls: int) -> list[np.ndarray]:
    """Return the corners (K, 3) of the pieces of V-HACD for a mesh, at most ``hulls`` of at most 64 corners each."""
    with explaining(MISSING.format("vhacd", "shapes"), ImportError):
        import vhacdx

    limits = {"maxConvexHulls": hulls, "maxNumVerticesPerCH": MOST_CORNERS}
    mesh = np.ascontiguousarray(vertices), np.ascontiguousarray(faces, np.uint32)
    pieces = vhacdx.compute_vhacd(*mesh, asyncACD=False, resolution=RESOLUTION, **limits)
    return [np.asarray(points) for points, _ in pieces]


def of_coacd(cloud: Cloud, threshold: float) -> Solid:
    """Return the pieces of CoACD (Wei et al., 2022), each with at most 64 corners; by default up to 1,000."""
    import coacd

    mesh = of_mesh(cloud)
    coacd.set_log_level("off")
    pieces = coacd.run_coacd(
        coacd.Mesh(mesh.vertices, mesh.faces), threshold, decimate=True, max_ch_vertex=MOST_CORNERS
    )
    return of_pieces("coacd", [np.asarray(corners) for corners, _ in pieces])
