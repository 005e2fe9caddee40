"""Scenes: parts in their own frames are joined; scenes that show too many parts are refused."""

from __future__ import annotations

import io
import logging
import re
from collections.abc import Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np

from .. import FormatError
from ..files import require_text_size
from ..sources import Geometry, joined_meshes

if TYPE_CHECKING:
    import trimesh

SEEN = ("visible parts", "has it collision geometry alone?")  # what `joined` expects of robots
MAX_INSTANCES = 10_000  # parts that a scene may show; with nested parts a small file can show billions
_UNDECLARED = expat.errors.codes[expat.errors.XML_ERROR_UNBOUND_PREFIX]
_PREFIX = re.compile(rb"[<\s/]([A-Za-z_][\w.-]*):[A-Za-z_]")  # of the name of an element or an attribute
_FIRST_TAG = re.compile(rb"<[A-Za-z_][\w.-]*")
Part = tuple[np.ndarray, np.ndarray]  # vertices (N, 3) in the scene's frame, faces (M, 3)


def joined(
    parts: Sequence[Part], expected: str = "a mesh or points in its scene", hint: str = "is it empty?"
) -> Geometry:
    """Return parts as one object, or raise FormatError if there are none."""
    if not parts:
        raise FormatError(f"expected {expected}, found none; {hint}")
    return Geometry(*joined_meshes(parts))


def parts_of(scene: trimesh.Scene, kind: str) -> list[Part]:
    """Return every part of a scene that has "faces" or "vertices", as ``kind`` says."""
    from trimesh.transformations import transform_points

    parts = []
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        part = scene.geometry[name]
        if len(getattr(part, kind, ())):
            faces = np.asarray(getattr(part, "faces", np.empty((0, 3))), dtype=np.int64)
            vertices = transform_points(np.asarray(part.vertices, dtype=np.float64), transform)
            parts.append((vertices, turned_over(faces, transform[:3, :3])))
    return parts


def turned_over(faces: np.ndarray, transform: np.ndarray) -> np.ndarray:
    """Return faces (M, 3) that are seen from the same side after a transform (3, 3), which may mirror."""
    return faces[:, ::-1] if np.linalg.det(transform) < 0 else faces


def scaled(part: Part, scale: Any) -> Part:
    """Return a part scaled along its axes by one factor, by three, or, if ``scale`` is None, not at all."""
    factors = np.ones(3) if scale is None else np.asarray(scale, dtype=np.float64)
    if factors.size not in (1, 3):
        raise FormatError(f"expected one or three factors as the scale of a mesh, got {factors.size}")
    factors = np.broadcast_to(factors, 3)
    return part[0] * factors, turned_over(part[1], np.diag(factors))


def primitive(kind: str, **sizes: Any) -> Part:
    """Return the vertices and faces of one of trimesh's primitives, centred on the origin."""
    import trimesh

    mesh = getattr(trimesh.creation, kind)(**sizes)
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def scene_of(data: bytes, file_type: str, **options: Any) -> trimesh.Scene:
    """Return the scene that trimesh reads from bytes; errors are raised, and not logged as well."""
    import trimesh

    logging.getLogger("trimesh").addHandler(logging.NullHandler())
    return trimesh.load_scene(io.BytesIO(data), file_type=file_type, process=False, **options)


class _PlainTree(ElementTree.TreeBuilder):
    """Refuses XML that defines entities, which may expand without end; the parser finds that in any encoding."""

    def doctype(self, name: str, pubid: str | None, system: str | None):
        raise FormatError("expected XML without a document type of its own, got one; is it from a source you trust?")


def plain_xml(data: bytes) -> ElementTree.Element:
    """Return the tree of well-formed XML, or raise FormatError for a document type and for too much text.

    Prefixes of names need not be declared, as those of Drake are not.
    """
    require_text_size(data)
    try:
        return ElementTree.fromstring(data.lstrip(), ElementTree.XMLParser(target=_PlainTree()))
    except ElementTree.ParseError as error:
        if error.code != _UNDECLARED:
            raise
    prefixes = {prefix for prefix in _PREFIX.findall(data) if b"xmlns:" + prefix not in data}
    declared = b"".join(b' xmlns:%s="%s"' % (prefix, prefix) for prefix in sorted(prefixes))
    data = _FIRST_TAG.sub(rb"\g<0>" + declared, data.lstrip(), count=1)
    return ElementTree.fromstring(data, ElementTree.XMLParser(target=_PlainTree()))


def require_few_instances(children: Mapping[str, Sequence[str]], roots: Sequence[str]):
    """Raise FormatError for parts that contain themselves, and for too many parts in total.

    Parameters
    ----------
    children : mapping of str to sequence of str
        The parts that each part contains, repeated if it contains them several times.
    """
    open_parts: set[str] = set()

    @cache
    def shown(name: str) -> int:
        """Return the number of parts that a part shows, including itself."""
        if name in open_parts or len(open_parts) > 200:
            raise FormatError("expected parts of parts that end, got a circle; is the file damaged?")
        open_parts.add(name)
        count = 1 + sum(shown(child) for child in children.get(name, ()))
        open_parts.remove(name)
        return count

    count = sum(shown(root) for root in roots)
    if count > MAX_INSTANCES:
        raise FormatError(f"expected at most {MAX_INSTANCES:,} parts in its scene, got {count:,}; join them")
