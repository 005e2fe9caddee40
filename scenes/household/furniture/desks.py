"""Desks: tables to work at, with drawers, panels and corners."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.legs import apron, families, family, four_legs, panel_ends, sled, stretchers
from ..parts.outlines import arc, at_height, circle, superellipse
from ..parts.solids import box, crossbar, cushion, hoop, join, lathe, prism, rod, sheet
from .tables import top


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
        parts += [box(0.07, 0.05, under - 0.42, x=x, z=0.42), box(0.05, 0.7 * depth, 0.03, x=x, z=under - 0.03)]
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
    *[family("desk", drawer_desk, sides=sides) for sides in (1, 2)],
    family("desk", drawer_desk, sides=1, to_floor=False),
    family("corner_desk", corner_desk),
    family("writing_desk", secretary),
]


def coffee_table(rng: Generator, *, shape: str = "rectangle", legs: str = "shelf"):
    """Return a low table, 0.35 to 0.5 m high: solid, or a thin sheet like glass on a light frame."""
    width, depth, height = rng.uniform(0.9, 1.3), rng.uniform(0.5, 0.75), rng.uniform(0.36, 0.48)
    thickness = 0.01 if legs == "sled" else rng.uniform(0.025, 0.05)
    under = height - thickness
    w, d = 0.94 * width, 0.92 * depth
    stands = {
        "shelf": lambda: [
            four_legs(w, d, under, 0.06),
            box(w - 0.02, d - 0.02, 0.02, z=0.1),
            apron(w - 0.02, d - 0.02, 0.05, 0.02, under),
        ],
        "sled": lambda: [sled(0.8 * w, 0.9 * d, under, 0.015), crossbar(0.8 * w, 0, 0.015, 0.02, 0.02)],
        "splayed": lambda: [four_legs(0.6 * w, 0.55 * d, under, 0.04, splay=0.07, taper=0.6, round_bars=True)],
        "slab": lambda: [panel_ends(width, depth, under, 0.05), box(width - 0.1, depth - 0.04, 0.02, z=0.12)],
    }
    return join(top(shape, width, depth, thickness, height), stands[legs]())


def side_table(rng: Generator, *, shape: str = "round"):
    """Return a small table for the side of a seat, 0.45 to 0.62 m high."""
    width, height = rng.uniform(0.38, 0.52), rng.uniform(0.45, 0.62)
    legs = four_legs(0.62 * width, 0.62 * width, height - 0.02, 0.03, splay=0.04, taper=0.7, round_bars=True)
    return join(top(shape, width, width, 0.022, height), legs)


def tray_table(rng: Generator):
    """Return a C-shaped table that reaches over a seat, and its foot under it."""
    width, depth, height = rng.uniform(0.42, 0.5), rng.uniform(0.32, 0.42), rng.uniform(0.6, 0.68)
    posts = [box(0.025, 0.025, height - 0.02, x=-width / 2 + 0.02, y=y) for y in (-depth / 2 + 0.03, depth / 2 - 0.03)]
    feet = [box(width - 0.04, 0.025, 0.02, y=y) for y in (-depth / 2 + 0.03, depth / 2 - 0.03)]
    return join(top("rectangle", width, depth, 0.02, height), posts, feet)


def bedside_table(rng: Generator):
    """Return a bedside table: a drawer under its top, on four legs."""
    width, depth, height = rng.uniform(0.4, 0.5), rng.uniform(0.35, 0.42), rng.uniform(0.5, 0.6)
    drawer = box(width - 0.03, depth - 0.03, 0.14, z=height - 0.16)
    knob = box(0.06, 0.04, 0.012, y=-depth / 2, z=height - 0.1)
    legs = four_legs(width - 0.02, depth - 0.02, height - 0.1, 0.035)
    return join(box(width, depth, 0.02, z=height - 0.02), drawer, knob, legs)


def child_table(rng: Generator):
    """Return a low square table for children."""
    width, height = rng.uniform(0.55, 0.75), rng.uniform(0.44, 0.52)
    legs = four_legs(0.8 * width, 0.8 * width, height - 0.025, 0.045, round_bars=True)
    return join(top("rounded", width, width, 0.025, height), legs)


LOW_TABLES = [
    *[family("coffee_table", coffee_table, legs=legs, also="sittable") for legs in ("shelf", "sled")],
    family("coffee_table", coffee_table, shape="oval", legs="splayed", also="sittable"),
    family("coffee_table", coffee_table, legs="slab", also="sittable"),
    *[family("side_table", side_table, shape=shape) for shape in ("round", "rounded")],
    *families(tray_table, bedside_table),
    family("child_table", child_table, also="sittable"),
]


def stool(rng: Generator, *, shape: str = "round", legs: int = 4, height: tuple[float, float] = (0.42, 0.48)):
    """Return a stool without a back."""
    width, seat = rng.uniform(0.3, 0.4), rng.uniform(*height)
    top = circle(width / 2, 32) if shape == "round" else superellipse(width, 0.85 * width, 6.0, 32)
    parts = [prism(top, 0.03, seat - 0.03)]
    if legs == 3:
        near, far = 0.3 * width, 0.5 * width
        ways = [(np.cos(angle), np.sin(angle)) for angle in np.radians([90, 210, 330])]
        ends = [([near * x, near * y, seat - 0.02], [far * x, far * y, 0]) for x, y in ways]
        return join(parts, [rod(top, foot, 0.018, 10) for top, foot in ends])
    splay = 0.03 + 0.06 * (seat > 0.6)
    size, round_bars = (0.68 * width, 0.6 * width, seat - 0.02), shape == "round"
    parts += four_legs(*size, 0.034, splay=splay, taper=0.8, round_bars=round_bars)
    inner = 0.68 * width - 0.034 + splay
    return join(parts, stretchers(inner, inner - 0.08 * width, 0.42 * seat, 0.018))


def bar_chair(rng: Generator, *, back: bool = True):
    """Return a bar stool on a column with a disc foot and a footrest, its seat dished or backed."""
    radius, seat = rng.uniform(0.17, 0.2), rng.uniform(0.65, 0.8)
    parts = [lathe([(0, 0), (0.2, 0), (0.2, 0.012), (0.03, 0.03), (0.025, seat - 0.05), (0, seat - 0.05)])]
    parts += [hoop(circle(0.16, 20), 0.3 * seat, 0.009), crossbar(0.32, 0, 0.3 * seat, 0.02, 0.015)]
    parts.append(cushion(2 * radius, 2 * radius, 0.07, z=seat - 0.07, corner=radius * 0.98, crown=0.01))
    if back:
        rim = arc(radius + 0.01, 10, 170, 14)
        rows = [at_height(rim * s, seat + z) for s, z in ((0.88, -0.05), (1.03, 0.1), (1.12, 0.24))]
        parts.append(sheet(rows, 0.018))
    return join(parts)


STOOLS = [
    family("stool", stool, shape="round", legs=3, also="table"),
    family("stool", stool, shape="square", also="table"),
    family("bar_stool", stool, shape="square", height=(0.68, 0.8)),
    *[family("bar_stool", bar_chair, back=back) for back in (True, False)],
]
