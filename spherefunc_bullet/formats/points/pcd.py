"""PCD, the point cloud format of PCL: ASCII, binary and compressed (LZF), organised or not.

We do not use Open3D's reader: it silently returns an empty cloud for a damaged file, and takes two seconds to import.
"""

from __future__ import annotations

import io

import numpy as np

from .. import FormatError
from ..files import require_counts, require_text_size, require_unpacked
from ..sources import Geometry, Source

_KINDS = {"F": "f", "I": "i", "U": "u"}
_KEPT = ("x", "y", "z", "rgb", "rgba")  # the fields that we read
_MAX_RATIO = 300  # LZF packs at most 264 bytes into 3; larger ratios mean that the sizes are damaged


def _parse_header(data: bytes) -> tuple[dict[str, list[str]], int]:
    """Return the words of the header by key, and the offset of the body."""
    header, position = {}, 0
    while "DATA" not in header:
        end = data.find(b"\n", position, position + 65536)
        if end < 0:
            raise FormatError("expected a PCD header that ends with 'DATA', found none; is it a PCD file?")
        words = data[position:end].decode("ascii").split()
        position = end + 1
        if words and not words[0].startswith("#"):
            header[words[0].upper()] = words[1:]
    return header, position


def _row_dtype(header: dict[str, list[str]]) -> np.dtype:
    """Return the dtype of one point; several fields may be called ``_``, so fields that we do not read are numbered."""
    names = header["FIELDS"]
    counts = header.get("COUNT", ["1"] * len(names))
    fields = []
    for n, (name, size, kind, count) in enumerate(zip(names, header["SIZE"], header["TYPE"], counts, strict=True)):
        unique = name if name in _KEPT else f"{n} {name}"
        fields.append((unique, f"<{_KINDS[kind]}{int(size)}", (int(count),)))
    return np.dtype(fields)


def _compressed_columns(body: bytes, dtype: np.dtype, count: int) -> dict[str, np.ndarray]:
    """Return the columns of a compressed body, which stores the values of each field together."""
    from .lzf import unpack

    packed_size, size = np.frombuffer(body, "<u4", 2).tolist()
    if size != count * dtype.itemsize or packed_size > len(body) - 8 or size > _MAX_RATIO * max(packed_size, 1):
        raise FormatError(f"expected {count} compressed points, their sizes do not agree; is the file damaged?")
    require_unpacked(size)
    unpacked = np.empty(size, np.uint8)
    if unpack(np.frombuffer(body, np.uint8, packed_size, 8), unpacked) != size:
        raise FormatError("expected compressed points, could not unpack them; is the file damaged?")
    columns, position = {}, 0
    for name in dtype.names:
        kind = dtype[name]
        columns[name] = unpacked[position : position + count * kind.itemsize].view(kind.base)
        position += count * kind.itemsize
    return columns


def _text_columns(body: bytes, dtype: np.dtype, count: int) -> dict[str, np.ndarray]:
    """Return the coordinates of an ASCII body, and the colours if there are any."""
    require_text_size(body)
    if count > body.count(b"\n") + 1:
        raise FormatError(f"expected {count} points, got fewer lines; is the file cut off?")
    names = [name for name in _KEPT if name in dtype.names]
    widths = [dtype[name].shape[0] for name in dtype.names]
    starts = dict(zip(dtype.names, np.cumsum([0, *widths[:-1]]), strict=True))
    columns = [int(starts[name]) for name in names]
    rows = np.loadtxt(io.StringIO(body.decode("ascii")), usecols=columns, ndmin=2, max_rows=count)
    return {name: row.astype(dtype[name].base) for name, row in zip(names, rows.T, strict=True)}


def _binary_columns(body: bytes, dtype: np.dtype, count: int) -> np.ndarray:
    """Return the rows of a binary body."""
    if count * dtype.itemsize > len(body):
        raise FormatError(f"expected {count} points, the file holds {len(body) // dtype.itemsize}; is it cut off?")
    return np.frombuffer(body, dtype, count)


_BODIES = {"ascii": _text_columns, "binary": _binary_columns, "binary_compressed": _compressed_columns}


def point_columns(data: bytes) -> tuple[dict[str, np.ndarray] | np.ndarray, int]:
    """Return the fields by name, with rgb still packed, and the declared number of points."""
    header, start = _parse_header(data)
    missing = [axis for axis in "xyz" if axis not in header["FIELDS"]]
    if missing:
        fields = " ".join(header["FIELDS"])[:80]
        raise FormatError(f"expected fields x, y and z, got {fields}; it holds an image or features, no points")
    dtype = _row_dtype(header)
    count = int(header["POINTS"][0]) if "POINTS" in header else int(header["WIDTH"][0]) * int(header["HEIGHT"][0])
    require_counts(points=count)
    return _BODIES[header["DATA"][0]](data[start:], dtype, count), count


def _colors(columns: dict[str, np.ndarray] | np.ndarray) -> np.ndarray | None:
    """Return the colours (N, 3) uint8 of the field rgb or rgba; None if there is neither."""
    names = columns.dtype.names if isinstance(columns, np.ndarray) else columns
    name = next((name for name in ("rgb", "rgba") if name in names), None)
    if name is None:
        return None
    packed = np.ascontiguousarray(columns[name]).reshape(-1)
    packed = packed.view(np.uint32) if packed.dtype.itemsize == 4 else packed.astype(np.uint32)
    return np.column_stack([packed >> 16 & 255, packed >> 8 & 255, packed & 255]).astype(np.uint8)


def read_pcd(source: Source) -> Geometry:
    """Return the points (N, 3) and their colours; points that the sensor did not measure are NaN."""
    columns, count = point_columns(source.data)
    points = np.column_stack([np.asarray(columns[axis], dtype=np.float64).reshape(-1) for axis in "xyz"])
    if count < 0 or len(points) != count:
        raise FormatError(f"expected {count} points, got {len(points)}; is the file cut off?")
    colors = _colors(columns)
    return Geometry(points, colors=colors if colors is not None and len(colors) == count else None)
