"""Collision geometry of files, as PyBullet and MuJoCo load it, and as PhysX is assumed to.

PyBullet's `loadURDF` makes one convex hull of each group (``o`` or ``g``) of an OBJ file, and of any other mesh as a
whole; only ``concave="yes"`` in the URDF keeps the mesh, for static objects. A mesh file is loaded in the same way.
In USD each collider says how its mesh is approximated. PhysX takes no triangles that move, so their hull is taken.
"""

from __future__ import annotations

import hashlib
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..clouds.orientation import to_metres, to_z_up
from ..errors import InputError, one_line
from ..formats.files import refusing, require_file
from ..formats.obj import read_groups
from ..formats.scenes.mjcf import bodies
from ..formats.scenes.named_meshes import find_mesh
from ..formats.scenes.parts import plain_xml, scaled
from ..formats.scenes.sdf import link_parts
from ..formats.scenes.urdf import geometry_part, robot_of
from ..formats.scenes.usd import Collider, colliders
from ..formats.sources import READERS, Geometry, as_source, joined_meshes, read_geometry
from .candidates import vhacd_pieces
from .solid import Solid, hull_of, of_pieces, surface

MOST_PIECES = 20_000
USD = (".usd", ".usda", ".usdc", ".usdz")
# of the mesh of a collider, as UsdPhysics and PhysX name them
APPROXIMATIONS = "none, convexHull, convexDecomposition, meshSimplification, sdf, boundingCube, boundingSphere"
DECOMPOSED = 32  # pieces of a mesh that PhysX decomposes, at most
PlacedPart = tuple[np.ndarray, np.ndarray, bool]  # vertices (N, 3), faces (M, 3), and whether the mesh stays concave
Part = tuple[np.ndarray, np.ndarray]  # vertices (N, 3) and faces (M, 3) in a frame of their own


@dataclass(frozen=True, kw_only=True)
class FileFrame:
    """The conversion from the coordinates of a file to those of its object's cloud."""

    up: str
    units: str
    shift: np.ndarray  # (3,) metres, added last

    def convert(self, points: np.ndarray, path: Path) -> np.ndarray:
        """Return points (N, 3) of a file in the frame of the cloud."""
        turned = to_z_up(Geometry(points), self.up, path, no_report)
        return to_metres(turned, self.units, path.name, no_report) + self.shift


def no_report(_: str):
    """Report nothing: the same was reported for the object's own file."""


def load_solids(path: Path, frame: FileFrame) -> Iterator[Solid]:
    """Yield the collision geometry of each link of a file, if it has any, as an engine loads it.

    Raises
    ------
    InputError
        If it cannot be used.
    """
    require_file(path)
    with refusing(path):
        for name, parts in links_of(path).items():
            yield solid_of(name, parts, frame, path)


def solid_of(name: str, parts: list[PlacedPart], frame: FileFrame, path: Path) -> Solid:
    """Return the parts of one link as the engine loads them."""
    if len(parts) > MOST_PIECES:
        limit = f"expected at most {MOST_PIECES:,} collision pieces"
        raise InputError(f"{one_line(path.name)}: {limit}, got {len(parts):,}; join them")
    if any(concave for _, _, concave in parts):
        vertices, faces = joined_meshes([(vertices, faces) for vertices, faces, _ in parts])
        return surface(name, frame.convert(vertices, path), faces)
    return of_pieces(name, [frame.convert(vertices, path) for vertices, _, _ in parts])


def links_of(path: Path) -> dict[str, list[PlacedPart]]:
    """Return the collision parts of each link of a file, in its frame."""
    ending = path.suffix.lower()
    if ending in LOADERS:
        return LOADERS[ending](path)
    if ending not in READERS:
        raise InputError(f"{one_line(path)}: expected a URDF, SDF, MJCF, USD or mesh, got '{path.suffix}'")
    return {path.stem: [(vertices, faces, False) for vertices, faces in groups_of(path)]}


def collision_digest(path: Path) -> bytes:
    """Return the hash of the collision geometry of a file, with all that it names."""
    digest = hashlib.sha256()
    if path.suffix.lower() not in LOADERS or path.suffix.lower() in USD:  # what a stage collides with follows from it
        for part in as_source(path).digests():
            digest.update(part)
        return digest.digest()
    with refusing(path):
        for name, parts in links_of(path).items():
            for vertices, faces, concave in parts:
                digest.update(f"{name} {len(vertices)} {len(faces)} {concave}".encode())
                digest.update(np.ascontiguousarray(vertices).tobytes() + np.ascontiguousarray(faces).tobytes())
    return digest.digest()


def urdf_links(path: Path) -> dict[str, list[PlacedPart]]:
    """Return the collision parts of each link of a URDF that has any, with every joint at zero."""
    from trimesh.transformations import transform_points

    tree = plain_xml(as_source(path).data)
    robot = robot_of(tree)
    nodes = {link.get("name"): link for link in tree.findall("link")}
    links = defaultdict(list)
    for link in robot.robot.links:
        pose, whole = robot.get_transform(link.name), nodes[link.name]
        for node, collision in zip(whole.findall("collision"), link.collisions, strict=True):
            place = pose @ (np.eye(4) if collision.origin is None else collision.origin)
            is_concave = "yes" in (whole.get("concave"), node.get("concave"))
            for vertices, faces in geometry_parts(collision.geometry, path.parent, whole=is_concave):
                links[link.name].append((transform_points(vertices, place), faces, is_concave))
    return links


def geometry_parts(shape: Any, folder: Path, whole: bool) -> list[Part]:
    """Return the parts of a collision element of which the engine makes hulls, or its whole mesh."""
    if shape.mesh is None:
        return [geometry_part(shape, lambda name: None)]
    return [scaled(part, shape.mesh.scale) for part in mesh_groups(shape.mesh.filename, folder, whole)]


def mesh_groups(name: str, folder: Path, whole: bool = False) -> list[Part]:
    """Return `groups_of` the mesh that a file in ``folder`` names."""
    target = find_mesh(name, folder)
    if target is None:
        raise InputError(f"collision mesh {name[:80]!r}: expected in the file's folder or its package")
    return groups_of(target, whole)


def groups_of(path: Path, whole: bool = False) -> list[Part]:
    """Return the vertices and faces of each group of an OBJ file; the whole mesh for other formats."""
    geometry = read_geometry(path)
    if not len(geometry.faces):
        raise InputError(f"{one_line(path.name)}: expected a mesh to collide with, got points")
    groups = [] if whole or path.suffix.lower() != ".obj" else read_groups(path.read_bytes())[1]
    groups = [np.unique(faces, return_inverse=True) for faces in groups if len(faces)]
    if len(groups) < 2:
        return [(geometry.vertices, geometry.faces)]
    return [(geometry.vertices[used], numbers.reshape(-1, 3)) for used, numbers in groups]


def mjcf_links(path: Path) -> dict[str, list[PlacedPart]]:
    """Return the colliding geoms of each body of an MJCF as MuJoCo compiles them, without planes."""
    links = defaultdict(list)
    for body, part in bodies(as_source(path), collision=True):
        links[body].append((*part, False))
    return links


def sdf_links(path: Path) -> dict[str, list[PlacedPart]]:
    """Return the collision parts of each link of an SDF in the model's frame; a mesh is one hull, or one per group."""
    links = defaultdict(list)
    for link, part in link_parts(as_source(path), "collision", partial(mesh_groups, folder=path.parent)):
        links[link].append((*part, False))
    return links


def usd_links(path: Path) -> dict[str, list[PlacedPart]]:
    """Return the collision parts of each rigid body of a USD stage, named by its path, and of what is static."""
    links = defaultdict(list)
    for collider in colliders(as_source(path)):
        links[collider.body or path.stem] += collider_parts(collider)
    return links


def collider_parts(collider: Collider) -> Iterator[PlacedPart]:
    """Yield the parts of a collider; of a mesh to be decomposed V-HACD's pieces, since those of PhysX are not known."""
    vertices, faces = collider.part
    kind = collider.approximation
    if kind in ("none", "meshSimplification") and collider.moves:
        kind = "convexHull"
    if kind == "convexDecomposition":
        yield from ((*hull_of(piece), False) for piece in vhacd_pieces(vertices, faces, DECOMPOSED))
    elif kind in ("convexHull", "boundingCube"):
        yield *hull_of(vertices), False
    elif kind in ("none", "meshSimplification", "sdf"):
        yield vertices, faces, True
    else:
        raise InputError(f"expected a collider approximated as {APPROXIMATIONS}, got {kind[:40]!r}")


LOADERS = {".urdf": urdf_links, ".sdf": sdf_links, ".xml": mjcf_links, ".mjcf": mjcf_links}
LOADERS |= dict.fromkeys(USD, usd_links)
