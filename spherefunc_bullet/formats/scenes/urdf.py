"""URDF, read by yourdfpy: a robot's or an object's visible parts as one object, every joint at zero.

Its meshes are read by the readers of their own formats, with their limits. They are looked for in its own folder, in
its package, and where the user points, with ``--package-path`` or ``ROS_PACKAGE_PATH``; nothing outside of these
folders is ever read.
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
from .parts import Part, joined, plain_xml, primitive

if TYPE_CHECKING:
    import yourdfpy

import os
from collections.abc import Iterator, Sequence
from urllib.parse import unquote

from ..sources import inside

PACKAGE_PATH = "ROS_PACKAGE_PATH"  # of the environment: folders of packages, or packages
_MARK = "package.xml"  # that ROS has in every package
_LAYOUT = ("urdf", "robots", "xacro")  # where a package keeps such files, if it has no mark


def find_mesh(name: str, folder: Path) -> Path | None:
    """Return the mesh that a URDF in a folder calls by a name; None if there is none where it may be."""
    folder = folder.resolve()
    trusted = [*(parent for parent in folder.parents if (parent / _MARK).is_file()), *_pointed()]
    places = _places(unquote(name), folder, trusted)
    return next((target for root, inner in places if (target := inside(root / inner, [root, *trusted]))), None)


def _pointed() -> list[Path]:
    """Return the folders that the user points to."""
    return [Path(part).resolve() for part in os.environ.get(PACKAGE_PATH, "").split(os.pathsep) if part.strip()]


def _places(name: str, folder: Path, trusted: Sequence[Path]) -> Iterator[tuple[Path, str]]:
    """Yield the folders in which a name may be, and what it is called there: in ``package://name/file``, file."""
    scheme, _, rest = name.rpartition("://")
    if scheme in ("", "file"):
        yield folder, rest
    elif scheme == "package":
        package, _, inner = rest.partition("/")
        if package.strip(".") and inner:
            roots = [folder, *_unmarked(folder), *trusted]
            yield from ((root, inner) for root in roots if root.name == package)
            yield from ((root / package, inner) for root in trusted)
            yield from ((folder, inner), (folder, rest))  # the second is where PyBullet finds it


def _unmarked(folder: Path) -> list[Path]:
    """Return the package that a folder is a part of by its name alone; homes and top folders hold more than that."""
    package = folder.parent
    shared = len(package.parents) < 2 or Path.home().resolve().is_relative_to(package)
    return [package] if folder.name in _LAYOUT and not shared else []


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
            T_link_visual = np.eye(4) if visual.origin is None else visual.origin
            parts.append((transform_points(vertices, pose @ T_link_visual), faces))
            if len(parts) > MAX_PARTS:
                raise FormatError(f"expected at most {MAX_PARTS:,} visible parts, got more; join them")
    return joined(parts)


def named_sources(source: Source) -> dict[str, Source]:
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
    if shape.mesh is not None:
        vertices, faces = read(shape.mesh.filename)
        return vertices * (1.0 if shape.mesh.scale is None else np.asarray(shape.mesh.scale, dtype=np.float64)), faces
    if shape.box is not None:
        return primitive("box", extents=shape.box.size)
    if shape.cylinder is not None:
        return primitive("cylinder", radius=shape.cylinder.radius, height=shape.cylinder.length)
    if shape.sphere is not None:
        return primitive("icosphere", radius=shape.sphere.radius)
    raise FormatError("expected a mesh, box, cylinder or sphere to be visible, got another shape")


def _mesh(name: str, named: dict[str, Source]) -> Part:
    """Return the vertices and faces of a mesh."""
    from ..sources import read_geometry

    geometry = read_geometry(named[name])
    if not len(geometry.faces):
        raise FormatError(f"expected meshes, got the points of {name[:80]!r}")
    return geometry.vertices, geometry.faces
