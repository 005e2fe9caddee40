"""The one exception that means "the user can mend this", and what can befall a task in a process of its own."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any


class InputError(ValueError):
    """A file, value or option that cannot be used.

    The message is one line: what it is about, what was expected, what came, and the fix.
    The command line prints it and exits with code 2; library code lets it pass.
    """

    outcome = "refused"  # what a ledger calls it


class Crashed(InputError):
    """A task whose process died twice."""

    outcome = "crashed"


class TimedOut(InputError):
    """A task that took longer than it may, twice."""

    outcome = "timed out"


class OutOfMemory(InputError):
    """A task that needed more memory than there is, or than it may have, twice."""

    outcome = "out of memory"


class Unexpected(InputError):
    """An error that is ours or a backend's, in a run that goes on whatever happens."""

    outcome = "error"


@contextmanager
def explaining(line: str, *kinds: type[Exception], why: str = "") -> Iterator[None]:
    """Turn errors of some kinds that are raised within into one line for the user.

    Parameters
    ----------
    line : str
        What it is about, what was expected, and the fix.
    why : str
        What stands between the line and what the error says, such as ``"; "``; if empty, that is left out.
    """
    try:
        yield
    except kinds as error:
        raise InputError(f"{line}{why}{error if why else ''}") from error


FAILURES = tuple(error.outcome for error in (InputError, Crashed, TimedOut, OutOfMemory, Unexpected))


def require_known(what: str, names: Iterable[str], known: Iterable[str]):
    """Raise InputError unless every one of the names is among those there are.

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
    """Return a value as text without line breaks: a file's name may hold one."""
    return " ".join(str(value).split())


def warn_renamed(old: str, new: str):
    """Warn whoever calls the caller that a public name has another one; the old one goes with the next version."""
    warnings.warn(f"{old} is now {new}, and goes with the next version", DeprecationWarning, stacklevel=3)


def renamed(old: str, new: str) -> property:
    """Return a property that warns and returns a public attribute, under its old name."""

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
