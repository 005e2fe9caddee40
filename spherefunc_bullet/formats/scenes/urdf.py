"""URDF, read by yourdfpy: the visible parts of a robot or an object as one object, with every joint at zero.

The readers of their own formats read its meshes, with the same limits. Meshes are looked for in the folder of the file,
in its ROS package or what is laid out like one, and in the folders that the user gives with ``--package-path`` or
``ROS_PACKAGE_PATH``; nothing outside these folders is ever read.
"""

from __future__ import annotations

import io
import logging
import os
import re
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np

from .. import FormatError
from ..sources import Geometry, Source, inside, read_geometry
from .parts import MAX_INSTANCES, SEEN, Part, joined, plain_xml, primitive, scaled

if TYPE_CHECKING:
    import yourdfpy

PACKAGE_PATH = "ROS_PACKAGE_PATH"  # environment variable: folders of packages, or packages
SHAPES = frozenset({"mesh", "box", "cylinder", "sphere"})
_MARK = "package.xml"  # every ROS package has this file
_XACRO = re.compile(r"\{[^}]*xacro[^}]*\}(\w+)")  # tag of a macro, with its namespace; a declaration alone is common
_LAYOUT = frozenset({"urdf", "robots", "xacro"})  # subfolders of a package without that file that hold URDF files,
_MESHES = ("meshes", "mesh")  # and their meshes
_ASSETS = "assets"  # folder of models, of what they include, and of their meshes
_NAMING_MESHES = (".urdf", ".sdf")  # files that are no mesh, but name some


def find_mesh(name: str, folder: Path) -> Path | None:
    """Return the path of the mesh that a URDF or SDF in ``folder`` names; None if it is in none of the allowed folders.

    Gazebo's ``model://name/file`` is found as ``package://name/file`` is.
    """
    folder = folder.resolve()
    given = [Path(part).resolve() for part in os.environ.get(PACKAGE_PATH, "").split(os.pathsep) if part.strip()]
    trusted = [*(parent for parent in folder.parents if (parent / _MARK).is_file()), *_unmarked(folder), *given]
    places = (place for spelling in (name, unquote(name)) for place in _places(spelling, folder, trusted))
    return next((target for root, inner in places if (target := inside(root / inner, [root, *trusted]))), None)


def _places(name: str, folder: Path, trusted: Sequence[Path]) -> Iterator[tuple[Path, str]]:
    """Yield each folder in which a mesh may be, and its path there: of ``package://name/file`` it is ``file``.

    A path without a scheme is looked for in the folder of the file, then in those given, as PyBullet does.
    """
    scheme, _, rest = name.rpartition("://")
    if scheme in ("", "file"):
        yield from ((root, rest) for root in (folder, *trusted))
    elif scheme in ("package", "model"):
        package, _, inner = rest.partition("/")
        if package.strip(".") and inner:
            yield from ((root, inner) for root in (folder, *trusted) if root.name == package)
            yield from ((root / package, inner) for root in trusted)
            yield from ((folder, inner), (folder, rest))  # the second is where PyBullet finds it


def _unmarked(folder: Path) -> list[Path]:
    """Return packages up to two folders above, recognised by names of folders; never a home or a top-level folder."""
    home = Path.home().resolve()
    return [
        package
        for package, inner in zip(folder.parents[:2], (folder, *folder.parents), strict=False)
        if len(package.parents) > 1
        and not home.is_relative_to(package)
        and (package.name == _ASSETS or inner.name in _LAYOUT or any((package / name).is_dir() for name in _MESHES))
    ]


def read_urdf(source: Source) -> Geometry:
    """Return the vertices (N, 3), in the frame of the base link, and triangles (M, 3) of all visible parts."""
    from trimesh.transformations import transform_points

    robot = robot_of(plain_xml(source.data))
    parts, read = [], cache(lambda name: mesh_part(name, source.named))
    for link in robot.robot.links:
        pose = robot.get_transform(link.name)
        for visual in link.visuals:
            vertices, faces = geometry_part(visual.geometry, read)
            T_link_visual = np.eye(4) if visual.origin is None else visual.origin
            parts.append((transform_points(vertices, pose @ T_link_visual), faces))
            if len(parts) > MAX_INSTANCES:
                raise FormatError(f"expected at most {MAX_INSTANCES:,} visible parts, got more; join them")
    return joined(parts, *SEEN)


def robot_of(tree: ElementTree.Element) -> yourdfpy.URDF:
    """Return the robot of a URDF, of which yourdfpy reads the tree.

    The file itself it would repair if it is not well formed, and may read half a robot.
    """
    import yourdfpy

    logging.getLogger("yourdfpy").addHandler(logging.NullHandler())  # it warns of joints, which are all at zero
    if macro := next(filter(None, (_XACRO.fullmatch(element.tag) for element in tree.iter())), None):
        name = f"xacro:{macro[1][:80]}"
        raise FormatError(f"expected a URDF, got macros ({name}) that are not expanded; expand it with xacro first")
    shapes = [[shape.tag for shape in geometry] for geometry in tree.iterfind("link/*/geometry")]
    if odd := next((tags[0] for tags in shapes if tags and SHAPES.isdisjoint(tags)), None):
        raise FormatError(f"expected meshes, boxes, cylinders and spheres, got a {odd[:80]}")
    return yourdfpy.URDF.load(
        io.BytesIO(ElementTree.tostring(tree)), load_meshes=False, build_collision_scene_graph=False
    )


def named_sources(source: Source) -> dict[str, Source]:
    """Return the meshes of all visible parts, by the names that the file gives them."""
    meshes = plain_xml(source.data).findall("link/visual/geometry/mesh")
    names = {mesh.get("filename", "") for mesh in meshes}
    return {name: mesh_source(name, source.path.parent) for name in names}


def mesh_source(name: str, folder: Path) -> Source:
    """Return the source of a mesh, or of another file, that a file in ``folder`` names; see `find_mesh`."""
    if not name.strip("./ "):
        raise FormatError(f"expected the name of a file, got {name[:80]!r}")
    target = find_mesh(name, folder)
    if target is None or target.suffix.lower() in _NAMING_MESHES:
        places = f"put them beside it, or name their package's folder in {PACKAGE_PATH}"
        raise FormatError(f"expected what it names in its own folder or its package, got {name[:80]!r}; {places}")
    return Source(target, target.suffix.lower())


def geometry_part(shape: yourdfpy.Geometry, read: Callable[[str], Part]) -> Part:
    """Return the vertices and faces of a URDF geometry in its own frame; ``read`` returns those of a mesh by name."""
    if shape.mesh is not None:
        return scaled(read(shape.mesh.filename), shape.mesh.scale)
    if shape.box is not None:
        return primitive("box", extents=shape.box.size)
    if shape.cylinder is not None:
        return primitive("cylinder", radius=shape.cylinder.radius, height=shape.cylinder.length)
    if shape.sphere is not None:
        # One of radius 0, which marks a point, would be NaN.
        return scaled(primitive("icosphere", radius=1.0), shape.sphere.radius)
    raise FormatError("expected a mesh, box, cylinder or sphere to be visible, got another shape")


def mesh_part(name: str, named: dict[str, Source]) -> Part:
    """Return the vertices and faces of a mesh among the sources that a file names."""
    geometry = read_geometry(named[name])
    if not len(geometry.faces):
        raise FormatError(f"expected meshes, got the points of {name[:80]!r}")
    return geometry.vertices, geometry.faces
