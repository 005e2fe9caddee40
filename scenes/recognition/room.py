"""The result for a scan: objects with their functions, and objects that are inferred without being seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from spherefunc_bullet.function_model import THRESHOLD, Membership
from spherefunc_bullet.learning.profiles.calibration import ScoreRange, uncertainty

from ..scans.levelling import Levelling
from ..segmentation.clusters import Box, members_of
from ..settings import RECOGNITION
from .proposals import CLUSTERS, POOLS, Proposal, shared_points


@dataclass(frozen=True, kw_only=True)
class ClaimThreshold:
    """The score above which a proposal claims a function."""

    usual: float
    by_function: Mapping[str, float] = field(default_factory=dict)  # where it is another

    def of(self, name: str) -> float:
        """Return the threshold of a function."""
        return self.by_function.get(name, self.usual)


# Chosen on virtual rooms of objects that the model had not learnt (docs/rooms.md): most clusters that may be a seat are
# one. For scores that are probabilities.
THRESHOLDS = {
    CLUSTERS: ClaimThreshold(usual=0.5, by_function={"cup": 0.55, "sittable": 0.4}),
    POOLS: ClaimThreshold(usual=0.5, by_function={"cup": 0.55}),
}
# Chosen in such rooms, too: 0.95 of the claims above it are true, and 0.01 of what is below it have the function.
UNSURE_RANGE: ScoreRange = (0.2, 0.95)
LOWEST_THRESHOLD = min(min(each.usual, *each.by_function.values()) for each in THRESHOLDS.values())


@dataclass(frozen=True, kw_only=True, eq=False)
class ObjectCandidate:
    """A proposal with its memberships."""

    proposal: Proposal
    functions: dict[str, Membership]
    place: int  # in the order of proposals
    fragment: bool = False  # see `judging.is_fragment`
    screened: bool = False  # its surroundings alone rule out all functions; see `forest.Screening`

    @property
    def claimed(self) -> frozenset[str]:
        """The functions that it has."""
        return frozenset(name for name, membership in self.functions.items() if membership.member)

    @property
    def score(self) -> float:
        """The best score of the functions that it has, 0 without any."""
        return max((membership.score for membership in self.functions.values() if membership.member), default=0.0)

    def taking(self, members: np.ndarray) -> ObjectCandidate:
        """Return the candidate with other points."""
        box = self.proposal.box if np.array_equal(members, self.proposal.members) else None
        return replace(self, proposal=replace(self.proposal, members=members, box=box))


def with_claims(functions: dict[str, Membership], threshold: ClaimThreshold) -> dict[str, Membership]:
    """Return memberships in which those functions are claimed whose scores are above the threshold."""
    return {name: replace(one, member=one.score > threshold.of(name)) for name, one in functions.items()}


def choose_objects(candidates: Sequence[ObjectCandidate], least: int) -> list[ObjectCandidate]:
    """Return the candidates that are objects, each with points of its own, the one of most points first.

    Of several claims of the same object the surest stays. A cluster without a claim is an object if claims leave enough
    of it. Points that several objects share belong to the smallest: to a cup, not to its table.

    Parameters
    ----------
    candidates : sequence of ObjectCandidate
    least : int
        The least number of points of an object.
    """
    claims: list[ObjectCandidate] = []
    for candidate in sorted((one for one in candidates if one.claimed), key=claim_order):
        if not any(is_same_object(candidate, other) for other in claims):
            claims.append(candidate)
    clusters = [one for one in candidates if one.proposal.by == CLUSTERS]
    claims = [with_cluster_points(one, clusters) for one in claims]
    held = points_held(claims, candidates)
    unclaimed = (one for one in clusters if not one.claimed)
    rest = [one for one in unclaimed if 1 - held[one.proposal.members].mean() > 1 - RECOGNITION.within]
    rest += standing(candidates, claims)
    rest += [one for one in candidates if one.proposal.by != CLUSTERS and not clusters and not one.claimed]
    return without_shared_points([*claims, *rest], least)


def standing(candidates: Sequence[ObjectCandidate], claims: Sequence[ObjectCandidate]) -> list[ObjectCandidate]:
    """Return candidates without a function that stand apart on a table and are no claimed object, the largest first."""
    apart: list[ObjectCandidate] = []
    for one in sorted(candidates, key=lambda one: -len(one.proposal.members)):
        if one.proposal.on_top and not one.claimed and not any(is_same_object(one, other) for other in claims):
            if not any(shared_points(one.proposal, other.proposal) for other in apart):
                apart.append(one)
    return apart


def claim_order(one: ObjectCandidate) -> tuple[int, bool, int, int]:
    """Return the sort key of claims: by score, where it is nearly equal clusters first, then the larger claim.

    A cluster that holds several objects has lower scores than the pools in it. A pool may hold half an object, such as
    one of a sofa's two seats, with the same score as the whole.
    """
    return -round(one.score / RECOGNITION.nearly), one.proposal.by != CLUSTERS, -len(one.proposal.members), one.place


def is_same_object(one: ObjectCandidate, other: ObjectCandidate) -> bool:
    """Return whether two claims are of the same object."""
    shared = shared_points(one.proposal, other.proposal)
    if not shared:
        return False
    sizes = len(one.proposal.members), len(other.proposal.members)
    if shared / (sum(sizes) - shared) >= RECOGNITION.same_object:
        return True
    return bool(one.claimed & other.claimed) and shared >= RECOGNITION.within * min(sizes)


def with_cluster_points(claim: ObjectCandidate, clusters: Sequence[ObjectCandidate]) -> ObjectCandidate:
    """Return a pool's claim with all points of the cluster that is the same object, if there is one."""
    if claim.proposal.by == CLUSTERS:
        return claim
    for cluster in clusters:
        shared = shared_points(claim.proposal, cluster.proposal)
        sizes = len(claim.proposal.members), len(cluster.proposal.members)
        if shared >= 0.9 * sizes[0] and shared / (sum(sizes) - shared) >= RECOGNITION.within:
            return claim.taking(cluster.proposal.members)
    return claim


def points_held(some: Sequence[ObjectCandidate], candidates: Sequence[ObjectCandidate]) -> np.ndarray:
    """Return which of the points, up to the last one of all candidates, some of these hold, (N,) bool."""
    last = max((one.proposal.members[-1] for one in candidates if len(one.proposal.members)), default=-1)
    held = np.zeros(last + 1, bool)
    for one in some:
        held[one.proposal.members] = True
    return held


def without_shared_points(candidates: Sequence[ObjectCandidate], least: int) -> list[ObjectCandidate]:
    """Return candidates without points that a smaller one holds, the one of most points first; too few are left out."""
    taken, left = points_held((), candidates), []
    for one in sorted(candidates, key=lambda one: len(one.proposal.members)):
        members = one.proposal.members
        free = members[~taken[members]]
        taken[free] = True
        if len(free) >= least:
            left.append(one.taking(free))
    return sorted(left, key=lambda one: (-len(one.proposal.members), one.place))


FRAGMENT = "it is small and carried by nothing: a part of an object that is not seen whole"
SCREENED = "its size and surroundings rule out all functions, so no sphere was dropped on it"
ASSUMED = "neither floor nor table top is seen: heights are over the lowest point"


@dataclass(frozen=True, kw_only=True, eq=False)
class SceneObject:
    """One object of a room."""

    id: int  # its label in `Room.labels`
    points: np.ndarray  # (N, 3) float64, metres, level frame; of a scan of many points, thinned
    support: float  # the height it stands on, metres
    box: Box  # in the level frame, down to the support, since legs may not be seen
    fragment: bool  # small, and carried by nothing: a part of an object that is not seen whole
    functions: dict[str, Membership]
    screened: bool = False  # its surroundings alone rule out all functions, so that its scores are 0
    proposed_by: str = CLUSTERS  # or "pools"
    made_from: str | None = None  # "table top": the support that serves as ground
    height: float | None = None  # of such a top over the floor, metres; None: unknown

    @property
    def members(self) -> frozenset[str]:
        """The functions that it has."""
        return frozenset(name for name, membership in self.functions.items() if membership.member)

    @property
    def main_function(self) -> str | None:
        """The function with the best score of those that it has; None if it has none."""
        claimed = [name for name, membership in self.functions.items() if membership.member]
        return max(claimed, key=lambda name: self.functions[name].score, default=None)


@dataclass(frozen=True, kw_only=True, eq=False)
class InferredObject:
    """An object whose place is known though it was not seen; see `inferring`."""

    function: str
    box: Box  # level frame: as deep as a chair, from the floor to the back's top
    table: int  # the object whose edge it stands at
    reason: str

    def at(self, table: int) -> InferredObject:
        """Return it with another number of its table."""
        return replace(self, table=table, reason=self.reason.replace(f"table {self.table};", f"table {table};"))


@dataclass(frozen=True, kw_only=True, eq=False)
class Room:
    """The objects of a scan, and what else was found in it."""

    levelling: Levelling
    labels: np.ndarray  # (N,) int32 of the scan's points: an object's id, -1 floor, -2 wall or ceiling, -3 left over
    objects: list[SceneObject]
    proposals: list[SceneObject] = field(default_factory=list)  # all that were classified, overlapping ones too
    inferred: list[InferredObject] = field(default_factory=list)  # not seen, and not counted among the objects
    stages: dict[str, float] = field(default_factory=dict)  # seconds that each step took
    thresholds: Mapping[str, ClaimThreshold] | None = None  # by the source of proposals; None: the model's own
    unsure_ranges: Mapping[str, ScoreRange] = field(default_factory=dict)  # of the scores of each function

    @cached_property
    def point_indices(self) -> list[np.ndarray]:
        """The indices of each object's points, ascending, (K,) int64 each."""
        return members_of(self.labels, len(self.objects))

    @property
    def function_names(self) -> list[str]:
        """The functions that objects can have; none without objects."""
        return list(self.objects[0].functions) if self.objects else []

    def threshold(self, item: SceneObject, function: str) -> float:
        """Return the score that an object had to exceed to have a function."""
        return THRESHOLD if self.thresholds is None else self.thresholds[item.proposed_by].of(function)

    def reasons(self, item: SceneObject) -> list[str]:
        """Return a sentence for each function that an object has, or why no function was tried."""
        if item.screened:
            return [SCREENED]
        return [
            f"{name} {one.score:.2f}: above the threshold of {self.threshold(item, name):.2f} for {item.proposed_by}"
            for name, one in item.functions.items()
            if one.member
        ]

    def doubts(self, item: SceneObject) -> list[str]:
        """Return why the answer about an object is unsure, each a sentence; none if it is sure."""
        doubts = [FRAGMENT] if item.fragment else []
        doubts += [
            uncertainty(name, item.functions[name].score, self.unsure_ranges[name])
            for name in self.unsure_functions(item)
        ]
        return [*doubts, ASSUMED] if self.levelling.source == "assumed" else doubts

    def unsure_functions(self, item: SceneObject) -> list[str]:
        """Return the functions of which an object's scores leave open whether it has them."""
        scores = {name: one.score for name, one in item.functions.items()}
        return [name for name, (low, high) in self.unsure_ranges.items() if low < scores[name] < high]

    def box_in_scan(self, box: Box) -> Box:
        """Return a box of the level frame in the scan's frame; it is exact only if that is level too."""
        center = self.levelling.to_scan(box.center[None])[0]
        x = box.axes[0] @ self.levelling.T_level_scan[:3, :3]
        return Box(center=center, size=box.size, yaw=float(np.arctan2(x[1], x[0])))
