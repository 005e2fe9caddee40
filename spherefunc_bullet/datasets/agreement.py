"""Whether a data set's labels agree: one file, or two of the same content, has one label."""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from contextlib import suppress
from functools import partial
from pathlib import Path

from ..errors import InputError
from .dataset import Dataset, DatasetObject, label_text, size_of


def require_agreement(dataset: Dataset):
    """Raise InputError if a file, or two files of the same content, are labelled with different functions.

    Only files of equal size are read; files that cannot be read are ignored here.
    """
    sizes = Counter(size_of(item.path) for item in dataset.objects)
    for same in (os.path.realpath, partial(content_of, sizes)):
        known: dict[str, DatasetObject] = {}
        for item in dataset.objects:
            first = known.setdefault(same(item.path), item)
            if first.functions != item.functions:
                raise InputError(contradiction(dataset, first, item))


def contradiction(dataset: Dataset, first: DatasetObject, second: DatasetObject) -> str:
    """Return the error for an object with two different labels, as one line."""
    names = [dataset.name_of(item.path) for item in (first, second)]
    what = "it is listed twice" if names[0] == names[1] else f"{names[1]} holds the same"
    labels = " and ".join(label_text(item.functions) for item in (first, second))
    return f"{dataset.name}: {names[0]}: expected one label for one object, got {labels} ({what}); keep one"


def content_of(sizes: Counter[int], path: Path) -> str:
    """Return a key for the content of a file: a hash if another file has the same size, else its path."""
    size = size_of(path)
    if size >= 0 and sizes[size] > 1:
        with suppress(OSError), open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    return str(path)
