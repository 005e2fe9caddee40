"""A room that is being filled: what stands in it, what may be added, and which places are free."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject

from .furnishing import Deck, PlacedObject, VirtualRoom, heading_transform, transformed
from .grounds import Ground
from .occupancy import Occupancy, raised


@dataclass
class Contents:
    """A room that is being filled."""

    room: VirtualRoom
    rng: np.random.Generator
    small: Sequence[Deck]  # what stands on boards, sills and objects
    seats: Sequence[Deck]
    surroundings: dict[str, Deck]  # by category
    objects: list[PlacedObject] = field(default_factory=list)
    size: np.ndarray = field(default_factory=lambda: np.zeros(3))  # of the room, metres

    def __post_init__(self):
        self.objects, self.size = list(self.room.objects), np.array(self.room.size)

    def occupancy(self) -> Occupancy:
        """Return which places are filled by the objects."""
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
        """Return where an object (4, 4) comes to stand on a ground, at random, and take the place, None without any."""
        T_room_object = heading_transform(float(self.rng.uniform(0, 2 * np.pi)))
        points = transformed(cloud.points, T_room_object)
        place = ground.place(points, 0.0, self.rng)
        if place is None or not occupancy.is_free(raised(points + place)):
            return None
        T_room_object[:3, 3] = place
        return T_room_object

    def deal(self, decks: Sequence[Deck]) -> tuple[DatasetObject, Cloud] | None:
        """Return the next object of one of the decks, at random, with its cloud; None if there are none."""
        if not decks:
            return None
        item = decks[int(self.rng.integers(len(decks)))].deal()
        return item, load_cloud(item.path)

    def finished(self) -> VirtualRoom:
        """Return the room as it is now."""
        return replace(self.room, size=self.size, objects=tuple(self.objects))


def decks_by_category(dataset: Dataset, rng: np.random.Generator) -> dict[str, Deck]:
    """Return a deck of each category of a data set."""
    names = sorted({item.category for item in dataset.objects})
    return {name: Deck([item for item in dataset.objects if item.category == name], rng) for name in names}
