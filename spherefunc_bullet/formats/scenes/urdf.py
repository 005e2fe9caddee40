"""URDF, read by yourdfpy: the visible parts of a robot or an object as one object, with every joint at zero."""

from __future__ import annotations

import io
import logging
import re
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from .. import FormatError
from ..sources import Geometry, Source
from .named_meshes import mesh_part, mesh_source
from .parts import MAX_INSTANCES, SEEN, Part, joined, plain_xml, primitive, scaled

if TYPE_CHECKING:
    import yourdfpy

SHAPES = frozenset({"mesh", "box", "cylinder", "sphere"})
_XACRO = re.compile(r"\{[^}]*xacro[^}]*\}(\w+)")  # tag of a macro, with its namespace; a declaration alone is common


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
