"""Tables to eat, stand and work at: one flat top on legs. Desks and low tables have files of their own."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.legs import apron, cross_foot, crossed_legs, family, four_legs, pedestal, sled, stretchers, trestles
from ..parts.outlines import at_height, outline, superellipse
from ..parts.solids import beam, box, join, loft, prism, tube


def dining_table(rng: Generator, *, shape: str = "rectangle", legs: str = "straight"):
    """Return a dining table for four to eight, 0.72 to 0.77 m high."""
    width, depth, height = rng.uniform(1.1, 2.2), rng.uniform(0.75, 1.0), rng.uniform(0.72, 0.77)
    thickness = rng.uniform(0.02, 0.045)
    under, bar = height - thickness, rng.uniform(0.05, 0.09)
    margin = 0.0 if legs == "flush" else rng.uniform(0.03, 0.1)
    w, d = width - 2 * margin, depth - 2 * margin
    if shape in ("oval", "rounded"):
        w, d = 0.8 * w, 0.66 * d
    parts = {
        "straight": lambda: [four_legs(w, d, under, bar), apron(w - 0.02, d - 0.02, 0.09, 0.02, under)],
        "flush": lambda: [four_legs(w, d, under, bar), apron(w, d, 0.06, 0.02, under)],
        "tapered": lambda: [four_legs(w, d, under, bar, taper=0.55), apron(w - 0.02, d - 0.02, 0.1, 0.02, under)],
        "splayed": lambda: [
            four_legs(0.85 * w, 0.8 * d, under, bar * 0.8, splay=0.08, taper=0.6, round_bars=True),
            apron(0.8 * w, 0.7 * d, 0.06, 0.02, under),
        ],
        "trestle": lambda: [trestles(0.7 * w, 0.8 * d, under, 0.06)],
        "crossed": lambda: [crossed_legs(0.72 * w, 0.85 * d, under, 0.06)],
    }
    return join(top(shape, width, depth, thickness, height), parts[legs]())


def round_table(rng: Generator, *, legs: str = "pedestal"):
    """Return a round table for two to six."""
    width, height, thickness = rng.uniform(0.85, 1.35), rng.uniform(0.71, 0.76), rng.uniform(0.02, 0.035)
    under = height - thickness
    surface = top("round", width, width, thickness, height)
    if legs == "pedestal":
        return join(surface, pedestal(under, 0.3 * width, 0.05))
    inner = 0.66 * width
    bars = four_legs(inner, inner, under, 0.05, taper=0.6)
    return join(surface, bars, apron(inner - 0.01, inner - 0.01, 0.08, 0.02, under))


def cafe_table(rng: Generator, *, shape: str = "round"):
    """Return a small table on one column, as in cafes."""
    width, height = rng.uniform(0.58, 0.8), rng.uniform(0.7, 0.76)
    depth = width if shape == "round" else rng.uniform(0.55, 0.75)
    foot = rng.choice(["cross", "disc"])
    surface = top(shape, width, depth, 0.025, height)
    if foot == "cross":
        return join(surface, cross_foot(height - 0.02, 0.42 * width, 0.03))
    return join(surface, pedestal(height - 0.02, 0.36 * width, 0.028))


def console(rng: Generator, *, legs: str = "shelf"):
    """Return a narrow table that stands against a wall."""
    width, depth, height = rng.uniform(0.9, 1.4), rng.uniform(0.3, 0.4), rng.uniform(0.76, 0.86)
    parts = [box(width, depth, 0.025, z=height - 0.025), four_legs(width, depth, height - 0.025, 0.035)]
    if legs == "shelf":
        return join(parts, box(width - 0.01, depth - 0.01, 0.02, z=0.15))
    drawer = box(width - 0.05, depth - 0.03, 0.12, z=height - 0.145)
    return join(parts, drawer, stretchers(width - 0.04, depth - 0.04, 0.1, 0.02))


def bar_table(rng: Generator, *, shape: str = "round"):
    """Return a table to stand at, 1.0 to 1.1 m high."""
    width, height = rng.uniform(0.6, 0.8), rng.uniform(1.0, 1.1)
    if shape == "round":
        return join(top(shape, width, width, 0.025, height), pedestal(height - 0.025, 0.24, 0.035))
    length = rng.uniform(1.1, 1.4)
    legs = four_legs(length - 0.06, width - 0.06, height - 0.03, 0.06)
    return join(top(shape, length, width, 0.03, height), legs, stretchers(length - 0.12, width - 0.12, 0.25, 0.035))


def work_bench(rng: Generator):
    """Return a heavy bench to work at, with a shelf near the floor and a vise."""
    width, depth, height = rng.uniform(1.2, 1.9), rng.uniform(0.6, 0.75), rng.uniform(0.82, 0.95)
    parts = [box(width, depth, 0.06, z=height - 0.06), four_legs(width - 0.15, depth - 0.06, height - 0.06, 0.09)]
    parts.append(box(width - 0.2, depth - 0.1, 0.03, z=0.18))
    x = -0.35 * width
    parts.append(box(0.3, 0.05, 0.14, x=x, y=-depth / 2 - 0.04, z=height - 0.16))
    parts.append(tube([[x, -depth / 2 - 0.16, height - 0.1], [x, -depth / 2 + 0.05, height - 0.1]], 0.014))
    return join(parts, apron(width - 0.17, depth - 0.08, 0.12, 0.025, height - 0.06))


def folding_table(rng: Generator, *, legs: str = "crossed"):
    """Return a light table whose legs fold: scissor legs, or bent tubes under a plastic top."""
    width, depth, height = rng.uniform(1.2, 1.85), rng.uniform(0.6, 0.78), rng.uniform(0.7, 0.75)
    surface = top("rectangle", width, depth, 0.04, height)
    if legs == "crossed":
        return join(surface, crossed_legs(0.8 * width, 0.9 * depth, height - 0.03, 0.025))
    loops = sled(0.8 * width, 0.8 * depth, height - 0.03, 0.014)
    ends = [[[x * 0.39 * width, 0, 0.014], [x * 0.1 * width, 0, height - 0.03]] for x in (-1, 1)]
    return join(surface, loops, [tube(brace, 0.008, sections=6) for brace in ends])


def picnic_table(rng: Generator):
    """Return a picnic table with a bench along each side, its top of boards."""
    width, height, seat = rng.uniform(1.5, 1.9), rng.uniform(0.72, 0.77), rng.uniform(0.42, 0.46)
    boards = [box(width, 0.142, 0.035, y=y, z=height - 0.035) for y in np.linspace(-0.3, 0.3, 5)]
    benches = [box(width, 0.26, 0.035, y=y, z=seat - 0.035) for y in (-0.62, 0.62)]
    ends = []
    for x in (-0.38 * width, 0.38 * width):
        ends += [box(0.04, 1.45, 0.09, x=x, z=seat - 0.12), box(0.04, 0.66, 0.07, x=x, z=height - 0.1)]
        ends += [beam([x, y * 0.24, height - 0.05], [x, y * 0.62, 0.01], 0.04, 0.09) for y in (-1, 1)]
    return join(boards, benches, ends)


def conference_table(rng: Generator):
    """Return a long boat-shaped table on two panel feet."""
    width, depth, height = rng.uniform(2.0, 2.6), rng.uniform(1.0, 1.2), rng.uniform(0.72, 0.76)
    feet = [box(0.08, 0.6 * depth, height - 0.03, x=x * 0.3 * width) for x in (-1, 1)]
    rail = box(0.6 * width, 0.04, 0.3, z=0.35)
    return join(top("boat", width, depth, 0.03, height), feet, rail)


def covered_table(rng: Generator):
    """Return a table under a cloth that hangs in folds most of the way to the floor."""
    width, height = rng.uniform(0.8, 1.1), rng.uniform(0.72, 0.76)
    angles = np.linspace(0, 2 * np.pi, 96, endpoint=False)
    wave = 1 + 0.035 * np.sin(12 * angles)
    unit = superellipse(1, 1, 5.0, 96)
    cloth = prism(unit * width, 0.006, height - 0.006)
    hem = height - rng.uniform(0.25, 0.5)
    upper, lower, high = unit * width, unit * width * 1.07 * wave[:, None], height - 0.003
    steps = [(upper, high), (lower, hem), (lower * 0.99, hem), (upper * 0.99, high)]  # a closed band of 4 mm
    skirt = loft([at_height(outline, z) for outline, z in steps], loop=True)
    return join(cloth, skirt, four_legs(0.85 * width, 0.85 * width, height - 0.004, 0.05))


TABLES = [
    family("dining_table", dining_table, 2, legs="straight"),
    family("dining_table", dining_table, legs="tapered"),
    family("dining_table", dining_table, shape="oval", legs="splayed"),
    family("dining_table", dining_table, legs="trestle"),
    family("dining_table", dining_table, shape="rounded", legs="crossed"),
    family("dining_table", dining_table, legs="flush"),
    *[family("round_table", round_table, legs=legs) for legs in ("pedestal", "four")],
    *[family("cafe_table", cafe_table, shape=shape) for shape in ("round", "rectangle")],
    *[family("console_table", console, legs=legs) for legs in ("shelf", "drawer")],
    *[family("bar_table", bar_table, shape=shape) for shape in ("round", "rectangle")],
    family("work_bench", work_bench),
    *[family("folding_table", folding_table, legs=legs) for legs in ("crossed", "tubes")],
    family("picnic_table", picnic_table, also="sittable"),
    family("conference_table", conference_table, 2),
    family("covered_table", covered_table),
]


def top(shape: str, width: float, depth: float, thickness: float, height: float):
    """Return a table top of the given plan whose upper face is at ``height``, metres."""
    return prism(outline(shape, width, depth), thickness, height - thickness)
