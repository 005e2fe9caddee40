"""Files on disk: checked for type and size before they are read, and written completely or not at all.

All limits are checked before the data are loaded. Together they keep the memory for reading one file below 2 GiB.
"""

from __future__ import annotations

import csv
import io
import os
import stat
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath

from ..errors import InputError, OutOfMemory, one_line
from . import FormatError

MAX_FILE_BYTES = 512 << 20  # of a model or scan, including the files that it names
MAX_TEXT_BYTES = 128 << 20  # of a text file, which takes several times its size to read
MAX_UNPACKED_BYTES = 512 << 20  # of all members of an archive together; a small archive can declare any size
MAX_MEMBERS = 10_000  # of an archive
MAX_TRIANGLES = 10_000_000
MAX_VERTICES = 20_000_000  # of a mesh, or points of a cloud
OPTIONAL = ("collada", "lxml", "yourdfpy", "laspy", "lazrs", "mujoco", "pxr")  # installed by the extra ``formats``


def require_ordinary(path: Path) -> int:
    """Return the size of a file in bytes; raise InputError if it is not a regular file, such as a pipe."""
    shown = one_line(path)
    try:
        about = path.stat()
    except (FileNotFoundError, NotADirectoryError) as error:
        raise InputError(f"{shown}: expected a file, found none; check the path") from error
    except (OSError, ValueError) as error:  # the name is too long, or contains a null byte
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{shown[:200]}: cannot be read: {reason}; check the path") from error
    if stat.S_ISDIR(about.st_mode):
        raise InputError(f"{shown}: expected a file, got a folder; name a file in it")
    if not stat.S_ISREG(about.st_mode):  # a pipe or a device may never end
        raise InputError(f"{shown}: expected an ordinary file, got a pipe or a device; copy it to a file")
    return about.st_size


def require_not_folder(path: Path, kinds: str) -> None:
    """Raise InputError for a folder, in which no file of some kinds was found."""
    if os.path.isdir(path):
        if not os.access(path, os.R_OK | os.X_OK):
            raise InputError(f"{one_line(path)}: cannot be read: Permission denied; check the path and its permissions")
        raise InputError(f"{one_line(path)}: expected a folder with {kinds}, found none")


def require_file(path: Path) -> None:
    """Raise InputError for a file that is not regular, or too large, without reading it."""
    size = require_ordinary(path)
    if size > MAX_FILE_BYTES:
        limit = f"expected at most {MAX_FILE_BYTES >> 20} MiB, got {size >> 20} MiB"
        raise InputError(f"{one_line(path)}: {limit}; simplify it")


def is_broken_link(path: Path) -> bool:
    """Return whether a path is a link to something that is missing, as git-annex leaves for files not fetched."""
    return path.is_symlink() and not path.exists()


def require_text_size(data: bytes) -> None:
    """Raise FormatError for more text than may be read."""
    if len(data) > MAX_TEXT_BYTES:
        limit = f"expected at most {MAX_TEXT_BYTES >> 20} MiB of text, got {len(data) >> 20} MiB"
        raise FormatError(f"{limit}; save it in a binary format, or simplify it")


def require_counts(**counts: int) -> None:
    """Raise FormatError for more triangles, vertices or points, declared or counted, than may be read.

    Examples
    --------
    >>> require_counts(triangles=10**8)
    Traceback (most recent call last):
        ...
    spherefunc_bullet.formats.FormatError: expected at most 10,000,000 triangles, got 100,000,000; simplify it
    """
    for name, count in counts.items():
        limit = MAX_TRIANGLES if name == "triangles" else MAX_VERTICES
        if count > limit:
            raise FormatError(f"expected at most {limit:,} {name}, got {count:,}; simplify it")


def require_members(archive: zipfile.ZipFile) -> None:
    """Raise FormatError for an archive that unpacks to too many bytes, or has members outside its own folder."""
    members = archive.infolist()
    if len(members) > MAX_MEMBERS:
        raise FormatError(f"expected an archive of at most {MAX_MEMBERS:,} members, got {len(members):,}")
    outside = next((member.filename for member in members if climbs_out(member.filename)), None)
    if outside is not None:
        raise FormatError(f"expected members inside the archive, got {outside[:80]!r}; is it from a source you trust?")
    require_unpacked(sum(member.file_size for member in members))


def require_unpacked(size: int) -> None:
    """Raise FormatError for more bytes, as a compressed file declares them, than may be unpacked."""
    if size > MAX_UNPACKED_BYTES:
        raise FormatError(f"expected at most {MAX_UNPACKED_BYTES >> 20} MiB unpacked, got {size >> 20} MiB declared")


def climbs_out(name: str) -> bool:
    """Return whether the name of a member leads out of the folder to which it would be unpacked.

    Examples
    --------
    >>> climbs_out("points.npy"), climbs_out("../points.npy"), climbs_out("/etc/points.npy"), climbs_out("a\\\\..\\\\b")
    (False, True, True, True)
    """
    path = PurePosixPath(name.replace("\\", "/"))
    return path.is_absolute() or ".." in path.parts or (len(name) > 1 and name[1] == ":")


@contextmanager
def refusing(path: Path) -> Iterator[None]:
    """Convert exceptions raised within to an InputError, one line that starts with the name of the file."""
    name = one_line(path.name)
    try:
        yield
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in OPTIONAL:
            raise  # the installation is broken, not the file
        needs = f"expected the extra 'formats' to read it, {error.name} is missing"
        raise InputError(f"{name}: {needs}; pip install 'spherefunc-bullet[formats]'") from error
    except (InputError, FormatError) as error:
        line = one_line(error)
        raise InputError(line if line.startswith(name) else f"{name}: {line}") from error
    except MemoryError as error:
        wanted = "expected to need no more memory to read it than there is"
        raise OutOfMemory(f"{name}: {wanted}; simplify it") from error
    except Exception as error:  # the only place that reports what readers raise on damaged bytes as the user's error
        detail = one_line(f"{type(error).__name__}: {error}")[:160]
        kind = path.suffix.lower()[1:].upper()
        raise InputError(f"{name}: expected a {kind} file, could not read it ({detail}); is it damaged?") from error


def cache_home() -> Path:
    """Return the cache folder: $SPHEREFUNC_CACHE, or a folder in the user's cache."""
    given = os.environ.get("SPHEREFUNC_CACHE")
    users = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return Path(given) if given else users / "spherefunc"


@contextmanager
def writing(place: Path, what: str = "a file", kind: type[InputError] = InputError) -> Iterator[None]:
    """Convert an OSError raised within, such as of a full disk, to one line for the user.

    Parameters
    ----------
    place : Path
        The file or folder that is written.
    what : str
        What it is, for the message.
    kind : type
        The type of the error that is raised.
    """
    try:
        yield
    except OSError as error:
        raise kind(f"{place}: expected {what} that can be written; {error.strerror or error}") from error


def unused_name(folder: Path, stem: str, suffix: str, written: Sequence[Path]) -> Path:
    """Return a path in ``folder`` that is not among those written: a second file with the same stem is numbered."""
    number = 1
    while (path := folder / (f"{stem}_{number}{suffix}" if number > 1 else f"{stem}{suffix}")) in written:
        number += 1
    return path


def write_bytes(path: Path, content: bytes) -> Path:
    """Write a file completely or not at all, creating its folder, and return its path.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    with writing(path):
        write_whole(path, content)
    return path


def write_text(path: Path, text: str) -> Path:
    """Write text in UTF-8, with ``?`` for what cannot be encoded, as in some file names. See `write_bytes`."""
    return write_bytes(path, text.encode("utf-8", "replace"))


def write_csv(path: Path, columns: Iterable[str], rows: Iterable[Iterable]) -> Path:
    """Write a table; see `write_text`."""
    table = io.StringIO(newline="")
    csv.writer(table).writerows([columns, *rows])
    return write_text(path, table.getvalue())


def write_whole(path: Path, content: bytes):
    """Write a file under a temporary name and rename it, so that it is never read half-written.

    A link, or a device such as ``/dev/stdout``, is written to and not replaced; nor is a file that is read-only.

    Raises
    ------
    OSError
        If it cannot be written; the temporary file is then removed.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.exists() and (path.is_symlink() or not path.is_file() or not os.access(path, os.W_OK)):
        path.write_bytes(content)
        return
    scratch = path.with_suffix(f".{os.getpid()}.tmp")
    try:
        scratch.write_bytes(content)
        os.replace(scratch, path)
    except BaseException:  # Ctrl-C as well
        with suppress(OSError):
            scratch.unlink(missing_ok=True)
        raise


def prepare_folder(folder: Path | None):
    """Create a folder for results before hours are spent on them, or raise InputError."""
    if folder is None:
        return
    with writing(folder, "a folder"):
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".writable"
        probe.touch()
        probe.unlink()


def require_place(file: Path, inputs: Iterable[Path] = ()):
    """Raise InputError for a file that cannot be written or is an input, before hours are spent on its content."""
    if os.path.exists(file) and any(os.path.exists(path) and file.samefile(path) for path in inputs):
        raise InputError(f"{file}: expected another file to write to, got an input, which would be lost")
    folder = file.absolute().parent
    if os.path.isdir(file) or not folder.is_dir() or not os.access(folder, os.W_OK):
        came = "a folder" if os.path.isdir(file) else "a folder that is missing or read-only"
        raise InputError(f"{file}: expected a file that can be written, got {came}")
