"""All that was asked about in a scan, as the score sees it, in the scan's frame, and as baselines do, as clouds.

A baseline tells every proposal, and what becomes an object is chosen by its own scores, as by those of the spheres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.function_model import THRESHOLD, Membership
from spherefunc_bullet.scenes.recognition.judging import object_cloud
from spherefunc_bullet.scenes.recognition.proposals import Proposal
from spherefunc_bullet.scenes.recognition.recognition import FINE, MANY, Room, SceneObject
from spherefunc_bullet.scenes.recognition.room import Candidate, chosen
from spherefunc_bullet.scenes.scans.cells import cells
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.segmentation.clusters import Box, bounding_box
from spherefunc_bullet.scenes.segmentation.segmentation import Segmentation

from .truth import RecognisedObject

_LEVEL = np.cos(np.radians(10.0))  # a scan turned by more has its truth in tilted boxes: axis-aligned in its own frame
Scores = dict[str, float]  # of each function


@dataclass(frozen=True, kw_only=True, eq=False)
class Places:
    """The places that points of a scan and of its proposals lie at, numbered."""

    points: np.ndarray  # (M, 3) float64, metres, level frame
    of_scan: np.ndarray  # (N,) int64
    of_proposals: list[np.ndarray]  # (K,) int64 of each, ascending


@dataclass(frozen=True, kw_only=True, eq=False)
class Asked:
    """A scan, and all that was proposed in it."""

    scan: Scan
    room: Room

    @cached_property
    def places(self) -> Places:
        """The places of the scan's points and of all proposals' points.

        A proposal has the same points as the scan, to the bit, and others that were filled in between them.
        """
        seen = self.scan.points
        fine = cells(seen, FINE) if len(seen) > MANY else None
        level = self.room.levelling.to_level(seen if fine is None else fine.means)
        clouds = [level, *(item.points for item in self.room.proposals)]
        together = np.vstack(clouds)
        number, first = numbered(together)
        parts = np.split(number, np.cumsum([len(points) for points in clouds])[:-1])
        return Places(
            points=together[first],
            of_scan=parts[0] if fine is None else parts[0][fine.cell_of],
            of_proposals=[np.unique(part) for part in parts[1:]],
        )

    def objects(self) -> list[RecognisedObject]:
        """Return the objects that the spheres found."""
        return [self.as_recognised(item, self.room.labels == item.id) for item in self.room.objects]

    def inferred(self) -> list[RecognisedObject]:
        """Return the objects that nobody saw, of which there are boxes alone."""
        none = np.zeros(len(self.scan), bool)
        return [
            RecognisedObject(
                functions=frozenset({item.function}), box=self.room.box_in_scan(item.box), points=none, scores={}
            )
            for item in self.room.inferred
        ]

    def proposals(self) -> list[RecognisedObject]:
        """Return all that was proposed, as the spheres tell it; what is the same as others too."""
        proposed = zip(self.room.proposals, self.places.of_proposals, strict=True)
        return [self.as_recognised(item, self.has(members)) for item, members in proposed]

    def has(self, members: np.ndarray) -> np.ndarray:
        """Return which of the scan's points lie at some places (K,), (N,) bool."""
        own = np.zeros(len(self.places.points), bool)
        own[members] = True
        return own[self.places.of_scan]

    def as_recognised(self, item: SceneObject, own: np.ndarray) -> RecognisedObject:
        """Return one object, or a proposal, that has some of the scan's points (N,) bool."""
        return RecognisedObject(
            functions=item.members,
            box=self.box_of(item.box, own),
            points=own,
            scores={name: membership.score for name, membership in item.functions.items()},
            fragment=item.fragment,
        )

    def box_of(self, box: Box, own: np.ndarray) -> Box:
        """Return a box of the level frame in the scan's; where that is tilted, that of points along its axes."""
        tilted = self.room.levelling.up[2] < _LEVEL and own.any()
        return aligned_box(self.scan.points[own]) if tilted else self.room.box_in_scan(box)

    def clouds(self, completion: Sequence[str]) -> list[Cloud]:
        """Return each proposal as spheres met it: completed, standing on its support."""
        return [object_cloud(item.points, completion, item.support)[0] for item in self.room.proposals]

    def classified_by(self, scores: Sequence[Scores]) -> list[RecognisedObject]:
        """Return the objects that the same proposals become by other scores, one for each proposal."""
        candidates = [self.candidate(place, row) for place, row in enumerate(scores)]
        return [self.as_chosen(one) for one in chosen(candidates, Segmentation.min_cluster_size)]

    def candidate(self, place: int, scores: Scores) -> Candidate:
        """Return a proposal with what is said of it; a fragment has no function."""
        item = self.room.proposals[place]
        functions = {
            name: Membership(member=score > THRESHOLD and not item.fragment, score=score, radius=0.0)
            for name, score in scores.items()
        }
        own = Proposal(by=item.proposed_by, members=self.places.of_proposals[place], support=item.support)
        return Candidate(proposal=own, functions=functions, place=place)

    def as_chosen(self, one: Candidate) -> RecognisedObject:
        """Return a candidate that has become an object, with the points that it was left."""
        members, support = one.proposal.members, one.proposal.support
        own, box = self.has(members), bounding_box(self.places.points[members]).lowered(support)
        scores = {name: membership.score for name, membership in one.functions.items()}
        return RecognisedObject(functions=one.claimed, box=self.box_of(box, own), points=own, scores=scores)


def numbered(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a number (N,) for each point (N, 3), the same for the same point, and where each number first stands."""
    order = np.lexsort(points.T)
    new = np.ones(len(points), bool)
    new[1:] = (np.diff(points[order], axis=0) != 0).any(axis=1)
    number = np.empty(len(points), np.int64)
    number[order] = np.cumsum(new) - 1
    return number, order[new]


def aligned_box(points: np.ndarray) -> Box:
    """Return the box around points (N, 3) along their frame's axes."""
    low, high = points.min(axis=0), points.max(axis=0)
    return Box(center=(low + high) / 2, size=high - low, yaw=0.0)
