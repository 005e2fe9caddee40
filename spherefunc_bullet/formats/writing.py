"""Every file that is written: whole or not at all, and one clear error."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from ..errors import InputError


def cache_home() -> Path:
    """Return the folder for what can be computed again: $SPHEREFUNC_CACHE, or the user's cache folder."""
    given = os.environ.get("SPHEREFUNC_CACHE")
    users = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return Path(given) if given else users / "spherefunc"


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
    """Make a folder for results, or say why it cannot be."""
    if folder is None:
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".writable"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(f"{folder}: expected a folder that can be written to; {error.strerror}") from error
