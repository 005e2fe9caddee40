"""What a point cloud's file says of each point beside where it is: its colour, and its label."""

from __future__ import annotations

from pathlib import Path

import numpy as np


def read_attributes(path: Path) -> dict[str, np.ndarray]:
    """Return the attributes of a PLY's or a PCD's points, by name; none of other formats.

    The file has been read before, and is sound.

    Returns
    -------
    dict
        ``color`` (N, 3) uint8 and ``label`` (N,) int64, where the file has them.
    """
    readers = {".ply": _ply_attributes, ".pcd": _pcd_attributes}
    reader = readers.get(path.suffix.lower())
    return reader(path.read_bytes()) if reader else {}


def _ply_attributes(data: bytes) -> dict[str, np.ndarray]:
    from .ply import vertex_columns

    columns = vertex_columns(data)
    found = {}
    if all(name in columns for name in ("red", "green", "blue")):
        channels = np.column_stack([columns[name] for name in ("red", "green", "blue")])
        found["color"] = np.clip(channels * (255 if channels.dtype.kind == "f" else 1), 0, 255).astype(np.uint8)
    if "label" in columns:
        found["label"] = columns["label"].astype(np.int64)
    return found


def _pcd_attributes(data: bytes) -> dict[str, np.ndarray]:
    from .pcd import point_columns

    columns, _ = point_columns(data)
    names = columns.dtype.names if isinstance(columns, np.ndarray) else columns
    name = next((each for each in ("rgb", "rgba") if each in names), None)
    if name is None:
        return {}
    packed = np.ascontiguousarray(columns[name]).reshape(-1)
    packed = packed.view(np.uint32) if packed.dtype.itemsize == 4 else packed.astype(np.uint32)
    return {"color": np.column_stack([packed >> 16 & 255, packed >> 8 & 255, packed & 255]).astype(np.uint8)}
