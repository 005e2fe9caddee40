"""What was recognised in a scan, as the score sees it: in the scan's frame."""

from __future__ import annotations

import numpy as np

from spherefunc_bullet.scenes.recognition.recognition import Room, SceneObject
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.segmentation.clusters import Box

from .truth import RecognisedObject

_LEVEL = np.cos(np.radians(10.0))  # a scan turned by more has its truth in tilted boxes: axis-aligned in its own frame


def recognised_in(scan: Scan, room: Room) -> list[RecognisedObject]:
    """Return the objects that the spheres found."""
    return [as_recognised(item, scan, room) for item in room.objects]


def inferred_in(scan: Scan, room: Room) -> list[RecognisedObject]:
    """Return the objects that nobody saw, of which there are boxes alone."""
    none = np.zeros(len(scan), bool)
    return [
        RecognisedObject(functions=frozenset({item.function}), box=room.box_in_scan(item.box), points=none, scores={})
        for item in room.inferred
    ]


def as_recognised(item: SceneObject, scan: Scan, room: Room) -> RecognisedObject:
    """Return one object with its points of the scan; where the scan is tilted, with their box."""
    own = room.labels == item.id
    tilted = room.levelling.up[2] < _LEVEL and own.any()
    return RecognisedObject(
        functions=item.members,
        box=aligned_box(scan.points[own]) if tilted else room.box_in_scan(item.box),
        points=own,
        scores={name: membership.score for name, membership in item.functions.items()},
    )


def aligned_box(points: np.ndarray) -> Box:
    """Return the box around points (N, 3) along their frame's axes."""
    low, high = points.min(axis=0), points.max(axis=0)
    return Box(center=(low + high) / 2, size=high - low, yaw=0.0)
