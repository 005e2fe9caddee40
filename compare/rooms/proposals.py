"""What was recognised in a scan, as the score sees it: in the scan's frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.scenes.recognition.recognition import Room, SceneObject
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.segmentation.clusters import Box

from .truth import RecognisedObject

_LEVEL = np.cos(np.radians(10.0))  # a scan turned by more has its truth in tilted boxes: axis-aligned in its own frame


@dataclass(frozen=True, kw_only=True, eq=False)
class RecognisedScan:
    """A scan, and what was recognised in it."""

    scan: Scan
    room: Room

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

    def as_recognised(self, item: SceneObject, own: np.ndarray) -> RecognisedObject:
        """Return one object that has some of the scan's points (N,) bool; where the scan is tilted, with their box."""
        tilted = self.room.levelling.up[2] < _LEVEL and own.any()
        return RecognisedObject(
            functions=item.members,
            box=aligned_box(self.scan.points[own]) if tilted else self.room.box_in_scan(item.box),
            points=own,
            scores={name: membership.score for name, membership in item.functions.items()},
        )


def aligned_box(points: np.ndarray) -> Box:
    """Return the box around points (N, 3) along their frame's axes."""
    low, high = points.min(axis=0), points.max(axis=0)
    return Box(center=(low + high) / 2, size=high - low, yaw=0.0)
