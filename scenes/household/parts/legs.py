"""Bases of tables and seats (legs, frames, pedestals and stars), and families of catalogue objects."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import trimesh

from .outlines import circle, rectangle, rounded
from .solids import beam, box, crossbar, lathe, rod, shift, stand, sweep, tube

CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def four_legs(
    width: float, depth: float, height: float, thickness: float,
    *, splay: float = 0.0, taper: float = 1.0, round_bars: bool = False,
):
    """Return four legs whose outer faces bound ``width`` x ``depth`` at the top.

    ``splay`` is the offset of each foot in x and y (m); ``taper`` the ratio of a foot's thickness to its top's.
    """
    section = circle(thickness / 2, 12) if round_bars else rectangle(thickness, thickness)
    legs = []
    for x, y in CORNERS:
        top = np.array([x * (width - thickness) / 2, y * (depth - thickness) / 2, height])
        legs.append(sweep([top, top + [x * splay, y * splay, -height]], section, scale=[1.0, taper]))
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
        parts += [box(thickness, depth, 0.06, x=x), box(thickness, 1.6 * thickness, height - 0.12, x=x, z=0.06)]
        parts.append(box(thickness, 0.85 * depth, 0.06, x=x, z=height - 0.06))
    return [*parts, crossbar(width, 0, 0.45 * height, 0.03, 0.09)]


def crossed_legs(width: float, depth: float, height: float, thickness: float):
    """Return an X of two bars at each end, joined by a rail where they cross."""
    ends = [(x, y * depth / 2) for x in (-width / 2, width / 2) for y in (-1, 1)]
    bars = [beam([x, y, height], [x, -y, 0.01], thickness, thickness) for x, y in ends]
    return [*bars, crossbar(width, 0, height / 2, thickness, thickness)]


def panel_ends(width: float, depth: float, height: float, thickness: float):
    """Return two boards that stand on the floor at the ends."""
    return [box(thickness, depth, height, x=x * (width - thickness) / 2) for x in (-1, 1)]


@dataclass(frozen=True)
class CatalogueObject:
    """One object of a catalogue: its mesh in metres, z up, its front to -y, and its functions."""

    name: str
    label: str  # cup, table, sittable or none
    also: str  # functions that are true as well, separated by ';'
    category: str
    mesh: trimesh.Trimesh
    watertight: bool = True  # False: open like the real object, or a single-sided shell like many models


@dataclass(frozen=True)
class Family:
    """Objects of one category, drawn from one parametric builder."""

    category: str
    build: Callable[[np.random.Generator], trimesh.Trimesh]
    count: int
    also: str
    watertight: bool


def family(
    category: str, build: Callable[..., trimesh.Trimesh], count: int = 1,
    *, also: str = "", watertight: bool = True, **options: object,
) -> Family:
    """Return a family whose builder gets these options."""
    return Family(category, partial(build, **options), count, also, watertight)


def families(*builders: Callable[[np.random.Generator], trimesh.Trimesh]) -> list[Family]:
    """Return a family of one object for each builder, whose name is the category."""
    return [family(build.__name__, build) for build in builders]


def draw_objects(families: Iterable[Family], label: str, seed: int) -> Iterator[CatalogueObject]:
    """Yield every object of the families, each from a random stream of its own.

    The stream depends on the seed, the category and the number within it, so that adding a family changes no other
    objects.
    """
    numbers = Counter[str]()
    for family in families:
        for _ in range(family.count):
            numbers[family.category] += 1
            number, key = numbers[family.category], zlib.crc32(family.category.encode())
            mesh = stand(family.build(np.random.default_rng([seed, key, number])))
            name = f"{family.category}_{number:02d}"
            yield CatalogueObject(name, label, family.also, family.category, mesh, family.watertight)


def stretched(objects: Iterable[CatalogueObject], share: float, seed: int) -> list[CatalogueObject]:
    """Return objects, each stretched along x, y and z by factors that depend only on its name and the seed.

    Parameters
    ----------
    objects : iterable of CatalogueObject
        With meshes that stand on z = 0.
    share : float
        Largest change, up or down: with 0.15 factors are from 1 / 1.15 to 1.15.
    seed : int
    """
    out = []
    for item in objects:
        rng, mesh = np.random.default_rng([seed, zlib.crc32(item.name.encode()), 5]), item.mesh.copy()
        out.append(replace(item, mesh=mesh.apply_scale((1 + share) ** rng.uniform(-1, 1, 3))))
    return out
