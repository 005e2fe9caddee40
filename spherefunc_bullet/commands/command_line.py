"""The console script ``spherefunc``: subcommands found through entry points, errors as one line.

Exit codes: 0 done, 2 the user's mistake (one line, no traceback), 1 ours.
"""

from __future__ import annotations

import gc
import os
import re
import sys
from collections.abc import Sequence
from importlib.metadata import entry_points
from typing import Annotated

import typer

from .. import __version__
from ..console import log_on_stderr, run, show
from ..errors import InputError

GARBAGE = 300_000  # new objects between garbage collections; with the default they take a seventh of a first answer


def say_version(requested: bool):
    """Print the version and exit, if requested."""
    if requested:
        show(f"spherefunc {__version__}")
        raise typer.Exit()


def spherefunc(
    version: Annotated[
        bool, typer.Option("--version", callback=say_version, is_eager=True, help="Show the version and exit.")
    ] = False,
):
    """Classify the function of objects from how spheres come to rest on them."""


def application(word: str | None = None) -> typer.Typer:
    """Return the application with every registered subcommand, ours and other packages'.

    If ``word`` names a subcommand, only that one: reading the parameters of all takes longer than importing it.
    """
    app = typer.Typer(name="spherefunc", no_args_is_help=True, pretty_exceptions_enable=False, callback=spherefunc)
    points = entry_points(group="spherefunc.commands")
    for point in sorted(points.select(name=word) if word in points.names else points, key=lambda point: point.name):
        command = point.load()
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=point.name)
        else:
            app.command(point.name)(command)
    return app


def require_no_empty(words: Sequence[str]):
    """Raise InputError for an empty argument, which as a path would be the current folder.

    Examples
    --------
    >>> require_no_empty(["simulate", "cup.ply", "--out", ""])
    Traceback (most recent call last):
    ...
    spherefunc_bullet.errors.InputError: '' after --out: expected a value, got an empty one; is a variable unset?
    """
    for before, word in zip(("spherefunc", *words), words, strict=False):
        if re.fullmatch(r"(--[\w-]+=)?", word):
            where = f"{word!r} after {before}"
            raise InputError(f"{where}: expected a value, got an empty one; is a variable unset?")


def main():
    """Run the command line; a user's mistake is one line on stderr and exit code 2."""
    gc.set_threshold(GARBAGE)
    # Matrices are small here: a second thread of OpenBLAS waits for work that never comes, a sixth of a first answer.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    log_on_stderr()
    run(answer_command_line)


def answer_command_line():
    """Run the command that the words of the command line name."""
    words = sys.argv[1:]
    require_no_empty(words)
    application(words[0] if words else None)(prog_name="spherefunc")
