"""Desks: tables to work at, with drawers, panels and corners."""

from __future__ import annotations

from numpy.random import Generator

from ..parts.family import family
from ..parts.legs import apron, four_legs, panel_ends, sled
from ..parts.solids import box, join


def _plan(rng: Generator) -> tuple[float, float, float]:
    return rng.uniform(1.1, 1.8), rng.uniform(0.55, 0.8), rng.uniform(0.7, 0.76)


def drawers(width: float, depth: float, height: float, x: float, z: float, count: int):
    """Return a box of drawers with its fronts and pulls to -y, its bottom centred on (x, 0, z)."""
    parts = [box(width, depth - 0.02, height, x=x, y=0.01, z=z)]
    front = height / count
    for number in range(count):
        low = z + number * front
        parts.append(box(width - 0.01, 0.02, front - 0.01, x=x, y=-depth / 2 + 0.012, z=low + 0.005))
        parts.append(box(0.3 * width, 0.015, 0.012, x=x, y=-depth / 2, z=low + 0.6 * front))
    return parts


def plain_desk(rng: Generator, *, legs: str = "posts"):
    """Return a desk without drawers: a top on posts, panels, or a tube frame."""
    width, depth, height = _plan(rng)
    under = height - 0.025
    surface = box(width, depth, 0.025, z=under)
    if legs == "posts":
        posts = four_legs(width - 0.02, depth - 0.04, under, 0.05)
        return join(surface, posts, apron(width - 0.04, depth - 0.06, 0.05, 0.02, under))
    if legs == "panels":
        ends = panel_ends(width, depth - 0.02, under, 0.025)
        return join(surface, ends, box(width - 0.05, 0.02, 0.4, y=0.4 * depth, z=under - 0.4))
    if legs == "sled":
        loops = sled(width - 0.1, depth - 0.06, under, 0.02)
        return join(surface, loops, box(width - 0.16, 0.03, 0.04, y=0.35 * depth, z=under - 0.04))
    return join(surface, _lifting_legs(width, depth, under))


def _lifting_legs(width: float, depth: float, under: float):
    """Return the two columns of a desk of adjustable height, each on a foot."""
    parts = [box(0.7 * width, 0.08, 0.04, z=under - 0.04)]
    for x in (-0.34 * width, 0.34 * width):
        parts += [box(0.08, 0.9 * depth, 0.035, x=x), box(0.09, 0.07, 0.4, x=x, z=0.03)]
        parts.append(box(0.07, 0.05, under - 0.42, x=x, z=0.42))
        parts.append(box(0.05, 0.7 * depth, 0.03, x=x, z=under - 0.03))
    return parts


def drawer_desk(rng: Generator, *, sides: int = 1, to_floor: bool = True):
    """Return a desk with a stack of drawers under one or both ends."""
    width, depth, height = _plan(rng)
    under, stack = height - 0.03, rng.uniform(0.36, 0.44)
    tall = under - 0.03 if to_floor else 0.3
    parts = [box(width, depth, 0.03, z=under)]
    for side in (1, -1)[:sides]:
        parts += drawers(stack, depth - 0.06, tall, side * (width - stack - 0.06) / 2, under - tall, 3)
    if sides == 2:
        plinths = [box(stack - 0.04, depth - 0.12, 0.04, x=x * (width - stack - 0.06) / 2) for x in (-1, 1)]
        return join(parts, plinths, box(width - 0.1, 0.02, 0.45, y=0.38 * depth, z=under - 0.45))
    ends = panel_ends(width, depth - 0.04, under, 0.03)
    return join(parts, ends, box(width - 0.06, 0.018, 0.3, y=0.4 * depth, z=under - 0.3))


def corner_desk(rng: Generator):
    """Return an L-shaped desk: a return joins its right end, towards -y."""
    width, depth, height = rng.uniform(1.5, 1.8), rng.uniform(0.6, 0.75), rng.uniform(0.72, 0.75)
    reach, under = rng.uniform(0.6, 0.9), height - 0.025
    x, y = (width - depth) / 2, -(depth + reach) / 2
    parts = [box(width, depth, 0.025, z=under), box(depth, reach, 0.025, x=x, y=y, z=under)]
    left, rear = -width / 2 + 0.04, depth / 2 - 0.04
    posts = [(left, -rear), (left, rear), (-left, rear)]
    posts += [(x + s * (depth / 2 - 0.04), -depth / 2 - reach + 0.04) for s in (-1, 1)]
    return join(parts, [box(0.05, 0.05, under + 0.005, x=px, y=py) for px, py in posts])


def secretary(rng: Generator):
    """Return a small writing desk on tapered legs with a drawer under its top."""
    width, depth, height = rng.uniform(0.85, 1.1), rng.uniform(0.45, 0.55), rng.uniform(0.72, 0.77)
    drawer = drawers(width - 0.12, depth - 0.06, 0.11, 0.0, height - 0.13, 1)
    legs = four_legs(width - 0.06, depth - 0.06, height - 0.02, 0.05, taper=0.5)
    return join(box(width, depth, 0.02, z=height - 0.02), drawer, legs)


DESKS = [
    *[family("desk", plain_desk, legs=legs) for legs in ("posts", "panels", "sled", "columns")],
    family("desk", drawer_desk, sides=1),
    family("desk", drawer_desk, sides=2),
    family("desk", drawer_desk, sides=1, to_floor=False),
    family("corner_desk", corner_desk),
    family("writing_desk", secretary),
]
