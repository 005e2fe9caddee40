"""PLY, ASCII and binary, meshes and clouds.

We do not use trimesh's reader: it takes the corner count of the first face for all faces of a binary file, so that a
mesh of triangles and quads is refused or, if the lengths happen to agree, misread.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass, field, replace

import numpy as np

from . import FormatError
from .files import require_counts, require_text_size
from .sources import Geometry, Source, fan_triangles

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8", "int64": "i8", "uint64": "u8",
}  # fmt: skip
_FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_FACE_LISTS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class _Property:
    name: str
    kind: str  # numpy type of the value, or of the items of a list
    count_kind: str = ""  # numpy type of a list's length; empty if it is not a list


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


def _parse_header(data: bytes) -> tuple[str, list[_Element], int]:
    """Return the byte order ("" for ASCII), the elements, and the offset of the body."""
    end = re.search(rb"(?:^|\n)[ \t]*end_header[ \t]*(?:\r\n|\n|\r)", data[: 1 << 20])
    if not data.startswith(b"ply") or end is None:
        raise FormatError("expected a PLY header from 'ply' to 'end_header', found none; is it a PLY file?")
    order, elements = None, []
    for line in data[: end.start()].decode("latin-1").splitlines()[1:]:
        words = line.split()
        match words[:1]:
            case ["format"]:
                order = _FORMATS.get(words[1])
            case ["element"]:
                elements.append(_Element(words[1], int(words[2])))
            case ["property"] if words[1] == "list":
                elements[-1].properties.append(_Property(words[4], _TYPES[words[3]], _TYPES[words[2]]))
            case ["property"]:
                elements[-1].properties.append(_Property(words[2], _TYPES[words[1]]))
    if order is None:
        raise FormatError(f"expected a PLY header with one of the formats {', '.join(_FORMATS)}; is it damaged?")
    return order, elements, end.end()


def _row_dtype(element: _Element, order: str, lengths: dict[str, int]) -> np.dtype:
    """Return the dtype of a row whose lists have the given lengths."""
    fields = []
    for prop in element.properties:
        if prop.count_kind:
            fields.append((f"{prop.name} count", order + prop.count_kind))
            fields.append((prop.name, order + prop.kind, (lengths[prop.name],)))
        else:
            fields.append((prop.name, order + prop.kind))
    return np.dtype(fields)


class _BinaryBody:
    """Reads values of given types from the bytes after the header."""

    def __init__(self, data: bytes, start: int, order: str):
        self.data, self.position, self.order = data, start, order

    def room(self, element: _Element) -> int:
        """Return how many rows of an element the remaining bytes could hold if its lists were empty."""
        sizes = (np.dtype(prop.count_kind or prop.kind).itemsize for prop in element.properties)
        return (len(self.data) - self.position) // max(1, sum(sizes))

    def take(self, kind: str, count: int) -> np.ndarray:
        values = np.frombuffer(self.data, self.order + kind, count, self.position)
        self.position += values.nbytes
        return values

    def table(self, element: _Element) -> np.ndarray | None:
        """Return all rows at once if their lists have the same lengths as those of the first row, else None."""
        start, lengths = self.position, {}
        for prop in element.properties:
            (first,) = self.take(prop.count_kind or prop.kind, 1)
            if prop.count_kind:
                lengths[prop.name] = int(first)
                self.take(prop.kind, max(lengths[prop.name], 0))
        self.position = start
        dtype = _row_dtype(element, self.order, lengths)
        if start + element.count * dtype.itemsize > len(self.data):
            return None
        rows = np.frombuffer(self.data, dtype, element.count, start)
        if any((rows[f"{p.name} count"] != lengths[p.name]).any() for p in element.properties if p.count_kind):
            return None
        self.position += rows.nbytes
        return rows


class _TextBody(_BinaryBody):
    """The same for numbers as text: values and list lengths are all numbers of one array."""

    def __init__(self, data: bytes, start: int):
        require_text_size(data)
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # numpy stops at anything that is not a number, and only warns
            numbers = np.fromstring(data[start:].decode("ascii"), sep=" ")
        super().__init__(numbers.tobytes(), 0, "")

    def room(self, element: _Element) -> int:
        return (len(self.data) - self.position) // (8 * max(1, len(element.properties)))

    def take(self, kind: str, count: int) -> np.ndarray:
        return super().take("f8", count)

    def table(self, element: _Element) -> np.ndarray | None:
        as_numbers = [_Property(p.name, "f8", "f8" if p.count_kind else "") for p in element.properties]
        return super().table(_Element(element.name, element.count, as_numbers))


def _read_element(body: _BinaryBody, element: _Element) -> dict[str, list] | np.ndarray:
    """Return the columns of an element."""
    if not 0 <= element.count <= body.room(element):
        raise FormatError(f"expected {element.count} of '{element.name}', more than the file holds; is it cut off?")
    if not element.count or not element.properties:
        return {}
    if (rows := body.table(element)) is not None:
        return rows
    columns = {prop.name: [] for prop in element.properties}
    for _ in range(element.count):  # row by row, since the lists differ in length
        for prop in element.properties:
            count = int(body.take(prop.count_kind, 1)[0]) if prop.count_kind else 1
            if count < 0:
                raise FormatError(f"expected lists of no negative length, got {count}; is the file damaged?")
            columns[prop.name].append(body.take(prop.kind, count) if count else np.empty(0))
    return columns


def _triangles(columns: dict[str, list] | np.ndarray, element: _Element) -> np.ndarray:
    """Return the triangles of the face element."""
    name = next((p.name for p in element.properties if p.name in _FACE_LISTS and p.count_kind), None)
    if name is None:
        raise FormatError("expected faces as a list 'vertex_indices', found none; save it as a mesh or a cloud")
    if isinstance(columns, np.ndarray):
        corners = columns[name]
        return fan_triangles(np.full(len(corners), corners.shape[1]), corners.reshape(-1))
    return fan_triangles([len(polygon) for polygon in columns[name]], np.concatenate(columns[name]))


def _colors(columns: dict[str, np.ndarray], element: _Element) -> np.ndarray | None:
    """Return the colours of the vertices (N, 3) uint8, None if there are none; floats range from 0 to 1."""
    kinds = {prop.name: prop.kind for prop in element.properties if not prop.count_kind}
    if not all(name in kinds for name in ("red", "green", "blue")):
        return None
    channels = np.column_stack([columns[name] for name in ("red", "green", "blue")])
    return np.clip(channels * (255 if kinds["red"][0] == "f" else 1), 0, 255).astype(np.uint8)


def read_ply(source: Source) -> Geometry:
    """Return the vertices (N, 3) with their colours and labels, and the triangles (M, 3); a cloud has no triangles."""
    data = source.data
    order, elements, start = _parse_header(data)
    declared = {element.name: element.count for element in elements}
    require_counts(vertices=declared.get("vertex", 0), triangles=declared.get("face", 0))
    body = _BinaryBody(data, start, order) if order else _TextBody(data, start)
    geometry = Geometry(np.empty((0, 3)))
    for element in elements:
        columns = _read_element(body, element)
        if element.name == "vertex" and element.count:
            vertices = np.column_stack([np.asarray(columns[axis], dtype=np.float64) for axis in "xyz"])
            has_labels = any(prop.name == "label" and not prop.count_kind for prop in element.properties)
            labels = np.asarray(columns["label"]).astype(np.int64) if has_labels else None
            geometry = Geometry(vertices, colors=_colors(columns, element), labels=labels)
        elif element.name == "face" and element.count:
            geometry = replace(geometry, faces=_triangles(columns, element))
        elif element.name == "tristrips" and element.count:
            raise FormatError("expected faces, got triangle strips; save it with faces")
    return geometry


COARSE = 0.001  # metres between neighbouring numbers of 32 bits, more than which loses shape
_WRITTEN = {"<f4": "float", "<f8": "double", "|u1": "uchar", "<i4": "int"}


def step_of_float32(points: np.ndarray) -> float:
    """Return the distance between neighbouring numbers of 32 bits at the farthest coordinate of points (N, 3)."""
    farthest = np.float64(np.abs(points).max(initial=0.0))
    return float(np.spacing(farthest)) * 2**29  # a double has so many steps between them


def ply_bytes(points: np.ndarray, comment: str, **attributes: np.ndarray) -> bytes:
    """Return points (N, 3) as a binary PLY file, with coordinates in float64 if they are too far out for float32.

    Parameters
    ----------
    comment : str
        One line of the header.
    **attributes : (N,) uint8 or int32
        Further properties of each point, by name.
    """
    columns = dict(zip("xyz", points.T, strict=True)) | attributes
    real = "<f8" if step_of_float32(points) > COARSE else "<f4"
    kinds = dict.fromkeys("xyz", real) | {name: values.dtype.str for name, values in attributes.items()}
    rows = np.empty(len(points), list(kinds.items()))
    for name, values in columns.items():
        rows[name] = values
    header = ["ply", "format binary_little_endian 1.0", f"comment {comment}", f"element vertex {len(points)}"]
    header += [f"property {_WRITTEN[kind]} {name}" for name, kind in kinds.items()]
    return "\n".join([*header, "end_header", ""]).encode("utf-8", "replace") + rows.tobytes()
