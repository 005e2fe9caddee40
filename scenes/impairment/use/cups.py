"""Cups and tables in use. Each change takes a specimen and a generator, and returns a surface, or None."""

from __future__ import annotations

import numpy as np

from ...household.furniture.chairs import CHAIRS
from ...household.parts import solids
from ..levels import Cavity, LevelPart
from ..specimen import Specimen, box, circle, level_direction, loft, needs, turn
from ..surfaces import ObjectSurface
from .placing import LoadedLevel, made, small_object, upright_box, with_objects

SPOON = (0.12, 0.19)  # metres long
FULL = (0.2, 0.55)  # of the way from the cavity's floor to its brim, where liquid stands
SAUCER = (1.5, 2.2)  # radius, times that of the cup's foot
FINGER = 0.008  # metres, the radius


@needs("cavity", triangles=True)
def with_spoon(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface:
    """Leave a spoon or a straw in the cup, leaning on the rim."""
    out, length = np.array([*level_direction(rng.uniform(0, 2 * np.pi)), 0.0]), rng.uniform(*SPOON)
    depth, wide = cup.brim - cup.floor, float(np.median(cup.radii))
    lean = np.arctan2(1.5 * wide, depth)
    foot = np.array([*cup.axis, cup.floor + 0.004]) - out * 0.6 * wide
    tip = foot + max(length, 1.15 * depth / np.cos(lean)) * (np.sin(lean) * out + [0, 0, np.cos(lean)])
    parts = [solids.tube([foot, tip], rng.uniform(0.0015, 0.004), sections=6)]
    if rng.uniform() < 0.7:
        bowl = min(0.018, 0.5 * wide)
        parts.append(solids.ellipsoid(1.3 * bowl, 1.3 * bowl, 0.008, *(foot + [0, 0, 0.003])))
    return specimen.surface.joined(ObjectSurface(np.concatenate([part.triangles for part in parts])))


@needs("cavity", triangles=True)
def with_liquid(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface:
    """Fill the cup a quarter to half, with something level and solid."""
    level = cup.floor + rng.uniform(*FULL) * (cup.brim - cup.floor)
    heights = np.linspace(cup.floor - 0.002, level, 6)
    rings = [circle(cup.axis, np.interp(height, cup.heights, cup.radii), height) for height in heights]
    return specimen.surface.joined(ObjectSurface(loft(rings)))


@needs("cavity", triangles=True)
def on_saucer(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface:
    """Stand the cup on a saucer or a coaster."""
    surface = specimen.surface
    foot = surface.centres[surface.centres[:, 2] < surface.bounds[0, 2] + 0.1 * surface.size[2]]
    radius = max(float(cup.distances(foot).max()), float(np.median(cup.radii))) * rng.uniform(*SAUCER)
    rise = rng.uniform(0.0, 0.016)
    profile = [(0, 0), (0.4 * radius, 0), (radius, rise), (radius, rise + 0.003), (0.45 * radius, 0.006), (0, 0.006)]
    saucer = solids.lathe(profile, sections=32)
    lift = [*cup.axis, surface.bounds[0, 2] - 0.0058]
    return surface.joined(ObjectSurface(np.asarray(saucer.triangles) + lift))


@needs("cavity", triangles=True)
def held(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface:
    """Close a hand's fingers about the wall: four on one side, a thumb on the other."""
    surface = specimen.surface
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
    return surface.joined(ObjectSurface(np.concatenate(parts)))


GAPS = (0.0, 0.05)  # metres between objects on a full table
SIDES = (0.09, 0.28)  # metres of these objects,
HIGH = (0.04, 0.4)  # and their heights
CHAIRS_HIGH = 0.55  # metres, the lowest top under which chairs fit


@needs("level", triangles=True)
def laid(specimen: Specimen, top: LevelPart, rng: np.random.Generator, least: int, most: int) -> ObjectSurface | None:
    """Put this many objects on the top, as many as have room there."""
    objects = [small_object(rng) for _ in range(rng.integers(least, most + 1))]
    return with_objects(specimen.surface, top, objects, rng)


@needs("level", triangles=True)
def full(specimen: Specimen, top: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Cover the top with boxes of different heights, so that nowhere a hand's breadth is free."""
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
    return specimen.surface.joined(ObjectSurface(np.concatenate(boxes))) if boxes else None


@needs("level", triangles=True)
def chairs_under(specimen: Specimen, top: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Push one to four chairs under the table, one on each side."""
    if top.height < CHAIRS_HIGH:
        return None
    parts, sides = [], rng.permutation(4)[: rng.integers(1, 5)]
    for side in sides:
        chair = made(CHAIRS[rng.integers(len(CHAIRS))], rng)
        reach, away = np.ptp(chair.reshape(-1, 3), axis=0)[:2].max() / 2, turn(np.array([0, 0, 1.0]), side * np.pi / 2)
        out = away @ [0, -1.0, 0]
        half = (top.box[1] - top.box[0]) / 2 @ np.abs(out[:2])
        middle = np.array([*top.box.mean(axis=0), 0]) + out * (half + reach * rng.uniform(-0.2, 0.8))
        parts.append(chair @ (away @ turn(np.array([0, 0, 1.0]), np.pi)).T + middle)
    return specimen.surface.joined(ObjectSurface(np.concatenate(parts)))


@needs("level", triangles=True)
def at_wall(specimen: Specimen, top: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Stand the table against a piece of wall, with something on it or not."""
    low, high = specimen.surface.bounds
    axis, side = int((high - low)[:2].argmin()), rng.choice([0, 1])
    start, end = low - [0.05, 0.05, 0], np.array([*(high[:2] + 0.05), high[2] + rng.uniform(0.2, 1.2)])
    start[axis], end[axis] = (high[axis], high[axis] + 0.05) if side else (low[axis] - 0.05, low[axis])
    placed = LoadedLevel(specimen.surface, top, parts=[box(start, end)])
    for _ in range(rng.integers(0, 3)):
        placed.put(small_object(rng), rng)
    return placed.joined()


@needs("level", triangles=True)
def cloth(specimen: Specimen, top: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Lay a cloth or a mat over a part of the top."""
    size = (top.box[1] - top.box[0]) * rng.uniform(0.3, 0.8, 2)
    return with_objects(specimen.surface, top, [upright_box(np.array([*size, 0.004]))], rng)
