"""Labels as people and scikit-learn write them: sets of functions, strings, or an indicator matrix of 0 and 1."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from numbers import Number

import numpy as np

from ..datasets.dataset import parse_functions
from ..errors import InputError

Label = str | Iterable[str]  # an object's functions: a set, a list, ``'table;sittable'`` or ``'none'``
Labels = Sequence[Label] | np.ndarray  # a label for each object, or an indicator (N, F) of 0 and 1


WANTED = "functions' names for each object, or an indicator (N, F) of 0 and 1"


def as_sets(labels: Sequence[Label]) -> list[frozenset[str]]:
    """Return each label as a set of functions.

    Examples
    --------
    >>> [sorted(functions) for functions in as_sets(["cup", "none", {"table", "sittable"}])]
    [['cup'], [], ['sittable', 'table']]
    """
    sets = sets_of(labels)
    if not sets:
        raise InputError("training set: expected at least one labelled object, got none")
    return sets


def sets_of(labels: Sequence[Label]) -> list[frozenset[str]]:
    """Return each label as a set of functions; an empty list for no labels.

    Raises
    ------
    InputError
        If a label is neither a string nor a collection of strings.
    """
    if isinstance(labels, str):
        raise InputError(f"labels: expected one for each object, got the text {labels!r}")
    return [set_of(label) for label in labels]


def set_of(label: Label) -> frozenset[str]:
    """Return one label as a set of functions."""
    if isinstance(label, str):
        return parse_functions(label)
    functions = frozenset(label) if isinstance(label, Iterable) else frozenset([label])
    odd = [name for name in functions if not isinstance(name, str)]
    if odd:
        raise InputError(f"labels: expected {WANTED}, got {odd[0]!r}")
    return functions


def columns_of_indicator(y: Labels, known: tuple[str, ...] | None = None) -> tuple[str, ...] | None:
    """Return the names of the columns of an indicator (N, F), or None for labels that are no indicator.

    Parameters
    ----------
    known : tuple of str, optional
        Names of the columns of an earlier indicator.
    """
    if y is None:
        raise InputError(f"labels: expected {WANTED}, got None")
    if not is_indicator(y):
        return None
    names = getattr(y, "columns", None)
    if names is None:
        count = dense(y).shape[1]
        return known if known is not None and len(known) == count else tuple(str(number) for number in range(count))
    return tuple(str(name) for name in names)


def is_indicator(y: Labels) -> bool:
    """Return whether labels are rows of numbers rather than of names."""
    if hasattr(y, "toarray") or hasattr(y, "columns"):
        return True
    if isinstance(y, np.ndarray):
        return y.ndim == 2 and y.dtype.kind in "biuf"
    first = next(iter(y), None) if isinstance(y, Sequence) and not isinstance(y, str) else None
    rows = isinstance(first, list | tuple | np.ndarray) and len(first) > 0
    return rows and all(isinstance(value, Number | np.generic) and not isinstance(value, str) for value in first)


def require_names(y: Labels):
    """Raise InputError for an indicator, which names no function that a classifier has learnt by name."""
    if is_indicator(y):
        raise InputError("labels: expected functions' names for each object, as they were learnt, got an indicator")


def dense(y: Labels) -> np.ndarray:
    """Return an indicator as an array (N, F)."""
    array = np.asarray(y.toarray() if hasattr(y, "toarray") else y)
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise InputError(f"labels: expected an indicator (N, F) of 0 and 1, got {array.dtype} of shape {array.shape}")
    return array


def labels_of_indicator(y: Labels, columns: Sequence[str]) -> list[frozenset[str]]:
    """Return the functions of each row of an indicator (N, F).

    Raises
    ------
    InputError
        If it holds other values than 0 and 1, or has another number of columns.
    """
    array = dense(y)
    if array.shape[1] != len(columns) or not np.isin(array, (0, 1)).all():
        raise InputError(f"labels: expected an indicator (N, {len(columns)}) of 0 and 1, got another {array.shape}")
    return [frozenset(name for name, has in zip(columns, row, strict=True) if has) for row in array]


def in_columns(scores: np.ndarray, functions: Sequence[str], columns: Sequence[str]) -> np.ndarray:
    """Return scores (N, F) of functions in the order of columns (N, C); 0 for functions of no training object."""
    if tuple(functions) == tuple(columns):
        return scores
    known = {name: number for number, name in enumerate(functions)}
    nobody = np.zeros(len(scores), scores.dtype)
    return np.column_stack([scores[:, known[name]] if name in known else nobody for name in columns])


def memberships(labels: Sequence[frozenset[str]], functions: Sequence[str]) -> np.ndarray:
    """Return which object has which function, (N, F) bool."""
    return np.array([[name in label for name in functions] for label in labels], bool).reshape(len(labels), -1)


def more_members(
    known: Sequence[str], members: np.ndarray, labels: Sequence[frozenset[str]]
) -> tuple[tuple[str, ...], np.ndarray]:
    """Return the functions, and which object has which (N, F) bool, after objects were added to known ones (M, F)."""
    functions = tuple(sorted(set(known).union(*labels)))
    return functions, np.vstack([in_columns(members, known, functions), memberships(labels, functions)])
