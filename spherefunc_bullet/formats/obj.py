"""OBJ: vertices and faces of all objects and groups; materials are not opened.

Not trimesh's reader: it takes relative indices (``f -3 -2 -1``) from the last vertex of the file instead of
from the last vertex so far, which scrambles files of several objects.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from . import FormatError
from .polygons import fan_triangles


def _corner(word: str, vertex_count: int) -> int:
    """Return the vertex number of ``7``, ``7/1``, ``7//3`` or, from the last vertex so far, ``-1``."""
    number = int(word.split("/", 1)[0])
    corner = number - 1 if number > 0 else vertex_count + number
    if number == 0 or corner < 0:
        raise FormatError(f"expected vertex numbers from 1, or -1 for the last, got {number}; is it damaged?")
    return corner


def read_obj(data: bytes, path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the vertices (N, 3) and triangles (M, 3), None for a cloud."""
    vertices, counts, corners = [], [], []
    text = data.decode("utf-8", errors="replace").replace("\\\r\n", " ").replace("\\\n", " ")
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split("#", 1)[0].split()
        try:
            if words[:1] == ["v"]:
                vertices.append((float(words[1]), float(words[2]), float(words[3])))
            elif words[:1] == ["f"]:
                corners.extend(_corner(word, len(vertices)) for word in words[1:])
                counts.append(len(words) - 1)
        except (ValueError, IndexError) as error:
            raise FormatError(f"line {number}: expected '{words[0]}' and its numbers: {error}") from error
    if not vertices:
        raise FormatError("expected lines of vertices ('v 1 2 3'), found none; is it an OBJ file?")
    return np.array(vertices), fan_triangles(counts, corners) if counts else None
