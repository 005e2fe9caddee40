"""OBJ: vertices and faces of all objects and groups; materials are not read.

We do not use trimesh's reader: it counts relative indices (``f -3 -2 -1``) from the last vertex of the file instead of
from the last vertex so far, which scrambles files with several objects.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator

import numpy as np

from . import FormatError
from .files import require_counts, require_text_size
from .sources import Geometry, Source, fan_triangles


def _corner(word: str, vertex_count: int) -> int:
    """Return the vertex index, from 0, of ``7``, ``7/1``, ``7//3`` or, counted from the last vertex so far, ``-1``."""
    number = int(word.split("/", 1)[0])
    corner = number - 1 if number > 0 else vertex_count + number
    if number == 0 or corner < 0:
        raise FormatError(f"expected vertex numbers from 1, or -1 for the last, got {number}; is it damaged?")
    return corner


def _lines(data: bytes) -> Iterator[tuple[int, list[str]]]:
    """Yield the number and the words of each line, without comments; continued lines are joined."""
    joined = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").replace(b"\r", b"\n")
    start, number = 0, 0
    while start < len(joined):
        end = joined.find(b"\n", start)
        end = len(joined) if end < 0 else end
        number += 1
        yield number, joined[start:end].split(b"#", 1)[0].decode("utf-8", errors="replace").split()
        start = end + 1


def read_obj(source: Source) -> Geometry:
    """Return the vertices (N, 3) and triangles (M, 3); a cloud has no triangles."""
    points, groups = read_groups(source.data)
    return Geometry(points, np.concatenate(groups))


def read_groups(data: bytes) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the vertices (N, 3) of a file and the triangles (M, 3) of each group, starting with those in no group."""
    require_text_size(data)
    vertices, counts, corners, begins = array("d"), array("q"), array("q"), []
    for number, words in _lines(data):
        try:
            if words[:1] == ["v"]:
                vertices.extend((float(words[1]), float(words[2]), float(words[3])))
            elif words[:1] == ["f"]:
                corners.extend(_corner(word, len(vertices) // 3) for word in words[1:])
                counts.append(len(words) - 1)
            elif words[:1] in (["g"], ["o"]):
                begins.append(len(counts))
        except (ValueError, IndexError) as error:
            raise FormatError(f"line {number}: expected '{words[0]}' and its numbers: {error}") from error
    if not vertices:
        raise FormatError("expected lines of vertices ('v 1 2 3'), found none; is it an OBJ file?")
    require_counts(vertices=len(vertices) // 3, triangles=len(corners) - 2 * len(counts))
    triangles = fan_triangles(np.array(counts), np.array(corners))
    ends = np.append(0, np.cumsum(np.maximum(np.array(counts, np.int64) - 2, 0)))
    return np.array(vertices).reshape(-1, 3), np.split(triangles, ends[begins])
