"""Objects put down on a level: where they have room, next to each other."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from ...household.parts.legs import Family
from ...household.wares.belongings import BELONGINGS
from ...household.wares.containers import BOWLS, CONTAINERS, DISHES
from ...household.wares.cups import CUPS
from ...household.wares.devices import DEVICES
from ...household.wares.lamps import LAMPS, PLANTS
from ..levels import LevelPart
from ..specimen import box, circle, loft, turn
from ..surfaces import ObjectSurface

TRIES = 30  # places and headings that are tried for each
BESIDE = 0.01  # metres between neighbours' circles


@dataclass(eq=False)
class LoadedLevel:
    """A level with the objects that are put down on it."""

    surface: ObjectSurface
    level: LevelPart
    parts: list[np.ndarray] = field(default_factory=list)  # triangles (T, 3, 3)
    circles: list[tuple[np.ndarray, float]] = field(default_factory=list)  # middle (2,), radius, metres

    def put(self, triangles: np.ndarray, rng: np.random.Generator, near: np.ndarray | None = None) -> bool:
        """Put an object down at a random place, or near a given one; return whether there was room."""
        places = self.level.grid.places(self.level.flat)
        for _ in range(TRIES):
            middle = places[rng.integers(len(places))] if near is None else near + rng.normal(0, 0.04, 2)
            turned = triangles @ turn(np.array([0.0, 0, 1]), rng.uniform(0, 2 * np.pi)).T
            corners = turned.reshape(-1, 3)[:, :2] + middle
            reach = 0.9 * float(np.linalg.norm(corners - middle, axis=1).max())
            if self._has_room(corners, middle, reach):
                self.parts.append(turned + [*middle, self._height(corners)])
                self.circles.append((middle, reach))
                return True
        return False

    def _has_room(self, corners: np.ndarray, middle: np.ndarray, reach: float) -> bool:
        """Return whether an object with these corners (N, 2) lies on the level and apart from all others."""
        level = self.level
        low, high = level.box - [[0.03], [-0.03]]
        within = ((corners > low) & (corners < high)).all()
        on_level = level.cells[level.grid.cells_of(corners)].mean() > 0.9
        apart = all(np.linalg.norm(middle - other) > reach + radius + BESIDE for other, radius in self.circles)
        return bool(within and on_level and apart)

    def _height(self, corners: np.ndarray) -> float:
        """Return the height of the level under these places, metres."""
        x, y = self.level.grid.cells_of(corners)
        inside = np.zeros(self.level.flat.shape, bool)
        inside[x.min() : x.max() + 1, y.min() : y.max() + 1] = True
        tops = self.level.grid.tops(self.surface.centres)[inside & self.level.flat]
        return float(tops.max()) if len(tops) else self.level.height

    def joined(self) -> ObjectSurface | None:
        """Return the surface with everything that was put down; None if nothing was."""
        return self.surface.joined(ObjectSurface(np.concatenate(self.parts))) if self.parts else None


def with_objects(
    surface: ObjectSurface, level: LevelPart, objects: Iterable[np.ndarray], rng: np.random.Generator
) -> ObjectSurface | None:
    """Return a surface with objects, triangles (T, 3, 3) about the origin, put down on a level; None without room."""
    placed = LoadedLevel(surface, level)
    for triangles in objects:
        placed.put(triangles, rng)
    return placed.joined()


LARGEST = 0.55  # metres, of objects that are put down
WARES: tuple[Family, ...] = (*BELONGINGS, *BOWLS, *CONTAINERS, *CUPS, *DEVICES, *DISHES, *LAMPS, *PLANTS)
BAGS = tuple(family for family in BELONGINGS if family.category in ("handbag", "backpack", "teddy_bear", "ball"))


def cuboid(rng: np.random.Generator) -> np.ndarray:
    """Return a box of 4 to 40 cm."""
    return upright_box(np.exp(rng.uniform(np.log([0.04, 0.04, 0.02]), np.log([0.4, 0.3, 0.35]))))


def book(rng: np.random.Generator) -> np.ndarray:
    """Return a lying book, a closed laptop or a small pile of them."""
    return upright_box(rng.uniform([0.11, 0.16, 0.008], [0.26, 0.38, 0.06]))


def cylinder(rng: np.random.Generator) -> np.ndarray:
    """Return a bottle, a tin or a plate, closed at the top."""
    radius = np.exp(rng.uniform(np.log(0.025), np.log(0.14)))
    height = rng.uniform(0.015, 0.04) if radius > 0.08 else rng.uniform(0.05, 0.32)
    neck = rng.uniform(0.3, 1.0)
    steps = (1, 0), (1, 0.7), (neck, 0.85), (neck, 1)
    return loft([circle(np.zeros(2), radius * share, height * up) for share, up in steps])


def ware(rng: np.random.Generator) -> np.ndarray:
    """Return one of the household catalogue's wares that is small enough."""
    while True:
        triangles = made(WARES[rng.integers(len(WARES))], rng)
        if np.ptp(triangles.reshape(-1, 3), axis=0).max() < LARGEST:
            return triangles


def bag(rng: np.random.Generator) -> np.ndarray:
    """Return a bag or a soft toy."""
    return made(BAGS[rng.integers(len(BAGS))], rng)


def made(family: Family, rng: np.random.Generator) -> np.ndarray:
    """Return an object of a family, standing on z = 0 about the origin, (T, 3, 3) metres."""
    mesh = family.build(rng)
    low, high = mesh.bounds
    return np.asarray(mesh.triangles) - [*(low + high)[:2] / 2, low[2]]


def upright_box(size: np.ndarray) -> np.ndarray:
    """Return a box of a size (3,) on z = 0 about the origin."""
    return box(np.array([-size[0] / 2, -size[1] / 2, 0]), np.array([size[0] / 2, size[1] / 2, size[2]]))


def small_object(rng: np.random.Generator) -> np.ndarray:
    """Return an object such as people put on a table, on z = 0 about the origin, (T, 3, 3) metres."""
    makers = (book, cuboid, cylinder, ware, ware)
    return makers[rng.integers(len(makers))](rng)
