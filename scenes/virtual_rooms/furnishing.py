"""Virtual rooms: objects of a data set on a floor between walls, small ones on table tops, with known labels.

A room's frame has z up, the floor at z = 0 and a corner at the origin. Neighbours keep a gap. An object touches the one
that carries it, and both are objects of their own: a cup, and the table below it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud, Mesh, load_cloud
from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.sources import read_geometry

from .grounds import Ground, floor_of, top_of

FLOOR, WALL = -1, -2  # labels of points that belong to no object; a ceiling is a wall
TABLE = "table"  # the function whose tops carry small objects
SIZE = (4.5, 4.0, 2.6)  # of a room: metres along x, y and z
TABLES = 2  # in a room
ON_FLOOR = 6  # besides tables: equally many of each other function and of none, as far as possible
ON_TOPS = 6  # likewise
GAP = 0.1  # metres between neighbours on the floor, and to the walls
TOP_GAP = 0.05  # metres between neighbours on a table top
SMALL = 0.4  # metres: objects that are no larger in any direction stand on tops
LOWEST = 0.04  # metres: lower objects (a spoon, a telephone) are left out
LARGEST = 2.5  # metres


@dataclass(frozen=True, eq=False)
class PlacedObject:
    """One object in a room."""

    item: DatasetObject
    cloud: Cloud  # in the object's frame, with its mesh
    T_room_object: np.ndarray  # (4, 4)
    support: int = FLOOR  # number of the object that it stands on

    @cached_property
    def points(self) -> np.ndarray:
        """The object's whole surface as points (N, 3), metres, in the room's frame."""
        return transformed(self.cloud.points, self.T_room_object)

    @property
    def mesh(self) -> Mesh:
        """The object's mesh in the room's frame."""
        return Mesh(transformed(self.cloud.mesh.vertices, self.T_room_object), self.cloud.mesh.faces)


@dataclass(frozen=True, eq=False)
class VirtualRoom:
    """A furnished room; an object's number is its place in ``objects``."""

    name: str
    size: np.ndarray  # (3,) width, depth and height, metres
    objects: tuple[PlacedObject, ...]

    def meshes(self) -> Iterator[tuple[int, Mesh]]:
        """Yield label and mesh of the room's shell and of every object."""
        yield from shell_meshes(self.size)
        for number, placed in enumerate(self.objects):
            yield number, placed.mesh


def transformed(points: np.ndarray, T: np.ndarray) -> np.ndarray:
    """Return points (N, 3) in the frame that a transform (4, 4) leads to."""
    return points @ T[:3, :3].T + T[:3, 3]


def shell_meshes(size: np.ndarray) -> Iterator[tuple[int, Mesh]]:
    """Yield label and mesh of the floor, the four walls and the ceiling."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * size
    for axis in range(3):
        for side in (0, 1):
            a, b, c, d = np.flatnonzero(corners[:, axis] == side * size[axis])
            label = FLOOR if axis == 2 and side == 0 else WALL
            yield label, Mesh(corners, np.array([[a, b, c], [b, d, c]]))


@dataclass
class ShuffledObjects:
    """Objects of one kind in random order, dealt one by one; after the last one they are shuffled again."""

    items: Sequence[DatasetObject]
    rng: np.random.Generator
    left: list[DatasetObject] = field(default_factory=list)

    def deal(self) -> DatasetObject:
        """Return the next object."""
        if not self.left:
            self.left = [self.items[i] for i in self.rng.permutation(len(self.items))]
        return self.left.pop()


@dataclass(frozen=True)
class FurnitureStock:
    """The objects that rooms are furnished with, by function or none."""

    large: dict[str, tuple[DatasetObject, ...]]
    small: dict[str, tuple[DatasetObject, ...]]


def take_stock(dataset: Dataset, failed: Callable[[InputError], None]) -> FurnitureStock:
    """Sort the objects of a data set that suit a room by function and size.

    Parameters
    ----------
    failed : callable
        Called with the error of each file that cannot be used; such files are left out.

    Raises
    ------
    InputError
        If no object is left.
    """
    kinds: dict[bool, dict[str, tuple[DatasetObject, ...]]] = {True: {}, False: {}}
    for item in dataset.objects:
        try:
            geometry = read_geometry(item.path)
            if not len(geometry.faces):
                raise InputError(f"{item.path.name}: expected a mesh, got points, which hide nothing from a camera")
        except InputError as error:
            failed(error)
            continue
        size = np.ptp(geometry.vertices[np.unique(geometry.faces)], axis=0)
        if size[2] >= LOWEST and size.max() <= LARGEST:
            kind, name = kinds[bool(size.max() <= SMALL)], min(item.functions, default="none")
            kind[name] = (*kind.get(name, ()), item)
    if not any(kinds.values()):
        wanted = f"at least {LOWEST} m high and at most {LARGEST} m long"
        raise InputError(f"{dataset.name}: expected objects {wanted}, found none")
    return FurnitureStock(kinds[False], kinds[True])


def furnish(
    dataset: Dataset,
    count: int,
    *,
    seed: int = 0,
    failed: Callable[[InputError], None],
    stock: FurnitureStock | None = None,
) -> Iterator[VirtualRoom]:
    """Yield rooms furnished at random; every object is used once before any is used again.

    Parameters
    ----------
    dataset : Dataset
        Meshes in metres, z up.
    failed : callable
        Called with the error of each file that cannot be used.
    stock : FurnitureStock, optional
        Of the data set, if it is known already.

    Raises
    ------
    InputError
        If no object of the data set can stand in a room.
    """
    stock = take_stock(dataset, failed) if stock is None else stock
    rng = np.random.default_rng(seed)
    decks = {name: ShuffledObjects(items, rng) for name, items in sorted(stock.large.items())}
    tables = [decks.pop(TABLE)] if TABLE in decks else []
    small = [ShuffledObjects(stock.small[name], rng) for name in sorted(stock.small)]
    for number in range(1, count + 1):
        on_floor = deal_objects(tables, TABLES) + deal_objects(list(decks.values()), ON_FLOOR)
        yield arrange(f"room_{number:02d}", on_floor, deal_objects(small, ON_TOPS), rng)


def deal_objects(decks: Sequence[ShuffledObjects], count: int) -> list[DatasetObject]:
    """Return this many objects, from each deck in turn; none if there are no decks."""
    return [decks[i % len(decks)].deal() for i in range(count if decks else 0)]


def arrange(
    name: str, on_floor: list[DatasetObject], on_tops: list[DatasetObject], rng: np.random.Generator
) -> VirtualRoom:
    """Return a room with objects at random places and headings; objects without a free place are left out."""
    clouds = {item.path: load_cloud(item.path) for item in [*on_floor, *on_tops]}
    floor = floor_of(*SIZE[:2])
    placed: list[PlacedObject] = []
    tops: dict[int, Ground] = {}
    # The largest first: small ones find a place between large ones, but not the other way round.
    for item in sorted(on_floor, key=lambda item: -np.prod(clouds[item.path].size[:2])):
        if place_object(item, clouds[item.path], {FLOOR: floor}, GAP, rng, placed) and TABLE in item.functions:
            tops[len(placed) - 1] = top_of(placed[-1].points)
    for item in on_tops:
        if not place_object(item, clouds[item.path], tops, TOP_GAP, rng, placed):
            place_object(item, clouds[item.path], {FLOOR: floor}, GAP, rng, placed)
    return VirtualRoom(name, np.array(SIZE), tuple(placed))


def place_object(
    item: DatasetObject,
    cloud: Cloud,
    grounds: dict[int, Ground],
    gap: float,
    rng: np.random.Generator,
    placed: list[PlacedObject],
) -> bool:
    """Place an object on the first ground, in random order, that has room for it; return whether one had."""
    T_room_object = heading_transform(rng.uniform(0, 2 * np.pi))
    points = transformed(cloud.points, T_room_object)
    for support in rng.permutation(list(grounds)):
        place = grounds[support].place(points, gap, rng)
        if place is not None:
            T_room_object[:3, 3] = place
            placed.append(PlacedObject(item, cloud, T_room_object, int(support)))
            return True
    return False


def heading_transform(angle: float) -> np.ndarray:
    """Return the transform (4, 4) that turns by an angle in radians about z."""
    T = np.eye(4)
    T[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return T
