"""SDF, the format of Gazebo: what the links of one model show, or collide with, with every joint at zero.

What is transparent is not seen, as in Gazebo.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from xml.etree import ElementTree

import numpy as np

from .. import FormatError
from ..sources import Geometry, Source
from .named_meshes import mesh_part, mesh_source
from .parts import MAX_INSTANCES, SEEN, Part, joined, plain_xml, primitive, scaled

_NOT_SOLID = ("mesh", "plane", "empty")  # what is read beside solids; planes and what is empty have no part


def read_sdf(source: Source) -> Geometry:
    """Return the vertices (N, 3), metres, in the frame of the model, and triangles (M, 3) of all visible parts."""
    read = cache(lambda name: [mesh_part(name, source.named)])
    parts = [part for _, part in link_parts(source, "visual", read)]
    if len(parts) > MAX_INSTANCES:
        raise FormatError(f"expected at most {MAX_INSTANCES:,} visible parts, got {len(parts):,}; join them")
    return joined(parts, *SEEN)


def named_sources(source: Source) -> dict[str, Source]:
    """Return the meshes of all visible parts, by the names that the file gives them."""
    meshes = plain_xml(source.data).findall(".//model/link/visual/geometry/mesh/uri")
    names = {(mesh.text or "").strip() for mesh in meshes}
    return {name: mesh_source(name, source.path.parent) for name in names}


def link_parts(source: Source, kind: str, read: Callable[[str], Sequence[Part]]) -> Iterator[tuple[str, Part]]:
    """Yield the name of its link and the placed triangles of each part.

    Parameters
    ----------
    source : Source
    kind : {"visual", "collision"}
    read : callable
        Returns the parts of a mesh by its name.
    """
    model = _model_of(source)
    place = _pose_of(model, "world")
    for link in model.findall("link"):
        T_link = place @ _pose_of(link, "__model__")
        for node in link.findall(kind):
            if _is_transparent(node):
                continue
            T_part = T_link @ _pose_of(node, link.get("name", ""))
            for vertices, faces in _geometry_parts(node.find("geometry"), read):
                yield link.get("name", source.path.stem), (vertices @ T_part[:3, :3].T + T_part[:3, 3], faces)


def _model_of(source: Source) -> ElementTree.Element:
    """Return the only model of an SDF, which may be in a world."""
    tree = plain_xml(source.data)
    models = [*tree.findall("model"), *tree.findall("world/model"), *tree.findall("include")]
    inner = [each for model in models for tag in ("model", "include") for each in model.findall(tag)]
    inner += tree.findall("world/include")
    if tree.tag != "sdf" or not models:
        raise FormatError(f"expected an SDF with a model, got a {tree.tag[:80]!r} without one")
    if len(models) + len(inner) > 1:
        raise FormatError(f"expected one model, got {len(models) + len(inner) - 1} more in it or beside it; join them")
    if models[0].tag == "include":
        raise FormatError("expected a model, got one that is included; name its own file")
    return models[0]


def _is_transparent(node: ElementTree.Element) -> bool:
    """Return whether nothing is seen of a visual."""
    colour = node.findtext("material/diffuse", "").split()
    return float(node.findtext("transparency", "0")) >= 1 or (len(colour) == 4 and float(colour[3]) == 0)


def _pose_of(node: ElementTree.Element, parent: str) -> np.ndarray:
    """Return the pose (4, 4) of an element in its parent: position, and roll, pitch and yaw or a quaternion."""
    from trimesh.transformations import euler_matrix, quaternion_matrix

    pose = node.find("pose")
    if pose is None:
        return np.eye(4)
    if (other := pose.get("relative_to") or pose.get("frame") or parent) != parent:
        raise FormatError(f"expected poses in the frame of their parent, got one relative to {other[:80]!r}")
    values, is_quaternion = list(map(float, (pose.text or "").split())), pose.get("rotation_format") == "quat_xyzw"
    if not values:
        return np.eye(4)
    if len(values) != 6 + is_quaternion:
        raise FormatError(f"expected poses of {6 + is_quaternion} numbers, got one of {len(values)}")
    if is_quaternion:
        x, y, z, w = values[3:]
        matrix = quaternion_matrix([w, x, y, z])
    else:
        in_degrees = pose.get("degrees") in ("true", "1")
        matrix = euler_matrix(*(np.radians(values[3:]) if in_degrees else values[3:]), axes="sxyz")
    matrix[:3, 3] = values[:3]
    return matrix


def _geometry_parts(geometry: ElementTree.Element | None, read: Callable[[str], Sequence[Part]]) -> list[Part]:
    """Return the parts of one element in its own frame; none for planes."""
    if geometry is None:
        return []
    sizes = partial(_sizes, geometry)
    if geometry.find("box") is not None:
        return [primitive("box", extents=sizes("box/size", 3))]
    for kind in ("cylinder", "capsule"):
        if geometry.find(kind) is not None:
            (radius,), (length,) = sizes(f"{kind}/radius", 1), sizes(f"{kind}/length", 1)
            return [primitive(kind, radius=radius, height=length)]
    if geometry.find("sphere") is not None:
        return [primitive("icosphere", radius=sizes("sphere/radius", 1)[0])]
    if geometry.find("ellipsoid") is not None:
        return [scaled(primitive("icosphere", radius=1.0), sizes("ellipsoid/radii", 3))]
    odd = [each.tag for each in (*geometry, *geometry.findall("mesh/submesh")) if each.tag not in _NOT_SOLID]
    if odd:
        raise FormatError(f"expected a box, cylinder, capsule, sphere, ellipsoid or whole mesh, got {odd[0][:80]}")
    name = geometry.findtext("mesh/uri")
    scale = None if geometry.find("mesh/scale") is None else sizes("mesh/scale", 3)
    return [] if name is None else [scaled(part, scale) for part in read(name.strip())]


def _sizes(geometry: ElementTree.Element, path: str, count: int) -> list[float]:
    """Return the numbers of an element of a geometry."""
    values = list(map(float, geometry.findtext(path, "").split()))
    if len(values) != count:
        raise FormatError(f"expected {count} numbers as {path}, got {len(values)}")
    return values
