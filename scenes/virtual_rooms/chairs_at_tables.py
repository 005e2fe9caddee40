"""Chairs at tables: each slides towards the table, front first, until it touches something or is under the top."""

from __future__ import annotations

import numpy as np

from ..segmentation.clusters import bounding_box
from .furnishing import FLOOR, TABLE, PlacedObject, heading_transform, transformed
from .occupancy import Occupancy, RoomContents

SEAT = "sittable"
WIDEST, HIGHEST = 0.75, 1.3  # metres, of a chair
TABLE_HEIGHTS = (0.55, 1.1)  # metres, of tables that people sit at
TABLE_SIDE = 0.5  # metres, the least
MOST = 4  # chairs at a table
PLACE = 0.65  # metres of a side that a chair takes
CLEAR = 0.05  # metres from a table at which a chair begins to slide
STEP = 0.01  # metres
TURNED = np.radians(10.0)  # at most, off the table's side
TOUCHING = 0.5  # of the chairs are pushed in completely, the others pulled out by
PULLED = 0.25  # metres, at most
_BACK = 0.7  # of a chair's height, above which there is only its back
_OFF = 0.04  # metres from the middle to the back, at least, for a chair to have a front


Seating = tuple[np.ndarray, np.ndarray]  # a place (2,) at a table's side, metres, and the unit vector (2,) away from it


def chairs_to_tables(contents: RoomContents):
    """Push chairs to every table: first the room's own that carry nothing, then others of the data set."""
    chairs = [k for k, item in enumerate(contents.objects) if is_chair(item) and k not in contents.carriers()]
    occupancy = contents.occupancy()
    for table in [item for item in contents.objects if is_dining_table(item)]:
        seatings = seatings_of(table)
        wanted = int(contents.rng.integers(1, MOST + 1))
        for place in contents.rng.permutation(len(seatings)):
            if wanted and seat_chair(contents, occupancy, seatings[place], chairs):
                wanted -= 1


def is_chair(placed: PlacedObject) -> bool:
    """Return whether an object is a movable seat for one."""
    size = placed.cloud.size
    return SEAT in placed.item.functions and size[:2].max() <= WIDEST and size[2] <= HIGHEST


def is_dining_table(placed: PlacedObject) -> bool:
    """Return whether an object is a table that chairs are pushed to."""
    size, (least, most) = placed.cloud.size, TABLE_HEIGHTS
    level = least <= size[2] <= most and size[:2].min() >= TABLE_SIDE
    return TABLE in placed.item.functions and placed.support == FLOOR and bool(level)


def seatings_of(table: PlacedObject) -> list[Seating]:
    """Return the places at the four sides of a table."""
    box, places = bounding_box(table.points), []
    for along in (0, 1):
        count = max(1, int(box.size[along] / PLACE))
        for sign in (-1, 1):
            outward = sign * box.axes[1 - along, :2]
            edge = box.center[:2] + outward * box.size[1 - along] / 2
            shares = (np.arange(count) + 0.5) / count - 0.5
            stretch = box.size[along] * box.axes[along, :2]
            places += [(edge + share * stretch, outward) for share in shares]
    return places


def seat_chair(contents: RoomContents, occupancy: Occupancy, seating: Seating, chairs: list[int]) -> bool:
    """Push one chair to a place and return whether it has room; one of the room's own is taken off the list."""
    number = chairs[-1] if chairs else None
    if number is None:
        dealt = contents.deal(contents.seats)
        chair = None if dealt is None else PlacedObject(*dealt, np.eye(4))
        if chair is None or not is_chair(chair):
            return False
    else:
        chair = contents.objects[number]
        occupancy.clear(chair.points)
    T_room_object = pushed(chair, seating, occupancy, contents.rng)
    if T_room_object is not None and number is not None:
        contents.move(chairs.pop(), T_room_object, FLOOR)
    elif T_room_object is not None:
        number = contents.add(chair.item, chair.cloud, T_room_object, FLOOR)
    if number is not None:
        occupancy.fill(contents.objects[number].points)
    return T_room_object is not None


def pushed(chair: PlacedObject, seating: Seating, occupancy: Occupancy, rng: np.random.Generator) -> np.ndarray | None:
    """Return the pose (4, 4) of a chair that is pushed to a place; None if there is no room next to the table."""
    (middle, outward), front = seating, front_of(chair.cloud.points, rng)
    inward = -outward
    angle = np.arctan2(inward[1], inward[0]) - np.arctan2(front[1], front[0])
    T_room_object = heading_transform(float(angle + rng.uniform(-TURNED, TURNED)))
    points = transformed(chair.cloud.points, T_room_object)
    along = points[:, :2] @ outward
    start = middle + (CLEAR - along.min()) * outward
    steps = np.arange(0.0, CLEAR + np.ptp(along), STEP)
    moved = (points + np.append(start + step * inward, 0.0) for step in steps)
    free = next((k for k, placed in enumerate(moved) if not occupancy.is_free(placed)), len(steps))
    pulled = 0.0 if rng.uniform() < TOUCHING else rng.uniform(0.0, PULLED)
    if free == 0:
        return None
    T_room_object[:2, 3] = start + max(steps[free - 1] - pulled, 0.0) * inward
    return T_room_object


def front_of(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return the direction (2,) that a chair (N, 3) about the z axis faces: away from its back; random for a stool."""
    high = points[points[:, 2] > _BACK * points[:, 2].max()]
    back = (high[:, :2].min(axis=0) + high[:, :2].max(axis=0)) / 2
    if np.linalg.norm(back) < _OFF:
        angle = rng.uniform(0, 2 * np.pi)
        return np.array([np.cos(angle), np.sin(angle)])
    return -back / np.linalg.norm(back)
