"""OFF, with or without colours."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from . import FormatError
from .polygons import fan_triangles

_HEADER = re.compile(r"\s*(?:ST)?(?:C)?(?:N)?OFF\b")


def read_off(data: bytes, path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the vertices (N, 3) and triangles (M, 3), None for a cloud."""
    text = re.sub(r"#[^\n]*", "", data.decode("ascii"))
    header = _HEADER.match(text)
    if header is None:
        raise FormatError("expected 'OFF' in the first line, found none; is it an OFF file?")
    lines = [line.split() for line in text[header.end() :].splitlines() if line.strip()]
    vertex_count, face_count = (int(word) for word in lines[0][:2])
    if vertex_count < 0 or face_count < 0 or len(lines) - 1 < vertex_count + face_count:
        raise FormatError(
            f"expected {vertex_count + face_count} lines of vertices and faces, got {len(lines) - 1}"
        )
    vertices = np.array([line[:3] for line in lines[1 : vertex_count + 1]], dtype=np.float64)
    polygons = lines[vertex_count + 1 : vertex_count + face_count + 1]
    counts = [int(line[0]) for line in polygons]
    corners = [
        int(word) for line, count in zip(polygons, counts, strict=True) for word in line[1 : count + 1]
    ]
    if sum(counts) != len(corners):
        raise FormatError(
            f"expected {sum(counts)} corners of faces, got {len(corners)}; is the file cut off?"
        )
    return vertices.reshape(-1, 3), fan_triangles(counts, corners) if counts else None
