"""Cups in use. Each takes a specimen and a generator, and returns a surface, or None."""

from __future__ import annotations

import numpy as np

from ...household.parts import solids
from ..bodies import circle, loft
from ..poses import level_direction
from ..specimen import Specimen
from ..surfaces import Surface

SPOON = (0.12, 0.19)  # metres long
FULL = (0.2, 0.55)  # of the way from the cavity's floor to its brim, where liquid stands
SAUCER = (1.5, 2.2)  # times the cup's foot, the radius
FINGER = 0.008  # metres, the radius


def with_spoon(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Leave a spoon or a straw in the cup, leaning on the rim."""
    cup, surface = specimen.cavity, specimen.surface
    if cup is None or surface.is_cloud:
        return None
    out, length = np.array([*level_direction(rng.uniform(0, 2 * np.pi)), 0.0]), rng.uniform(*SPOON)
    depth, wide = cup.brim - cup.floor, float(np.median(cup.radii))
    lean = np.arctan2(1.5 * wide, depth)
    foot = np.array([*cup.axis, cup.floor + 0.004]) - out * 0.6 * wide
    tip = foot + max(length, 1.15 * depth / np.cos(lean)) * (np.sin(lean) * out + [0, 0, np.cos(lean)])
    parts = [solids.tube([foot, tip], rng.uniform(0.0015, 0.004), sections=6)]
    if rng.uniform() < 0.7:
        bowl = min(0.018, 0.5 * wide)
        parts.append(solids.ellipsoid(1.3 * bowl, 1.3 * bowl, 0.008, *(foot + [0, 0, 0.003])))
    return surface.joined(Surface(np.concatenate([part.triangles for part in parts])))


def with_liquid(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Fill the cup a quarter to half, with something level and solid."""
    cup, surface = specimen.cavity, specimen.surface
    if cup is None or surface.is_cloud:
        return None
    level = cup.floor + rng.uniform(*FULL) * (cup.brim - cup.floor)
    heights = np.linspace(cup.floor - 0.002, level, 6)
    rings = [circle(cup.axis, np.interp(height, cup.heights, cup.radii), height) for height in heights]
    return surface.joined(Surface(loft(rings)))


def on_saucer(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Stand the cup on a saucer or a coaster."""
    cup, surface = specimen.cavity, specimen.surface
    if cup is None or surface.is_cloud:
        return None
    foot = surface.centres[surface.centres[:, 2] < surface.bounds[0, 2] + 0.1 * surface.size[2]]
    radius = max(float(cup.distances(foot).max()), float(np.median(cup.radii))) * rng.uniform(*SAUCER)
    rise = rng.uniform(0.0, 0.016)
    profile = [(0, 0), (0.4 * radius, 0), (radius, rise), (radius, rise + 0.003), (0.45 * radius, 0.006), (0, 0.006)]
    saucer = solids.lathe(profile, sections=32)
    lift = [*cup.axis, surface.bounds[0, 2] - 0.0058]
    return surface.joined(Surface(np.asarray(saucer.triangles) + lift))


def held(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Close a hand's fingers about the wall: four on one side, a thumb on the other."""
    cup, surface = specimen.cavity, specimen.surface
    if cup is None or surface.is_cloud:
        return None
    start, count = rng.uniform(0, 2 * np.pi), 4
    low, high = 0.25 * surface.size[2], 0.75 * surface.size[2]
    heights = np.append(np.linspace(low, max(high, low + 0.01), count), (low + high) / 2)
    parts = []
    for number, height in enumerate(heights):
        near = np.abs(surface.centres[:, 2] - surface.bounds[0, 2] - height) < 0.1 * surface.size[2]
        wide = float(np.median(cup.distances(surface.centres[near]))) if near.any() else cup.reach
        span = (0.0, 2.0) if number < count else (-1.2, -0.5)
        angles = start + np.linspace(*span, 7)
        ring = cup.axis + (wide + FINGER) * np.column_stack([np.cos(angles), np.sin(angles)])
        path = np.column_stack([ring, np.full(7, surface.bounds[0, 2] + height)])
        parts.append(solids.tube(path, FINGER, sections=8).triangles)
    return surface.joined(Surface(np.concatenate(parts)))
