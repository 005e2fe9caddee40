"""DAE (COLLADA), read by trimesh and pycollada: all parts in one frame, with the file's own up axis and unit."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from .. import FormatError
from ..sources import Geometry, Source
from .parts import joined, parts_of, plain_xml, require_few_instances, scene_of

# Rotations to z up: the rows are the axes that become x, y and z.
_TURNS = {
    "X_UP": [[0, -1, 0], [0, 0, -1], [1, 0, 0]],
    "Y_UP": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
    "Z_UP": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
}


def read_dae(source: Source) -> Geometry:
    """Return the vertices (N, 3) in metres, z up, and the triangles (M, 3)."""
    import collada  # noqa: F401 - trimesh imports it only when it reads such a file

    data = source.data
    tree = plain_xml(data)
    require_few_instances(*_instances(tree))
    geometry = joined(parts_of(scene_of(data, "dae", resolver={}), "faces"))
    return Geometry(_metres(tree) * geometry.vertices @ _turn(tree).T, geometry.faces)


def _instances(tree: ElementTree.Element) -> tuple[dict[str, list[str]], list[str]]:
    """Return the names of the nodes that each node contains, and those of the top nodes."""
    nodes = [element for element in tree.iter() if element.tag.rpartition("}")[2] == "node"]
    names = {node: node.get("id") or f"node {n}" for n, node in enumerate(nodes)}
    children = {
        name: [names[child] for child in node.findall("{*}node")]
        + [link.get("url", "").lstrip("#") for link in node.findall("{*}instance_node")]
        for node, name in names.items()
    }
    return children, [names[node] for node in tree.findall(".//{*}visual_scene/{*}node")]


def _turn(tree: ElementTree.Element) -> np.ndarray:
    """Return the rotation (3, 3) to z up; without an up axis the standard says y."""
    axis = (tree.findtext("{*}asset/{*}up_axis") or "Y_UP").strip()
    if axis not in _TURNS:
        raise FormatError(f"expected up_axis X_UP, Y_UP or Z_UP, got {axis[:40]!r}; is the file damaged?")
    return np.array(_TURNS[axis], dtype=np.float64)


def _metres(tree: ElementTree.Element) -> float:
    """Return the file's unit in metres."""
    unit = tree.find("{*}asset/{*}unit")
    metres = float(unit.get("meter", "1")) if unit is not None else 1.0
    if not 0 < metres < 1e6:
        raise FormatError(f"expected a unit of more than 0 metres, got {metres}; is the file damaged?")
    return metres
