"""What commands print: JSON on stdout, everything else on stderr, a progress bar only on a terminal."""

from __future__ import annotations

import json
import logging
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from .errors import InputError, one_line

_shown: list[str] = []  # the bar on the terminal, which has room for one


def print_json(value: object):
    """Print a value as JSON on stdout."""
    print(json.dumps(value, indent=2))


def say(line: str):
    """Print a line on stderr, in one piece: other processes may write there at the same time."""
    sys.stderr.write(f"{line}\n")


def log_on_stderr(level: int = logging.INFO):
    """Have the library say on stderr what takes long."""
    logger = logging.getLogger("spherefunc")
    logger.setLevel(level)
    logger.addHandler(logging.StreamHandler())


def progress(items: Iterable, total: int, doing: str) -> Iterator:
    """Pass items on and show how far it is, on a terminal only, and not within a stage that shows that already."""
    if _shown or not sys.stderr.isatty():
        yield from items
        return
    from rich.console import Console
    from rich.progress import track

    _shown.append(doing)
    try:
        yield from track(items, description=doing, total=total, console=Console(stderr=True), transient=True)
    finally:
        _shown.remove(doing)


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence]):
    """Print a table on stdout, the first column to the left and numbers to the right."""
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for i, column in enumerate(columns):
        table.add_column(column, justify="left" if i == 0 else "right", no_wrap=True)
    for row in rows:
        table.add_row(*[cell if isinstance(cell, str) else f"{cell:g}" for cell in row])
    console = Console()
    if not console.is_terminal:
        console = Console(width=200)  # a pipe has no width to fit
    console.print(title, highlight=False, soft_wrap=True)  # as the table's own title it would wrap at its width
    console.print(table)


class Failures:
    """Files that could not be used: said at once, and remembered for the exit code."""

    def __init__(self):
        self.count = 0

    def add(self, error: InputError):
        """Say one file's error and go on."""
        fail(error)
        self.count += 1

    def passed(self, outcomes: Iterable[tuple[int, Any]], total: int, doing: str) -> Iterator[tuple[int, Any]]:
        """Pass on numbered outcomes under a progress bar; errors among them are said, and left out."""
        for index, outcome in progress(outcomes, total, doing):
            if isinstance(outcome, InputError):
                self.add(outcome)
            else:
                yield index, outcome

    def exit(self):
        """Leave with code 2 if there were any."""
        if self.count:
            sys.exit(2)


def fail(error: InputError) -> int:
    """Print a user's mistake on stderr and return its exit code."""
    say(f"spherefunc: {one_line(error)}")
    return 2


def run(main: Callable[[], object]):
    """Run a program; a user's mistake is one line on stderr and exit code 2."""
    try:
        main()
    except InputError as error:
        sys.exit(fail(error))
