"""Every file that is written: one clear line where the disk refuses, and whole or not at all where it matters."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import InputError


def cache_home() -> Path:
    """Return the folder for what can be computed again: $SPHEREFUNC_CACHE, or the user's cache folder."""
    given = os.environ.get("SPHEREFUNC_CACHE")
    users = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return Path(given) if given else users / "spherefunc"


@contextmanager
def writing(place: Path, what: str = "a file", kind: type[InputError] = InputError) -> Iterator[None]:
    """Turn what the system raises within into one line for the user, such as of a full disk.

    Parameters
    ----------
    place : Path
        What is written.
    what : str
        What it is, for the line.
    kind : type
        Of the error that is raised.
    """
    try:
        yield
    except OSError as error:
        raise kind(f"{place}: expected {what} that can be written; {error.strerror or error}") from error


def unused_name(folder: Path, stem: str, suffix: str, written: Sequence[Path]) -> Path:
    """Return a file's path that is none of those written; two files of one stem get two names."""
    number = 1
    while (path := folder / (f"{stem}_{number}{suffix}" if number > 1 else f"{stem}{suffix}")) in written:
        number += 1
    return path


def write_bytes(path: Path, content: bytes) -> Path:
    """Write a file, and the folder that it lies in; return its path.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return path


def write_text(path: Path, text: str) -> Path:
    """Write a text in UTF-8; what that has no bytes for, as in some files' names, becomes ``?``. See `write_bytes`."""
    return write_bytes(path, text.encode("utf-8", "replace"))


def write_csv(path: Path, columns: Iterable[str], rows: Iterable[Iterable]) -> Path:
    """Write a table in one step, so that a reader never finds half of it; see `write_bytes`."""
    part = path.with_name(f"{path.name}.part")
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        with part.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(columns)
            writer.writerows(rows)
        os.replace(part, path)
    return path


def write_whole(path: Path, content: bytes):
    """Write a file under a name of its own first, so that nobody ever reads half of it.

    Raises
    ------
    OSError
        If it cannot be written; then nothing is left of it.
    """
    scratch = path.with_suffix(f".{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch.write_bytes(content)
        os.replace(scratch, path)
    except OSError:
        with suppress(OSError):
            scratch.unlink(missing_ok=True)
        raise


def prepare_folder(folder: Path | None):
    """Make a folder for results before hours are spent on them, or say why it cannot be."""
    if folder is None:
        return
    with writing(folder, "a folder"):
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".writable"
        probe.touch()
        probe.unlink()


def require_place(file: Path):
    """Refuse a file that could not be written, before hours are spent on what it is to hold."""
    folder = file.absolute().parent
    if file.is_dir() or not folder.is_dir() or not os.access(folder, os.W_OK):
        came = "a folder" if file.is_dir() else "a folder that is missing or read-only"
        raise InputError(f"{file}: expected a file that can be written, got {came}")
