"""Chairs and benches of bars, schools, gardens, waiting rooms and bathrooms: of slats, cloth and wire."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.random import Generator

from ..household.parts.legs import crossed_tubes, families, family, four_legs, pedestal, stretchers
from ..household.parts.outlines import circle, outline, rounded, superellipse
from ..household.parts.solids import (
    beam,
    box,
    crossbar,
    cushion,
    hoop,
    join,
    prism,
    rail,
    rod,
    sheet,
    shift,
    stacked,
    tube,
    turn,
)


def bar_chair(rng: Generator):
    """Return a chair for a bar: four legs or a column, a back of bars or a panel, with or without arms."""
    width, depth, seat = rng.uniform(0.34, 0.48), rng.uniform(0.33, 0.44), rng.uniform(0.58, 0.82)
    rise, lean, legged = rng.uniform(0.15, 0.42), rng.uniform(0.02, 0.08), rng.uniform() < 0.6
    parts = [cushion(width, depth, 0.05, z=seat - 0.05, rounding=0.015, crown=rng.uniform(0, 0.012))]
    if legged:
        parts += four_legs(0.9 * width, 0.9 * depth, seat - 0.04, 0.035, splay=rng.uniform(0, 0.05))
        parts += stretchers(0.86 * width, 0.86 * depth, 0.35 * seat, 0.025)
    else:
        parts += pedestal(seat - 0.04, 0.21, 0.025)
        parts += [hoop(circle(0.17, 20), 0.35 * seat, 0.01), crossbar(0.34, 0, 0.35 * seat, 0.02, 0.015)]
    y = depth / 2 - 0.02
    posts = [[x * 0.42 * width, y, seat - 0.03] for x in (-1, 1)]
    parts += [beam(foot, np.add(foot, [0, lean, rise + 0.03]), 0.03, 0.022) for foot in posts]
    tall = rng.uniform(0.25, 0.8) * rise
    parts.append(beam([0, y + lean * (1 - tall / rise), seat + rise - tall], [0, y + lean, seat + rise], width, 0.02))
    if rng.uniform() < 0.35:
        parts += [box(0.04, 0.8 * depth, 0.025, x=x * width / 2, y=0.06, z=seat + 0.18) for x in (-1, 1)]
        parts += [box(0.03, 0.03, 0.24, x=x * width / 2, y=-0.25 * depth, z=seat - 0.05) for x in (-1, 1)]
    return join(parts)


def toilet(rng: Generator):
    """Return a toilet: a bowl with its lid down or open, and a cistern."""
    width, seat = rng.uniform(0.35, 0.4), rng.uniform(0.38, 0.44)
    plan = superellipse(width, 1.3 * width, 2.4, 36)
    rings = [(0.6, 0), (0.6, 0.5 * seat), (0.95, 0.85 * seat), (1, seat - 0.02), (1, seat)]
    inside = [(0.72, seat), (0.66, seat - 0.08), (0.3, seat - 0.2), (0.02, seat - 0.21)]
    lid = [(0.96, seat + 0.02), (0.02, seat + 0.022)]
    bowl = stacked(plan, [*rings, *(inside if rng.uniform() < 0.5 else lid)])
    neck = box(0.24, 0.2, seat - 0.03, y=0.6 * width)
    cistern = cushion(rng.uniform(0.36, 0.44), 0.18, 0.36, y=0.82 * width, z=seat - 0.04, rounding=0.015, corner=0.02)
    return join(bowl, neck, cistern)


def garden_bench(rng: Generator, *, back: bool):
    """Return a bench of slats on two panels, its seat level or hollow, with a leaning back or none."""
    width, seat, depth = rng.uniform(1.0, 1.9), rng.uniform(0.4, 0.48), rng.uniform(0.34, 0.5)
    count, thick, dish = int(rng.integers(3, 9)), rng.uniform(0.02, 0.05), rng.uniform(0, 0.018)
    pitch = depth / count
    spots = (np.arange(count) + 0.5) * pitch - depth / 2
    fall = dish * (1 - (2 * spots / depth) ** 2)
    gap = rng.uniform(0.006, 0.02)
    parts = [box(width, pitch - gap, thick, y=y, z=seat - thick - low) for y, low in zip(spots, fall, strict=True)]
    ends = [x * rng.uniform(0.3, 0.46) * width for x in (-1, 1)]
    parts += [box(0.07, 0.96 * depth, seat - thick + 0.001, x=x) for x in ends]
    if back:
        rise, lean = rng.uniform(0.3, 0.5), rng.uniform(0.06, 0.18)
        rungs = np.linspace(0.25, 1, int(rng.integers(2, 5)))
        parts += [crossbar(width, depth / 2 + lean * t, seat + rise * t - 0.04, 0.022, 0.08) for t in rungs]
        foot, end = (depth / 2 - 0.03, seat - 0.1), (depth / 2 + lean + 0.02, seat + rise)
        parts += [beam([x, *foot], [x, *end], 0.06, 0.03) for x in ends]
    return join(parts)


def sagging(
    width: float, front: Sequence[float], rear: Sequence[float], sag: float, thick: float = 0.004
) -> trimesh.Trimesh:
    """Return a cloth that hangs between a front and a rear bar, each (y, z), and sags in its middle; metres."""
    t, across = np.linspace(0, 1, 15), np.linspace(-1, 1, 5)
    line = np.outer(1 - t, front) + np.outer(t, rear)
    line[:, 1] -= 4 * sag * t * (1 - t)
    grid = np.empty((15, 5, 3))
    grid[..., 0], grid[..., 1], grid[..., 2] = across[None] * width / 2, line[:, :1], line[:, 1:]
    return sheet(grid, thick)


def slung_chair(rng: Generator, *, kind: str):
    """Return a chair of cloth: a director's, a deck chair, one for camping, or a stool for it."""
    width, depth = rng.uniform(0.44, 0.58), rng.uniform(0.36, 0.46)
    seat, high = rng.uniform(0.38, 0.46) if kind != "deck" else 0.34, rng.uniform(0.78, 0.9)
    half, bar = width / 2, 0.013
    if kind == "deck":
        cloth = sagging(width, [-0.6, seat], [0.45, high], rng.uniform(0.12, 0.22))
        rails = [rod([x * half, -0.6, seat], [x * half, 0.45, 0.0], bar) for x in (-1, 1)]
        rails += [rod([x * half, -0.45, 0.0], [x * half, 0.45, high], bar) for x in (-1, 1)]
        return join(cloth, rails, [rail(width, y, z, bar) for y, z in ((-0.6, seat), (0.45, high), (0.45, 0.013))])
    if kind == "stool":
        depth, seat = 0.36, rng.uniform(0.34, 0.44)
    cloth = turn(sagging(depth, [-half, seat], [half, seat], rng.uniform(0.02, 0.07)), "z", 90)
    legs = crossed_tubes((half, depth / 2), (-half, depth / 2), seat, 0.01, bar)
    ends = [(x * half, z) for x in (-1, 1) for z in (seat, 0.012)]
    bars = [rod([x, -depth / 2, z], [x, depth / 2, z], bar) for x, z in ends]
    if kind == "stool":
        return join(cloth, legs, bars)
    posts = [rod([x * half, depth / 2, seat], [x * half, depth / 2 + 0.06, high], bar) for x in (-1, 1)]
    arms = [box(0.05, depth + 0.06, 0.02, x=x * half, y=0.02, z=seat + 0.2) for x in (-1, 1)]
    arms += [rod([x * half, -depth / 2, seat], [x * half, -depth / 2, seat + 0.21], bar) for x in (-1, 1)]
    back = beam([0, depth / 2 + 0.025, seat + 0.18], [0, depth / 2 + 0.058, high], width, 0.005)
    return join(cloth, legs, bars, posts, arms, back)


def sloped_chair(rng: Generator):
    """Return a garden chair with broad arms, its seat of slats falling towards the back."""
    width, front, fall = rng.uniform(0.5, 0.6), rng.uniform(0.34, 0.42), rng.uniform(0.06, 0.14)
    slat = turn(box(width, 0.058, 0.02), "x", -np.degrees(fall / 0.5))
    parts = [shift(slat, 0, y, front - fall * (y + 0.24) / 0.46 - 0.02) for y in np.linspace(-0.24, 0.22, 7)]
    spread = np.linspace(-0.4, 0.4, 5) * width
    parts += [beam([x, 0.2, front - fall - 0.04], [1.15 * x, 0.48, front + 0.55], 0.09, 0.018) for x in spread]
    for x in (-1, 1):
        side = x * (width / 2 + 0.012)
        parts.append(box(0.03, 0.09, front + 0.2, x=side, y=-0.24))
        parts.append(beam([side, -0.26, front - 0.06], [side, 0.5, 0.03], 0.03, 0.08))
        parts.append(box(0.13, 0.68, 0.022, x=x * (width / 2 + 0.05), y=0.04, z=front + 0.19))
        parts.append(box(0.03, 0.05, front + 0.2, x=side, y=0.3))
    return join(parts, crossbar(1.25 * width, 0.36, front + 0.22, 0.02, 0.06))


def wire_chair(rng: Generator):
    """Return a chair whose seat and back are a net of wires or bands."""
    width, depth, seat = rng.uniform(0.42, 0.54), rng.uniform(0.4, 0.48), rng.uniform(0.42, 0.47)
    rise, lean, thick = rng.uniform(0.3, 0.42), rng.uniform(0.08, 0.16), rng.uniform(0.003, 0.006)
    pitch = rng.uniform(0.02, 0.035)
    bends = [(-depth / 2, seat), (0.45 * depth, seat - 0.02), (depth / 2 + lean, seat + rise)]
    spine = rounded([[0, y, z] for y, z in bends], rounds=3)
    wires = [tube(spine + [x, 0, 0], thick, sections=4) for x in np.arange(-width / 2, width / 2 + 0.001, pitch)]
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(spine, axis=0), axis=1))])
    steps = np.arange(0, along[-1], pitch * rng.uniform(1.0, 1.6))
    across = [[np.interp(s, along, spine[:, k]) for k in (1, 2)] for s in steps]
    wires += [rail(width, y, z, thick, 4) for y, z in across]
    legs = four_legs(0.8 * width, 0.75 * depth, seat - 0.005, 0.022, splay=0.04, round_bars=True)
    rails = [crossbar(0.84 * width, y * 0.32 * depth, seat - 0.015, 0.02, 0.02) for y in (-1, 1)]
    return join(wires, legs, rails)


def tablet_chair(rng: Generator):
    """Return a school chair with a board to write on at one arm."""
    width, depth, seat = rng.uniform(0.4, 0.46), rng.uniform(0.38, 0.44), rng.uniform(0.42, 0.46)
    legs = four_legs(0.9 * width, 0.9 * depth, seat - 0.015, 0.025, splay=0.03)
    back = beam([0, depth / 2, seat + 0.14], [0, depth / 2 + 0.06, seat + 0.38], width, 0.018)
    foot, end = (depth / 2 - 0.02, seat - 0.02), (depth / 2 + 0.06, seat + 0.37)
    posts = [beam([x * 0.4 * width, *foot], [x * 0.4 * width, *end], 0.025, 0.02) for x in (-1, 1)]
    board = prism(outline("oval", 0.3, rng.uniform(0.4, 0.55)), 0.015, seat + 0.24)
    x = width / 2 + 0.02
    arm = [box(0.03, 0.03, 0.27, x=x, y=-0.1, z=seat - 0.02), box(0.06, 0.2, 0.02, x=x - 0.04, y=-0.1, z=seat - 0.03)]
    return join(box(width, depth, 0.02, z=seat - 0.02), legs, back, posts, shift(board, x, -0.16), arm)


def row_of_seats(rng: Generator):
    """Return seats side by side on one beam, as in waiting rooms, or on a step, as in a stadium."""
    count, pitch, seat = int(rng.integers(2, 5)), rng.uniform(0.5, 0.58), rng.uniform(0.4, 0.46)
    shell = [box(0.45, 0.42, 0.03, z=seat - 0.03), beam([0, 0.2, seat - 0.02], [0, 0.3, seat + 0.4], 0.45, 0.025)]
    spots = (np.arange(count) - (count - 1) / 2) * pitch
    rail = crossbar(count * pitch, 0.02, seat - 0.06, 0.08, 0.07)
    ends = (-0.35 * count * pitch, 0.35 * count * pitch)
    feet = [[box(0.06, 0.5, 0.04, x=x), box(0.06, 0.06, seat - 0.06, x=x, y=0.02)] for x in ends]
    return join([shift(join(shell), x) for x in spots], rail, feet)


def modern_armchair(rng: Generator):
    """Return an armchair with a thin frame and two loose cushions."""
    width, depth, seat = rng.uniform(0.62, 0.85), rng.uniform(0.66, 0.82), rng.uniform(0.36, 0.44)
    arm, thick = rng.uniform(0.52, 0.64), rng.uniform(0.1, 0.18)
    parts = [cushion(width - 0.1, depth - 0.14, thick, y=-0.05, z=seat - thick, crown=rng.uniform(0, 0.02))]
    back = turn(cushion(width - 0.1, 0.48, 0.14, rounding=0.05), "x", rng.uniform(68, 80))
    parts += [shift(back, 0, depth / 2 - 0.12, seat + 0.2), box(width - 0.04, depth - 0.1, 0.05, z=seat - thick - 0.04)]
    for x in (-1, 1):
        side = x * width / 2
        parts.append(box(0.045, depth, 0.035, x=side, z=arm - 0.035))
        parts += [box(0.045, 0.045, arm, x=side, y=y * depth) for y in (-0.42, 0.42)]
        parts.append(box(0.045, 0.9 * depth, 0.04, x=side, z=seat - thick - 0.035))
    return join(parts)


def high_chair(rng: Generator):
    """Return a high chair for a small child, without its tray."""
    width, seat = rng.uniform(0.32, 0.38), rng.uniform(0.5, 0.6)
    parts = [box(width, 0.3, 0.02, z=seat - 0.02), four_legs(0.95 * width, 0.3, seat - 0.01, 0.035, splay=0.09)]
    parts.append(beam([0, 0.14, seat], [0, 0.18, seat + 0.34], width, 0.018))
    parts += [box(0.02, 0.26, 0.14, x=x * width / 2, z=seat - 0.02) for x in (-1, 1)]
    rest = [box(0.03, 0.3, 0.03, x=x * 0.42 * width, y=-0.2, z=0.4 * seat) for x in (-1, 1)]
    return join(parts, box(0.8 * width, 0.16, 0.02, y=-0.24, z=0.4 * seat), rest)


CHAIRS = [
    family("bar_chair", bar_chair, 3),
    family("toilet", toilet, 2),
    family("garden_bench", garden_bench, 2, back=True),
    family("backless_bench", garden_bench, 2, back=False, also="table"),
    *[family(f"{kind}_sling_chair", slung_chair, kind=kind) for kind in ("director", "deck", "stool")],
    family("wire_chair", wire_chair, 2),
    family("modern_armchair", modern_armchair, 2),
    *families(sloped_chair, tablet_chair, row_of_seats, high_chair),
]
