"""Low and small tables: for coffee, beside a seat or a bed, for children."""

from __future__ import annotations

from numpy.random import Generator

from ..parts.family import families, family
from ..parts.legs import apron, four_legs, panel_ends, sled
from ..parts.solids import box, crossbar, join
from .tables import top


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
    """Return a small table for beside a seat, 0.45 to 0.62 m high."""
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
    family("coffee_table", coffee_table, legs="shelf", also="sittable"),
    family("coffee_table", coffee_table, legs="sled", also="sittable"),
    family("coffee_table", coffee_table, shape="oval", legs="splayed", also="sittable"),
    family("coffee_table", coffee_table, legs="slab", also="sittable"),
    family("side_table", side_table, shape="round"),
    family("side_table", side_table, shape="rounded"),
    *families(tray_table, bedside_table),
    family("child_table", child_table, also="sittable"),
]
