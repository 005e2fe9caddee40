"""What people put on furniture: books, boxes, bottles, plates and the wares of the catalogue, as triangles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...household.parts.family import Family
from ...household.wares.belongings import BELONGINGS
from ...household.wares.bowls import BOWLS
from ...household.wares.containers import CONTAINERS
from ...household.wares.cups import CUPS
from ...household.wares.devices import DEVICES
from ...household.wares.dishes import DISHES
from ...household.wares.lamps import LAMPS
from ...household.wares.plants import PLANTS
from ..bodies import box, circle, loft

LARGEST = 0.55  # metres, of what is put down
WARES: tuple[Family, ...] = (
    *BELONGINGS,
    *BOWLS,
    *CONTAINERS,
    *CUPS,
    *DEVICES,
    *DISHES,
    *LAMPS,
    *PLANTS,
)
BAGS = tuple(family for family in BELONGINGS if family.category in ("handbag", "backpack", "teddy_bear", "ball"))
Maker = Callable[[np.random.Generator], np.ndarray]


def cuboid(rng: np.random.Generator) -> np.ndarray:
    """Return a box of 4 to 40 cm."""
    size = np.exp(rng.uniform(np.log([0.04, 0.04, 0.02]), np.log([0.4, 0.3, 0.35])))
    return upright_box(size)


def book(rng: np.random.Generator) -> np.ndarray:
    """Return a lying book, a closed laptop or a small pile of them."""
    return upright_box(rng.uniform([0.11, 0.16, 0.008], [0.26, 0.38, 0.06]))


def cylinder(rng: np.random.Generator) -> np.ndarray:
    """Return a bottle, a tin or a plate, closed at the top."""
    radius = np.exp(rng.uniform(np.log(0.025), np.log(0.14)))
    height = rng.uniform(0.015, 0.04) if radius > 0.08 else rng.uniform(0.05, 0.32)
    neck = rng.uniform(0.3, 1.0)
    rings = [
        circle(np.zeros(2), radius * share, height * up) for share, up in ((1, 0), (1, 0.7), (neck, 0.85), (neck, 1))
    ]
    return loft(rings)


def ware(rng: np.random.Generator) -> np.ndarray:
    """Return one of the catalogue's wares that is small enough."""
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


MAKERS: tuple[Maker, ...] = (book, cuboid, cylinder, ware, ware)


def small_object(rng: np.random.Generator) -> np.ndarray:
    """Return anything that people put on a table, on z = 0 about the origin, (T, 3, 3) metres."""
    return MAKERS[rng.integers(len(MAKERS))](rng)
