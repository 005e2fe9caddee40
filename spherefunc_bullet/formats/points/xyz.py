"""XYZ, CSV and TXT: one point per line; comments are skipped.

A heading may name the columns x, y and z; without one they are the first three columns.
"""

from __future__ import annotations

import io
import re

import numpy as np

from .. import FormatError
from ..files import require_counts, require_text_size
from ..sources import Geometry, Source

_COMMENT = re.compile(r"(?:#|//|%)[^\n]*")
_NUMBER = re.compile(r"[-+.\d]|nan|inf", re.IGNORECASE)


def read_xyz(source: Source) -> Geometry:
    """Return the points (N, 3).

    Raises
    ------
    FormatError
        If there are none, or a CSV file names columns but not x, y and z.
    """
    data = source.data
    require_text_size(data)
    require_counts(points=data.count(b"\n"))
    text = data.decode("utf-8-sig").strip()
    first, _, rest = text.partition("\n")
    words = _words(first.lstrip("#/% "))
    columns = _columns(words)
    if columns is not None:
        return Geometry(_numbers(rest, columns, next((mark for mark in ",;\t" if mark in first), None)))
    text = _COMMENT.sub("", text).strip()
    first, _, rest = text.partition("\n")
    words = _words(first)
    if len(words) > 1 and not _NUMBER.match(words[0]) and source.kind == ".csv":
        raise FormatError(f"expected columns named x, y and z, got {', '.join(words)[:80]}; name them so")
    has_heading = len(words) == 1 or (words and not _NUMBER.match(words[0]))  # one word counts the points
    return Geometry(_numbers(re.sub("[,;]", " ", rest if has_heading else text), (0, 1, 2), None))


def _words(line: str) -> list[str]:
    """Return a line's words, without quotation marks."""
    return [word.strip(" \t\"'") for word in re.split(r"[,;\t]\s*|\s+", line.strip())]


def _columns(words: list[str]) -> tuple[int, int, int] | None:
    """Return the indices of the columns x, y and z in a heading; None if it does not name them."""
    names = [word.lower() for word in words]
    return tuple(names.index(axis) for axis in "xyz") if {"x", "y", "z"} <= set(names) else None


def _numbers(text: str, columns: tuple[int, int, int], delimiter: str | None) -> np.ndarray:
    """Return three columns (N, 3) of a text with a row of numbers per line."""
    text = _COMMENT.sub("", text).strip("\r\n")
    if not text.strip():
        raise FormatError("expected lines of three numbers, found none; is the file empty?")
    return np.loadtxt(io.StringIO(text), usecols=columns, ndmin=2, delimiter=delimiter, quotechar='"')
