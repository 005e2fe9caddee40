"""Output of commands: results on stdout, messages on stderr, a progress bar only on a terminal.

All output goes through this module (ruff forbids `print` elsewhere): names of files and of training objects come from
strangers, so characters that control a terminal are written out as text.
"""

from __future__ import annotations

import errno
import json
import logging
import os
import re
import signal
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from numbers import Integral
from pathlib import Path
from types import FrameType
from typing import Any

from .errors import InputError, one_line

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # no room is left: of the disk, of the user's share, of a file
REFUSED = (errno.ENAMETOOLONG, errno.EACCES, errno.EPERM, errno.EROFS)  # by the system, for the name of a file
INTERRUPTED = 130  # exit code that shells expect after Ctrl-C
AGAIN = 3.0  # seconds after which Ctrl-C is raised again, where a library has swallowed it
SOON = 0.05  # seconds after which it is tried again during an import
_shown: list[str] = []  # the progress bar on the terminal, at most one
# Arguments that errors of the library name as in Python; on the command line they are options, see `as_options`.
_ARGUMENTS = ("up", "units", "shape", "model", "topic", "time", "depth_scale", "intrinsics", "color")
_ARGUMENT = re.compile(rf'\b({"|".join(_ARGUMENTS)})=(?:"([^"]*)"|(?=[\s,;.:)]|$))')
_RANGES = ("person", "pose_error", "leaf_size", "cluster_tolerance", "min_cluster_size", "max_cluster_size")
_RANGE = re.compile(rf"(?<![\w/.])({'|'.join(_RANGES)})(?: and ({'|'.join(_RANGES)}))?(?=: expected )")
# Characters that control terminals or cannot be shown: control characters except tab and line break, marks that change
# the direction of writing, and bytes in the name of a file that are not text.
_OBEYED = [*range(9), *range(11, 32), *range(127, 160), 0x2028, 0x2029, *range(0x202A, 0x202F), *range(0x2066, 0x206A)]
_AS_TEXT = {code: ascii(chr(code))[1:-1] for code in [*_OBEYED, *range(0xD800, 0xE000)]}


def printable(text: str) -> str:
    r"""Return a text in which characters that control a terminal are written out.

    Examples
    --------
    >>> print(printable("a\x1b[31m cup"))
    a\x1b[31m cup
    """
    return text.translate(_AS_TEXT)


def as_options(text: str) -> str:
    """Return an error of the library, with the arguments in it written as options of the command line.

    Examples
    --------
    >>> as_options('cup.obj: 300 m wide; in millimetres? units="mm"'), as_options("expected topic=, one of a, b")
    ('cup.obj: 300 m wide; in millimetres? --units mm', 'expected --topic, one of a, b')
    >>> as_options("leaf_size: expected more than 0 and at most 1, got 99.0")
    '--leaf-size: expected more than 0 and at most 1, got 99.0'
    """
    text = _RANGE.sub(
        lambda found: " and ".join(f"--{name.replace('_', '-')}" for name in found.groups() if name), text
    )
    return _ARGUMENT.sub(lambda found: f"--{found[1].replace('_', '-')} {found[2] or ''}".rstrip(), text)


def show(text: str = ""):
    """Print lines on stdout."""
    sys.stdout.write(f"{printable(text)}\n")


def print_json(value: object):
    """Print a value as JSON on stdout."""
    show(json.dumps(value, indent=2))


def say(line: str):
    """Print a line on stderr in one write, since other processes may write there at the same time."""
    sys.stderr.write(f"{printable(as_options(line))}\n")


class _Saying(logging.Handler):
    """Prints log records on stderr."""

    def emit(self, record: logging.LogRecord):
        say(self.format(record))


def log_on_stderr(level: int = logging.INFO):
    """Print messages of the library about slow steps, and its warnings, on stderr, each in one line."""
    logger = logging.getLogger("spherefunc")
    logger.setLevel(level)
    logger.addHandler(_Saying())
    usual = warnings.showwarning

    def show_in_one_line(message: Warning | str, category: type[Warning], *where: Any):
        """Print a plain warning, as the library gives them, as one line, and others as Python does."""
        if category is UserWarning:
            say(one_line(message))
        else:
            usual(message, category, *where)

    warnings.showwarning = show_in_one_line


def progress(items: Iterable, total: int, doing: str) -> Iterator:
    """Yield items under a progress bar, on a terminal only, and not within a stage that has a bar already."""
    if _shown or not sys.stderr.isatty():
        yield from items
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import track

    _shown.append(doing)
    shown = {"description": escape(printable(doing)), "console": Console(stderr=True), "transient": True}
    try:
        yield from track(items, total=total, **shown)
    finally:
        _shown.remove(doing)


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence]):
    """Print a table on stdout, with the first column aligned left and others right; nothing if it has no rows."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    if not (rows := list(rows)):
        return
    table = Table(box=None, pad_edge=False)
    for i, column in enumerate(columns):
        table.add_column(Text(printable(column)), justify="left" if i == 0 else "right", no_wrap=True)
    for row in rows:
        table.add_row(*[Text(printable(cell_text(cell))) for cell in row])  # no markup: a name may hold brackets
    console = Console()
    if not console.is_terminal:  # a pipe has no width to fit
        console = Console(width=max(200, Console(width=10_000).measure(table).maximum))
    console.print(Text(printable(title)), soft_wrap=True)  # as the table's own title it would wrap at its width
    console.print(table)


def cell_text(cell: str | float) -> str:
    """Return the text of a cell in one line: whole numbers with all digits, others with six."""
    if isinstance(cell, str):
        return cell.replace("\n", " ")
    return f"{cell:d}" if isinstance(cell, Integral) else f"{cell:g}"


def shown_names(files: Iterable[str | Path]) -> dict[str, str]:
    """Return what each file is called in a table: its name, or its path if another file has the same name.

    Examples
    --------
    >>> shown_names(["lamp/model.obj", "mug/model.obj", "mug/mug.ply"])
    {'lamp/model.obj': 'lamp/model.obj', 'mug/model.obj': 'mug/model.obj', 'mug/mug.ply': 'mug.ply'}
    """
    paths = dict.fromkeys(map(str, files))
    counts = Counter(Path(path).name for path in paths)
    return {path: path if counts[Path(path).name] > 1 else Path(path).name for path in paths}


def with_path(outcome: Any, file: str | Path) -> Any:
    """Return an error of a file with the file's path in place of its name, any other outcome unchanged.

    Libraries hold many files of one name, such as ``model.obj``.
    """
    if not isinstance(outcome, InputError) or not str(outcome).startswith(f"{(name := one_line(Path(file).name))}:"):
        return outcome
    return InputError(one_line(file) + str(outcome).removeprefix(name))


def passed(
    outcomes: Iterable[tuple[int, Any]], total: int, doing: str, failed: Callable[[InputError], object]
) -> Iterator[tuple[int, Any]]:
    """Yield numbered outcomes under a progress bar, except for errors, which go to ``failed``."""
    for index, outcome in progress(outcomes, total, doing):
        if isinstance(outcome, InputError):
            failed(outcome)
        else:
            yield index, outcome


class Failures:
    """Files that could not be used: errors are printed at once, and counted for the exit code."""

    def __init__(self):
        self.count = 0

    def add(self, error: InputError):
        """Print the error of a file."""
        fail(error)
        self.count += 1

    def exit(self):
        """Exit with code 2 if there were any."""
        if self.count:
            sys.exit(2)


def fail(error: InputError) -> int:
    """Print a user's mistake on stderr and return its exit code."""
    say(f"spherefunc: {one_line(error)}")
    return 2


def run(main: Callable[[], object]):
    """Run a program; a user's mistake is one line on stderr and exit code 2, Ctrl-C one line and exit code 130."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by the caller, as by ``2>&-``
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 - as long as the program runs
        if isinstance(getattr(sys, name), TextIOWrapper):
            getattr(sys, name).reconfigure(errors="backslashreplace")  # what the locale has no letter for, such as ²
    try:
        with ended_by_ctrl_c():
            try:
                main()
            finally:
                sys.stdout.flush()
    except InputError as error:
        sys.exit(fail(error))
    except OSError as error:
        if error.errno in REFUSED and error.filename is not None:
            sys.exit(fail(InputError(f"{error.filename}: expected a file that can be used; {error.strerror}")))
        if error.errno not in (*FULL, errno.EPIPE):
            raise
        closed = error.errno == errno.EPIPE  # nobody reads on, as after ``| head``
        code = 1 if closed else fail(InputError(f"output: expected room to write to; {error.strerror}"))
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - what is left in it cannot be written at the end either
        sys.exit(code)


@contextmanager
def ended_by_ctrl_c() -> Iterator[None]:
    """Let Ctrl-C end the program with one line and exit code 130, even where a library catches every exception.

    KeyboardInterrupt is raised again until the program ends. It waits for the end of an import, which it would leave
    half done. If the program was started without Ctrl-C, as a shell does in the background, nothing changes.
    """
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler or not hasattr(signal, "setitimer"):
        yield
        return
    came = []

    def interrupt(number: int, frame: FrameType | None):
        """Say it once, raise KeyboardInterrupt if nothing is imported, and come again."""
        if not came:
            with suppress(OSError):
                os.write(2, b"spherefunc: interrupted\n")  # the stream itself may be in the middle of a write
            sys.unraisablehook = lambda swallowed: None  # it is raised again
        came.append(number)
        waits = importing(frame)
        signal.setitimer(signal.ITIMER_REAL, SOON if waits else AGAIN)
        if not waits:
            raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in (signal.SIGINT, signal.SIGALRM)}
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        for number, handler in before.items():
            signal.signal(number, handler)
        if came:
            sys.exit(INTERRUPTED)


def importing(frame: FrameType | None) -> bool:
    """Return whether a frame, or one that has called it, imports a module."""
    while frame is not None and not frame.f_code.co_filename.startswith("<frozen importlib"):
        frame = frame.f_back
    return frame is not None
