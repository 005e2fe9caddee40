"""glTF and GLB, read by trimesh: all parts in one frame, without materials.

Trimesh receives the buffers as bytes and opens no files itself; buffers outside the folder of the file are refused.
"""

from __future__ import annotations

import json
from typing import Any
from urllib.parse import unquote

from .. import FormatError
from ..files import MAX_FILE_BYTES, MAX_TRIANGLES
from ..sources import Geometry, Source, inside
from .parts import joined, parts_of, scene_of

Tree = dict[str, Any]  # a part of the file's JSON
MAX_CORNERS = 3 * MAX_TRIANGLES  # of all parts, each counted as often as the scene shows it
_ITEM_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_ITEMS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_PACKED = (
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "EXT_mesh_gpu_instancing",
)
_READABLE_MODES = (0, 1, 4, 5)  # points, lines (ignored), triangles, triangle strips


def _parse_tree(data: bytes) -> Tree:
    """Return the JSON part of a glTF or GLB file."""
    if data.startswith(b"glTF"):
        if len(data) < 20 or int.from_bytes(data[8:12], "little") > len(data):
            raise FormatError("expected a GLB file as long as its header says, it is shorter; is it cut off?")
        data = data[20 : 20 + int.from_bytes(data[12:16], "little")]
    return json.loads(data)


def _require_sizes(tree: Tree) -> None:
    """Raise FormatError for what trimesh does not unpack, and for more data than a file of any size may declare."""
    packed = [name for name in _PACKED if name in tree.get("extensionsUsed", [])]
    if packed:
        raise FormatError(f"expected plain geometry, got {packed[0]}; save it without compression and instancing")
    accessors = tree.get("accessors", [])
    for accessor in accessors:
        if not isinstance(accessor["count"], int) or accessor["count"] < 0:
            raise FormatError(f"expected accessors with a count, got {accessor['count']!r}; is the file damaged?")
    total = sum(a["count"] * _ITEM_BYTES[a["componentType"]] * _ITEMS[a["type"]] for a in accessors)
    if total > MAX_FILE_BYTES:
        raise FormatError(f"expected at most {MAX_FILE_BYTES >> 20} MiB of geometry, got {total >> 20} MiB declared")
    corners = [sum(_count_corners(p, accessors) for p in mesh["primitives"]) for mesh in tree.get("meshes", [])]
    shown = sum(corners[node["mesh"]] for node in tree.get("nodes", []) if "mesh" in node)
    if shown > MAX_CORNERS:
        raise FormatError(f"expected at most {MAX_CORNERS} corners of faces, got {shown}; simplify the mesh")


def _count_corners(primitive: Tree, accessors: list[Tree]) -> int:
    """Return the number of vertices that one part draws."""
    if primitive.get("mode", 4) not in _READABLE_MODES:
        raise FormatError("expected triangles or triangle strips, got another kind; save it as triangles")
    used = primitive["attributes"]["POSITION"]
    if odd := [name for name in ("normalized", "sparse") if accessors[used].get(name)]:
        raise FormatError(f"expected plain positions, got {odd[0]} ones, as of a quantized mesh; save it without that")
    return max(accessors[used]["count"], accessors[primitive.get("indices", used)]["count"])


def named_sources(source: Source) -> dict[str, Source]:
    """Return the buffers that are files, by URI; all must be in the folder of the file or below it."""
    folder, buffers = source.path.parent.resolve(), {}
    for uri in (buffer.get("uri", "data:") for buffer in _parse_tree(source.data).get("buffers", [])):
        if uri.startswith("data:"):
            continue
        target = None if "://" in uri else inside(folder / unquote(uri), [folder])
        if target is None:
            raise FormatError(f"expected its buffers in its own folder, got {uri[:80]!r}; put them beside it")
        buffers[uri] = Source(target, "")
    return buffers


def read_gltf(source: Source) -> Geometry:
    """Return the vertices (N, 3) and triangles (M, 3) of all parts; if none has triangles, their points."""
    data, tree = source.data, _parse_tree(source.data)
    _require_sizes(tree)
    for buffer in tree.get("buffers", []):
        if (named := source.named.get(buffer.get("uri", ""))) and len(named.data) < buffer["byteLength"]:
            sizes = f"{buffer['byteLength']:,} bytes in {buffer['uri'][:80]!r}, got {len(named.data):,}"
            raise FormatError(f"expected {sizes}; is its download cut off?")
    file_type = "glb" if data.startswith(b"glTF") else "gltf"
    buffers = {uri: buffer.data for uri, buffer in source.named.items()}
    scene = scene_of(data, file_type, resolver=buffers, skip_materials=True)
    return joined(parts_of(scene, "faces") or parts_of(scene, "vertices"))
