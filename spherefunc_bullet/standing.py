"""What a ledger's row is worth now: the same object, and its centres where they were put?"""

from __future__ import annotations

from pathlib import Path

from .cache import read_entry
from .errors import InputError
from .ledger import DONE, WAITING, Row
from .run_folder import RunFolder, digest
from .simulation import Loading, content_hash, file_parts


def still_holds(row: Row, path: Path, folder: RunFolder, loading: Loading, retry_failed: bool) -> bool:
    """Return whether a row is as true as when it was written: same object, and the centres are there.

    Sizes and times tell; where they differ, as after a copy, the contents do.
    """
    if row.outcome == WAITING or (row.outcome != DONE and retry_failed):
        return False
    if row.source != source_stamp(path) and not same_content(row, path, loading):
        return False
    return row.outcome != DONE or is_kept(row, folder)


def same_content(row: Row, path: Path, loading: Loading) -> bool:
    """Return whether a file holds what it held when a row was written."""
    try:
        return content_hash(path, loading) == row.content
    except InputError:
        return False


def source_stamp(path: Path) -> str:
    """Return the size and time of an object's file, and of what belongs to it; empty if there is none."""
    try:
        about = [part.stat() for part in file_parts(path)]
    except OSError:
        return ""
    return f"{sum(each.st_size for each in about)} {max(each.st_mtime_ns for each in about)}"


def is_kept(row: Row, folder: RunFolder) -> bool:
    """Return whether the centres of a row are where they were put; what is not them is thrown away."""
    path = folder.entry(row.run)
    try:
        about = path.stat()
    except OSError:
        return False
    if (about.st_size, about.st_mtime_ns) == (row.bytes, row.kept):
        return True
    arrays = read_entry(path)
    if arrays is not None and "centers" in arrays and digest(arrays["centers"]) == row.digest:
        return True
    path.unlink(missing_ok=True)
    return False
