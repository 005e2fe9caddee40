"""XYZ: one point a line, with spaces or commas; further columns and comments are passed over."""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np

from . import FormatError
from .geometry import Geometry
from .limits import require_counts, require_text_size

_COMMENT = re.compile(r"(?:#|//|%)[^\n]*")


def _is_heading(line: str) -> bool:
    """Return whether a first line names the columns or counts the points."""
    words = line.split()
    return len(words) == 1 or not re.match(r"[-+.\d]|nan|inf", words[0], re.IGNORECASE)


def read_xyz(data: bytes, path: Path) -> Geometry:
    """Return the points (N, 3)."""
    require_text_size(data)
    require_counts(points=data.count(b"\n"))
    text = _COMMENT.sub("", data.decode("utf-8-sig")).replace(",", " ").replace(";", " ").strip()
    first, _, rest = text.partition("\n")
    if first and _is_heading(first):
        text = rest
    if not text.strip():
        raise FormatError("expected lines of three numbers, found none; is the file empty?")
    return Geometry(np.loadtxt(io.StringIO(text), usecols=(0, 1, 2), ndmin=2))
