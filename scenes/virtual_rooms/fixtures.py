"""Fixtures of a lived-in room: beds, shelves and window sills at its walls, cartons with gaps, and piles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.datasets.dataset import DatasetObject

from .furnishing import FLOOR, GAP, WALL, heading_transform, transformed
from .grounds import Ground, boards_of, floor_of, top_of
from .occupancy import RoomContents
from .surroundings import BED, CARTON, PILE, SHELF, SILL

STRIP = 1.6  # metres by which a room is longer if beds, shelves, cartons or piles stand in it
ON_FLOOR = frozenset({"beds", "shelves", "gaps", "piles"})
WALLS = ((1, 0), (-1, 0), (0, 1), (0, -1))  # outward, along x and y
SILL_HEIGHTS = (0.65, 0.85)  # metres of its lower edge; the board is 15 cm higher
CLOSE = 0.001  # metres off the wall
TRIES = 8  # places for a sill
ON_BOARD, ON_SILL = 3, 3  # objects, at most
HEADROOM = 0.02  # metres above an object on a board
CARTONS = (3, 6)  # in a row, from and to below
CARTON_GAPS = (0.03, 0.22)  # metres

Dealt = tuple[DatasetObject, Cloud]


def fixtures_added(contents: RoomContents, kinds: frozenset[str]):
    """Add the fixtures of some kinds; those without a free place are left out."""
    if kinds & ON_FLOOR:
        contents.size[0] += STRIP
    floor = floor_of(*contents.size[:2])
    for placed in contents.objects:
        if placed.support == FLOOR:
            floor.take(placed.points)
    if "beds" in kinds:
        stand_at_wall(contents, floor, BED)
    if "shelves" in kinds:
        for _ in range(int(contents.rng.integers(1, 3))):
            fill_shelf(contents, stand_at_wall(contents, floor, SHELF))
    if "gaps" in kinds:
        row_of_cartons(contents, floor)
    if "piles" in kinds:
        for _ in range(int(contents.rng.integers(1, 3))):
            stand_anywhere(contents, floor, [contents.deal([contents.surroundings[PILE]])], np.zeros((1, 2)))
    if "sills" in kinds:
        window_sills(contents)


def facing_away(outward: Sequence[int]) -> np.ndarray:
    """Return the transform (4, 4) that turns an object's back, +y, towards a wall."""
    return heading_transform(float(np.arctan2(-outward[0], outward[1])))


def stand_at_wall(contents: RoomContents, floor: Ground, category: str) -> int | None:
    """Stand an object against a wall that has room for it; return its number, None without such a wall."""
    item, cloud = contents.deal([contents.surroundings[category]])
    for wall in contents.rng.permutation(len(WALLS)):
        T_room_object = facing_away(WALLS[wall])
        points = transformed(cloud.points, T_room_object)
        place = floor.place_at_wall(points, np.array(WALLS[wall]), GAP, contents.rng)
        if place is not None:
            T_room_object[:3, 3] = place
            return contents.add(item, cloud, T_room_object, FLOOR)
    return None


def stand_anywhere(contents: RoomContents, floor: Ground, dealt: Sequence[Dealt], offsets: np.ndarray):
    """Stand a group of objects on the floor at a random heading, each at an offset (K, 2) in metres."""
    turned = heading_transform(float(contents.rng.uniform(0, 2 * np.pi)))
    shifts = np.column_stack([offsets, np.zeros(len(offsets))]) @ turned[:3, :3].T
    clouds = [transformed(cloud.points, turned) + shift for (_, cloud), shift in zip(dealt, shifts, strict=True)]
    place = floor.place(np.vstack(clouds), GAP, contents.rng)
    if place is None:
        return
    for (item, cloud), shift in zip(dealt, shifts, strict=True):
        T_room_object = turned.copy()
        T_room_object[:3, 3] = place + shift
        contents.add(item, cloud, T_room_object, FLOOR)


def row_of_cartons(contents: RoomContents, floor: Ground):
    """Stand cartons in a row, with gaps into which spheres fall."""
    dealt = [contents.deal([contents.surroundings[CARTON]]) for _ in range(int(contents.rng.integers(*CARTONS)))]
    gaps = contents.rng.uniform(*CARTON_GAPS, len(dealt))
    widths = np.array([cloud.size[0] for _, cloud in dealt])
    along = np.cumsum(widths + gaps) - widths / 2
    across = contents.rng.uniform(-0.04, 0.04, len(dealt))
    stand_anywhere(contents, floor, dealt, np.column_stack([along - along.mean(), across]))


def fill_shelf(contents: RoomContents, shelf: int | None):
    """Put small objects on the boards of a shelf, where they fit below the next board."""
    if shelf is None:
        return
    occupancy, boards = contents.occupancy(), boards_of(contents.objects[shelf].points)
    above = [board.height for board in boards[1:]] + [contents.size[2]]
    for board, ceiling in zip(boards, above, strict=True):
        for _ in range(int(contents.rng.integers(0, ON_BOARD + 1))):
            dealt = contents.deal(contents.small)
            if dealt is not None and dealt[1].size[2] <= ceiling - board.height - HEADROOM:
                contents.put_on(dealt, board, occupancy, shelf)


def window_sills(contents: RoomContents):
    """Hang one sill on a wall, where it is free, with small objects on it."""
    occupancy = contents.occupancy()
    item, cloud = contents.deal([contents.surroundings[SILL]])
    for _ in range(TRIES):
        T_room_object = hung(contents, cloud)
        if occupancy.is_free(transformed(cloud.points, T_room_object)):
            sill = contents.add(item, cloud, T_room_object, WALL)
            break
    else:
        return
    board = top_of(contents.objects[sill].points)
    for _ in range(int(contents.rng.integers(1, ON_SILL + 1))):
        dealt = contents.deal(contents.small)
        if dealt is None:
            return
        T_room_object = contents.place_on(dealt[1], board, occupancy)
        if T_room_object is not None:
            contents.add(*dealt, T_room_object, sill)


def hung(contents: RoomContents, cloud: Cloud) -> np.ndarray:
    """Return a random pose (4, 4) of a sill on a wall."""
    outward = np.array(WALLS[int(contents.rng.integers(len(WALLS)))])
    T_room_object = facing_away(outward)
    half = np.ptp(transformed(cloud.points, T_room_object), axis=0)[:2] / 2
    low, high = half + CLOSE, contents.size[:2] - half - CLOSE
    place = np.where(outward > 0, high, np.where(outward < 0, low, contents.rng.uniform(low, high)))
    T_room_object[:3, 3] = np.append(place, contents.rng.uniform(*SILL_HEIGHTS))
    return T_room_object
