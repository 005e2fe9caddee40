"""Seats without legs, without backs, with domes and hollows, and those that hang."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..household.parts.legs import cross_foot, families, family, four_legs, pedestal, star_base
from ..household.parts.outlines import arc, at_height, circle, outline, rounded, superellipse
from ..household.parts.solids import (
    beam,
    box,
    crossbar,
    cushion,
    ellipsoid,
    join,
    lathe,
    prism,
    rod,
    sheet,
    shift,
    stacked,
    tube,
    turn,
)
from .tops import bumps, stand_under, tripod


def curved_wall(radius: float, low: float, high: float, thick: float, *, opening_deg: float, flare: float, drop: float):
    """Return a wall that runs about a seat and is open in front, lower by ``drop`` at its ends; metres."""
    rim = arc(radius, -90 + opening_deg / 2, 270 - opening_deg / 2, 32)
    front = np.clip((0.4 - rim[:, 1] / radius) / 1.2, 0, 1)
    rows = [at_height(rim * (1 + flare * t), low + t * (high - low - drop * front)) for t in (0, 0.5, 1)]
    return sheet(np.stack(rows), thick)


def tub_seat(rng: Generator):
    """Return a tub chair, small or as large as a love seat: a round seat within one curved wall."""
    radius, seat = rng.uniform(0.29, 0.44), rng.uniform(0.36, 0.47)
    high, thick = seat + rng.uniform(0.22, 0.42), rng.uniform(0.03, 0.13)
    low = rng.choice([0.0, 0.05, 0.12])
    opening, flare, drop = rng.uniform(80, 130), rng.uniform(0, 0.12), rng.uniform(0, 0.16)
    wall = curved_wall(radius, low, high, thick, opening_deg=opening, flare=flare, drop=drop)
    inner = radius - 0.4 * thick
    plan = superellipse(2 * inner, 2 * inner, rng.uniform(2.0, 3.0), 36)
    edge, crown = rng.uniform(0.01, 0.04), rng.uniform(0, 0.04)
    steps = [(1, low), (1, seat - edge), (0.95, seat), (0.6, seat + 0.6 * crown), (0.02, seat + crown)]
    feet = four_legs(1.2 * radius, 1.2 * radius, low + 0.02, 0.04) if low else []
    return join(wall, stacked(plan, steps), feet)


def floor_chair(rng: Generator):
    """Return a seat without legs on the floor, its back leaning: padded, or of bent board as in rooms with tatami."""
    width, depth, thick = rng.uniform(0.38, 0.54), rng.uniform(0.38, 0.52), rng.uniform(0.015, 0.14)
    rise, lean = rng.uniform(0.35, 0.6), rng.uniform(0.08, 0.3)
    if thick < 0.035:
        spine = rounded([[0, -depth / 2, thick], [0, depth / 2, thick], [0, depth / 2 + lean, rise]], rounds=3)
        across = np.linspace(-1, 1, 9)
        grid = spine[:, None] + np.column_stack([across * width / 2, np.zeros(9), np.zeros(9)])[None]
        pad = cushion(0.9 * width, 0.9 * depth, rng.uniform(0.02, 0.05), z=thick, rounding=0.01)
        return join(sheet(grid, thick), [pad] if rng.uniform() < 0.6 else [])
    seat = cushion(width, depth, thick, rounding=0.4 * thick, crown=rng.uniform(0, 0.02))
    slope = np.arctan2(rise, lean)
    back = turn(cushion(width, rise, rng.uniform(0.05, 0.12), rounding=0.03), "x", np.degrees(slope))
    parts = [seat, shift(back, 0, depth / 2 + 0.3 * lean, 0.4 * thick + rise / 2 * np.sin(slope))]
    if rng.uniform() < 0.3:
        parts += [cushion(0.07, 0.8 * depth, thick + 0.16, x=x * (width / 2 + 0.03), y=0.04) for x in (-1, 1)]
    return join(parts)


def frame_of_swing(width: float, height: float):
    """Return two pairs of leaning posts and the beam over them, metres."""
    feet = [(x * width / 2, y * 0.42 * height) for x in (-1, 1) for y in (-1, 1)]
    posts = [rod([x, y, 0], [x, 0, height], 0.03, 8) for x, y in feet]
    return [*posts, rod([-width / 2 - 0.05, 0, height], [width / 2 + 0.05, 0, height], 0.03, 8)]


def swing(rng: Generator, *, bench: bool):
    """Return a swing: a board on ropes, or a bench with a back for two, that hangs from a frame."""
    height, seat = rng.uniform(1.5, 2.2), rng.uniform(0.38, 0.55)
    width, depth = (rng.uniform(0.95, 1.4), 0.46) if bench else (rng.uniform(0.38, 0.55), rng.uniform(0.16, 0.26))
    parts = [frame_of_swing(width + rng.uniform(0.5, 0.9), height)]
    corners = [(x * 0.46 * width, y * 0.42 * depth) for x in (-1, 1) for y in (-1, 1)]
    ends = corners if bench else [(x, 0.0) for x in (-0.46 * width, 0.46 * width)]
    parts += [rod([x, y, seat - 0.02], [x, 0, height], 0.008) for x, y in ends]
    if not bench:
        return join(parts, box(width, depth, 0.025, z=seat - 0.025))
    parts += [box(width, 0.07, 0.02, y=y, z=seat - 0.02) for y in np.linspace(-0.4, 0.4, 5) * depth]
    parts += [box(0.04, depth, 0.03, x=x * 0.4 * width, z=seat - 0.045) for x in (-1, 1)]
    parts += [crossbar(width, depth / 2 + 0.02 + 0.1 * t, seat + 0.1 + 0.3 * t, 0.02, 0.07) for t in (0, 0.5, 1)]
    posts = [[x * 0.4 * width, depth / 2, seat - 0.04] for x in (-1, 1)]
    return join(parts, [beam(foot, np.add(foot, [0, 0.14, 0.46]), 0.04, 0.025) for foot in posts])


def hanging_egg(rng: Generator):
    """Return a basket seat that hangs from a curved stand."""
    radius, seat, height = rng.uniform(0.42, 0.52), rng.uniform(0.4, 0.5), rng.uniform(1.75, 2.0)
    wall = curved_wall(radius, seat, seat + 0.95, 0.03, opening_deg=120, flare=-0.35, drop=0.15)
    outside = [(0, seat - 0.02), (0.7 * radius, seat), (radius, seat + 0.14)]
    inside = [(0.97 * radius, seat + 0.15), (0.68 * radius, seat + 0.03), (0, seat + 0.02)]
    pad = cushion(1.15 * radius, 1.1 * radius, 0.12, z=seat + 0.01, corner=0.4 * radius, crown=0.03)
    bow = rounded([[0, 0.75, 0.03], [0, 0.85, 1.2], [0, 0.6, height], [0, 0, height]], rounds=3)
    foot = tube(at_height(circle(0.55, 28) + [0, 0.2], 0.03), 0.03, sections=8, loop=True)
    chain = rod([0, 0, height], [0, 0.5 * radius, seat + 0.9], 0.01)
    return join(wall, lathe([*outside, *inside]), pad, tube(bow, 0.03, sections=8), foot, chain)


def pouf(rng: Generator):
    """Return a pouf, hassock or padded stool whose top is a dome."""
    radius, height, dome = rng.uniform(0.19, 0.36), rng.uniform(0.28, 0.48), rng.uniform(0.015, 0.1)
    t = np.linspace(0, 1, 10)
    belly = radius * (1 + rng.uniform(0, 0.1) * np.sin(np.pi * t))
    foot = rng.choice([0.0, 0.1])
    side = list(zip(belly, foot + t * (height - dome - foot), strict=True))
    top = [(radius * np.cos(a), height - dome + dome * np.sin(a)) for a in np.linspace(0.15, np.pi / 2, 10)]
    legs = four_legs(1.2 * radius, 1.2 * radius, foot + 0.02, 0.035, taper=0.7) if foot else []
    body = lathe([(0, foot), *side, *top])
    return join(body.apply_scale([1, rng.uniform(0.75, 1.0), 1]), legs)


def bean_bag(rng: Generator):
    """Return a bean bag: a heap of a sack with a hollow that somebody has left in it."""
    width, height = rng.uniform(0.7, 1.05), rng.uniform(0.45, 0.8)
    folds = 1 + bumps(rng, np.linspace(-1, 1, 41)[:-1] * 2, 0.03)
    plan = circle(width / 2, 40) * folds[:, None]
    back = np.clip(np.sin(np.linspace(0, 2 * np.pi, 40, endpoint=False)), 0, 1)
    low = rng.uniform(0.3, 0.42)
    rings = [(0.8, 0), (0.98, 0.2 * low), (1.0, 0.5 * low), (0.88, 0.95 * low + 0.55 * (height - low) * back)]
    rings += [(0.72, low + (height - low) * back), (0.5, low + 0.35 * (height - low) * back)]
    return stacked(plan, [*rings, (0.3, low), (0.05, low - 0.015)])


def cube_seat(rng: Generator):
    """Return a square ottoman or a storage bench, its top flat, crowned or tufted."""
    width, height = rng.choice([rng.uniform(0.36, 0.5), rng.uniform(0.7, 1.2)]), rng.uniform(0.36, 0.48)
    depth, foot = rng.uniform(0.36, 0.5), rng.choice([0.0, 0.06, 0.14])
    body = cushion(width, depth, height - foot, z=foot, rounding=rng.uniform(0.005, 0.04), crown=rng.uniform(0, 0.025))
    tufts = []
    if rng.uniform() < 0.4:
        spots = [(x, y) for x in np.arange(-0.5 * width + 0.1, 0.5 * width - 0.05, 0.15) for y in (-0.1, 0.1)]
        tufts = [ellipsoid(0.16, 0.16, 0.035, x=x, y=y, z=height - 0.012, sections=12) for x, y in spots]
    return join(body, tufts, four_legs(0.9 * width, 0.86 * depth, foot + 0.01, 0.04) if foot else [])


def chaise(rng: Generator):
    """Return an upholstered seat for one to lie on, its back at one end, with loose pillows or none."""
    width, length, seat = rng.uniform(0.6, 0.8), rng.uniform(1.3, 1.7), rng.uniform(0.36, 0.44)
    body = cushion(width, length, seat - 0.1, z=0.1, rounding=0.04, crown=0.015)
    back = turn(cushion(width, 0.55, 0.16, rounding=0.05), "x", rng.uniform(55, 75))
    parts = [body, shift(back, 0, length / 2 - 0.1, seat + 0.2), four_legs(0.9 * width, 0.9 * length, 0.12, 0.05)]
    pillow = cushion(0.42, 0.42, 0.14, rounding=0.06, crown=0.02)
    return join(parts, [shift(turn(pillow, "x", 50), 0, 0.25 * length, seat + 0.18)] if rng.uniform() < 0.5 else [])


def bowl_chair(rng: Generator):
    """Return a round cushioned bowl, tilted, on a ring of cane or steel."""
    radius, tilt = rng.uniform(0.42, 0.56), rng.uniform(12, 30)
    t = np.linspace(0, 1, 8)
    inner = [(radius * s, 0.26 * s**2.2) for s in t[::-1]]
    outer = [(radius * s, 0.26 * s**2.2 - 0.1 + 0.06 * s) for s in t]
    bowl = shift(turn(lathe([*outer, *inner], sections=36), "x", tilt), 0, 0.05, 0.36)
    ring = [tube(at_height(circle(r, 24), z), 0.018, sections=6, loop=True) for r, z in ((0.4, 0.02), (0.24, 0.28))]
    bars = [rod([*(0.4 * d), 0.02], [*(0.24 * d), 0.28], 0.012) for d in circle(1.0, 8)]
    return join(bowl, ring, bars)


def low_stool(rng: Generator):
    """Return a low stool for a child, a milker or a step: 0.18 to 0.36 m high."""
    height, width = rng.uniform(0.18, 0.36), rng.uniform(0.24, 0.36)
    shape, thick = str(rng.choice(["round", "rectangle", "oval"])), rng.uniform(0.02, 0.04)
    depth = width * rng.uniform(0.65, 1.0)
    plan = outline(shape, width, depth)
    stand = stand_under(rng, ("panels", "splayed", "tripod", "four"), width, depth, height - thick)
    return join(prism(plan, thick, height - thick), stand)


def dished_stool(rng: Generator):
    """Return a stool whose seat is dished like a saddle or a tractor's, on a column, a tripod or castors."""
    width, seat, dish = rng.uniform(0.32, 0.44), rng.uniform(0.42, 0.75), rng.uniform(0.01, 0.05)
    across = np.linspace(-1, 1, 17)
    grid = np.empty((17, 17, 3))
    grid[..., 0], grid[..., 1] = across[None] * width / 2, across[:, None] * 0.42 * width
    fall = 1 - across[:, None] ** 2 * rng.uniform(0.3, 1.0)
    grid[..., 2] = seat + dish * (np.abs(across[None]) ** 2 - fall)
    stands = {
        "column": lambda: pedestal(seat - dish, 0.2, 0.025),
        "tripod": lambda: tripod(seat - dish, 0.22, 0.016),
        "star": lambda: star_base(0.24, seat - dish),
        "cross": lambda: cross_foot(seat - dish, 0.24, 0.025),
    }
    stand = stands[str(rng.choice(list(stands)))]()
    return join(sheet(grid, 0.02), stand, prism(circle(0.09, 16), 0.03, seat - dish - 0.035))


SEATS = [
    family("tub_seat", tub_seat, 4),
    family("floor_chair", floor_chair, 4),
    family("swing", swing, 2, bench=False),
    family("porch_swing", swing, bench=True),
    family("pouf", pouf, 4),
    family("bean_bag", bean_bag, 2),
    family("cube_seat", cube_seat, 3, also="table"),
    family("low_stool", low_stool, 2, also="table"),
    family("dished_stool", dished_stool, 2),
    *families(hanging_egg, bowl_chair, chaise),
]
