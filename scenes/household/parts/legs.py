"""What tables and seats stand on: legs, frames, pedestals and stars."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import trimesh

from .outlines import circle, rectangle, rounded
from .solids import beam, box, crossbar, lathe, rod, shift, stand, sweep, tube

CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def four_legs(
    width: float,
    depth: float,
    height: float,
    thickness: float,
    *,
    splay: float = 0.0,
    taper: float = 1.0,
    round_bars: bool = False,
):
    """Return four legs whose outer faces bound ``width`` x ``depth`` at the top.

    ``splay`` is how far each foot stands out in x and y (m); ``taper`` the foot's thickness over its top's.
    """
    section = circle(thickness / 2, 12) if round_bars else rectangle(thickness, thickness)
    legs = []
    for x, y in CORNERS:
        top = np.array([x * (width - thickness) / 2, y * (depth - thickness) / 2, height])
        foot = top + [x * splay, y * splay, -height]
        legs.append(sweep([top, foot], section, scale=[1.0, taper]))
    return legs


def stretchers(width: float, depth: float, z: float, thickness: float):
    """Return bars in an H between four legs: one along each side and one across."""
    sides = [beam([x * width / 2, -depth / 2, z], [x * width / 2, depth / 2, z], thickness, thickness) for x in (-1, 1)]
    return [*sides, crossbar(width, 0, z, thickness, thickness)]


def apron(width: float, depth: float, height: float, thickness: float, z: float):
    """Return the four boards below a top, their upper edges at z."""
    low = z - height
    front = [box(width, thickness, height, y=y * (depth - thickness) / 2, z=low) for y in (-1, 1)]
    return front + [box(thickness, depth, height, x=x * (width - thickness) / 2, z=low) for x in (-1, 1)]


def pedestal(height: float, foot_radius: float, column_radius: float):
    """Return a turned column on a round foot."""
    rim = 0.012
    profile = [
        (0, 0), (foot_radius, 0), (foot_radius, rim), (0.6 * foot_radius, 2.2 * rim),
        (column_radius, 0.12 * height + rim), (column_radius, 0.9 * height), (1.8 * column_radius, height),
        (0, height),
    ]
    return [lathe(profile, sections=28)]


def cross_foot(height: float, reach: float, column_radius: float):
    """Return a column on a foot of four flat arms."""
    angles = np.arange(4) * 2 * np.pi / 4 + np.pi / 4
    tips = [np.array([reach * np.cos(a), reach * np.sin(a), 0.015]) for a in angles]
    feet = [beam([0, 0, 0.05], tip, 0.06, 0.03, taper=0.8) for tip in tips]
    return [*feet, lathe([(0, 0.03), (column_radius, 0.03), (column_radius, height), (0, height)], sections=16)]


def star_base(reach: float, height: float):
    """Return an office chair's base: five arms on castors and a gas spring up to ``height``."""
    parts = [lathe([(0, 0.07), (0.03, 0.07), (0.03, 0.22), (0.018, 0.22), (0.018, height), (0, height)], sections=14)]
    castor = lathe([(0, -0.02), (0.022, -0.02), (0.028, 0), (0.022, 0.02), (0, 0.02)], sections=12)
    castor.vertices = castor.vertices[:, [2, 0, 1]]
    for angle in np.arange(5) * 2 * np.pi / 5 - np.pi / 2:
        x, y = np.cos(angle), np.sin(angle)
        parts.append(beam([0, 0, 0.1], [reach * x, reach * y, 0.065], 0.05, 0.035, taper=0.7))
        parts.append(shift(castor, reach * x, reach * y, 0.028))
        parts.append(rod([reach * x, reach * y, 0.03], [reach * x, reach * y, 0.075], 0.008))
    return parts


def sled(width: float, depth: float, height: float, radius: float):
    """Return two upright loops of bent tube, one on each side."""
    y, bend = depth / 2, 0.08  # how far from each lower corner the tube starts to bend
    half = [[0, -y, height], [0, -y, bend], [0, -y, radius], [0, bend - y, radius]]
    loop = rounded([*half, *[[0, -back, z] for _, back, z in half[::-1]]], rounds=2)
    return [tube(loop + [x * (width / 2 - radius), 0, 0], radius, sections=8) for x in (-1, 1)]


def trestles(width: float, depth: float, height: float, thickness: float):
    """Return two T-shaped ends on feet, joined by a rail."""
    parts = []
    for x in (-width / 2, width / 2):
        parts.append(box(thickness, depth, 0.06, x=x))
        parts.append(box(thickness, 1.6 * thickness, height - 0.12, x=x, z=0.06))
        parts.append(box(thickness, 0.85 * depth, 0.06, x=x, z=height - 0.06))
    return [*parts, crossbar(width, 0, 0.45 * height, 0.03, 0.09)]


def crossed_legs(width: float, depth: float, height: float, thickness: float):
    """Return an X of two bars at each end, joined by a rail where they cross."""
    parts = []
    for x in (-width / 2, width / 2):
        for y in (-1, 1):
            parts.append(beam([x, y * depth / 2, height], [x, -y * depth / 2, 0.01], thickness, thickness))
    return [*parts, crossbar(width, 0, height / 2, thickness, thickness)]


def panel_ends(width: float, depth: float, height: float, thickness: float):
    """Return two boards that stand on the floor at the ends."""
    return [box(thickness, depth, height, x=x * (width - thickness) / 2) for x in (-1, 1)]


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
