"""What a ledger's row is worth now: the same object, and its centres where they were put?"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ..errors import InputError
from ..formats.sources import as_source
from ..settling.cache import read_entry
from ..settling.records import Dropping
from .folder import RunFolder, digest, size_and_time
from .ledger import DONE, WAITING, Row


def valid_row(row: Row, path: Path, folder: RunFolder, dropping: Dropping, retry_failed: bool) -> Row | None:
    """Return a row that is as true as when it was written: same object, and the centres are there. Else None.

    Sizes and times tell; where they differ, as after a copy, the contents do, and the row notes the new ones.
    """
    if row.outcome == WAITING or (row.outcome != DONE and retry_failed):
        return None
    stamp = source_stamp(path)
    if row.source != stamp and not same_content(row, path, dropping):
        return None
    if row.outcome != DONE:
        return replace(row, source=stamp)
    about = kept_file(row, folder)
    return about and replace(row, source=stamp, **about)


def same_content(row: Row, path: Path, dropping: Dropping) -> bool:
    """Return whether a file holds what it held when a row was written."""
    try:
        return dropping.content_hash(path) == row.content
    except InputError:
        return False


def source_stamp(path: Path) -> str:
    """Return the size and time of an object's file, and of each that it names; empty if one is not there."""
    try:
        about = [part.path.stat() for part in as_source(path).parts()]
    except (OSError, ValueError):  # InputError is a ValueError, and so is a name that no file can have
        return ""
    return " ".join(f"{file.st_size} {file.st_mtime_ns}" for file in about)


def kept_file(row: Row, folder: RunFolder) -> dict[str, int] | None:
    """Return size and time of the file of a row's centres; what is not that file is thrown away."""
    path = folder.entry(row.run)
    try:
        now = size_and_time(path)
    except OSError:
        return None
    if now == {"bytes": row.bytes, "kept": row.kept}:
        return now
    arrays = read_entry(path)
    if arrays is not None and "centers" in arrays and digest(arrays["centers"]) == row.digest:
        return now
    path.unlink(missing_ok=True)
    return None
