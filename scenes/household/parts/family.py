"""Catalogues: named, labelled objects, the families they are drawn from, and how they are written."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import trimesh

from .solids import stand


@dataclass(frozen=True)
class CatalogueObject:
    """One object of a catalogue: its mesh in metres, z up, its front to -y, and what it is for."""

    name: str
    label: str  # cup, table, sittable or none
    also: str  # functions that are true as well, separated by ';'
    category: str
    mesh: trimesh.Trimesh
    watertight: bool = True  # False: as open as the real object, or a single-sided shell as many models are


@dataclass(frozen=True)
class Family:
    """Objects of one category, drawn from one parametric builder."""

    category: str
    build: Callable[[np.random.Generator], trimesh.Trimesh]
    count: int
    also: str
    watertight: bool


def family(
    category: str,
    build: Callable[..., trimesh.Trimesh],
    count: int = 1,
    *,
    also: str = "",
    watertight: bool = True,
    **options: object,
) -> Family:
    """Return a family whose builder is given these options."""
    return Family(category, partial(build, **options), count, also, watertight)


def families(*builders: Callable[[np.random.Generator], trimesh.Trimesh]) -> list[Family]:
    """Return a family of one object of each builder, whose name is the category."""
    return [family(build.__name__, build) for build in builders]


def draw_objects(families: Iterable[Family], label: str, seed: int) -> Iterator[CatalogueObject]:
    """Yield every object of the families, each from a random stream of its own.

    The stream depends on the seed, the category and the number within it, so that a family added later leaves
    the objects of all others as they are.
    """
    numbers: dict[str, int] = {}
    for family in families:
        for _ in range(family.count):
            number = numbers[family.category] = numbers.get(family.category, 0) + 1
            rng = np.random.default_rng([seed, zlib.crc32(family.category.encode()), number])
            mesh = stand(family.build(rng))
            name = f"{family.category}_{number:02d}"
            yield CatalogueObject(name, label, family.also, family.category, mesh, family.watertight)


def stretched(objects: Iterable[CatalogueObject], share: float, seed: int) -> list[CatalogueObject]:
    """Return objects, each stretched along x, y and z by factors of its own.

    Parameters
    ----------
    objects : iterable of CatalogueObject
        With meshes that stand on z = 0.
    share : float
        By how much at most, up or down: 0.15 is from a factor of 1 / 1.15 to one of 1.15.
    seed : int
    """
    return [replace(item, mesh=stretched_mesh(item, share, seed)) for item in objects]


def stretched_mesh(item: CatalogueObject, share: float, seed: int):
    """Return an object's mesh, stretched; what becomes of it depends on its name and the seed alone."""
    rng = np.random.default_rng([seed, zlib.crc32(item.name.encode()), 5])
    mesh = item.mesh.copy()
    mesh.apply_scale((1 + share) ** rng.uniform(-1, 1, 3))
    return mesh
