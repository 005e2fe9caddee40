"""Cabinets, shelves and kitchen machines: furniture closed to the floor, or open only in front."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.legs import families, family, four_legs
from ..parts.solids import box, crossbar, cushion, join, lathe, shift, tube, turn
from .desks import drawers


def drawer_cabinet(rng: Generator, *, width: float, depth: float, height: float, fronts: int, feet: float = 0.0):
    """Return a chest of drawers of about the given size, metres, closed to the floor or on short feet."""
    width, depth, height = np.array([width, depth, height]) * rng.uniform(0.9, 1.1, 3)
    top = box(width + 0.03, depth + 0.02, 0.025, z=height - 0.025)
    legs = four_legs(width - 0.02, depth - 0.02, feet + 0.01, 0.05) if feet else []
    stack = drawers(width, depth, height - 0.03 - feet, 0.0, feet, fronts)
    return join(stack, top, box(width, depth - 0.05, 0.04, z=height - 0.06), legs)


def base_cabinet(rng: Generator, *, sink: bool = False):
    """Return a kitchen cabinet with a worktop, a recessed plinth and doors; a sink is let into the top."""
    width, depth, height = 0.9 * rng.uniform(0.9, 1.3), rng.uniform(0.56, 0.62), rng.uniform(0.84, 0.92)
    parts = [box(width - 0.02, depth - 0.12, 0.1, y=0.04), box(width, depth - 0.04, height - 0.14, y=0.01, z=0.1)]
    parts += _doors(width, height - 0.16, -depth / 2 + 0.02, 0.11)
    if not sink:
        return join(parts, box(width + 0.02, depth, 0.04, z=height - 0.04))
    rim = [box(width + 0.02, 0.1, 0.2, y=y * (depth / 2 - 0.05), z=height - 0.2) for y in (-1, 1)]
    rim += [box(0.12, depth, 0.2, x=x * (width / 2 - 0.05), z=height - 0.2) for x in (-1, 1)]
    parts[1] = box(width, depth - 0.04, height - 0.34, y=0.01, z=0.1)
    bends = [(0.42, -0.01), (0.42, 0.22), (0.2, 0.25), (0.15, 0.18)]
    tap = tube([[0, y * depth, height + z] for y, z in bends], 0.012)
    return join(parts, rim, box(width, depth - 0.02, 0.05, z=height - 0.25), tap)


def _doors(width: float, height: float, y: float, z: float):
    """Return two doors side by side with upright pulls, their faces at y."""
    door, parts = width / 2, []
    for side in (1, -1):
        x = -side * door / 2
        parts.append(box(door - 0.008, 0.02, height - 0.01, x=x, y=y, z=z + 0.005))
        parts.append(box(0.012, 0.03, min(0.2, 0.3 * height), x=x + side * 0.4 * door, y=y - 0.02, z=z + 0.5 * height))
    return parts


def wardrobe(rng: Generator):
    """Return a wardrobe, 1.8 to 2.2 m high."""
    width, depth, height = rng.uniform(0.9, 1.1), rng.uniform(0.5, 0.62), rng.uniform(1.8, 2.2)
    parts = [box(width, depth - 0.03, height - 0.08, y=0.01, z=0.05), box(width - 0.04, depth - 0.1, 0.06)]
    parts += _doors(width, height - 0.12, -depth / 2 + 0.016, 0.06)
    return join(parts, box(width + 0.03, depth, 0.035, z=height - 0.035))


def bookcase(rng: Generator, *, tall: bool = True, back: bool = True):
    """Return open shelves between two boards."""
    width, depth = rng.uniform(0.7, 1.1), rng.uniform(0.26, 0.34)
    height = rng.uniform(1.6, 2.1) if tall else rng.uniform(0.8, 1.15)
    levels = np.linspace(0.06, height - 0.02, 6 if tall else 4)
    parts = [box(0.02, depth, height, x=x * (width / 2 - 0.01)) for x in (-1, 1)]
    parts += [box(width - 0.02, depth, 0.02, z=z - 0.02) for z in levels]
    if back:
        parts.append(box(width, 0.008, height, y=depth / 2 - 0.004))
    return join(parts)


def utility_shelf(rng: Generator):
    """Return metal shelving on four angle posts, open on all sides."""
    width, depth, height = rng.uniform(0.75, 1.1), rng.uniform(0.32, 0.45), rng.uniform(1.4, 1.9)
    boards = [box(width, depth, 0.03, z=z) for z in np.linspace(0.1, height - 0.04, 5)]
    return join(boards, four_legs(width + 0.005, depth + 0.005, height, 0.03))


def refrigerator(rng: Generator):
    """Return a tall refrigerator with a freezer door."""
    width, depth, height = rng.uniform(0.55, 0.7), rng.uniform(0.58, 0.68), rng.uniform(1.55, 1.85)
    split = 0.68 * height
    parts = [box(width, depth - 0.06, height - 0.03, y=0.03, z=0.03), box(width - 0.06, depth - 0.16, 0.05, y=0.03)]
    for low, high in ((0.06, split), (split, height)):
        tall = high - low
        parts.append(cushion(width, 0.06, tall - 0.01, y=-depth / 2 + 0.04, z=low, rounding=0.01, corner=0.015))
        parts.append(box(0.02, 0.05, 0.4 * tall, x=-0.42 * width, y=-depth / 2 - 0.005, z=low + 0.3 * tall))
    return join(parts)


def stove(rng: Generator):
    """Return a free-standing cooker with four burners and a splashback."""
    width, depth, height = rng.uniform(0.5, 0.62), rng.uniform(0.56, 0.64), rng.uniform(0.84, 0.92)
    parts = [box(width, depth, height), box(width, 0.03, 0.12, y=depth / 2 - 0.015, z=height - 0.01)]
    ring = lathe([(0, 0), (0.085, 0), (0.085, 0.02), (0.06, 0.02), (0.05, 0.03), (0, 0.03)], sections=20)
    parts += [shift(ring, x * 0.24 * width, y * 0.22 * depth - 0.02, height - 0.005) for x in (-1, 1) for y in (-1, 1)]
    parts.append(crossbar(0.8 * width, -depth / 2 - 0.03, 0.7 * height, 0.02, 0.02))
    parts += [box(0.02, 0.05, 0.02, x=x * 0.38 * width, y=-depth / 2 - 0.01, z=0.7 * height - 0.01) for x in (-1, 1)]
    knob = turn(lathe([(0, 0), (0.02, 0), (0.018, 0.03), (0, 0.03)], sections=12), "x", 90)
    return join(parts, [shift(knob, x * width, -depth / 2 + 0.004, height - 0.06) for x in np.linspace(-0.38, 0.38, 5)])


def washing_machine(rng: Generator):
    """Return a front-loading washing machine."""
    width, depth, height = 0.6, rng.uniform(0.52, 0.62), rng.uniform(0.82, 0.87)
    door = turn(lathe([(0, 0), (0.19, 0), (0.19, 0.02), (0.14, 0.04), (0, 0.02)], sections=28), "x", 90)
    door = shift(door, 0, -depth / 2 + 0.004, 0.47 * height)
    body = cushion(width, depth, height, rounding=0.012, corner=0.02)
    return join(body, door, box(0.18, 0.01, 0.09, x=-0.18, y=-depth / 2, z=height - 0.13))


def counter_oven(rng: Generator):
    """Return a microwave oven."""
    width, depth, height = rng.uniform(0.42, 0.54), rng.uniform(0.32, 0.42), rng.uniform(0.24, 0.31)
    body = box(width, depth, height - 0.012, z=0.012)
    door = box(0.72 * width, 0.02, 0.85 * height, x=-0.11 * width, y=-depth / 2, z=0.03)
    feet = four_legs(width - 0.04, depth - 0.04, 0.015, 0.03)
    return join(body, door, box(0.015, 0.04, 0.7 * height, x=0.22 * width, y=-depth / 2 - 0.02, z=0.05), feet)


def oven(rng: Generator):
    """Return a built-in oven, standing by itself: a door with a window and a bar, and knobs above it."""
    width, depth, height = rng.uniform(0.56, 0.6), rng.uniform(0.52, 0.57), rng.uniform(0.57, 0.61)
    door = box(0.96 * width, 0.03, 0.74 * height, y=-depth / 2, z=0.03)
    bar = box(0.8 * width, 0.03, 0.02, y=-depth / 2 - 0.028, z=0.68 * height)
    knobs = [box(0.035, 0.03, 0.035, x=x * width, y=-depth / 2, z=0.87 * height) for x in (-0.38, -0.22, 0.22, 0.38)]
    return join(box(width, depth, height), door, bar, knobs)


def counter(rng: Generator):
    """Return a bar or shop counter: a closed front and ends, a worktop over them, and a higher shelf for guests."""
    width, depth, height = rng.uniform(1.4, 1.9), rng.uniform(0.5, 0.65), rng.uniform(0.88, 0.95)
    front = box(width, 0.04, height + 0.12, y=-depth / 2 + 0.02)
    ends = [box(0.04, depth, height - 0.03, x=x * (width - 0.04) / 2) for x in (-1, 1)]
    worktop = box(width, depth, 0.04, z=height - 0.04)
    return join(front, ends, worktop, box(width + 0.06, 0.28, 0.035, y=-depth / 2, z=height + 0.12))


def kitchen_island(rng: Generator):
    """Return a kitchen island on legs, with a drawer box and a slatted shelf."""
    width, depth, height = rng.uniform(0.95, 1.3), rng.uniform(0.6, 0.75), rng.uniform(0.86, 0.93)
    slats = [box(0.06, depth - 0.1, 0.02, x=x, z=0.2) for x in np.linspace(-width / 2 + 0.09, width / 2 - 0.09, 8)]
    rails = [box(width - 0.1, 0.03, 0.05, y=y * (depth / 2 - 0.06), z=0.16) for y in (-1, 1)]
    drawers = box(width - 0.08, depth - 0.08, 0.18, z=height - 0.22)
    legs = four_legs(width - 0.06, depth - 0.06, height - 0.04, 0.07)
    return join(box(width, depth, 0.04, z=height - 0.04), drawers, legs, slats, rails)


def media_unit(rng: Generator):
    """Return a low unit for a television, with the set on it."""
    width, depth, height = rng.uniform(1.2, 1.7), rng.uniform(0.38, 0.48), rng.uniform(0.38, 0.52)
    parts = [box(width, depth, 0.03, z=z) for z in (height - 0.03, 0.04)]
    parts.append(box(width, 0.01, height - 0.05, y=depth / 2 - 0.005, z=0.04))
    parts += [box(0.03, depth, height, x=x * width) for x in (-0.48, -0.16, 0.16, 0.48)]
    wide = 0.75 * width
    foot = [box(0.4 * wide, 0.22, 0.015, z=height), box(0.1, 0.04, 0.08, z=height)]
    return join(parts, box(wide, 0.05, 0.56 * wide, z=height + 0.06), foot)


CABINETS = [
    family("filing_cabinet", drawer_cabinet, width=0.42, depth=0.6, height=1.15, fronts=4),
    family("filing_cabinet", drawer_cabinet, width=0.42, depth=0.58, height=0.72, fronts=2),
    family("dresser", drawer_cabinet, width=1.2, depth=0.48, height=0.85, fronts=4, feet=0.12),
    family("chest_of_drawers", drawer_cabinet, width=0.8, depth=0.45, height=1.15, fronts=5),
    family("kitchen_cabinet", base_cabinet),
    family("kitchen_sink", base_cabinet, sink=True),
    *families(wardrobe, bookcase),
    family("low_bookcase", bookcase, tall=False, back=False),
    family("shelf", utility_shelf),
    *families(refrigerator, stove, washing_machine),
    family("microwave", counter_oven),
    *families(oven, counter),
    family("kitchen_island", kitchen_island),  # a counter, which §IV-B calls confused for a table
    family("tv_unit", media_unit),
]
