"""OFF, with or without colours."""

from __future__ import annotations

import re
from array import array

import numpy as np

from . import FormatError
from .files import require_counts, require_text_size
from .sources import Geometry, Source, fan_triangles

_HEADER = re.compile(r"\s*(?:ST)?(?:C)?(?:N)?OFF\b")


def read_off(source: Source) -> Geometry:
    """Return the vertices (N, 3) and triangles (M, 3); a cloud has no triangles."""
    data = source.data
    require_text_size(data)
    # Comments may be in any encoding, numbers are ASCII.
    text = re.sub(r"#[^\n]*", "", data.removeprefix(b"\xef\xbb\xbf").decode("latin-1"))
    header = _HEADER.match(text)
    if header is None:
        raise FormatError("expected 'OFF' before its numbers, found none; is it an OFF file?")
    lines = [line for line in text[header.end() :].splitlines() if line.strip()]
    vertex_count, face_count = (int(word) for word in lines[0].split()[:2])
    require_counts(vertices=vertex_count, triangles=face_count)
    if vertex_count < 0 or face_count < 0 or len(lines) - 1 < vertex_count + face_count:
        raise FormatError(f"expected {vertex_count + face_count} lines of vertices and faces, got {len(lines) - 1}")
    coordinates, counts, corners = array("d"), array("q"), array("q")
    for line in lines[1 : vertex_count + 1]:
        coordinates.extend(_numbers(float, line.split()[:3], 3))
    for line in lines[vertex_count + 1 : vertex_count + face_count + 1]:
        words = line.split()
        counts.append(int(words[0]))
        corners.extend(_numbers(int, words[1 : counts[-1] + 1], counts[-1]))
    vertices = np.array(coordinates).reshape(-1, 3)
    return Geometry(vertices, fan_triangles(np.array(counts), np.array(corners)))


def _numbers(kind: type, words: list[str], count: int) -> list:
    """Return ``count`` words as numbers, or raise FormatError if there are fewer."""
    if len(words) != count:
        raise FormatError(f"expected {count} numbers in a line, got {len(words)}; is the file cut off?")
    return [kind(word) for word in words]
