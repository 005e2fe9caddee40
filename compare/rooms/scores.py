"""How well rooms are parsed: objects found at IoU 0.5, and the functions that the found ones are given.

Truth counts every object as one of its own, also where it touches another: a cup on a table, a chair under one.
Objects that the scan hardly shows are neither asked for nor held against anybody: their points are left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TypedDict

import numpy as np

IOU = 0.5  # above one half no two parts can claim the same object

Matches = Mapping[int, int | None]  # a part's number -> the number of the true object that it is, None for none
Functions = Mapping[int, frozenset[str]]  # the functions of a part or of an object, by its number


class CountsRow(TypedDict):
    """Counts as reports have them; a figure is None where there is nothing to divide by."""

    f_measure: float | None
    precision: float | None
    recall: float | None
    hits: int
    false_alarms: int
    misses: int


@dataclass(frozen=True)
class Counts:
    """Right, wrong and missing answers, which add up over rooms."""

    hits: int = 0
    false_alarms: int = 0
    misses: int = 0

    def __add__(self, other: Counts) -> Counts:
        return Counts(self.hits + other.hits, self.false_alarms + other.false_alarms, self.misses + other.misses)

    @property
    def precision(self) -> float | None:
        return ratio(self.hits, self.hits + self.false_alarms)

    @property
    def recall(self) -> float | None:
        return ratio(self.hits, self.hits + self.misses)

    @property
    def f_measure(self) -> float | None:
        return ratio(2 * self.hits, 2 * self.hits + self.false_alarms + self.misses)

    def row(self) -> CountsRow:
        """Return the figures for a report, rounded."""
        return {name: rounded(getattr(self, name)) for name in ("f_measure", "precision", "recall")} | asdict(self)


def ratio(part: float, whole: float) -> float | None:
    """Return a quotient, None where there is nothing to divide by."""
    return part / whole if whole else None


def rounded(value: float | None, places: int = 4) -> float | None:
    """Return a figure as reports have it."""
    return None if value is None else round(value, places)


def match_parts(truth: np.ndarray, part_of: np.ndarray, asked: Iterable[int]) -> dict[int, int | None]:
    """Return for each part that a scan fell into the true object that it is, None if it is none.

    Parameters
    ----------
    truth : (N,) int
        Each point's object from 0, or below 0 for none.
    part_of : (N,) int
        Each point's part from 0, or below 0 for none.
    asked : iterable of int
        The objects that count; points of all others are left out, and parts that mostly hold such points as well.
    """
    asked = set(asked)
    counts = truth < 0
    counts |= np.isin(truth, sorted(asked))
    objects = dict(zip(*np.unique(truth[counts & (truth >= 0)], return_counts=True), strict=True))
    matches: dict[int, int | None] = {}
    for part in np.unique(part_of[part_of >= 0]).tolist():
        inside = part_of == part
        own = truth[inside & counts]
        if 2 * len(own) <= inside.sum():
            continue
        numbers, shared = np.unique(own[own >= 0], return_counts=True)
        pairs = zip(numbers.tolist(), shared, strict=True)
        best = {number: both / (len(own) + objects[number] - both) for number, both in pairs}
        matches[part] = next((number for number, iou in best.items() if iou > IOU), None)
    return matches


def segmentation_counts(matches: Matches, asked: Sequence[int]) -> Counts:
    """Return how many objects were found, parts that are no object, and objects that no part is."""
    hits = sum(number is not None for number in matches.values())
    return Counts(hits, len(matches) - hits, len(asked) - hits)


def function_counts(matches: Matches, given: Functions, labels: Functions, name: str) -> Counts:
    """Return how often a function was given rightly, wrongly and not at all, from scan to label.

    Parameters
    ----------
    matches : dict of int to int or None
        See `match_parts`.
    given : dict of int to set of str
        The functions that each part was given.
    labels : dict of int to set of str
        The functions of each object that counts, found or not.
    """
    claimed = [number for part, number in matches.items() if name in given[part]]
    hits = sum(number is not None and name in labels[number] for number in claimed)
    members = sum(name in functions for functions in labels.values())
    return Counts(hits, len(claimed) - hits, members - hits)
