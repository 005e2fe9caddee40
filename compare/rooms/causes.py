"""Why an object was missed and why a claim is false, as far as what was proposed tells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from spherefunc_bullet.function_model import THRESHOLD
from spherefunc_bullet.scenes.segmentation.segmentation import FLOOR, LEFT_OVER, WALL

from .matching import JudgedScan, Verdict, sufficient_overlap
from .truth import RecognisedObject, TrueObject

NOT_PROPOSED, MERGED, TORN, MISLABELLED, UNSURE = "not proposed", "merged", "torn", "mislabelled", "unsure"
CAUSES = (NOT_PROPOSED, MERGED, TORN, MISLABELLED, UNSURE)
Cause = tuple[str, str]  # one of CAUSES, and what happened
SURE = 0.1  # off the threshold: what scores nearer to it is decided by neither side with conviction
_SPARED = 0.03  # metres, of an object's lowest slice, which may be what it stands on; less of a low one:
_SPARED_SHARE = 0.2  # of its height
_PROPOSED = 0.3  # of an object's points: if fewer are in proposals, it was not proposed
_MOST = 0.5  # of an object's points, or of a proposal's
_SOME = 0.05  # of a proposal's points: if an object has so many in it, it is named


class CauseRow(TypedDict):
    """One miss, or one false claim, as JSON has it."""

    scan: str
    function: str
    object: str | None  # None for a claim
    visible: str | None
    score: float | None  # of a claim
    center: list[float]  # of the object's or the claim's box, metres, the scan's frame
    cause: str  # one of CAUSES
    detail: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Overlaps:
    """How the points of true objects and of proposals lie in each other."""

    inside: np.ndarray  # (T, P) share of a proposal's points that an object's box or label holds
    covered: np.ndarray  # (T, P) share of an object's own points that a proposal has


def overlaps_of(scan: JudgedScan, proposals: Sequence[RecognisedObject]) -> Overlaps:
    """Return how objects and proposals overlap."""
    inside, covered = (np.zeros((len(scan.truth), len(proposals))) for _ in range(2))
    for t, true in enumerate(scan.truth):
        whole, own = true.holds(scan.points), own_points(scan, t)
        for p, proposal in enumerate(proposals):
            inside[t, p] = share(proposal.points & whole, proposal.points)
            covered[t, p] = share(proposal.points & own, own)
    return Overlaps(inside=inside, covered=covered)


def own_points(scan: JudgedScan, t: int) -> np.ndarray:
    """Return which of a scan's points are a true object's own, not of what it stands on, (N,) bool."""
    true = scan.truth[t]
    height = 0.0 if true.box is None else true.box.size[2]
    return true.holds(scan.points, min(_SPARED, _SPARED_SHARE * height))


def whereabouts(scan: JudgedScan, own: np.ndarray) -> str:
    """Return where an object's points (N,) bool went, in words."""
    labels = scan.labels
    kinds = {"floor": labels == FLOOR, "wall or ceiling": labels == WALL, "left over": labels == LEFT_OVER}
    kinds["in parts"] = labels >= 0
    shares = {name: share(kind & own, own) for name, kind in kinds.items()}
    return ", ".join(f"{part:.0%} {name}" for name, part in shares.items() if part >= 0.01) or "none"


def share(some: np.ndarray, of: np.ndarray) -> float:
    """Return the share of points (N,) bool that are some of them, 0 where there are none."""
    return np.count_nonzero(some) / max(np.count_nonzero(of), 1)


def cause_rows(scan: JudgedScan) -> tuple[list[CauseRow], list[CauseRow]]:
    """Return every miss of what was seen, and every false claim, each with its cause."""
    missed = [verdict for verdict in scan.verdicts if verdict.outcome == "missed"]
    false = [verdict for verdict in scan.verdicts if verdict.outcome == "false"]
    if not missed and not false:
        return [], []
    proposed, found = overlaps_of(scan, scan.asked), overlaps_of(scan, scan.recognised)
    return (
        [cause_row(scan, verdict, cause_of_miss(scan, verdict, proposed)) for verdict in missed],
        [cause_row(scan, verdict, cause_of_claim(scan, verdict, found)) for verdict in false],
    )


def cause_row(scan: JudgedScan, verdict: Verdict, cause: Cause) -> CauseRow:
    """Return a missed object or a false claim for a report."""
    (kind, detail), true, claim = cause, verdict.true, verdict.claim
    labelled = true is not None and true.points is not None
    center = scan.points[true.points].mean(axis=0) if labelled else (true or claim).box.center
    return {
        "scan": scan.name,
        "function": verdict.function,
        "object": true and true.name,
        "visible": true and true.visible,
        "score": claim and claim.scores[verdict.function],
        "center": np.round(center, 2).tolist(),
        "cause": kind,
        "detail": detail,
    }


def cause_of_miss(scan: JudgedScan, verdict: Verdict, overlaps: Overlaps) -> Cause:
    """Return why an object was not found: what was proposed in its place, and how that was classified."""
    t = scan.truth.index(verdict.true)
    inside, covered = overlaps.inside[t], overlaps.covered[t]
    fits = np.array([sufficient_overlap(verdict.true, proposal) > 0 for proposal in scan.asked])
    fitting = np.flatnonzero(fits & (inside >= _MOST)) if len(fits) else []
    if len(fitting):
        best = max(fitting, key=lambda p: scan.asked[p].scores[verdict.function])
        return cause_of_misclassification(scan, scan.asked[best], verdict.function)
    if fits.any():
        best = int(np.argmax(np.where(fits, inside, -1)))
        return MERGED, f"one part with {others_in(scan, overlaps, best, t)}"
    if covered.max(initial=0.0) < _SOME or covered.sum() < _PROPOSED:
        return NOT_PROPOSED, f"its points: {whereabouts(scan, own_points(scan, t))}"
    best = int(np.argmax(covered))
    if inside[best] < _MOST:
        return MERGED, f"one part with {others_in(scan, overlaps, best, t)}"
    parts = int((covered > _SOME).sum())
    if covered[best] < _MOST or parts > 1:
        return TORN, f"{parts} parts, the largest of {covered[best]:.0%} of its points"
    return TORN, f"one part of {covered[best]:.0%} of its points, too small for its box"


def cause_of_misclassification(scan: JudgedScan, proposal: RecognisedObject, function: str) -> Cause:
    """Return why an object that was proposed as it is was misclassified."""
    score = proposal.scores[function]
    if function in proposal.functions:
        if any(np.array_equal(proposal.points, item.points) for item in scan.recognised):
            return MERGED, "what was found there is another object"
        return MISLABELLED, f"{function} {score:.2f}, but what overlaps it was surer"
    if proposal.fragment:
        return TORN, f"refused as a fragment, {function} {score:.2f}"
    classes = ", ".join(f"{name} {proposal.scores[name]:.2f}" for name in sorted(proposal.functions)) or "nothing"
    kind = UNSURE if score > THRESHOLD - SURE else MISLABELLED
    return kind, f"classified as {classes}; {function} {score:.2f}"


def cause_of_claim(scan: JudgedScan, verdict: Verdict, overlaps: Overlaps) -> Cause:
    """Return why a claim is false: what it is instead, as far as the truth lists that."""
    p = scan.recognised.index(verdict.claim)
    inside, covered = overlaps.inside[:, p], overlaps.covered[:, p]
    fits = np.array([sufficient_overlap(true, verdict.claim) for true in scan.truth])
    held = [t for t in range(len(scan.truth)) if covered[t] >= _MOST and inside[t] >= _SOME]
    if len(held) > 1 and inside[held].max() < 1 - _SOME:
        return MERGED, f"holds {names_of(scan.truth, held)}"
    if fits.max(initial=0.0) > 0:
        true = scan.truth[int(np.argmax(fits))]
        if verdict.function in true.functions:
            return TORN, f"a second part of the {true.name} that was found"
        return MISLABELLED, f"is the {true.name}"
    best = int(np.argmax(inside)) if len(inside) else -1
    if best >= 0 and inside[best] >= _MOST:
        return TORN, f"lies in the box of the {scan.truth[best].name}, {covered[best]:.0%} of it"
    if held:
        return MERGED, f"holds {names_of(scan.truth, held)} and what the truth does not list"
    unsure = verdict.claim.scores[verdict.function] < THRESHOLD + SURE
    return (UNSURE if unsure else MISLABELLED), "an object that the truth does not list"


def others_in(scan: JudgedScan, overlaps: Overlaps, proposal: int, but: int) -> str:
    """Return the names of the true objects that a proposal holds points of, but for one."""
    inside = overlaps.inside[:, proposal]
    return names_of(scan.truth, [t for t in np.argsort(-inside).tolist() if t != but and inside[t] >= _SOME])


def names_of(truth: Sequence[TrueObject], places: Sequence[int]) -> str:
    """Return the names of some objects; of none, what they then are."""
    return ", ".join(truth[t].name for t in places) or "what the truth does not list"
