"""Whether a data set labels each object once: a file, or its content, under two labels teaches nothing."""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from pathlib import Path

from ..errors import InputError
from .dataset import Dataset, DatasetObject, label_text


def require_agreement(dataset: Dataset):
    """Raise InputError if a file, or two files of the same content, are labelled with different functions.

    Files that cannot be read are left to whoever reads them. Only files of one size are read at all.
    """
    for same in (os.path.realpath, Content(dataset)):
        known: dict[str, DatasetObject] = {}
        for item in dataset.objects:
            first = known.setdefault(same(item.path), item)
            if first.functions != item.functions:
                raise InputError(contradiction(dataset, first, item))


def contradiction(dataset: Dataset, first: DatasetObject, second: DatasetObject) -> str:
    """Return what two labels of one object say, in one line."""
    names = [dataset.name_of(item.path) for item in (first, second)]
    what = "it is listed twice" if names[0] == names[1] else f"{names[1]} holds the same"
    said = " and ".join(label_text(item.functions) for item in (first, second))
    return f"{dataset.name}: {names[0]}: expected one label for one object, got {said} ({what}); keep one"


class Content:
    """Tells what a file holds: a hash where another file is of the same size, else its path."""

    def __init__(self, dataset: Dataset):
        self.sizes = [size_of(item.path) for item in dataset.objects]

    def __call__(self, path: Path) -> str:
        """Return the hash or the path."""
        size = size_of(path)
        if size >= 0 and self.sizes.count(size) > 1:
            with suppress(OSError), open(path, "rb") as file:
                return hashlib.file_digest(file, "sha256").hexdigest()
        return str(path)


def size_of(path: Path) -> int:
    """Return a file's size in bytes, -1 where there is none."""
    return path.stat().st_size if path.is_file() else -1
