"""Small objects on top of each other and side by side without a gap, and what lies on seats."""

from __future__ import annotations

import numpy as np

from .chairs_at_tables import SEAT
from .contents import Contents
from .furnishing import FLOOR, SMALL, PlacedObject
from .grounds import top_of
from .occupancy import Occupancy
from .surroundings import CLUTTER

MOVED = 0.6  # of the small objects on a top, that are stacked or pushed together
STACKED = 0.5  # of those
TOUCH = 0.002  # metres at which two objects touch
STEP = 0.001  # metres: an object that could slide on by less has come to its end
PROBES = 1_500  # points of an object that are looked at
CLUTTERED = 0.6  # of the seats
SEAT_HEIGHTS = (0.3, 0.65)  # metres
UPHOLSTERED = 0.02  # metres by which a seat may be uneven


def small_objects_stacked(contents: Contents):
    """Stack some of the small objects on tops, and push others together."""
    occupancy, moved = contents.occupancy(), set()
    for number in range(len(contents.objects)):
        item = contents.objects[number]
        partners = [k for k in neighbours(contents, number) if k not in moved]
        if not is_small(item) or not partners or number in contents.carriers() or contents.rng.uniform() > MOVED:
            continue
        partner = partners[int(contents.rng.integers(len(partners)))]
        occupancy.clear(item.points)
        if contents.rng.uniform() > STACKED or not stacked(contents, occupancy, number, partner):
            pushed_together(contents, number, partner)
        occupancy.fill(contents.objects[number].points)
        moved.add(number)


def is_small(placed: PlacedObject) -> bool:
    """Return whether an object is small and stands on another."""
    return placed.support != FLOOR and placed.cloud.size.max() <= SMALL


def neighbours(contents: Contents, number: int) -> list[int]:
    """Return the small objects on the same top as another."""
    item = contents.objects[number]
    return [
        k
        for k, other in enumerate(contents.objects)
        if k != number and is_small(other) and other.support == item.support
    ]


def stacked(contents: Contents, occupancy: Occupancy, number: int, partner: int) -> bool:
    """Put one object on another's top, if it has room there."""
    ground = top_of(contents.objects[partner].points)
    T_room_object = contents.place_on(contents.objects[number].cloud, ground, occupancy)
    if T_room_object is not None:
        contents.move(number, T_room_object, partner)
    return T_room_object is not None


def pushed_together(contents: Contents, number: int, partner: int):
    """Slide an object towards another on the same top until it touches that, or whatever is between."""
    from scipy.spatial import cKDTree

    item, other = contents.objects[number], contents.objects[partner]
    carrier = contents.objects[item.support].points
    near = [contents.objects[k].points for k in neighbours(contents, number)]
    near.append(carrier[carrier[:, 2] > item.points[:, 2].min() + TOUCH + STEP])
    tree, own = cKDTree(np.vstack(near)), some_of(item.points)
    way = other.T_room_object[:2, 3] - item.T_room_object[:2, 3]
    length = float(np.linalg.norm(way))
    if length < STEP:
        return
    direction, gone = np.append(way / length, 0.0), 0.0
    # So far nothing can be in the way, wherever it is.
    while gone < length and (free := tree.query(own + gone * direction)[0].min() - TOUCH) > STEP:
        gone += free
    moved = min(gone, length) * direction
    if ((own + moved > 0) & (own + moved < contents.size)).all():
        T_room_object = item.T_room_object.copy()
        T_room_object[:3, 3] += moved
        contents.move(number, T_room_object, item.support)


def some_of(points: np.ndarray) -> np.ndarray:
    """Return some of many points (N, 3), evenly chosen."""
    return points[:: max(1, len(points) // PROBES)]


def clutter_on_seats(contents: Contents):
    """Leave objects on some of the seats, where nothing is in the way."""
    occupancy = contents.occupancy()
    for number, seat in enumerate(list(contents.objects)):
        if SEAT not in seat.item.functions or contents.rng.uniform() > CLUTTERED:
            continue
        ground, (least, most) = top_of(seat.points, UPHOLSTERED), SEAT_HEIGHTS
        if least <= ground.height <= most:
            item, cloud = contents.deal([contents.surroundings[CLUTTER]])
            T_room_object = contents.place_on(cloud, ground, occupancy)
            if T_room_object is not None:
                added = contents.add(item, cloud, T_room_object, number)
                occupancy.fill(contents.objects[added].points)
