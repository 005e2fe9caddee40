"""The exception for errors that the user can fix, and those of tasks in processes of their own."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any


class InputError(ValueError):
    """A file, value or option that cannot be used.

    The message is one line: the subject, what was expected, what was found, and the fix. The command line prints it and
    exits with code 2; library code does not catch it.
    """

    outcome = "refused"  # its name in a ledger


class Crashed(InputError):
    """A task whose process died twice."""

    outcome = "crashed"


class TimedOut(InputError):
    """A task that exceeded its time limit twice."""

    outcome = "timed out"


class OutOfMemory(InputError):
    """A task that exceeded its memory limit, or all memory, twice."""

    outcome = "out of memory"


class Unexpected(InputError):
    """An error in this package or in a backend, during a run that goes on."""

    outcome = "error"


@contextmanager
def explaining(line: str, *kinds: type[Exception], why: str = "") -> Iterator[None]:
    """Raise InputError with a line for the user in place of errors of some kinds.

    Parameters
    ----------
    line : str
        The subject, what was expected, and the fix.
    why : str
        Separator between the line and the text of the error, such as ``"; "``; if empty, that text is left out.
    """
    try:
        yield
    except kinds as error:
        raise InputError(f"{line}{why}{error if why else ''}") from error


FAILURES = tuple(error.outcome for error in (InputError, Crashed, TimedOut, OutOfMemory, Unexpected))


def require_known(what: str, names: Iterable[str], known: Iterable[str]):
    """Raise InputError unless all names are known.

    Examples
    --------
    >>> require_known("--colour", ["red", "bleu"], ["red", "blue"])
    Traceback (most recent call last):
    ...
    spherefunc_bullet.errors.InputError: --colour 'bleu': expected some of red, blue
    """
    expected = list(known)
    for name in names:
        if name not in expected:
            raise InputError(f"{what} {name!r}: expected some of {', '.join(expected)}")


def one_line(value: object) -> str:
    """Return a value as text without line breaks, which the name of a file may contain."""
    return " ".join(str(value).split())


def warn_renamed(old: str, new: str):
    """Warn, for the code that calls the caller, that a public name has changed and the old one will be removed."""
    message = f"{old} is now {new}; the old name will be removed in the next version"
    warnings.warn(message, DeprecationWarning, stacklevel=3)


def renamed(old: str, new: str) -> property:
    """Return a property for the old name of a public attribute, which warns and returns the attribute."""

    def read(self: object) -> Any:
        warn_renamed(old, new)
        return getattr(self, new)

    return property(read)


def attempt(function: Callable, task: tuple) -> Any:
    """Return what a function returns, or the InputError that it raises."""
    try:
        return function(*task)
    except InputError as error:
        return error
