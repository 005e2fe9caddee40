"""Scans from recorded bags of ROS 1 (``.bag``) and ROS 2 (a folder with ``metadata.yaml``, ``.mcap``, ``.db3``)."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spherefunc_bullet.errors import InputError, explaining, one_line
from spherefunc_bullet.formats.files import require_ordinary

from ..scans.scan import Report, Scan, scan_from_points
from .frames import FrameTree, plain, seconds
from .point_cloud2 import colours_of, points_of

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import Connection

CLOUD = "sensor_msgs/msg/PointCloud2"
TRANSFORMS, FIXED_TRANSFORMS = "/tf", "/tf_static"
SUFFIXES = (".bag", ".mcap", ".db3")
NEAR_IN_TIME = 0.1  # seconds between a cloud and a transform; more is reported
_SHOWN = 12  # topics in an error


def is_bag(path: Path) -> bool:
    """Return whether a path names a recorded bag."""
    return path.suffix.lower() in SUFFIXES or os.path.isfile(path / "metadata.yaml")


def load_bag(path: str | Path, *, topic: str | None = None, time: float = 0.0, report: Report | None = None) -> Scan:
    """Return the scan of one cloud of a bag, in a level frame where ``/tf`` has one, else in the sensor's own.

    Parameters
    ----------
    path : str or Path
    topic : str, optional
        Of the clouds; by default the only one of the bag.
    time : float
        Seconds after the start of the bag, from which on the first cloud is used.
    report : callable, optional
        Takes one line of text about the choice.

    Raises
    ------
    InputError
        If the bag cannot be read, or has no such cloud; the message is one line and begins with the bag's name.
    """
    path = Path(path)
    name = one_line(path.resolve().name if path.name in ("", "..") else path.name)
    with opened(path, name) as reader:
        chosen = topic_of_clouds(reader.topics, topic, name)
        connections = [known for known in reader.connections if known.topic == chosen]
        message, recorded = cloud_at(reader, connections, time, f"{name} {chosen}")
        frames = frame_tree(reader)
    stamp, frame = seconds(message.header.stamp) or recorded, plain(message.header.frame_id)
    level = frames.to_level(frame, stamp)
    if report is not None:
        placed = "its own frame, as no level frame is in /tf" if level is None else f"the level frame {level[0]}"
        if level is not None and level[2] > NEAR_IN_TIME:
            placed += f", by a transform {level[2]:.3g} s away; did the robot move meanwhile, or is it another clock?"
        report(f"{name}: {chosen} at {stamp:.3f} s, of the frame {frame or '(none)'}, in {placed}")
    points = points_of(message, name)
    if level is not None:
        points = points @ level[1][:3, :3].T + level[1][:3, 3]
    colours = colours_of(message, name)
    return scan_from_points(points, name, colors=colours, level_frame=None if level is None else level[0])


@contextmanager
def opened(path: Path, name: str) -> Iterator[AnyReader]:
    """Open a bag; errors of a damaged one become one line."""
    needs = "expected the package rosbags to read a bag"
    with explaining(f"{name}: {needs}; pip install 'spherefunc-bullet[ros]'", ImportError):
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    if not path.is_dir():
        require_ordinary(path)
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            yield reader
    except InputError:
        raise
    except Exception as error:  # damaged files make the storages raise exceptions of any kind
        came = one_line(str(error)) or type(error).__name__
        raise InputError(f"{name}: expected a bag of ROS 1 or ROS 2; {came[:200]}") from error


def topic_of_clouds(topics: Mapping[str, Any], topic: str | None, name: str) -> str:
    """Return the topic whose clouds are used.

    Raises
    ------
    InputError
        If the bag does not have it, it has no clouds, or it is not named though several topics have clouds.
    """
    clouds = [known for known, about in topics.items() if about.msgtype == CLOUD]
    if not clouds:
        raise InputError(f"{name}: expected a topic of sensor_msgs/PointCloud2, found {listed(topics)}")
    if topic is None and len(clouds) > 1:
        raise InputError(f"{name}: expected topic=, one of {', '.join(clouds)}")
    chosen = clouds[0] if topic is None else topic
    if chosen not in topics:
        raise InputError(f"{name}: expected topic= to be one of {', '.join(clouds)}, got {chosen}")
    if chosen not in clouds:
        came = f"{chosen} of {topics[chosen].msgtype}"
        raise InputError(f"{name}: expected a topic of sensor_msgs/PointCloud2 ({', '.join(clouds)}), got {came}")
    return chosen


def listed(topics: Mapping[str, Any]) -> str:
    """Return topics with their types as a text."""
    shown = [f"{name} ({about.msgtype})" for name, about in list(topics.items())[:_SHOWN]]
    more = f" and {len(topics) - _SHOWN} more" if len(topics) > _SHOWN else ""
    return ", ".join(shown) + more or "an empty bag"


def cloud_at(reader: AnyReader, connections: list[Connection], time: float, what: str) -> tuple[Any, float]:
    """Return the first cloud from a time on, seconds after the start of the bag, and when it was recorded, seconds.

    Raises
    ------
    InputError
        If there is none.
    """
    begin = reader.start_time
    for connection, recorded, raw in reader.messages(connections, start=begin + round(time * 1e9)):
        return reader.deserialize(raw, connection.msgtype), recorded / 1e9
    count = sum(known.msgcount for known in connections)
    length = (reader.end_time - begin) / 1e9 if count else 0.0
    wanted = f"a cloud from {time:g} s on" if count else "a cloud"
    raise InputError(f"{what}: expected {wanted}, found {count} in {max(length, 0.0):.1f} s; set time=")


def frame_tree(reader: AnyReader) -> FrameTree:
    """Return all frames of a bag."""
    tree = FrameTree()
    connections = [known for known in reader.connections if known.topic in (TRANSFORMS, FIXED_TRANSFORMS)]
    for connection, _, raw in reader.messages(connections) if connections else ():
        message = reader.deserialize(raw, connection.msgtype)
        tree.add(message.transforms, static=connection.topic == FIXED_TRANSFORMS)
    return tree
