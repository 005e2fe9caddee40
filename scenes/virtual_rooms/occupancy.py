"""Occupancy of a room in cubes of two centimetres, so that objects may touch but not cross."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject

from .furnishing import PlacedObject, ShuffledObjects, VirtualRoom, heading_transform, transformed
from .grounds import Ground

SIDE = 0.02  # metres, of a cube; surfaces are sampled every 5 mm, so nothing slips through
_GRAZE = 1e-6  # metres below the floor that rounding may put a point


@dataclass(frozen=True, eq=False)
class Occupancy:
    """How many objects fill each cube of a room, from its corner at the origin."""

    counts: np.ndarray  # (X, Y, Z) int8

    @classmethod
    def of(cls, size: np.ndarray, clouds: Iterable[np.ndarray]) -> Occupancy:
        """Return the occupancy of a room of a size (3,) that holds clouds (N, 3), metres."""
        occupancy = cls(np.zeros(np.ceil(np.asarray(size) / SIDE).astype(int), np.int8))
        for points in clouds:
            occupancy.fill(points)
        return occupancy

    def clear(self, points: np.ndarray):
        """Remove an object's points (N, 3), metres, which were filled before."""
        self.fill(points, -1)

    def fill(self, points: np.ndarray, count: int = 1):
        """Count an object of points (N, 3), metres, once in every cube of the room that it has points in."""
        cubes = np.floor((points.T + _GRAZE) / SIDE).astype(np.int64, order="C")  # each axis in one piece of memory
        ends = np.array(self.counts.shape)[:, None]
        if cubes.size and not (0 <= cubes.min() and (cubes.max(axis=1, keepdims=True) < ends).all()):
            cubes = cubes[:, ((cubes >= 0) & (cubes < ends)).all(axis=0)]
        if not cubes.size:
            return
        low, high = cubes.min(axis=1), cubes.max(axis=1) + 1
        cells = np.zeros(high - low, np.int8)
        cells[tuple(cubes - low[:, None])] = count
        self.counts[tuple(map(slice, low, high))] += cells

    def is_free(self, points: np.ndarray) -> bool:
        """Return whether points (N, 3), metres, all lie in the room and in no filled cube."""
        cubes = np.floor((points + _GRAZE) / SIDE).astype(np.int64)
        inside = ((cubes >= 0) & (cubes < self.counts.shape)).all()
        return bool(inside and not self.counts[tuple(cubes.T)].any())


def raised(points: np.ndarray) -> np.ndarray:
    """Return points (N, 3) without those in the lowest two cubes, into which a support may reach."""
    return points[points[:, 2] > points[:, 2].min() + 2 * SIDE]


@dataclass
class RoomContents:
    """A room that is being filled."""

    room: VirtualRoom
    rng: np.random.Generator
    small: Sequence[ShuffledObjects]  # objects that stand on boards, sills and others
    seats: Sequence[ShuffledObjects]
    surroundings: dict[str, ShuffledObjects]  # by category
    objects: list[PlacedObject] = field(default_factory=list)
    size: np.ndarray = field(default_factory=lambda: np.zeros(3))  # of the room, metres

    def __post_init__(self):
        self.objects, self.size = list(self.room.objects), np.array(self.room.size)

    def occupancy(self) -> Occupancy:
        """Return the occupancy by all objects."""
        return Occupancy.of(self.size, (item.points for item in self.objects))

    def carriers(self) -> frozenset[int]:
        """Return the numbers of the objects that something stands on."""
        return frozenset(item.support for item in self.objects)

    def add(self, item: DatasetObject, cloud: Cloud, T_room_object: np.ndarray, support: int) -> int:
        """Add an object and return its number."""
        self.objects.append(PlacedObject(item, cloud, T_room_object, support))
        return len(self.objects) - 1

    def move(self, number: int, T_room_object: np.ndarray, support: int):
        """Move an object that nothing stands on."""
        old = self.objects[number]
        self.objects[number] = PlacedObject(old.item, old.cloud, T_room_object, support)

    def place_on(self, cloud: Cloud, ground: Ground, occupancy: Occupancy) -> np.ndarray | None:
        """Return a random pose (4, 4) of an object on a ground, and take the place; None if there is no room."""
        T_room_object = heading_transform(float(self.rng.uniform(0, 2 * np.pi)))
        points = transformed(cloud.points, T_room_object)
        place = ground.place(points, 0.0, self.rng)
        if place is None or not occupancy.is_free(raised(points + place)):
            return None
        T_room_object[:3, 3] = place
        return T_room_object

    def put_on(self, dealt: tuple[DatasetObject, Cloud], ground: Ground, occupancy: Occupancy, support: int):
        """Put an object on a ground, if it has room there, and fill its place."""
        T_room_object = self.place_on(dealt[1], ground, occupancy)
        if T_room_object is not None:
            occupancy.fill(self.objects[self.add(*dealt, T_room_object, support)].points)

    def deal(self, decks: Sequence[ShuffledObjects]) -> tuple[DatasetObject, Cloud] | None:
        """Return the next object of one of the decks, at random, with its cloud; None if there are none."""
        if not decks:
            return None
        item = decks[int(self.rng.integers(len(decks)))].deal()
        return item, load_cloud(item.path)

    def finished(self) -> VirtualRoom:
        """Return the room as it is now."""
        return replace(self.room, size=self.size, objects=tuple(self.objects))


def decks_by_category(dataset: Dataset, rng: np.random.Generator) -> dict[str, ShuffledObjects]:
    """Return a deck of each category of a data set."""
    names = sorted({item.category for item in dataset.objects})
    return {name: ShuffledObjects([item for item in dataset.objects if item.category == name], rng) for name in names}
