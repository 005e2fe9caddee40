"""What was proposed in a scan, as the score sees it, in the scan's frame, and as baselines do, as clouds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.scenes.recognition.recognition import Room, SceneObject, object_cloud
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.segmentation.box import Box

from .truth import RecognisedObject

_LEVEL = np.cos(np.radians(10.0))  # a scan turned by more has its truth in tilted boxes: axis-aligned in its own frame


def recognised_objects(scan: Scan, room: Room) -> list[RecognisedObject]:
    """Return the objects of a room in the scan's frame."""
    return [recognised_object(scan, room, item) for item in room.objects]


def recognised_object(scan: Scan, room: Room, item: SceneObject) -> RecognisedObject:
    """Return one object in the scan's frame; where that is tilted, by the box of its points along the frame's axes."""
    own = room.labels == item.id
    tilted = room.levelling.up[2] < _LEVEL
    return RecognisedObject(
        functions=item.members,
        box=aligned_box(scan.points[own]) if tilted else room.box_in_scan(item.box),
        points=own,
        scores={name: membership.score for name, membership in item.functions.items()},
        fragment=item.fragment,
    )


def aligned_box(points: np.ndarray) -> Box:
    """Return the box around points (N, 3) along their frame's axes."""
    low, high = points.min(axis=0), points.max(axis=0)
    return Box(center=(low + high) / 2, size=high - low, yaw=0.0)


def proposal_clouds(room: Room, completion: Sequence[str]) -> list[Cloud]:
    """Return each object as spheres met it: completed, standing on its support."""
    return [object_cloud(item.points, completion, item.support)[0] for item in room.objects]


def told_otherwise(recognised: RecognisedObject, scores: dict[str, float], threshold: float) -> RecognisedObject:
    """Return an object as something else tells it; what was refused as a fragment stays refused."""
    members = frozenset(name for name, score in scores.items() if score > threshold and not recognised.fragment)
    return replace(recognised, functions=members, scores=scores)
