"""Lived-in rooms: chairs at tables, stacks, shelves, beds, sills, cartons, piles and clutter, by options.

Each kind is in a share of the rooms, chosen by the room's number and the seed alone. A room without any of them is, bit
for bit, the one that `furnishing` makes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from spherefunc_bullet.datasets.dataset import Dataset, open_dataset
from spherefunc_bullet.errors import InputError

from .chairs_at_tables import SEAT, chairs_to_tables
from .fixtures import fixtures_added
from .furnishing import FLOOR, SMALL, FurnitureStock, PlacedObject, ShuffledObjects, VirtualRoom, furnish, take_stock
from .grounds import top_of
from .occupancy import Occupancy, RoomContents, decks_by_category
from .surroundings import CLUTTER

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

MOVED = 0.6  # of the small objects on a top that are stacked or pushed together
STACKED = 0.5  # of those, that are stacked
TOUCH = 0.002  # metres at which two objects touch
STEP = 0.001  # metres: an object that could slide by less stops
PROBES = 1_500  # points of an object that are checked
FEW = 50  # one point in so many is checked first
CLUTTERED = 0.6  # of the seats
SEAT_HEIGHTS = (0.3, 0.65)  # metres
UPHOLSTERED = 0.02  # metres by which a seat may be uneven


def small_objects_stacked(contents: RoomContents):
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


def neighbours(contents: RoomContents, number: int) -> list[int]:
    """Return the small objects on the same top as another."""
    item = contents.objects[number]
    return [
        k
        for k, other in enumerate(contents.objects)
        if k != number and is_small(other) and other.support == item.support
    ]


def stacked(contents: RoomContents, occupancy: Occupancy, number: int, partner: int) -> bool:
    """Put one object on another's top, and return whether it has room there."""
    ground = top_of(contents.objects[partner].points)
    T_room_object = contents.place_on(contents.objects[number].cloud, ground, occupancy)
    if T_room_object is not None:
        contents.move(number, T_room_object, partner)
    return T_room_object is not None


def pushed_together(contents: RoomContents, number: int, partner: int):
    """Slide an object towards another on the same top until it touches that one, or whatever is in between."""
    from scipy.spatial import cKDTree

    item, other = contents.objects[number], contents.objects[partner]
    carrier = contents.objects[item.support].points
    near = [contents.objects[k].points for k in neighbours(contents, number)]
    near.append(carrier[carrier[:, 2] > item.points[:, 2].min() + TOUCH + STEP])
    probes = item.points[:: max(1, len(item.points) // PROBES)]
    way = other.T_room_object[:2, 3] - item.T_room_object[:2, 3]
    length = float(np.linalg.norm(way))
    if length < STEP:
        return
    direction, gone = np.append(way / length, 0.0), 0.0
    near = within_reach(np.vstack(near), probes, length * direction)
    tree = cKDTree(near, balanced_tree=False, compact_nodes=False)  # made in half the time
    # Within the distance to the nearest obstacle the object can slide freely in any direction.
    while gone < length and (free := least_distance(probes + gone * direction, tree) - TOUCH) > STEP:
        gone += free
    moved = min(gone, length) * direction
    if ((probes + moved > 0) & (probes + moved < contents.size)).all():
        T_room_object = item.T_room_object.copy()
        T_room_object[:3, 3] += moved
        contents.move(number, T_room_object, item.support)


def within_reach(points: np.ndarray, probes: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Return the points (N, 3) that may stop an object of points (M, 3) on its way (3,): those near its swept box."""
    margin = np.linalg.norm(way) + TOUCH + 2 * STEP
    low = np.minimum(probes.min(axis=0), (probes + way).min(axis=0)) - margin
    high = np.maximum(probes.max(axis=0), (probes + way).max(axis=0)) + margin
    return points[((points > low) & (points < high)).all(axis=1)]


def least_distance(points: np.ndarray, tree: cKDTree) -> float:
    """Return the least distance of points (N, 3) from a tree's; a few of them bound the search for the others."""
    least = tree.query(points[::FEW])[0].min()
    return min(least, tree.query(points, distance_upper_bound=least)[0].min())


def clutter_on_seats(contents: RoomContents):
    """Put clutter on some of the seats, where they are free."""
    occupancy = contents.occupancy()
    for number, seat in enumerate(list(contents.objects)):
        if SEAT not in seat.item.functions or contents.rng.uniform() > CLUTTERED:
            continue
        ground, (least, most) = top_of(seat.points, UPHOLSTERED), SEAT_HEIGHTS
        if least <= ground.height <= most:
            contents.put_on(contents.deal([contents.surroundings[CLUTTER]]), ground, occupancy, number)


EVERYTHING = "all"


@dataclass(frozen=True, kw_only=True)
class LivedIn:
    """The share of rooms, 0 to 1, that has each kind of additional contents."""

    chairs: float = 0.0  # pushed against and under tables
    stacks: float = 0.0  # small objects on top of each other, and touching
    shelves: float = 0.0  # with objects on their boards
    beds: float = 0.0
    sills: float = 0.0  # of windows, with objects on them
    gaps: float = 0.0  # between cartons
    piles: float = 0.0
    clutter: float = 0.0  # on seats

    def kinds(self, seed: int, number: int) -> frozenset[str]:
        """Return the kinds that the room of a number has; the share of one kind does not affect the others."""
        names = [kind.name for kind in fields(self)]
        offsets = np.random.default_rng([seed, 7]).uniform(size=len(names)).tolist()
        chosen = zip(names, offsets, strict=True)
        return frozenset(name for name, offset in chosen if falls(number, getattr(self, name), offset))


def falls(number: int, share: float, offset: float) -> bool:
    """Return whether the room of a number is among a share of all rooms, evenly spread.

    Examples
    --------
    >>> [falls(number, 0.5, 0.2) for number in range(1, 5)]
    [False, True, False, True]
    """
    return bool(np.floor(number * share + offset) > np.floor((number - 1) * share + offset))


def parse_lived_in(text: str | None) -> LivedIn:
    """Return the shares of a list such as ``chairs=0.5,stacks`` or ``all``; a share left out is 1.

    Raises
    ------
    InputError
        If there is no such kind, or its share is not between 0 and 1.

    Examples
    --------
    >>> parse_lived_in("chairs=0.5,beds").chairs
    0.5
    """
    names = [kind.name for kind in fields(LivedIn)]
    shares = {}
    for part in filter(None, (part.strip() for part in (text or "").split(","))):
        name, _, text = part.partition("=")
        try:
            share = float(text or 1)
        except ValueError:
            share = -1.0
        if not 0 <= share <= 1:
            raise InputError(f"--lived-in {part}: expected a share of rooms from 0 to 1, such as chairs=0.5")
        if name not in (*names, EVERYTHING):
            raise InputError(f"--lived-in {part}: expected some of {', '.join(names)}, or {EVERYTHING}")
        shares |= dict.fromkeys(names if name == EVERYTHING else [name], share)
    return LivedIn(**shares)


def filled(room: VirtualRoom, kinds: frozenset[str], stock: FurnitureStock, rng: np.random.Generator) -> VirtualRoom:
    """Return a room with the additional contents of its kinds."""
    contents = RoomContents(
        room=room,
        rng=rng,
        small=[ShuffledObjects(stock.small[name], rng) for name in sorted(stock.small)],
        seats=[ShuffledObjects(stock.large[SEAT], rng)] if SEAT in stock.large else [],
        surroundings=decks_by_category(open_dataset("surroundings"), rng),
    )
    fixtures_added(contents, kinds)
    if "chairs" in kinds:
        chairs_to_tables(contents)
    if "stacks" in kinds:
        small_objects_stacked(contents)
    if "clutter" in kinds:
        clutter_on_seats(contents)
    return contents.finished()


def furnish_lived_in(
    dataset: Dataset, count: int, *, seed: int = 0, failed: Callable[[InputError], None], lived_in: LivedIn
) -> Iterator[VirtualRoom]:
    """Yield the rooms of `furnish` (see there), shares of which have additional contents.

    Raises
    ------
    InputError
        If no object of the data set can stand in a room.
    """
    stock = take_stock(dataset, failed)
    for number, room in enumerate(furnish(dataset, count, seed=seed, failed=failed, stock=stock), start=1):
        kinds = lived_in.kinds(seed, number)
        yield filled(room, kinds, stock, np.random.default_rng([seed, number, 7])) if kinds else room
