"""Tables: with rims and handles, of slats, boards and glass, low, round, folding, and with seats of their own."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.random import Generator

from ..household.parts.legs import apron, crossed_tubes, families, family, four_legs
from ..household.parts.outlines import at_height, outline
from ..household.parts.solids import beam, box, crossbar, join, lathe, loft, prism, rail, rod, shift, stacked
from .tops import SHAPES, STANDS, around, border, column, grips, rough_slab, slats, stand_under

LIGHT = ("splayed", "crossed", "column", "cross", "tripod", "hairpins", "four", "sled")


def rimmed_table(rng: Generator, *, low: float, high: float, wide: float = 0.75):
    """Return a small table whose top has a raised rim, as trays have, and often handles; its height low to high."""
    height, width = rng.uniform(low, high), rng.uniform(0.34, wide)
    shape, rise, thick = str(rng.choice(SHAPES)), rng.uniform(0.008, 0.045), rng.uniform(0.003, 0.014)
    depth = width if shape in ("round", "octagon") else width * rng.uniform(0.6, 1.0)
    plan, board = outline(shape, width, depth), rng.uniform(0.006, 0.025)
    parts = [prism(plan, board, height - board), border(plan, rise, thick, height - 0.002, flare=rng.choice([0, 0.01]))]
    if shape in ("rectangle", "rounded", "oval") and rng.uniform() < 0.6:
        parts += grips(rng, width, depth, height + rise)
    return join(parts, stand_under(rng, LIGHT, width, depth, height - board))


def gallery_table(rng: Generator):
    """Return a table with a thin rail on posts along three sides of its top."""
    width, depth, height = rng.uniform(0.4, 1.3), rng.uniform(0.3, 0.5), rng.uniform(0.45, 0.85)
    x, y, rise = width / 2 - 0.01, depth / 2 - 0.01, rng.uniform(0.03, 0.08)
    corners = [[-x, -y], [-x, y], [x, y], [x, -y]]
    bars = [rod([*a, height + rise], [*b, height + rise], 0.005) for a, b in pairwise(corners)]
    posts = [[-x, -y], [-x, y], [0, y], [x, y], [x, -y]]
    bars += [rod([*at, height - 0.005], [*at, height + rise], 0.004) for at in posts]
    stand = stand_under(rng, STANDS[:6], width, depth, height - 0.02)
    return join(box(width, depth, 0.02, z=height - 0.02), bars, stand)


def lipped_desk(rng: Generator):
    """Return a desk with a board along its back, and often its ends, that stands higher than its top."""
    width, depth, height = rng.uniform(0.8, 1.7), rng.uniform(0.5, 0.8), rng.uniform(0.68, 0.78)
    lip, ends = rng.uniform(0.02, 0.12), rng.uniform() < 0.5
    parts = [box(width, depth, 0.025, z=height - 0.025), box(width, 0.018, lip, y=depth / 2 - 0.009, z=height - 0.002)]
    if ends:
        reach = rng.uniform(0.3, 1.0) * depth
        y = (depth - reach) / 2
        parts += [box(0.018, reach, lip, x=x * (width / 2 - 0.009), y=y, z=height - 0.002) for x in (-1, 1)]
    return join(parts, stand_under(rng, ("four", "panels", "sled", "trestles"), width, depth, height - 0.025))


def slatted_table(rng: Generator, *, low: float = 0.68, high: float = 0.76, uneven: float = 0.0):
    """Return a garden table: boards with gaps between them, at nearly one height or none."""
    width, height = rng.uniform(0.6, 1.9), rng.uniform(low, high)
    shape = str(rng.choice(["rectangle", "round", "oval", "octagon"]))
    width = min(width, 1.2) if shape in ("round", "octagon") else width
    plan = outline(shape, width, rng.uniform(0.5, 0.95))
    thick = rng.uniform(0.015, 0.04)
    boards = slats(rng, plan, thick, height, gap=rng.uniform(0.003, 0.014), uneven=uneven)
    inner = 0.7 if shape in ("round", "octagon") else 1.0
    size = 2 * inner * np.abs(plan).max(axis=0)
    return join(boards, stand_under(rng, ("four", "crossed", "trestles", "sled"), *size, height - thick + 0.002))


def rustic_table(rng: Generator, *, low: float, high: float):
    """Return a table whose top is a slab with an irregular edge, not quite even."""
    height, thick = rng.uniform(low, high), rng.uniform(0.03, 0.07)
    width, depth = (rng.uniform(0.8, 2.0), rng.uniform(0.5, 0.9)) if low > 0.6 else (rng.uniform(0.6, 1.2), 0.5)
    slab = rough_slab(rng, width, depth, thick, height)
    return join(slab, stand_under(rng, ("four", "hairpins", "trestles", "panels"), width, 0.8 * depth, height - thick))


def glass_table(rng: Generator, *, low: float, high: float):
    """Return a thin top that lies over a light frame, as glass does."""
    height, thick, shape = rng.uniform(low, high), rng.uniform(0.006, 0.012), str(rng.choice(SHAPES))
    width = rng.uniform(0.5, 1.4)
    depth = width if shape in ("round", "octagon") else rng.uniform(0.45, 0.95)
    under = height - thick
    frame = stand_under(rng, ("sled", "crossed", "cross", "splayed", "column", "tripod"), width, depth, under - 0.01)
    corners = [(x * 0.2 * width, y * 0.2 * depth) for x in (-1, 1) for y in (-1, 1)]
    pads = [box(0.03, 0.03, 0.012, x=x, y=y, z=under - 0.011) for x, y in corners]
    rails = [crossbar(0.95 * width, y * 0.2 * depth, under - 0.02, 0.03, 0.02) for y in (-1, 1)]
    middle = box(0.03, 0.66 * depth, 0.02, z=under - 0.03)
    return join(prism(outline(shape, width, depth), thick, under), frame, pads, rails, middle)


def sheet_table(rng: Generator):
    """Return a table whose top is a single surface, as many models have it."""
    height, width = rng.uniform(0.4, 0.78), rng.uniform(0.5, 1.4)
    shape = str(rng.choice(SHAPES))
    plan = outline(shape, width, rng.uniform(0.45, 0.9))
    top = loft([at_height(plan * 1e-4, height), at_height(plan, height)], capped=False)
    return join(top, stand_under(rng, STANDS, width, 2 * np.abs(plan[:, 1]).max(), height - 0.001))


def pedestal_table(rng: Generator, *, low: float, high: float, least: float, most: float):
    """Return a top of a diameter from least to most on one column, metres."""
    height, width, thick = rng.uniform(low, high), rng.uniform(least, most), rng.uniform(0.012, 0.04)
    shape = str(rng.choice(["round", "octagon", "oval", "rounded"]))
    plan = outline(shape, width, width * rng.uniform(0.85, 1))
    top = stacked(plan, [(0.94, height - thick), (1, height - 0.4 * thick), (1, height)])
    return join(top, column(rng, height - thick, rng.uniform(0.24, 0.36) * width))


def half_round_table(rng: Generator):
    """Return a half-round table for a wall, or one with a leaf hanging down."""
    width, height, thick = rng.uniform(0.7, 1.1), rng.uniform(0.7, 0.85), 0.022
    plan = outline("round", width, width)
    half = np.concatenate([plan[plan[:, 1] <= 0.001], [[-width / 2, 0.02], [width / 2, 0.02]]])
    middle = half.mean(axis=0)
    half = half[np.argsort(np.arctan2(*(half - middle).T[::-1]))]
    leaf = [box(0.7 * width, 0.018, 0.3, y=0.02, z=height - 0.32)] if rng.uniform() < 0.4 else []
    legs = four_legs(0.7 * width, 0.3 * width, height - thick, 0.04, taper=0.6)
    board = apron(0.68 * width, 0.28 * width, 0.08, 0.02, height - thick)
    return join(prism(half, thick, height - thick), leaf, shift(join(legs, board), 0, -0.17 * width))


def parasol_table(rng: Generator):
    """Return a garden table with a hole in its middle for a parasol."""
    width, height, hole = rng.uniform(0.8, 1.3), rng.uniform(0.68, 0.76), rng.uniform(0.02, 0.035)
    rings = [(width / 2, height - 0.02), (width / 2, height), (hole, height), (hole, height - 0.02)]
    legs = four_legs(0.6 * width, 0.6 * width, height - 0.015, 0.035, splay=0.06, round_bars=True)
    return join(lathe(rings, loop=True), legs)


def leaned_top(rng: Generator):
    """Return a C-shaped table that reaches over a sofa or a bed, on a foot with or without castors."""
    width, depth, height = rng.uniform(0.4, 0.75), rng.uniform(0.3, 0.42), rng.uniform(0.55, 0.9)
    shape, post = str(rng.choice(["rectangle", "rounded", "oval"])), 0.42 * width
    plan, thick = outline(shape, width, depth), rng.uniform(0.01, 0.025)
    parts = [prism(plan, thick, height - thick), box(0.05, 0.08, height - thick + 0.002, x=-post)]
    parts += [box(0.9 * width, 0.04, 0.03, y=y * 0.36 * depth) for y in (-1, 1)]
    parts.append(box(0.06, 0.8 * depth, 0.03, x=-post))
    if rng.uniform() < 0.5:
        parts.append(border(plan, rng.uniform(0.008, 0.02), 0.008, height - 0.002))
    return join(parts)


def low_table(rng: Generator):
    """Return a coffee table of one or two levels, 0.25 to 0.5 m high."""
    height, width = rng.uniform(0.25, 0.5), rng.uniform(0.5, 1.3)
    shape = str(rng.choice(SHAPES))
    depth = width if shape in ("round", "octagon") else rng.uniform(0.45, 0.8)
    plan, thick = outline(shape, width, depth), rng.uniform(0.02, 0.06)
    top = prism(plan, thick, height - thick)
    parts = [top, stand_under(rng, ("four", "splayed", "sled", "panels", "hairpins"), width, depth, height - thick)]
    if rng.uniform() < 0.5:
        parts.append(prism(0.9 * plan, 0.02, 0.35 * height))
    return join(parts)


def heated_table(rng: Generator):
    """Return a low table with a blanket that spreads over the floor under its top."""
    width, height = rng.uniform(0.7, 1.0), rng.uniform(0.34, 0.42)
    plan, wide = outline("rounded", width, width), rng.uniform(1.25, 1.6)
    blanket = stacked(plan, [(wide, 0), (wide, 0.04), (1.02, height - 0.08), (0.98, height - 0.025)])
    return join(blanket, prism(plan, 0.03, height - 0.03))


def seat_board(rng: Generator, width: float, height: float):
    """Return a bench without a back on two panels, its length along x, metres."""
    ends = [box(0.04, 0.26, height - 0.03, x=x * 0.38 * width) for x in (-1, 1)]
    return join(box(width, rng.uniform(0.26, 0.32), 0.035, z=height - 0.035), ends)


def picnic_table(rng: Generator, *, round_top: bool, scale: float = 1.0):
    """Return a table and its benches in one: two along its sides, or four about a round top."""
    width, height, seat = rng.uniform(1.1, 1.9), rng.uniform(0.7, 0.78), rng.uniform(0.4, 0.47)
    shape, long = ("round", min(width, 1.2)) if round_top else ("rectangle", width)
    plan = outline(shape, long, rng.uniform(0.65, 0.85))
    boards = slats(rng, plan, 0.035, height, gap=rng.uniform(0.0, 0.01))
    short, count = 2 * np.abs(plan[:, 1]).max(), 4 if round_top else 2
    length = 0.55 * short if round_top else rng.uniform(0.85, 1.0) * width
    reach = short / 2 + rng.uniform(0.16, 0.3)
    arms = [box(2 * reach, 0.05, 0.07, z=seat - 0.1), box(0.05, 2 * reach, 0.07, z=seat - 0.1)]
    if not round_top:
        arms = [box(0.05, 2 * reach, 0.07, x=x * 0.3 * width, z=seat - 0.1) for x in (-1, 1)]
    legs = four_legs(0.66 * np.abs(plan[:, 0]).max() * 2, 0.5 * short, height - 0.03, 0.07, splay=0.04)
    posts = [box(0.1, 0.1, height - 0.03)] if round_top else []
    return join(boards, legs, arms, posts, around(seat_board(rng, length, seat), count, reach)).apply_scale(scale)


def school_desk(rng: Generator, *, seat: str):
    """Return a school desk with a box for books: alone, with its chair drawn up, or with a seat on its frame."""
    width, depth, height = rng.uniform(0.55, 0.75), rng.uniform(0.42, 0.55), rng.uniform(0.6, 0.76)
    parts = [box(width, depth, 0.02, z=height - 0.02), four_legs(0.9 * width, 0.85 * depth, height - 0.02, 0.03)]
    parts.append(box(0.84 * width, 0.7 * depth, 0.01, z=height - 0.13))
    parts.append(box(0.84 * width, 0.01, 0.12, y=0.35 * depth, z=height - 0.13))
    parts += [box(0.01, 0.7 * depth, 0.12, x=x * 0.42 * width, z=height - 0.13) for x in (-1, 1)]
    level, y = 0.6 * height, -depth / 2 - rng.uniform(0.1, 0.3)
    chair = [box(0.36, 0.34, 0.018, y=y, z=level - 0.018)]
    chair.append(beam([0, y - 0.17, level + 0.12], [0, y - 0.22, level + 0.36], 0.36, 0.016))
    foot, end = (y - 0.165, level - 0.02), (y - 0.225, level + 0.36)
    chair += [beam([x * 0.17, *foot], [x * 0.17, *end], 0.025, 0.02) for x in (-1, 1)]
    if seat == "chair":
        chair.append(shift(join(four_legs(0.36, 0.33, level - 0.01, 0.025)), 0, y))
    if seat == "frame":
        chair += [box(0.03, 0.45 * depth - y, 0.03, x=x * 0.16, y=y / 2, z=level - 0.045) for x in (-1, 1)]
        chair += [box(0.03, 0.03, level, x=x * 0.16, y=y) for x in (-1, 1)]
        chair.append(crossbar(0.9 * width, 0.2 * depth, level - 0.03, 0.03, 0.03))
        chair += [box(0.03, 0.34 * depth, 0.03, x=x * 0.44 * width, y=0.3 * depth, z=level - 0.045) for x in (-1, 1)]
    return join(parts, [] if seat == "none" else chair)


def child_set(rng: Generator):
    """Return a child's table with two to four stools about it."""
    width, height, stool = rng.uniform(0.5, 0.75), rng.uniform(0.42, 0.54), rng.uniform(0.24, 0.3)
    plan = outline(str(rng.choice(["rounded", "round"])), width, width)
    seat = join(box(0.27, 0.26, 0.025, z=stool - 0.025), four_legs(0.25, 0.24, stool - 0.02, 0.03))
    legs = four_legs(0.62 * width, 0.62 * width, height - 0.02, 0.045, round_bars=True)
    seats = around(seat, int(rng.integers(2, 5)), width / 2 + rng.uniform(-0.1, 0.14))
    return join(prism(plan, 0.025, height - 0.025), legs, seats)


def camp_table(rng: Generator):
    """Return a light folding table of narrow slats or one board on thin crossed legs."""
    width, depth, height = rng.uniform(0.45, 1.2), rng.uniform(0.35, 0.7), rng.uniform(0.35, 0.72)
    plan = outline("rectangle", width, depth)
    board = slats(rng, plan, 0.012, height, gap=0.003) if rng.uniform() < 0.5 else [prism(plan, 0.02, height - 0.02)]
    x, y = 0.42 * width, 0.46 * depth
    legs = crossed_tubes((x, y), (x, -y), height - 0.015, 0.01, 0.01)
    rails = [rail(2 * x, side * y, z, 0.008) for side in (-1, 1) for z in (0.012, height - 0.016)]
    return join(board, legs, rails)


def stone_table(rng: Generator):
    """Return a heavy slab on a block that stands on a plate, as a cable drum does."""
    height, width = rng.uniform(0.45, 0.78), rng.uniform(0.6, 1.3)
    plan = outline(str(rng.choice(["round", "octagon", "rectangle"])), width, rng.uniform(0.55, 0.9))
    thick = rng.uniform(0.05, 0.12)
    slab, foot = prism(plan, thick, height - thick), rng.uniform(0.35, 1.0)
    return join(slab, prism(rng.uniform(0.35, 0.6) * plan, height - thick + 0.002), prism(foot * plan, thick))


TABLES = [
    family("rimmed_table", rimmed_table, 4, low=0.4, high=0.7),
    family("tray_stand", rimmed_table, 3, low=0.6, high=0.95, wide=0.6),
    family("rimmed_dining_table", rimmed_table, low=0.7, high=0.77, wide=1.6),
    family("rimmed_low_table", rimmed_table, 2, low=0.28, high=0.48, wide=1.1),
    family("slatted_table", slatted_table, 3),
    family("uneven_table", slatted_table, 2, uneven=0.004),
    family("slatted_low_table", slatted_table, low=0.35, high=0.5, uneven=0.002),
    family("rustic_table", rustic_table, 2, low=0.7, high=0.78),
    family("rustic_low_table", rustic_table, low=0.32, high=0.48, also="sittable"),
    family("glass_table", glass_table, 2, low=0.68, high=0.76),
    family("glass_low_table", glass_table, 2, low=0.35, high=0.48),
    family("sheet_table", sheet_table, 2, watertight=False),
    family("pedestal_table", pedestal_table, 2, low=0.68, high=0.78, least=0.6, most=1.4),
    family("side_pedestal", pedestal_table, 2, low=0.42, high=0.66, least=0.28, most=0.5),
    family("bar_pedestal", pedestal_table, low=0.95, high=1.12, least=0.5, most=0.8),
    family("low_table", low_table, 4, also="sittable"),
    family("picnic_bench_table", picnic_table, 2, also="sittable", round_top=False),
    family("round_picnic_table", picnic_table, also="sittable", round_top=True),
    family("child_picnic_table", picnic_table, also="sittable", round_top=False, scale=0.65),
    *[
        family("school_desk", school_desk, also=also, seat=seat)
        for seat, also in (("none", ""), ("chair", "sittable"), ("frame", "sittable"))
    ],
    family("child_set", child_set, 2, also="sittable"),
    family("gallery_table", gallery_table, 2),
    family("lipped_desk", lipped_desk, 3),
    family("camp_table", camp_table, 2),
    family("over_bed_table", leaned_top, 2),
    *families(half_round_table, parasol_table, heated_table, stone_table),
]
