"""Stairs, stands, racks and frames: levels on legs that are no tables."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..household.parts.legs import crossed_tubes, families, family, four_legs, pedestal
from ..household.parts.outlines import at_height, circle, outline, rectangle
from ..household.parts.solids import (
    beam,
    box,
    crossbar,
    ellipsoid,
    hoop,
    join,
    lathe,
    prism,
    rail,
    rod,
    shift,
    tube,
    turn,
)
from .tops import slats, tripod


def stairs(rng: Generator):
    """Return two to five steps, closed or on stringers, with a rail or none."""
    count, rise = int(rng.integers(2, 6)), rng.uniform(0.16, 0.24)
    run, width = rng.uniform(0.2, 0.3), rng.uniform(0.4, 0.8)
    thick = rng.choice([0.03, 1.0])
    tops = [rise * (k + 1) for k in range(count)]
    steps = [(top, 0) if thick == 1.0 else (thick, top - thick) for top in tops]
    steps = [box(width, run + 0.02, height, y=k * run, z=z) for k, (height, z) in enumerate(steps)]
    foot, end = (-run / 2, rise - 0.06), ((count - 0.5) * run, count * rise - 0.02)
    sides = [beam([x * width / 2, *foot], [x * width / 2, *end], 0.03, 0.12) for x in (-1, 1)]
    posts = [box(0.03, 0.03, count * rise, x=x * width / 2, y=(count - 1) * run) for x in (-1, 1)]
    return join(steps, sides, posts)


def plant_stand(rng: Generator):
    """Return a narrow stand with a pot on each of its plates, which leave no room."""
    height, count = rng.uniform(0.5, 1.1), int(rng.integers(1, 4))
    parts = [tube([[0, 0, 0], [0, 0, height]], 0.015), *pedestal(0.08, 0.16, 0.03)]
    pot = lathe([(0, 0), (0.08, 0), (0.11, 0.16), (0.1, 0.16), (0.095, 0.12), (0, 0.13)])
    for k in range(count):
        z, x = height * (k + 1) / count, 0.0 if k == count - 1 else 0.1 * (-1) ** k
        parts += [shift(prism(circle(0.12, 24), 0.01), x, 0, z - 0.01), shift(pot, x, 0, z - 0.002)]
        parts.append(ellipsoid(0.2, 0.2, rng.uniform(0.15, 0.3), x=x, z=z + 0.2))
    return join(parts)


def cake_stand(rng: Generator):
    """Return a plate on a foot, or two to three plates over each other."""
    count, wide = int(rng.integers(1, 4)), rng.uniform(0.1, 0.17)
    post = rod([0, 0, 0], [0, 0, 0.14 * count + 0.08], 0.008, 10)
    parts = [post, lathe([(0, 0), (0.07, 0), (0.06, 0.012), (0, 0.02)])]
    for k in range(count):
        size, z = wide * (1 - 0.22 * k), 0.12 * (k + 1)
        edge = [(size, z + 0.004), (size, z + 0.014), (size - 0.004, z + 0.014), (size - 0.006, z + 0.008)]
        parts.append(lathe([(0, z), *edge, (0, z + 0.006)]))
    return join(parts, ellipsoid(0.03, 0.03, 0.03, z=0.14 * count + 0.09))


def trampoline(rng: Generator):
    """Return a small trampoline: a mat hung within a ring on legs."""
    radius, height = rng.uniform(0.45, 0.75), rng.uniform(0.2, 0.35)
    mat, ring = prism(circle(0.8 * radius, 32), 0.004, height - 0.012), at_height(circle(radius, 32), height)
    ties = [rod([*(0.79 * radius * d), height - 0.01], [*(radius * d), height], 0.004, 4) for d in circle(1.0, 28)]
    legs = [rod([*(0.98 * radius * d), 0], [*(0.98 * radius * d), height], 0.016) for d in circle(1.0, 6)]
    return join(tube(ring, 0.018, sections=8, loop=True), mat, ties, legs)


def easel(rng: Generator):
    """Return a lectern, a music stand or an easel: a board that leans on legs."""
    height, width, lean = rng.uniform(0.9, 1.3), rng.uniform(0.4, 0.7), rng.uniform(20, 65)
    board = shift(turn(join(box(width, 0.36, 0.015), box(width, 0.012, 0.03, y=-0.18)), "x", lean), z=height)
    return join(board, tube([[0, 0, 0.3], [0, 0, height + 0.01]], 0.015), tripod(0.5, 0.28, 0.012))


def drying_rack(rng: Generator):
    """Return a rack for washing: bars a hand apart on crossed legs."""
    width, depth, height = rng.uniform(0.9, 1.5), rng.uniform(0.5, 0.6), rng.uniform(0.85, 1.0)
    places = np.arange(-depth / 2, depth / 2 + 0.01, rng.uniform(0.05, 0.1))
    bars = [rail(width, y, height, 0.004, 5) for y in places]
    legs = crossed_tubes((0.45 * width, depth / 2), (0.45 * width, -depth / 2), height, 0, 0.01)
    return join(bars, hoop(rectangle(width, depth), height, 0.008), legs)


def rack(rng: Generator):
    """Return a low rack for shoes or wine: levels of bars between two sides."""
    width, depth, count = rng.uniform(0.5, 0.9), rng.uniform(0.24, 0.34), int(rng.integers(2, 5))
    height = count * rng.uniform(0.17, 0.24)
    levels = np.linspace(0.08, height - 0.02, count)
    bars = [crossbar(width, y, z, 0.012, 0.012) for z in levels for y in np.linspace(-0.45, 0.45, 6) * depth]
    return join(bars, [box(0.02, depth, height, x=x * width / 2) for x in (-1, 1)])


def cat_tree(rng: Generator):
    """Return posts with small plates at several heights and a box below."""
    posts, parts = rng.uniform(0.6, 1.5, 3), [box(0.55, 0.45, 0.03)]
    for x, y, high in zip((-0.17, 0.0, 0.17), (-0.05, 0.1, -0.05), posts, strict=True):
        parts.append(shift(prism(circle(0.045, 12), high - 0.02), x, y, 0.02))
        parts.append(box(0.3, 0.28, 0.025, x=x, y=y, z=high - 0.025))
    return join(parts, box(0.3, 0.26, 0.28, x=0.1, y=-0.08, z=0.02))


def slide(rng: Generator):
    """Return a child's slide with its ladder."""
    high, width, length = rng.uniform(0.6, 1.1), rng.uniform(0.34, 0.45), rng.uniform(1.1, 1.7)
    deck = [box(width, 0.3, 0.03, z=high), four_legs(width, 0.3, high + 0.01, 0.05)]
    chute = [beam([0, -0.13, high], [0, -length, 0.08], width, 0.02)]
    chute += [beam([x * width / 2, -0.13, high + 0.05], [x * width / 2, -length, 0.13], 0.02, 0.12) for x in (-1, 1)]
    rungs = [box(width, 0.06, 0.03, y=0.17, z=z) for z in np.arange(0.2, high, 0.2)]
    return join(deck, chute, rungs, [box(0.03, 0.06, high, x=x * width / 2, y=0.17) for x in (-1, 1)])


def pallet(rng: Generator):
    """Return a pallet: slats on three blocks' rows."""
    width, depth = rng.uniform(0.8, 1.2), rng.uniform(0.6, 1.0)
    boards = slats(rng, outline("rectangle", width, depth), 0.02, 0.14, gap=rng.uniform(0.02, 0.05))
    rows = [box(width, 0.1, 0.1, y=y * 0.44 * depth, z=0.02) for y in (-1, 0, 1)]
    return join(boards, rows, [box(0.1, depth, 0.025, x=x * 0.44 * width) for x in (-1, 0, 1)])


def plinth(rng: Generator):
    """Return a column or a plinth with a bust, a vase or a ball on it."""
    height, width = rng.uniform(0.6, 1.1), rng.uniform(0.24, 0.36)
    base = [box(width, width, 0.08), box(0.8 * width, 0.8 * width, height), box(width, width, 0.05, z=height - 0.05)]
    return join(base, ellipsoid(0.7 * width, 0.6 * width, 0.9 * width, z=height + 0.43 * width))


STANDS = [
    family("stairs", stairs, 2),
    *families(plant_stand, cake_stand, trampoline, easel, drying_rack, rack, cat_tree, slide, pallet, plinth),
]
