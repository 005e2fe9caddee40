"""Chairs: a seat for one with a back, the front to -y."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator
from trimesh import Trimesh

from ..parts.legs import families, family, four_legs, star_base, stretchers
from ..parts.outlines import arch, circle, rectangle, rounded
from ..parts.solids import beam, box, crossbar, cushion, hoop, join, prism, rail, sheet, shift, sweep, tube, turn


def back_posts(width: float, low: float, high: float, y: float, lean: float, thickness: float):
    """Return the two uprights of a back, from (y, low) leaning back by ``lean`` to ``high``, metres."""
    return [beam([x, y, low], [x, y + lean, high], thickness, thickness, taper=0.8) for x in (-width / 2, width / 2)]


def back_fill(rng: Generator, style: str, width: float, low: float, high: float, y: float, lean: float):
    """Return the parts between the uprights of a back: slats, rungs, a panel, a splat, spindles or a cross."""

    def at(z: float) -> float:
        return y + lean * (z - low) / (high - low)

    def rung(z: float, height: float):
        return crossbar(width, at(z), z, 0.02, height)

    def upright(x: float, breadth: float, foot: float):
        return beam([x, at(foot), foot], [x, at(high - 0.03), high - 0.03], breadth, 0.015)

    def diagonal(side: int):
        foot, end = low + 0.12, high - 0.04
        return beam([-side * 0.46 * width, at(foot), foot], [side * 0.46 * width, at(end), end], 0.018, 0.035)

    tall = high - low
    spread = np.linspace(-0.36, 0.36, int(rng.integers(4, 7))) * width
    fills = {
        "ladder": lambda: [rung(low + tall * t, 0.06) for t in np.linspace(0.3, 0.95, int(rng.integers(3, 5)))],
        "slats": lambda: [
            rung(high - 0.03, 0.07), rung(low + 0.15, 0.04), [upright(x, 0.03, low + 0.15) for x in spread],
        ],
        "panel": lambda: [sweep([[0, at(low + 0.12), low + 0.12], [0, at(high), high]], rectangle(width, 0.024))],
        "splat": lambda: [rung(high - 0.03, 0.07), upright(0, 0.14, low - 0.02)],
        "spindles": lambda: [
            rung(high - 0.02, 0.05),
            [tube([[x, at(low - 0.02), low - 0.02], [x, at(high), high - 0.02]], 0.007, sections=6) for x in spread],
        ],
        "cross": lambda: [rung(high - 0.03, 0.06), rung(low + 0.12, 0.04), *map(diagonal, (-1, 1))],
        "bands": lambda: [rung(high - 0.05, 0.1), rung(low + 0.4 * tall, 0.05)],
    }
    return fills[style]()


def dining_chair(
    rng: Generator, *, back: str = "slats", legs: str = "straight", arms: bool = False, pad: bool = False,
    scale: float = 1.0,
):
    """Return a wooden chair with a four-legged base and a leaning back."""
    width, depth = rng.uniform(0.4, 0.48) + 0.08 * arms, rng.uniform(0.39, 0.45)
    seat, high, lean = rng.uniform(0.43, 0.48), rng.uniform(0.8, 1.02), rng.uniform(0.04, 0.12)
    bar, thick = rng.uniform(0.032, 0.045), 0.025
    surface = box(width, depth, thick, z=seat - thick)
    if pad:
        surface = cushion(width, depth, 0.06, z=seat - 0.06, crown=0.012)
    size, splayed = (width - 0.01, depth - 0.01, seat - thick), legs == "splayed"
    taper = 1.0 if legs == "straight" else 0.65
    base = four_legs(*size, bar, splay=0.04 if splayed else 0.0, taper=taper, round_bars=splayed)
    y = depth / 2 - bar / 2
    parts = [surface, base, back_posts(width - bar, seat - 0.05, high, y, lean, bar)]
    parts += back_fill(rng, back, width - bar, seat, high, y, lean)
    if legs == "straight":
        parts += stretchers(width - bar, depth - bar, 0.3 * seat, 0.02)
    if arms:
        parts += armrests(width, depth, seat, rng.uniform(0.19, 0.24), bar)
    return join(parts).apply_scale(scale)


def armrests(width: float, depth: float, seat: float, rise: float, bar: float):
    """Return a pair of wooden armrests on posts at the sides of a seat."""
    parts = []
    for x in (-(width - bar) / 2, (width - bar) / 2):
        parts.append(beam([x, -depth / 2 + bar, seat - 0.04], [x, -depth / 2 + bar, seat + rise], 0.03, 0.03))
        parts.append(beam([x, -depth / 2, seat + rise], [x, depth / 2 + 0.03, seat + rise], 0.05, 0.025))
    return parts


def shell_grid(width: float, depth: float, rise: float, dish: float, lean: float) -> np.ndarray:
    """Return a moulded seat-and-back surface (K, N, 3), metres: its seat near z = 0, its sides curled up."""
    across = np.linspace(-1, 1, 13)
    seat = [[0, -depth / 2, -0.015], [0, -0.1 * depth, 0], [0, 0.42 * depth, 0]]
    spine = rounded([*seat, [0, 0.5 * depth, 0.1], [0, 0.5 * depth + lean, rise]])
    upper = np.clip(spine[:, 2] / rise, 0, 1)
    half = width / 2 * (1 - 0.12 * upper)
    grid = np.repeat(spine[:, None, :], len(across), axis=1)
    grid[..., 0] = half[:, None] * across
    curl = np.abs(across) ** 2.5 * dish
    grid[..., 2] += curl * (1 - upper[:, None])
    grid[..., 1] -= 1.4 * curl * upper[:, None]
    return grid


def shell_chair(rng: Generator, *, stand: str = "splayed"):
    """Return a moulded shell on splayed legs, on a tube frame, or on a central star."""
    width, depth, seat = rng.uniform(0.44, 0.52), rng.uniform(0.42, 0.47), rng.uniform(0.42, 0.46)
    grid = shell_grid(width, depth, rng.uniform(0.33, 0.42), rng.uniform(0.02, 0.06), rng.uniform(0.06, 0.12))
    shell = shift(sheet(grid, 0.008), z=seat)
    stands = {
        "splayed": lambda: four_legs(0.26, 0.24, seat - 0.006, 0.03, splay=0.11, taper=0.6, round_bars=True),
        "tubes": lambda: four_legs(0.36, 0.28, seat - 0.006, 0.022, splay=0.05, round_bars=True),
    }
    reach = 0.105 if stand == "splayed" else 0.129  # of the legs' tops in y
    rails = [beam([-0.17, y, seat - 0.015], [0.17, y, seat - 0.015], 0.03, 0.02) for y in (-reach, reach)]
    return join(shell, rails, stands[stand]())


def cantilever_chair(rng: Generator):
    """Return a chair on one bent tube that has no rear legs."""
    width, depth, seat = rng.uniform(0.44, 0.5), rng.uniform(0.42, 0.48), rng.uniform(0.44, 0.47)
    rear, front, low = depth / 2, -depth / 2, 0.012
    bends = [(rear + 0.08, seat + 0.42), (rear, seat), (front, seat), (front, low), (rear, low)]
    side = rounded([[0, y, z] for y, z in bends], rounds=2)
    frame = [tube(side + [x * width / 2, 0, 0], 0.0125, sections=8) for x in (-1, 1)]
    frame.append(tube([[-width / 2, depth / 2, 0.012], [width / 2, depth / 2, 0.012]], 0.0125, sections=8))
    seat_pad = cushion(width, depth - 0.03, 0.035, z=seat - 0.005, rounding=0.01)
    back = beam([0, depth / 2 + 0.04, seat + 0.2], [0, depth / 2 + 0.075, seat + 0.41], width, 0.02)
    return join(frame, seat_pad, back)


def bistro_chair(rng: Generator):
    """Return a bentwood chair: a round seat, a hoop for a back, four turned legs."""
    radius, seat, high = rng.uniform(0.19, 0.22), rng.uniform(0.44, 0.47), rng.uniform(0.84, 0.92)
    disc = prism(circle(radius, 32), 0.03, seat - 0.03)
    ring = hoop(circle(0.99 * radius + 0.009, 20), 0.2, 0.009)
    legs = four_legs(1.4 * radius, 1.4 * radius, seat - 0.02, 0.03, splay=0.04, taper=0.75, round_bars=True)
    low, y, hoops = seat - 0.02, 0.7 * radius, []
    for width, top in ((0.92, high), (0.5, high - 0.1)):
        x = 0.66 * width * radius
        path = arch([[-x, y, low], [-x, y + 0.08, top - 0.1], [-0.6 * x, y + 0.1, top]], 3)
        hoops.append(tube(path, 0.012, sections=8))
    return join(disc, ring, legs, hoops)


def folding_chair(rng: Generator):
    """Return a folding chair: two crossed tube frames, a flat seat and a band for the back."""
    width, depth, seat = rng.uniform(0.42, 0.46), rng.uniform(0.38, 0.42), rng.uniform(0.43, 0.46)
    parts = [cushion(width - 0.05, depth, 0.02, z=seat - 0.02, rounding=0.006)]
    for x in (-width / 2, width / 2):
        parts.append(tube([[x, -depth / 2 - 0.03, 0.01], [x, depth / 2 + 0.1, seat + 0.38]], 0.011, sections=8))
        inner = [[0.9 * x, depth / 2 + 0.06, 0.01], [0.9 * x, -depth / 2 + 0.04, seat - 0.01]]
        parts.append(tube(inner, 0.011, sections=8))
        parts.append(beam([0.86 * x, -depth / 2, seat - 0.012], [x, depth / 2 - 0.14, seat - 0.012], 0.02, 0.02))
    parts += [rail(width, y, z, 0.009) for y, z in ((depth / 2 + 0.05, 0.02), (-depth / 2 - 0.012, 0.05))]
    top = depth / 2 + 0.07
    return join(parts, beam([0, top - 0.02, seat + 0.2], [0, top + 0.03, seat + 0.38], width, 0.015))


def office_chair(rng: Generator, *, arms: bool = True, headrest: bool = False):
    """Return a swivel chair on a star base with castors."""
    width, depth, seat = rng.uniform(0.46, 0.52), rng.uniform(0.44, 0.5), rng.uniform(0.44, 0.52)
    tall = rng.uniform(0.4, 0.65)
    parts = [star_base(rng.uniform(0.28, 0.33), seat - 0.06)]
    parts.append(cushion(width, depth, 0.085, z=seat - 0.085, crown=0.015, corner=0.12, rounding=0.035))
    pad = cushion(width - 0.02, tall, 0.07, corner=0.1, rounding=0.03)
    parts.append(_upright(pad, depth / 2 + 0.03, seat + 0.08 + tall / 2, lean_deg=8))
    parts.append(box(0.12, 0.3, 0.03, y=depth / 2 - 0.12, z=seat - 0.1))
    parts.append(beam([0, depth / 2 + 0.03, seat - 0.09], [0, depth / 2 + 0.06, seat + 0.35], 0.07, 0.025))
    if headrest:
        parts.append(_upright(cushion(0.28, 0.16, 0.06, corner=0.05), depth / 2 + 0.06, seat + tall + 0.16, lean_deg=5))
    for x in (-1, 1) if arms else ():
        side = x * (width / 2 + 0.03)
        parts.append(cushion(0.07, 0.26, 0.03, x=side, y=0.02, z=seat + 0.19, rounding=0.01))
        parts.append(beam([side, 0.05, seat - 0.06], [side, 0.05, seat + 0.2], 0.03, 0.06))
        parts.append(beam([0, 0.05, seat - 0.075], [side, 0.05, seat - 0.05], 0.05, 0.02))
    return join(parts)


def _upright(pad: Trimesh, y: float, z: float, lean_deg: float):
    """Return a pad that lay flat, stood up as a back whose middle is at (0, y, z), leaning back."""
    return shift(turn(pad, "x", 90 - lean_deg), 0, y + 0.03, z)


CHAIRS = [
    *[family("dining_chair", dining_chair, back=back) for back in ("slats", "ladder")],
    family("dining_chair", dining_chair, back="panel", legs="tapered"),
    family("dining_chair", dining_chair, back="splat", legs="tapered", pad=True),
    family("dining_chair", dining_chair, back="spindles", legs="splayed"),
    family("dining_chair", dining_chair, back="cross", legs="tapered", pad=True),
    family("dining_chair", dining_chair, back="bands", legs="splayed"),
    family("arm_chair", dining_chair, back="panel", legs="tapered", arms=True, pad=True),
    family("arm_chair", dining_chair, back="slats", arms=True),
    family("child_chair", dining_chair, back="bands", scale=0.68),
    *[family("shell_chair", shell_chair, stand=stand) for stand in ("splayed", "tubes")],
    *families(cantilever_chair, bistro_chair, folding_chair),
    *[family("office_chair", office_chair, arms=arms) for arms in (True, False)],
    family("office_chair", office_chair, arms=True, headrest=True),
]
