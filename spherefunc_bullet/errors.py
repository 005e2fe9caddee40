"""The exception for errors that the user can fix, and those of tasks in processes of their own."""

from __future__ import annotations

import math
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import field, fields
from numbers import Integral, Real
from pathlib import Path
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


@contextmanager
def blaming(subject: str) -> Iterator[None]:
    """Raise `Unexpected` with one line about a subject in place of what only its programmer can mend."""
    try:
        yield
    except (InputError, MemoryError):
        raise
    except (Exception, SystemExit) as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        line = f"{subject}: expected a result, got {type(error).__name__}: {one_line(error)}"
        raise Unexpected(f"{line} ({Path(last.filename).name}, line {last.lineno})") from error


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


def require_kind(name: str, value: object, kind: type):
    """Raise InputError unless a value is None or of a class.

    Examples
    --------
    >>> require_kind("settings", 3, dict)
    Traceback (most recent call last):
    ...
    spherefunc_bullet.errors.InputError: settings: expected a dict, got 3
    """
    if value is not None and not isinstance(value, kind):
        raise InputError(f"{name}: expected a {kind.__name__}, got {one_line(repr(value)):.200}")


def amount(default: Any, **limits: float) -> Any:
    """Return a dataclass field for a setting with its range, see `require_amount`; None is allowed as a default.

    A function as the default is called for each new object.
    """
    kept = "default_factory" if callable(default) else "default"
    return field(**{kept: default}, metadata={"limits": limits})


class CheckedSettings:
    """Settings that raise InputError for values outside the range of a field, see `amount`; one of int is whole."""

    def __post_init__(self):
        for setting in fields(self):
            value = getattr(self, setting.name)
            if "limits" in setting.metadata and value is not setting.default:
                whole = str(setting.type).startswith("int")
                require_amount(setting.name, value, whole=whole, **setting.metadata["limits"])


def require_amount(
    name: str,
    value: float,
    *,
    above: float | None = None,
    least: float = 0.0,
    most: float = math.inf,
    whole: bool = False,
    finite: bool = True,
):
    """Raise InputError unless a setting is a number in its range.

    Examples
    --------
    >>> require_amount("drops", 2.5, least=1, whole=True)
    Traceback (most recent call last):
    ...
    spherefunc_bullet.errors.InputError: drops: expected a whole number of at least 1, got 2.5
    """
    right = isinstance(value, Integral if whole else Real) and not isinstance(value, bool)
    if right and (value >= least if above is None else value > above) and value <= most:
        if not finite or abs(value) != math.inf:
            return
    bounds = [f"more than {above:g}"] if above is not None else [f"at least {least:g}"] if least > -math.inf else []
    bounds += [f"at most {most:g}"] if most < math.inf else []
    kind = "a whole number" if whole else "a finite number" if finite else "a number"
    limits = " of ".join(filter(None, ["" if right and bounds else kind, " and ".join(bounds)]))
    shown = value.item() if hasattr(value, "item") and not getattr(value, "ndim", 0) else value  # -1, not np.int64(-1)
    raise InputError(f"{name}: expected {limits}, got {one_line(repr(shown)):.200}")


def one_line(value: object) -> str:
    """Return a value as text without what the name of a file may contain: line breaks, bytes that are not UTF-8."""
    return escaped(" ".join(str(value).split()))


def escaped(name: str) -> str:
    r"""Return a name in which bytes that are not UTF-8 are written out, so that files and SQLite can keep it.

    Examples
    --------
    >>> escaped("caf\udce9")
    'caf\\udce9'
    """
    return name.encode(errors="backslashreplace").decode()


def warn_renamed(old: str, new: str):
    """Warn, for the code that calls the caller, that a public name has changed and the old one will be removed."""
    message = f"{old} is now {new}; the old name will be removed in version 2"
    warnings.warn(message, DeprecationWarning, stacklevel=3)


def renamed(old: str, new: str) -> property:
    """Return a property for the old name of a public attribute, which warns and returns the attribute."""

    def read(self: object) -> Any:
        warn_renamed(old, new)
        return getattr(self, new)

    return property(read)


def attempt(function: Callable, task: tuple, subject: str | None = None) -> Any:
    """Return what a function returns, or the InputError that it raises; see `blaming` for the subject of any other."""
    try:
        with nullcontext() if subject is None else blaming(subject):
            return function(*task)
    except InputError as error:
        return error
