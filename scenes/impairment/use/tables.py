"""Tables in use. Each takes a specimen and a generator, and returns a surface, or None."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...household.furniture.chairs import CHAIRS
from ..bodies import box
from ..poses import turn
from ..specimen import Specimen
from ..surfaces import Surface
from .placing import Placed, with_objects
from .small_objects import made, small_object, upright_box

FREE = 0.1  # metres, a hand's breadth: less than that is left free of a table that is full
GAPS = (0.0, 0.05)  # metres between what stands on a full one
SIDES = (0.09, 0.28)  # metres of what stands there
HIGH = (0.04, 0.4)
CHAIRS_HIGH = 0.55  # metres, a top under which chairs go


def laid(least: int, most: int) -> Callable[[Specimen, np.random.Generator], Surface | None]:
    """Return the change that puts so many objects on the top."""

    def change(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
        """Return the table with what has room on it."""
        if specimen.level is None or specimen.surface.is_cloud:
            return None
        objects = [small_object(rng) for _ in range(rng.integers(least, most + 1))]
        return with_objects(specimen.surface, specimen.level, objects, rng)

    return change


def full(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Cover the top with boxes of all heights, so that no hand's breadth of it is free."""
    top = specimen.level
    if top is None or specimen.surface.is_cloud:
        return None
    (x, y), high = top.box
    boxes = []
    while y < high[1]:
        deep, left = min(rng.uniform(*SIDES), max(high[1] - y, 0.03)), x
        while left < high[0]:
            wide = min(rng.uniform(*SIDES), max(high[0] - left, 0.03))
            gap = rng.uniform(*GAPS)
            low = np.array([left, y, top.height - 0.005])
            body = box(low, low + [max(wide - gap, 0.02), max(deep - gap, 0.02), rng.uniform(*HIGH)])
            if top.cells[top.grid.cells_of(body.reshape(-1, 3))].mean() > 0.7:
                boxes.append(body)
            left += wide
        y += deep
    return specimen.surface.joined(Surface(np.concatenate(boxes))) if boxes else None


def chairs_under(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Push one to four chairs under the table, as far as they go."""
    top, surface = specimen.level, specimen.surface
    if top is None or surface.is_cloud or top.height < CHAIRS_HIGH:
        return None
    parts, sides = [], rng.permutation(4)[: rng.integers(1, 5)]
    for side in sides:
        chair = made(CHAIRS[rng.integers(len(CHAIRS))], rng)
        reach, away = np.ptp(chair.reshape(-1, 3), axis=0)[:2].max() / 2, turn(np.array([0, 0, 1.0]), side * np.pi / 2)
        out = away @ [0, -1.0, 0]
        half = (top.box[1] - top.box[0]) / 2 @ np.abs(out[:2])
        middle = np.array([*top.box.mean(axis=0), 0]) + out * (half + reach * rng.uniform(-0.2, 0.8))
        parts.append(chair @ (away @ turn(np.array([0, 0, 1.0]), np.pi)).T + middle)
    return surface.joined(Surface(np.concatenate(parts)))


def at_wall(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Stand the table against a piece of wall, with something on it or not."""
    if specimen.level is None or specimen.surface.is_cloud:
        return None
    low, high = specimen.surface.bounds
    axis, side = int((high - low)[:2].argmin()), rng.choice([0, 1])
    start, end = low - [0.05, 0.05, 0], np.array([*(high[:2] + 0.05), high[2] + rng.uniform(0.2, 1.2)])
    start[axis], end[axis] = (high[axis], high[axis] + 0.05) if side else (low[axis] - 0.05, low[axis])
    placed = Placed(specimen.surface, specimen.level, parts=[box(start, end)])
    for _ in range(rng.integers(0, 3)):
        placed.put(small_object(rng), rng)
    return placed.joined()


def cloth(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Lay a cloth or a mat over a part of the top."""
    if specimen.level is None or specimen.surface.is_cloud:
        return None
    size = (specimen.level.box[1] - specimen.level.box[0]) * rng.uniform(0.3, 0.8, 2)
    return with_objects(specimen.surface, specimen.level, [upright_box(np.array([*size, 0.004]))], rng)
