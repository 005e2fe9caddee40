"""URDF, read by yourdfpy: a robot's or a thing's visible parts as one object, every joint at zero.

Its meshes are read by the readers of their own formats, with their limits; a mesh outside the file's folder is refused.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np

from .. import FormatError
from ..geometry import Geometry
from .parts import Part, joined, require_plain_xml

if TYPE_CHECKING:
    import yourdfpy

MAX_PARTS = 10_000


def read_urdf(data: bytes, path: Path) -> Geometry:
    """Return the vertices (N, 3) in the frame of the base link and triangles (M, 3) of all that is visible."""
    import yourdfpy
    from trimesh.transformations import transform_points

    require_plain_xml(data)
    ElementTree.fromstring(data)  # yourdfpy mends what is not well formed, and reads half a robot
    robot = yourdfpy.URDF.load(io.BytesIO(data), load_meshes=False, build_collision_scene_graph=False)
    parts, read = [], cache(lambda name: _mesh(name, path))
    for link in robot.robot.links:
        pose = robot.get_transform(link.name)
        for visual in link.visuals:
            vertices, faces = _part(visual.geometry, read)
            own = np.eye(4) if visual.origin is None else visual.origin
            parts.append((transform_points(vertices, pose @ own), faces))
            if len(parts) > MAX_PARTS:
                raise FormatError(f"expected at most {MAX_PARTS:,} visible parts, got more; join them")
    return joined(parts)


def named_meshes(path: Path) -> list[Path]:
    """Return the mesh files that a URDF file names, those that there are; none of a file that cannot be read."""
    try:
        tree = ElementTree.parse(path)
    except (OSError, ElementTree.ParseError, ValueError):
        return []
    files = []
    for mesh in tree.iter("mesh"):
        target = _inside(mesh.get("filename", ""), path.parent)
        files += [target] if target is not None and target.is_file() else []
    return sorted(set(files))


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


def _mesh(name: str, path: Path) -> Part:
    """Return the vertices and faces of a mesh that stands in the file's folder or below it, or beside that folder."""
    from ..reading import read_geometry

    target = _inside(name, path.parent)
    if target is None or target.suffix.lower() == ".urdf":
        raise FormatError(f"expected its meshes in its own folder, got {name[:80]!r}; put them beside it")
    geometry = read_geometry(target)
    if not len(geometry.faces):
        raise FormatError(f"expected meshes, got the points of {name[:80]!r}")
    return geometry.vertices, geometry.faces


def _inside(name: str, folder: Path) -> Path | None:
    """Return where a mesh is: below the folder, or below the package that the folder is a part of; None: elsewhere."""
    for root, relative in _places(unquote(name), folder.resolve()):
        target = (root / relative).resolve()
        if target.is_relative_to(root) and target.exists():
            return target
    return None


def _places(name: str, folder: Path) -> Iterator[tuple[Path, str]]:
    """Yield where a name may lead: ``package://`` names the package's folder, in which the file is somewhere."""
    scheme, _, rest = name.rpartition("://")
    if scheme in ("", "file"):
        yield folder, rest
    elif scheme == "package":
        package, _, inner = rest.partition("/")
        yield folder, inner
        for parent in (folder, *folder.parents):
            if parent.name == package:
                yield parent, inner
