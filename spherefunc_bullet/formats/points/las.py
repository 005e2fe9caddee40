"""LAS and LAZ, read by laspy: points only."""

from __future__ import annotations

import io
import struct

from .. import FormatError
from ..files import require_counts, require_unpacked
from ..sources import Geometry, Source

_RECORD, _LONG_RECORD = 54, 60  # minimum size in bytes of the records that the header counts besides the points


def _require_records(data: bytes) -> None:
    """Raise FormatError for more records than the file can hold; laspy would allocate as many as the header says."""
    if len(data) < 247:
        raise FormatError("expected a LAS header, the file is shorter; is it cut off?")
    size = _RECORD * struct.unpack_from("<I", data, 100)[0]
    if data[25] >= 4:
        size += _LONG_RECORD * struct.unpack_from("<I", data, 243)[0]
    if size > len(data):
        raise FormatError("expected as many records as its header says, the file is shorter; is it damaged?")


def _require_chunks(data: bytes, start: int) -> None:
    """Raise FormatError unless the chunk table of a LAZ file fits into it; lazrs would abort the process."""
    table = struct.unpack_from("<q", data, start)[0] if start + 8 <= len(data) else -1
    if not start + 8 <= table <= len(data) - 8:
        raise FormatError("expected a table of its chunks at the end, found none; is the file cut off?")
    if struct.unpack_from("<I", data, table + 4)[0] > table - start:
        raise FormatError("expected as many chunks as its table says, the file is shorter; is it damaged?")


def read_las(source: Source) -> Geometry:
    """Return the points (N, 3), scaled and shifted as the file says."""
    import laspy
    import lazrs  # noqa: F401 - laspy imports it only for compressed files

    data = source.data
    _require_records(data)
    with laspy.open(io.BytesIO(data)) as file:
        header = file.header
        require_counts(points=header.point_count)
        require_unpacked(header.point_count * header.point_format.size)
        packed = header.are_points_compressed
        if not packed and header.point_count * header.point_format.size > len(data):
            raise FormatError(f"expected {header.point_count} points, the file is shorter; is it cut off?")
        if packed:
            _require_chunks(data, struct.unpack_from("<I", data, 96)[0])
        points = file.read()
    if len(points) != header.point_count:
        raise FormatError(f"expected {header.point_count} points, got {len(points)}; is the file cut off?")
    return Geometry(points.xyz)
