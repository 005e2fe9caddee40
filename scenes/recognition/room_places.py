"""Places in a scanned room: on what the sensor saw, none where it did not see."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.places.place import Place, Similarity
from spherefunc_bullet.places.pouring import pour_places
from spherefunc_bullet.places.putting import put_places
from spherefunc_bullet.places.sitting import sit_places
from spherefunc_bullet.places.surface import surface_of

from ..scans.filling import filled
from ..scans.scan import Scan
from ..segmentation.segmentation import Segmentation
from .partial_places import hollow_places, level_place
from .room import Room, SceneObject

FLOOR = 0.12  # metres: what is lower in a room is its floor
ABOVE_TABLE = -0.03  # the same where a table top serves as ground
AROUND = 0.6  # metres about a seat that decide where its back is and whether knees have room
SEAT_CELL = 0.025
SIMULATOR = "fast"  # whose spheres tell where a vessel that was seen in part holds them


def room_places(
    scan: Scan, room: Room, put: Cloud | None = None, person: float = 1.75
) -> dict[int | None, list[Place]]:
    """Return the places of each object by its id, and under None those to put of no object; in the scan's frame."""
    cloud = Cloud(filled(room.levelling.to_level(scan.points), Segmentation.leaf_size), scan.name)
    found: dict[int | None, list[Place]] = {item.id: object_places(cloud, item, person) for item in room.objects}
    lowest = ABOVE_TABLE if room.levelling.source == "table top" else FLOOR
    for place in put_places(surface_of(cloud), put, lowest):
        found.setdefault(owner_of(place, room), []).append(place)
    for item in room.objects:
        if "table" in item.members and not any(place.kind == "put" for place in found[item.id]):
            found[item.id] += in_part(item, "put", cloud.points)
    back = from_level(room)
    return {owner: [place.moved(back) for place in places] for owner, places in found.items() if places}


def object_places(room_cloud: Cloud, item: SceneObject, person: float) -> list[Place]:
    """Return where to sit on and to pour into an object, in the level frame."""
    found = []
    if "sittable" in item.members:
        near = around(room_cloud.points, item)
        lifted = Cloud(near - [0, 0, item.support], room_cloud.name)
        seats = sit_places(surface_of(lifted, SEAT_CELL), person, 1.0)
        inside = [place for place in seats if within(place.position, item)]
        found += [raised(place, item.support) for place in inside] or in_part(item, "sit", room_cloud.points)
    if "cup" in item.members and len(item.points) >= 10:
        found += pour_places(Cloud(item.points, room_cloud.name)) or hollow_places(item, SIMULATOR)
    return [replace(place, score=weighed(place, item)) for place in found]


def in_part(item: SceneObject, kind: str, points: np.ndarray) -> list[Place]:
    """Return the place on the level of an object that was seen in part, where there is room for one."""
    place = level_place(item, kind, points)
    return [] if place is None else [place]


def weighed(place: Place, item: SceneObject) -> float:
    """Return the score of a place on an object whose functions are known."""
    return float(np.sqrt(place.score * item.functions[place.function].score))


def around(points: np.ndarray, item: SceneObject) -> np.ndarray:
    """Return the points (N, 3) on and about an object."""
    low, high = item.points.min(axis=0) - AROUND, item.points.max(axis=0) + AROUND
    low[2] = item.support - 0.05
    return points[((points >= low) & (points <= high)).all(axis=1)]


def within(position: np.ndarray, item: SceneObject) -> bool:
    """Return whether a position is above an object's box."""
    aside = (position[:2] - item.box.center[:2]) @ item.box.axes[:2, :2].T
    return bool((np.abs(aside) <= item.box.size[:2] / 2 + 0.05).all())


def owner_of(place: Place, room: Room) -> int | None:
    """Return the id of the object on which a place is, the smallest; None for none."""
    on = [
        item
        for item in room.objects
        if within(place.position, item) and item.support - 0.05 <= place.height <= item.points[:, 2].max() + 0.05
    ]
    return min(on, key=lambda item: float(item.box.size[0] * item.box.size[1])).id if on else None


def raised(place: Place, height: float) -> Place:
    """Return a place on an object that stands so high."""
    return place.moved(Similarity(np.eye(3), 1.0, np.array([0.0, 0.0, height])))


def from_level(room: Room) -> Similarity:
    """Return what takes the level frame to the scan's."""
    turn = room.levelling.T_level_scan[:3, :3].T
    return Similarity(turn, 1.0, -turn @ room.levelling.T_level_scan[:3, 3])
