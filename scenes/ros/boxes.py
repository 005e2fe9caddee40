"""Found objects as boxes with a pose, for ``visualization_msgs/Marker`` and ``vision_msgs/Detection3D``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from spherefunc_bullet.places.place import Place

from ..recognition.objects import FoundObject

COLOURS = {"sittable": (0.0, 0.75, 0.84), "table": (0.88, 0.0, 0.75), "cup": (0.96, 0.59, 0.0)}  # as in pictures
OTHER = (0.4, 0.4, 0.4)
OPACITY = 0.5


@dataclass(frozen=True, kw_only=True)
class FoundBox:
    """The box of one object that has a function, in the frame of the cloud."""

    function: str  # with the best score
    score: float
    position: tuple[float, float, float]  # of the centre, metres
    orientation: tuple[float, float, float, float]  # quaternion x, y, z, w
    size: tuple[float, float, float]  # metres, along the box's own axes
    colour: tuple[float, float, float]  # 0 to 1


def boxes_of(objects: Sequence[FoundObject]) -> list[FoundBox]:
    """Return the boxes of all objects that have a function, in their order."""
    return [box_of(item) for item in objects if item.functions]


def box_of(item: FoundObject) -> FoundBox:
    """Return an object's box; its pose is computed from its corners, which are right in tilted frames too."""
    from scipy.spatial.transform import Rotation

    sides = item.corners[[1, 3, 4]] - item.corners[0]
    size = np.linalg.norm(sides, axis=1)
    axes = sides / np.maximum(size, 1e-9)[:, None]
    function = max(item.functions, key=lambda name: (item.scores[name], name))
    return FoundBox(
        function=function,
        score=item.scores[function],
        position=tuple(item.corners.mean(axis=0).tolist()),
        orientation=tuple(Rotation.from_matrix(axes.T).as_quat().tolist()),
        size=tuple(size.tolist()),
        colour=COLOURS.get(function, OTHER),
    )


def fill_marker(marker: Any, box: FoundBox, number: int) -> Any:
    """Set a ``visualization_msgs/Marker``, without its header, to a box, and return it."""
    marker.ns, marker.id, marker.type, marker.action = box.function, number, 1, 0  # a cube, added or changed
    marker.text = f"{box.function} {box.score:.2f}"
    return posed(marker, box.position, box.orientation, box.size, (*box.colour, OPACITY))


def posed(
    marker: Any, position: Sequence[float], orientation: Sequence[float], size: Sequence[float], colour: Sequence[float]
) -> Any:
    """Set a marker's place, quaternion, size and colour, and return it."""
    at, turn = marker.pose.position, marker.pose.orientation
    at.x, at.y, at.z = position
    turn.x, turn.y, turn.z, turn.w = orientation
    marker.scale.x, marker.scale.y, marker.scale.z = size
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = colour
    return marker


ARROW = 0.3, 0.02, 0.02  # metres: length, width and height of the one that shows a place


def fill_arrow(marker: Any, place: Place, number: int) -> Any:
    """Set a marker, without its header, to an arrow at a place: along a sitter's heading, or up; return it."""
    from scipy.spatial.transform import Rotation

    up = place.normal
    level = np.eye(3)[0 if abs(up[0]) < 0.9 else 1]  # from which headings count, see `Similarity.heading`
    level = (level - level @ up * up) / np.linalg.norm(level - level @ up * up)
    angle = np.radians(place.heading_deg or 0.0)
    ahead = np.cos(angle) * level + np.sin(angle) * np.cross(up, level)
    first, last = (ahead, up) if place.kind == "sit" and place.heading_deg is not None else (up, -ahead)
    axes = np.column_stack([first, np.cross(last, first), last])
    marker.ns, marker.id, marker.type, marker.action = f"place to {place.kind}", number, 0, 0  # added or changed
    marker.text = f"{place.kind} {place.score:.2f}"
    turn = Rotation.from_matrix(axes).as_quat().tolist()
    return posed(marker, place.position.tolist(), turn, ARROW, (*COLOURS[place.function], 1.0))
