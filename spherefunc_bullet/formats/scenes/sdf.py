"""SDF, the format of Gazebo: what the links of one model show, or collide with, with every joint at zero."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from xml.etree import ElementTree

import numpy as np

from .. import FormatError
from ..sources import Geometry, Source
from .parts import MAX_INSTANCES, SEEN, Part, joined, plain_xml, primitive, scaled
from .urdf import mesh_part, mesh_source

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
    tree = plain_xml(source.data)
    if (others := sum(1 for tag in ("model", "include") for _ in tree.iter(tag)) - 1) > 0:
        raise FormatError(f"expected one model, got {others} more in it or beside it; join them")
    for link in tree.findall(".//model/link"):
        for node in link.findall(kind):
            place = _pose_of(link, "__model__") @ _pose_of(node, link.get("name", ""))
            for vertices, faces in _geometry_parts(node.find("geometry"), read):
                yield link.get("name", source.path.stem), (vertices @ place[:3, :3].T + place[:3, 3], faces)


def _pose_of(node: ElementTree.Element, parent: str) -> np.ndarray:
    """Return the pose (4, 4) of an element in its parent: position, and roll, pitch and yaw or a quaternion."""
    from trimesh.transformations import euler_matrix, quaternion_matrix

    pose = node.find("pose")
    if pose is None or not (values := [float(word) for word in (pose.text or "").split()]):
        return np.eye(4)
    if (other := pose.get("relative_to", parent)) not in ("", parent):
        raise FormatError(f"expected poses in the frame of their parent, got one relative to {other[:80]!r}")
    if pose.get("rotation_format") == "quat_xyzw":
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
    names = ("size", "radius", "length", "scale", "radii")
    sizes = {name: list(map(float, geometry.findtext(f".//{name}", "").split())) for name in names}
    if geometry.find("box") is not None:
        return [primitive("box", extents=sizes["size"])]
    if geometry.find("cylinder") is not None:
        return [primitive("cylinder", radius=sizes["radius"][0], height=sizes["length"][0])]
    if geometry.find("capsule") is not None:
        return [primitive("capsule", radius=sizes["radius"][0], height=sizes["length"][0])]
    if geometry.find("sphere") is not None:
        return [primitive("icosphere", radius=sizes["radius"][0])]
    if geometry.find("ellipsoid") is not None:
        return [scaled(primitive("icosphere", radius=1.0), sizes["radii"])]
    odd = [each.tag for each in (*geometry, *geometry.findall("mesh/submesh")) if each.tag not in _NOT_SOLID]
    if odd:
        raise FormatError(f"expected a box, cylinder, capsule, sphere, ellipsoid or whole mesh, got {odd[0][:80]}")
    name = geometry.findtext("mesh/uri")
    return [] if name is None else [scaled(part, sizes["scale"] or None) for part in read(name.strip())]
