"""``sensor_msgs/PointCloud2`` as arrays: the same whether rclpy, rospy or `rosbags` made the message."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from spherefunc_bullet.errors import InputError, explaining

# ``sensor_msgs/PointField``: the numbers of its types, and numpy's names of them without the order of bytes.
DATATYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
COLOUR_FIELDS = ("rgb", "rgba")  # 0xAARRGGBB in four bytes, whatever type they are called


class PointField(Protocol):
    """``sensor_msgs/PointField``."""

    name: str
    offset: int  # bytes
    datatype: int
    count: int


class PointCloud2(Protocol):
    """``sensor_msgs/PointCloud2``."""

    header: Any  # stamp and frame_id
    height: int
    width: int
    fields: Sequence[PointField]
    is_bigendian: bool
    point_step: int  # bytes
    row_step: int
    data: Any  # bytes, or an array of them


def records_of(message: PointCloud2, name: str = "cloud") -> np.ndarray:
    """Return a message's points as records (N,) with its fields, row after row.

    Raises
    ------
    InputError
        If the message is cut off, or its fields do not fit into a point.
    """
    order = ">" if message.is_bigendian else "<"
    height, width, step = int(message.height), int(message.width), int(message.point_step)
    known = {field.name: field for field in reversed(message.fields) if field.datatype in DATATYPES}
    fields = list(known.values())  # the first of each name: several are called `_` where PCL's points are padded
    layout = {
        "names": [field.name for field in fields],
        "formats": [order + DATATYPES[field.datatype] for field in fields],
        "offsets": [int(field.offset) for field in fields],
        "itemsize": step,
    }
    data = np.frombuffer(memoryview(message.data), np.uint8)
    row = int(message.row_step) if height > 1 else width * step
    if row * height > len(data) or width * step > row:
        wanted = f"{message.height} x {message.width} points of {message.point_step} bytes"
        raise InputError(f"{name}: expected {wanted}, got {len(data)} bytes; is the message cut off?")
    with explaining(f"{name}: expected fields within {message.point_step} bytes a point", ValueError, why="; "):
        dtype = np.dtype(layout)
    rows = data[: row * height].reshape(height, row)
    return np.ascontiguousarray(rows[:, : width * step]).view(dtype).reshape(height * width)


def points_of(message: PointCloud2, name: str = "cloud") -> np.ndarray:
    """Return a message's points (N, 3) float64 in its frame, metres; NaN where the sensor saw nothing.

    Raises
    ------
    InputError
        If it lacks x, y or z, one of them has no valid type, or it is damaged.
    """
    types = {field.name: field.datatype for field in message.fields}
    if not {"x", "y", "z"} <= set(types):
        raise InputError(f"{name}: expected the fields x, y and z, got {', '.join(sorted(types)) or 'none'}")
    odd = next((axis for axis in "xyz" if types[axis] not in DATATYPES), None)
    if odd is not None:
        raise InputError(f"{name}: expected {odd} of a datatype from 1 to 8, got {types[odd]}; is the message damaged?")
    records = records_of(message, name)
    return np.column_stack([records[axis].astype(np.float64) for axis in "xyz"])


def colours_of(message: PointCloud2, name: str = "cloud") -> np.ndarray | None:
    """Return a message's colours (N, 3) uint8; None without any."""
    known = [field.name for field in message.fields if field.datatype in DATATYPES]
    colour = next((name for name in known if name in COLOUR_FIELDS), None)
    if colour is None:
        return None
    packed = np.ascontiguousarray(records_of(message, name)[colour])
    if packed.dtype.itemsize != 4:
        return None
    bits = packed.view(packed.dtype.newbyteorder("=").str.replace("f", "u").replace("i", "u"))
    if packed.dtype.byteorder == ">":
        bits = bits.byteswap()
    return np.column_stack([bits >> 16 & 255, bits >> 8 & 255, bits & 255]).astype(np.uint8)
