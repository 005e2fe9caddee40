"""Objects recognised in a scan against its ground truth: which are found, which are missed, which claims are false."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import chain
from typing import Any

import numpy as np

from spherefunc_bullet.scenes.recognition.room import Room
from spherefunc_bullet.scenes.segmentation.clusters import Box

from .truth import BACK_ONLY, SEEN, RecognisedObject, TrueObject, overlap

IOU = 0.5  # above it no two parts can match the same object

Row = dict[str, Any]  # of a report for JSON; a figure is None where there is nothing to divide by
Matches = Mapping[int, int | None]  # a part's number -> the number of the true object that it matches, or None
Functions = Mapping[int, frozenset[str]]  # the functions of a part or of an object, by its number
Score = Counter[str]  # the number of results of each outcome; scores add up over scans and functions


@dataclass(frozen=True)
class MatchCounts:
    """Numbers of hits, false alarms and misses, which add up over rooms."""

    hits: int = 0
    false_alarms: int = 0
    misses: int = 0

    def __add__(self, other: MatchCounts) -> MatchCounts:
        return MatchCounts(self.hits + other.hits, self.false_alarms + other.false_alarms, self.misses + other.misses)

    @property
    def precision(self) -> float | None:
        return ratio(self.hits, self.hits + self.false_alarms)

    @property
    def recall(self) -> float | None:
        return ratio(self.hits, self.hits + self.misses)

    @property
    def f_measure(self) -> float | None:
        return ratio(2 * self.hits, 2 * self.hits + self.false_alarms + self.misses)

    def row(self) -> Row:
        """Return the figures for a report, rounded."""
        return {name: rounded(getattr(self, name)) for name in ("f_measure", "precision", "recall")} | asdict(self)


def ratio(part: float, whole: float) -> float | None:
    """Return a quotient, None where there is nothing to divide by."""
    return part / whole if whole else None


def rounded(value: float | None, places: int = 4) -> float | None:
    """Return a rounded figure."""
    return None if value is None else round(value, places)


def match_parts(truth: np.ndarray, part_of: np.ndarray, objects_that_count: Iterable[int]) -> dict[int, int | None]:
    """Return for each part of a segmented scan the true object that it matches, None if it matches none.

    Parameters
    ----------
    truth : (N,) int
        Each point's object from 0, or below 0 for none.
    part_of : (N,) int
        Each point's part from 0, or below 0 for none.
    objects_that_count : iterable of int
        The objects that count; points of all others are left out, and parts that mostly hold such points as well.
    """
    counts = (truth < 0) | np.isin(truth, sorted(set(objects_that_count)))
    objects = dict(zip(*np.unique(truth[counts & (truth >= 0)], return_counts=True), strict=True))
    matches: dict[int, int | None] = {}
    for part in np.unique(part_of[part_of >= 0]).tolist():
        inside = part_of == part
        labels = truth[inside & counts]
        if 2 * len(labels) <= inside.sum():
            continue
        numbers, shared = np.unique(labels[labels >= 0], return_counts=True)
        pairs = zip(numbers.tolist(), shared, strict=True)
        best = {number: both / (len(labels) + objects[number] - both) for number, both in pairs}
        matches[part] = next((number for number, iou in best.items() if iou > IOU), None)
    return matches


def segmentation_counts(matches: Matches, numbers: Sequence[int]) -> MatchCounts:
    """Return the numbers of objects found, of parts that match no object, and of objects not found."""
    hits = sum(number is not None for number in matches.values())
    return MatchCounts(hits, len(matches) - hits, len(numbers) - hits)


def function_counts(matches: Matches, given: Functions, labels: Functions, name: str) -> MatchCounts:
    """Return how often a function was given correctly, wrongly and not at all, from scan to label.

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
    return MatchCounts(hits, len(claimed) - hits, members - hits)


def counts_by_function(
    room: Room, truth: np.ndarray, labels: Functions, names: Sequence[str]
) -> dict[str, MatchCounts]:
    """Return the counts of each function in a recognised room.

    Parameters
    ----------
    truth : (N,) int
        Each point's object, see `match_parts`.
    labels : dict of int to set of str
        The functions of each object that counts.
    """
    matches, given = match_parts(truth, room.labels, labels), {item.id: item.members for item in room.objects}
    return {name: function_counts(matches, given, labels, name) for name in names}


LEAST_OF_POINTS = 0.5  # intersection over union at which an object counts as found, where points are labelled
LEAST_OF_BOXES = 0.25  # the same for boxes, as in VoteNet and SUN RGB-D, since a scan shows only part of a box
_MARGIN = 0.05  # metres: half of the thickness of a chair's back, which is at the edge of an inferred box


@dataclass(frozen=True, kw_only=True, eq=False)
class MatchResult:
    """One function of a true object, of a claim, or of both: found, missed, false, or counted separately."""

    function: str
    true: TrueObject | None = None
    claim: RecognisedObject | None = None

    @property
    def outcome(self) -> str:
        """``found``, ``missed``, ``false``, ``back found``, ``back missed``, ``disputed`` or ``uncounted``."""
        if self.true is None:
            return "false"
        if self.function in self.true.disputed:
            return "uncounted" if self.claim is None else "disputed"
        ending = "missed" if self.claim is None else "found"
        if self.true.visible in SEEN:
            return ending
        return f"back {ending}" if self.true.visible == BACK_ONLY else "uncounted"

    @property
    def sure(self) -> bool:
        """Whether it is a claim whose score leaves no doubt."""
        return self.claim is not None and self.function not in self.claim.unsure


def score_of(verdicts: Iterable[MatchResult]) -> Score:
    """Return the number of results of each outcome, and of those that are sure."""
    outcomes = ([one.outcome, *([f"sure {one.outcome}"] if one.sure else [])] for one in verdicts)
    return Counter(chain.from_iterable(outcomes))


def score_row(score: Score) -> Row:
    """Return the figures for a report; backs and disputed functions count for neither recall nor precision."""
    found, seen, claims = score["found"], score["found"] + score["missed"], score["found"] + score["false"]
    return {
        "found": found,
        "seen": seen,
        "recall": rounded(ratio(found, seen), 3),
        "true_claims": found,
        "claims": claims,
        "precision": rounded(ratio(found, claims), 3),
        "true_sure_claims": score["sure found"],
        "sure_claims": score["sure found"] + score["sure false"],
        "backs_found": score["back found"],
        "backs": score["back found"] + score["back missed"],
        "disputed": score["disputed"],
    }


def match_objects(truth: Sequence[TrueObject], recognised: Sequence[RecognisedObject]) -> list[MatchResult]:
    """Compare each function of each object: the largest overlaps are matched first, each object once."""
    wanted = [item.functions | item.disputed for item in truth]
    functions = sorted(set().union(*wanted, *(item.functions for item in recognised)))
    return [verdict for name in functions for verdict in match_function(name, truth, recognised)]


def match_by_place(truth: Sequence[TrueObject], inferred: Sequence[RecognisedObject]) -> list[MatchResult]:
    """Compare inferred objects with the truth: correct if the middle of an object of that function lies in its box.

    This is seen from above, and each object matches once. Most of an inferred object was not seen, and the true box may
    be that of a back alone, so boxes need not overlap by much.
    """
    verdicts, left = [], list(truth)
    for claim in inferred:
        inside = [true for true in left if lies_in(true, claim.box)]
        fitting = [true for true in inside if claim.functions <= true.functions | true.disputed]
        nearest = min(fitting, key=lambda true: np.linalg.norm(true.box.center - claim.box.center), default=None)
        left = [true for true in left if true is not nearest]
        verdicts += [MatchResult(function=name, true=nearest, claim=claim) for name in claim.functions]
    return verdicts


def lies_in(true: TrueObject, box: Box) -> bool:
    """Return whether the middle of a true object's box, if it has one, lies in another box seen from above."""
    if true.box is None:
        return False
    return bool((np.abs(box.to_own(true.box.center[None])[0, :2]) <= box.size[:2] / 2 + _MARGIN).all())


def match_function(name: str, truth: Sequence[TrueObject], recognised: Sequence[RecognisedObject]) -> list[MatchResult]:
    """Compare one function of each object."""
    wanted = [item for item in truth if name in item.functions | item.disputed]
    claimed = [item for item in recognised if name in item.functions]
    least = [[LEAST_OF_BOXES if true.points is None else LEAST_OF_POINTS] for true in wanted]
    shared = np.array([[overlap(true, claim) for claim in claimed] for true in wanted])
    pairs = best_pairs(np.where(shared >= least, shared, 0.0)) if wanted and claimed else {}
    found = {t: claimed[c] for t, c in pairs.items()}
    verdicts = [MatchResult(function=name, true=true, claim=found.get(t)) for t, true in enumerate(wanted)]
    others = [claim for c, claim in enumerate(claimed) if c not in pairs.values()]
    return verdicts + [MatchResult(function=name, claim=claim) for claim in others]


def best_pairs(shared: np.ndarray) -> dict[int, int]:
    """Return pairs of rows and columns with the largest overlaps (T, F), each at most once and none with 0."""
    pairs: dict[int, int] = {}
    for flat in np.argsort(-shared, axis=None, kind="stable"):
        t, f = divmod(int(flat), shared.shape[1])
        if shared[t, f] > 0 and t not in pairs and f not in pairs.values():
            pairs[t] = f
    return pairs
