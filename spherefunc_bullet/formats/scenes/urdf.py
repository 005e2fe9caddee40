"""URDF, read by yourdfpy: a robot's or an object's visible parts as one object, every joint at zero.

Its meshes are read by the readers of their own formats, with their limits; see `packages` for where they may lie.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .. import FormatError
from ..sources import Geometry, Source
from .packages import PACKAGE_PATH, find_mesh
from .parts import Part, joined, plain_xml

if TYPE_CHECKING:
    import yourdfpy

MAX_PARTS = 10_000


def read_urdf(source: Source) -> Geometry:
    """Return the vertices (N, 3) in the frame of the base link and triangles (M, 3) of all that is visible."""
    import yourdfpy
    from trimesh.transformations import transform_points

    plain_xml(source.data)  # yourdfpy mends what is not well formed, and reads half a robot
    robot = yourdfpy.URDF.load(io.BytesIO(source.data), load_meshes=False, build_collision_scene_graph=False)
    parts, read = [], cache(lambda name: _mesh(name, source.named))
    for link in robot.robot.links:
        pose = robot.get_transform(link.name)
        for visual in link.visuals:
            vertices, faces = _part(visual.geometry, read)
            own = np.eye(4) if visual.origin is None else visual.origin
            parts.append((transform_points(vertices, pose @ own), faces))
            if len(parts) > MAX_PARTS:
                raise FormatError(f"expected at most {MAX_PARTS:,} visible parts, got more; join them")
    return joined(parts)


def named_meshes(source: Source) -> dict[str, Source]:
    """Return the meshes of all visible parts, by the names that the file gives them."""
    meshes = plain_xml(source.data).findall("link/visual/geometry/mesh")
    names = {mesh.get("filename", "") for mesh in meshes}
    return {name: _source(name, source.path.parent) for name in names}


def _source(name: str, folder: Path) -> Source:
    """Return the source of a mesh."""
    target = find_mesh(name, folder)
    if target is None or target.suffix.lower() == ".urdf":
        places = f"put them beside it, or name their package's folder in {PACKAGE_PATH}"
        raise FormatError(f"expected its meshes in its own folder or its package, got {name[:80]!r}; {places}")
    return Source(target, target.suffix.lower())


def _part(shape: yourdfpy.Geometry, read: Callable[[str], Part]) -> Part:
    """Return one part in its own frame."""
    import trimesh

    if shape.mesh is not None:
        vertices, faces = read(shape.mesh.filename)
        return vertices * (1.0 if shape.mesh.scale is None else np.asarray(shape.mesh.scale, dtype=np.float64)), faces
    if shape.box is not None:
        solid = trimesh.creation.box(shape.box.size)
    elif shape.cylinder is not None:
        solid = trimesh.creation.cylinder(radius=shape.cylinder.radius, height=shape.cylinder.length)
    elif shape.sphere is not None:
        solid = trimesh.creation.icosphere(radius=shape.sphere.radius)
    else:
        raise FormatError("expected a mesh, box, cylinder or sphere to be visible, got another shape")
    return np.asarray(solid.vertices), np.asarray(solid.faces)


def _mesh(name: str, named: dict[str, Source]) -> Part:
    """Return the vertices and faces of a mesh."""
    from ..sources import read_geometry

    geometry = read_geometry(named[name])
    if not len(geometry.faces):
        raise FormatError(f"expected meshes, got the points of {name[:80]!r}")
    return geometry.vertices, geometry.faces
