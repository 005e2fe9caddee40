"""Upholstered and outdoor seats: armchairs, sofas, benches, loungers, rockers."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.legs import families, family, four_legs, stretchers
from ..parts.outlines import arc, at_height
from ..parts.solids import beam, box, crossbar, cushion, join, lathe, sheet, shift, tube, turn


def sofa(rng: Generator, *, seats: int = 2, arms: str = "box", feet: float = 0.08, soft: bool = True):
    """Return an upholstered seat for one or more: base, seat and back cushions, arms."""
    place = rng.uniform(0.55, 0.68)
    arm = rng.uniform(0.12, 0.24) if arms != "none" else 0.0
    inner, depth = place * seats, rng.uniform(0.78, 0.95)
    seat, high = rng.uniform(0.38, 0.46), rng.uniform(0.72, 0.92)
    back, width = rng.uniform(0.16, 0.24), inner + 2 * arm
    thick = rng.uniform(0.12, 0.18)
    body = box(width - 0.04, depth - 0.04, seat - thick - feet + 0.01, z=feet)
    parts = [body, four_legs(width - 0.12, depth - 0.12, feet + 0.01, 0.05)]
    parts += _seat_cushions(seats, place, depth - back, seat, thick, y=-back / 2, crown=0.02 if soft else 0.0)
    parts += _back_cushions(seats, place, depth, seat - 0.03, high)
    parts += _sofa_arms(arms, width, arm, depth, feet, rng.uniform(0.54, 0.66))
    return join(parts)


def _seat_cushions(seats: int, place: float, depth: float, seat: float, thick: float, y: float, crown: float):
    """Return one cushion for each place side by side, their tops at ``seat``, metres."""
    size, shape = (place - 0.004, depth, thick), {"crown": crown, "rounding": 0.035, "corner": 0.04}
    return [cushion(*size, x, y, seat - thick, **shape) for x in (np.arange(seats) - (seats - 1) / 2) * place]


def _back_cushions(seats: int, place: float, depth: float, low: float, high: float):
    """Return one leaning pad for each place, and the frame behind them."""
    pad = turn(cushion(place - 0.01, high - low, 0.14, crown=0.02, rounding=0.05, corner=0.06), "x", 78)
    spots = (np.arange(seats) - (seats - 1) / 2) * place
    pads = [shift(pad, x, depth / 2 - 0.08, (low + high) / 2) for x in spots]
    return [*pads, cushion(place * seats, 0.1, high - 0.12, y=depth / 2 - 0.05, z=0.08, rounding=0.03)]


def _sofa_arms(style: str, width: float, arm: float, depth: float, feet: float, height: float):
    """Return both arms: boxes, soft cushions, or scrolls with a round top."""
    parts = []
    for x in (-1, 1) if style != "none" else ():
        middle = x * (width - arm) / 2
        if style == "scroll":
            level = height - arm / 2
            roll = tube([[middle, -depth / 2, level], [middle, depth / 2 - 0.02, level]], 0.55 * arm, sections=16)
            parts += [roll, box(0.8 * arm, depth - 0.02, level - feet, x=middle, z=feet)]
        else:
            rounding = 0.015 if style == "box" else 0.06
            parts.append(cushion(arm, depth, height - feet, x=middle, z=feet, rounding=rounding, corner=0.05))
    return parts


def corner_sofa(rng: Generator, *, ottoman: bool = False):
    """Return an L-shaped sofa with a return or a chaise at its right end, towards -y."""
    place, depth = rng.uniform(0.6, 0.7), rng.uniform(0.85, 0.95)
    seat, high, thick, back = rng.uniform(0.38, 0.44), rng.uniform(0.74, 0.86), 0.16, 0.2
    inner, reach = 3 * place, rng.uniform(0.65, 0.95)
    parts = [box(inner, depth - 0.04, seat - thick - 0.05, z=0.06), four_legs(inner - 0.1, depth - 0.12, 0.08, 0.05)]
    parts += _seat_cushions(3, place, depth - back, seat, thick, y=-back / 2, crown=0.015)
    parts += _back_cushions(3, place, depth, seat - 0.03, high)
    x, y = inner / 2 - place / 2, -(depth + reach) / 2
    parts.append(box(place, reach, seat - thick - 0.05, x=x, y=y, z=0.06))
    parts.append(box(0.05, 0.05, 0.07, x=x, y=y - reach / 2 + 0.05))
    parts.append(cushion(place, reach, thick, x=x, y=y, z=seat - thick, crown=0.015))
    parts.append(cushion(0.18, depth, 0.52, x=-inner / 2 - 0.09, z=0.06))
    if not ottoman:
        size = 0.18, depth + reach, high - 0.06
        parts.append(cushion(*size, x=inner / 2 + 0.09, y=-reach / 2, z=0.06, rounding=0.05))
    return join(parts)


def wing_chair(rng: Generator):
    """Return a high-backed armchair with wings on both sides of the head."""
    width, depth = rng.uniform(0.7, 0.78), rng.uniform(0.75, 0.85)
    seat, high = rng.uniform(0.42, 0.46), rng.uniform(1.0, 1.15)
    parts = [four_legs(width - 0.08, depth - 0.1, 0.16, 0.05, taper=0.6)]
    parts.append(box(width - 0.04, depth - 0.06, seat - 0.28, z=0.15))
    parts.append(cushion(width - 0.24, depth - 0.2, 0.15, y=-0.08, z=seat - 0.15, crown=0.025))
    back = turn(cushion(width - 0.2, high - seat + 0.1, 0.14, crown=0.02, rounding=0.05), "x", 80)
    parts.append(shift(back, 0, depth / 2 - 0.06, (seat + high) / 2 - 0.04))
    for x in (-(width - 0.12) / 2, (width - 0.12) / 2):
        parts.append(cushion(0.12, depth - 0.05, 0.5, x=x, z=0.15, rounding=0.05))
        parts.append(cushion(0.09, 0.26, high - 0.62, x=x, y=depth / 2 - 0.12, z=0.6, rounding=0.04))
    return join(parts)


def tub_chair(rng: Generator):
    """Return a club chair whose arms and back are one curved wall."""
    radius, seat, high = rng.uniform(0.29, 0.33), rng.uniform(0.4, 0.45), rng.uniform(0.68, 0.78)
    rim = arc(radius, -35, 215, 24)
    drop = np.clip((-rim[:, 1] / radius + 0.3) / 0.9, 0, 1) * 0.12
    rows = [
        at_height(rim * s, np.maximum(z - (z > seat) * drop, 0.06))
        for s, z in ((0.95, 0.06), (1.0, seat), (1.03, high))
    ]
    wall = sheet(np.stack(rows), 0.1)
    base = cushion(1.96 * radius, 1.9 * radius, seat - 0.06, y=-0.03, z=0.06, corner=0.8 * radius, crown=0.02)
    return join(wall, base, four_legs(1.2 * radius, 1.2 * radius, 0.08, 0.05))


def ottoman(rng: Generator):
    """Return a round upholstered pouf."""
    radius, height = rng.uniform(0.24, 0.32), rng.uniform(0.38, 0.45)
    edge = 0.05
    side = [(0, 0), (radius - edge, 0), (radius, edge), (radius, height - 1.6 * edge)]
    top = [(radius - 0.4 * edge, height - 0.6 * edge), (0.6 * radius, height - 0.1 * edge), (0, height)]
    return lathe(side + top)


def bench(rng: Generator):
    """Return a bench without a back."""
    width, depth, height = rng.uniform(0.9, 1.5), rng.uniform(0.32, 0.4), rng.uniform(0.42, 0.48)
    under = height - 0.035
    legs = four_legs(width - 0.1, depth - 0.04, under, 0.05)
    return join(box(width, depth, 0.035, z=under), legs, stretchers(width - 0.15, depth - 0.09, 0.15, 0.03))


def park_bench(rng: Generator):
    """Return a slatted bench with a back and armrests."""
    width, seat = rng.uniform(1.2, 1.7), rng.uniform(0.42, 0.46)
    parts = [box(width, 0.07, 0.025, y=y, z=seat - 0.025) for y in np.linspace(-0.2, 0.2, 6)]
    parts += [crossbar(width, 0.25 + 0.1 * t, seat + 0.08 + 0.36 * t, 0.02, 0.08) for t in np.linspace(0, 1, 4)]
    for x in (-0.46 * width, 0.46 * width):
        parts.append(beam([x, -0.22, 0], [x, -0.2, seat + 0.2], 0.05, 0.05))
        parts.append(beam([x, 0.24, 0], [x, 0.25, seat], 0.05, 0.05))
        parts.append(beam([x, 0.25, seat - 0.02], [x, 0.37, seat + 0.48], 0.05, 0.04))
        parts += [box(0.05, 0.46, 0.05, x=x, z=seat - 0.075), box(0.06, 0.52, 0.03, x=x, y=0.02, z=seat + 0.2)]
    return join(parts)


def pew(rng: Generator):
    """Return a church pew: a plank seat between two end boards, a straight back."""
    width, seat, high = rng.uniform(1.4, 2.0), rng.uniform(0.43, 0.46), rng.uniform(0.85, 0.95)
    ends = [box(0.04, 0.5, 0.62, x=x * width / 2) for x in (-1, 1)]
    posts = [box(0.04, 0.1, high, x=x * width / 2, y=0.22) for x in (-1, 1)]
    back = beam([0, 0.2, seat - 0.1], [0, 0.25, high], width, 0.025)
    plank = box(width, 0.4, 0.03, y=-0.02, z=seat - 0.03)
    return join(ends, posts, back, plank, box(width, 0.025, 0.14, y=0.1, z=seat - 0.17))


def rocking_chair(rng: Generator):
    """Return a slatted armchair on two curved runners."""
    width, depth, seat, high = rng.uniform(0.52, 0.58), 0.48, rng.uniform(0.42, 0.45), rng.uniform(1.0, 1.12)
    curve = arc(1.1, -112, -64, 12)
    runner = np.column_stack([np.zeros(len(curve)), curve[:, 0], curve[:, 1] + 1.115])
    parts = [box(width, depth, 0.03, z=seat - 0.03)]
    for x in (-0.46 * width, 0.46 * width):
        parts.append(tube(runner + [x, 0, 0], 0.018, sections=8))
        parts.append(beam([x, -0.21, 0.03], [x, -0.2, seat + 0.21], 0.035, 0.035))
        parts.append(beam([x, 0.21, 0.03], [x, 0.22, seat], 0.035, 0.035))
        parts.append(beam([x, 0.22, seat - 0.05], [x, 0.4, high], 0.035, 0.03))
        parts.append(beam([x, -0.25, seat + 0.21], [x, 0.29, seat + 0.21], 0.06, 0.025))
    spread = np.linspace(-0.36, 0.36, 6) * width
    parts += [beam([x, 0.22, seat - 0.02], [x, 0.39, high - 0.04], 0.035, 0.012) for x in spread]
    return join(parts, crossbar(width, 0.395, high - 0.04, 0.025, 0.08))


def lounger(rng: Generator):
    """Return a deck chair for lying back: slats on a long low frame, the head end raised."""
    width, raise_deg = rng.uniform(0.58, 0.68), rng.uniform(28, 50)
    low, long, head = rng.uniform(0.3, 0.36), rng.uniform(1.1, 1.25), rng.uniform(0.65, 0.75)
    lift = np.array([0, np.cos(np.radians(raise_deg)), np.sin(np.radians(raise_deg))])
    hinge = np.array([0, long / 2, low])
    level = np.linspace(-long / 2 + 0.05, long / 2 - 0.05, 12)
    raised = np.linspace(0.06, head - 0.04, 7)
    parts = [box(width - 0.06, 0.075, 0.02, y=y, z=low - 0.02) for y in level]
    parts += [beam(hinge + lift * (t - 0.04), hinge + lift * (t + 0.04), width - 0.06, 0.02) for t in raised]
    for x in (-width / 2 + 0.03, width / 2 - 0.03):
        parts.append(box(0.04, long + 0.5, 0.05, x=x, y=0.25, z=low - 0.06))
        parts.append(beam(hinge + [x, 0, -0.03], hinge + [x, 0, -0.03] + lift * head, 0.04, 0.035))
        parts.append(beam([x, hinge[1] + 0.3, low - 0.03], hinge + [x, 0, 0] + lift * 0.5, 0.025, 0.025))
        parts += [box(0.05, 0.05, low - 0.02, x=x, y=y) for y in (-long / 2 + 0.12, long / 2 + 0.3)]
    return join(parts)


SOFAS = [
    *[family("armchair", sofa, seats=1, arms=arms) for arms in ("box", "soft")],
    family("armchair", sofa, seats=1, arms="scroll", feet=0.05),
    *families(wing_chair, tub_chair),
    family("sofa", sofa, seats=2, arms="box"),
    family("sofa", sofa, seats=3, arms="soft"),
    family("sofa", sofa, seats=3, arms="scroll", feet=0.04),
    family("sofa", sofa, seats=2, arms="none", feet=0.14, soft=False),
    *[family("corner_sofa", corner_sofa, ottoman=ottoman) for ottoman in (False, True)],
    family("ottoman", ottoman, also="table"),
    family("bench", bench, also="table"),
    *families(park_bench, pew, rocking_chair, lounger),
]
