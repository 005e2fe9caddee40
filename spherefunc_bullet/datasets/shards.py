"""Shards: parts of a batch for the tasks of a job array, each with a run directory of its own."""

from __future__ import annotations

import re

from ..errors import InputError
from .dataset import Dataset


def parse_shard(text: str | None) -> tuple[int, int]:
    """Return which shard and of how many, from 1.

    Examples
    --------
    >>> parse_shard("3/8"), parse_shard(None)
    ((3, 8), (1, 1))
    """
    if text is None:
        return 1, 1
    match = re.fullmatch(r"\s*(\d{1,9})\s*/\s*(\d{1,9})\s*", text)
    if not match or not 1 <= int(match[1]) <= int(match[2]):
        raise InputError(f"--shard {text}: expected i/n with i from 1 to n, such as 3/8")
    return int(match[1]), int(match[2])


def shard_of(dataset: Dataset, shard: tuple[int, int]) -> Dataset:
    """Return every n-th object of a data set, from the i-th: neighbours in a manifest are alike in cost.

    Raises
    ------
    InputError
        If there are fewer objects than shards, and none for this one.
    """
    index, count = shard
    objects = dataset.objects[index - 1 :: count]
    if not objects:
        raise InputError(f"--shard {index}/{count}: expected at most {len(dataset)} shards, as many as objects")
    return Dataset(dataset.name, objects, dataset.folder)
