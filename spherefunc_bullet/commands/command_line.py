"""The console script ``spherefunc``: subcommands found through entry points, errors as one line.

Exit codes: 0 done, 2 the user's mistake (one line, no traceback), 1 ours.
"""

from __future__ import annotations

from importlib.metadata import entry_points

import typer

from ..console import log_on_stderr, run


def application() -> typer.Typer:
    """Return the application with every registered subcommand, ours and other packages'."""
    app = typer.Typer(
        name="spherefunc",
        help="Tell what an object is for from how spheres come to rest on it.",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
    )
    for point in sorted(entry_points(group="spherefunc.commands"), key=lambda point: point.name):
        command = point.load()
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=point.name)
        else:
            app.command(point.name)(command)
    return app


def main():
    """Run the command line; a user's mistake is one line on stderr and exit code 2."""
    log_on_stderr()
    run(application())
