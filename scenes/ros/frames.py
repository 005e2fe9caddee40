"""Frames of ``/tf`` and ``/tf_static``: from a sensor's own to one whose z points up."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

# Frames that are level by convention (REP 105, and 120 for humanoids); the first known one is used.
LEVEL = ("map", "odom", "world", "base_footprint", "base_link", "base")
_SHORTEST = 0.5  # length of a quaternion, at least; 0 in a message that was never filled
_DEEPEST = 100  # frames from a sensor to the root: a deeper tree has a cycle


@dataclass(frozen=True, kw_only=True, eq=False)
class Edge:
    """The pose of a frame in its parent at a time."""

    parent: str
    stamp: float  # seconds; minus infinity for static transforms
    T_parent_child: np.ndarray  # (4, 4)


@dataclass
class FrameTree:
    """The published frames, each with its transforms over time."""

    edges: dict[str, list[Edge]] = field(default_factory=dict)  # by child

    def add(self, transforms: Iterable[Any], static: bool = False):
        """Add the transforms of a ``tf2_msgs/TFMessage``, without those that are none, which tf2 ignores as well.

        A static transform takes the place of all earlier ones of its frame, as in tf2.
        """
        for transform in filter(is_transform, transforms):
            edge = Edge(
                parent=plain(transform.header.frame_id),
                stamp=-np.inf if static else seconds(transform.header.stamp),
                T_parent_child=matrix_of(transform.transform),
            )
            known = self.edges.setdefault(plain(transform.child_frame_id), [])
            if static:
                known.clear()
            known.append(edge)

    def edge_at(self, child: str, stamp: float) -> Edge | None:
        """Return the transform of a frame nearest to a time, None if there is none."""
        known = self.edges.get(child, ())
        return min(known, key=lambda edge: 0.0 if np.isinf(edge.stamp) else abs(edge.stamp - stamp), default=None)

    def to_level(self, frame: str, stamp: float) -> tuple[str, np.ndarray, float] | None:
        """Return a level ancestor's name, the transform (4, 4) to it, and how far that is in time, seconds; or None.

        Of transforms at several times the nearest is used, without interpolation.
        """
        frame, T, apart, placed = plain(frame), np.eye(4), 0.0, {}
        for _ in range(_DEEPEST):
            placed.setdefault(frame.rpartition("/")[2], (frame, T, apart))
            edge = self.edge_at(frame, stamp)
            if edge is None:
                break
            frame, T = edge.parent, edge.T_parent_child @ T
            apart = apart if np.isinf(edge.stamp) else max(apart, abs(edge.stamp - stamp))
        return next((placed[name] for name in LEVEL if name in placed), None)


def plain(frame: str) -> str:
    """Return a frame's name without the leading slash that ROS 1 allowed."""
    return frame.lstrip("/")


def seconds(stamp: Any) -> float:
    """Return a ``builtin_interfaces/Time`` as seconds, with the field names of ROS 1 or 2.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> seconds(SimpleNamespace(sec=2, nanosec=500_000_000)), seconds(SimpleNamespace(secs=2, nsecs=0))
    (2.5, 2.0)
    """
    whole = stamp.sec if hasattr(stamp, "sec") else stamp.secs
    rest = stamp.nanosec if hasattr(stamp, "nanosec") else stamp.nsecs
    return float(whole) + 1e-9 * float(rest)


def is_transform(stamped: Any) -> bool:
    """Return whether a ``geometry_msgs/TransformStamped`` has a rotation and a translation."""
    turn, shift = stamped.transform.rotation, stamped.transform.translation
    length = np.linalg.norm([turn.x, turn.y, turn.z, turn.w])
    return bool(_SHORTEST < length < np.inf and np.isfinite([shift.x, shift.y, shift.z]).all())


def matrix_of(transform: Any) -> np.ndarray:
    """Return a ``geometry_msgs/Transform`` as a matrix (4, 4)."""
    from scipy.spatial.transform import Rotation

    turn, shift = transform.rotation, transform.translation
    T = np.eye(4)
    T[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
    T[:3, 3] = [shift.x, shift.y, shift.z]
    return T
