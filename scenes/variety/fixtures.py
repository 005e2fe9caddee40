"""Lamps, machines, tanks, cribs, pools, cases and basins: hollow or level, and for none of the three."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..household.parts.legs import families, family, four_legs
from ..household.parts.outlines import arch, at_height, circle, outline, rectangle, rounded, rounded_rectangle
from ..household.parts.solids import (
    box,
    crossbar,
    cushion,
    ellipsoid,
    hoop,
    join,
    lathe,
    prism,
    rail,
    rod,
    shift,
    stacked,
    tube,
    turn,
)
from .tops import border, tripod


def lamp(rng: Generator, *, kind: str):
    """Return a lamp: a bowl that shines upwards, several shades on arms, a globe, or a shade on a tripod."""
    height, wide = rng.uniform(0.35, 0.6) if kind == "globe" else rng.uniform(1.3, 1.85), rng.uniform(0.1, 0.24)
    foot = [lathe([(0, 0), (0.14, 0), (0.14, 0.015), (0.012, 0.03), (0.012, height - 0.05), (0, height - 0.05)])]
    outside, inside = [(0.01, -0.06), (0.6 * wide, -0.03), (wide, 0.04)], [(0.97 * wide, 0.04), (0.57 * wide, -0.02)]
    bowl = lathe([*outside, *inside, (0.01, -0.05)])
    shade = lathe([(wide, -0.2), (0.6 * wide, 0), (0.58 * wide, 0), (0.98 * wide, -0.2)], loop=True)
    spokes = crossbar(1.3 * wide, 0, -0.03, 0.008, 0.008)
    if kind == "uplight":
        return join(foot, shift(bowl, z=height))
    if kind == "globe":
        return join(foot, ellipsoid(2 * wide, 2 * wide, 2 * wide, z=height + 0.4 * wide))
    if kind == "tripod":
        post = rod([0, 0, height - 0.2], [0, 0, height], 0.012, 10)
        return join(tripod(height - 0.15, 0.3, 0.014), shift(join(shade, spokes), z=height), post)
    small = join(bowl).apply_scale(0.6) if rng.uniform() < 0.5 else join(shade, spokes).apply_scale(0.6)
    reach = rng.uniform(0.18, 0.35)
    ends = [reach * np.array([np.cos(a), np.sin(a)]) for a in np.radians([0, 120, 240])]
    bends = [rounded([[0, 0, 0.8 * height], [*(0.7 * e), 0.85 * height], [*e, height]], 2) for e in ends]
    arms = [tube(path, 0.008, sections=6) for path in bends]
    return join(foot, arms, [shift(small, *e, height) for e in ends])


def coffee_machine(rng: Generator):
    """Return an espresso machine: a body, a head over a drip tray with a slatted grid, and cups' shelf on top."""
    width, depth, height = rng.uniform(0.18, 0.36), rng.uniform(0.28, 0.4), rng.uniform(0.28, 0.42)
    grid = [box(width - 0.03, 0.006, 0.012, y=y, z=0.045) for y in np.arange(-depth / 2 + 0.02, -0.03, 0.012)]
    parts = [box(width, depth, 0.045), grid, box(width, 0.5 * depth, height, y=0.25 * depth)]
    parts.append(box(width, depth, 0.3 * height, z=0.7 * height))
    head = lathe([(0, 0.55 * height), (0.03, 0.55 * height), (0.035, 0.71 * height), (0, 0.71 * height)], sections=16)
    lever = rod([0, -0.3 * depth, 0.6 * height], [0, -0.3 * depth - 0.16, 0.58 * height], 0.012, 10)
    edge = border(rectangle(width, depth) * 0.97, rng.uniform(0.005, 0.03), 0.006, height - 0.002)
    return join(parts, shift(head, y=-0.3 * depth), lever, edge)


def toaster(rng: Generator):
    """Return a toaster, a rice cooker or a bread box on a kitchen counter."""
    width, depth, height = rng.uniform(0.25, 0.4), rng.uniform(0.16, 0.28), rng.uniform(0.16, 0.26)
    body = cushion(width, depth, height, rounding=rng.uniform(0.02, 0.07), corner=0.04)
    slots = [box(0.6 * width, 0.012, 0.01, y=y * 0.2 * depth, z=height) for y in (-1, 1)]
    return join(body, slots, box(0.02, 0.03, 0.03, x=width / 2, z=0.6 * height))


def aquarium(rng: Generator):
    """Return a tank of glass, with gravel and water in it or empty, with a stand or none."""
    width, height = rng.uniform(0.35, 1.1), rng.uniform(0.26, 0.5)
    depth, wall = rng.uniform(0.24, 0.45), rng.uniform(0.005, 0.01)
    low = rng.choice([0.0, rng.uniform(0.5, 0.75)])
    parts = [box(width, depth, 0.012, z=low), border(rectangle(width, depth), height, wall, low)]
    level = rng.choice([0.012, rng.uniform(0.03, 0.07), rng.uniform(0.7, 0.92) * height])
    parts.append(box(width - wall, depth - wall, level, z=low))
    if level < 0.1:
        parts += [ellipsoid(0.1, 0.08, 0.09, x=x * width, z=low + level) for x in rng.uniform(-0.35, 0.35, 3)]
    if low:
        parts.append(box(width, depth, 0.03, z=low - 0.03))
        parts += [box(0.03, depth, low - 0.02, x=x * (width / 2 - 0.015)) for x in (-1, 1)]
    return join(parts)


def barred_bed(rng: Generator, *, kind: str):
    """Return a crib with its mattress, a playpen, or a cage: bars on four sides."""
    width, depth = rng.uniform(1.1, 1.35), rng.uniform(0.6, 0.75)
    if kind != "crib":
        width, depth = rng.uniform(0.6, 1.1), rng.uniform(0.55, 1.1)
    height, low = rng.uniform(0.6, 1.0), rng.uniform(0.03, 0.4)
    pitch, bar = rng.uniform(0.05, 0.09), rng.uniform(0.004, 0.012)
    xs, ys = np.arange(-width / 2, width / 2 + 0.001, pitch), np.arange(-depth / 2, depth / 2 + 0.001, pitch)
    feet = [(x, y) for x in xs for y in (-depth / 2, depth / 2)] + [(x, y) for y in ys for x in (-width / 2, width / 2)]
    parts = [tube([[*at, 0.6 * low], [*at, height - 0.01]], bar, sections=5) for at in feet]
    parts += [hoop(rectangle(width, depth), z, bar + 0.006) for z in (0.6 * low + 0.005, height - 0.01)]
    parts += [four_legs(width + 0.04, depth + 0.04, height, 0.04), box(width, depth, 0.02, z=0.6 * low)]
    mattress = cushion(width - 0.03, depth - 0.03, 0.1, z=0.6 * low + 0.015, rounding=0.02)
    lid = [box(width, 0.01, 0.01, y=y, z=height - 0.015) for y in np.linspace(-depth / 2, depth / 2, 14)]
    return join(parts, {"crib": [mattress], "playpen": [], "cage": lid}[kind])


def pool(rng: Generator):
    """Return a paddling pool or a sand pit, empty or filled to below its rim."""
    width, height, thick = rng.uniform(0.9, 1.8), rng.uniform(0.16, 0.4), rng.uniform(0.02, 0.09)
    plan = outline(str(rng.choice(["round", "octagon", "rounded"])), width, width * rng.uniform(0.7, 1.0))
    level = rng.choice([0.015, rng.uniform(0.3, 0.85) * height])
    levels = [] if rng.uniform() < 0.5 else np.arange(thick / 2, height, thick)
    rings = [hoop(plan * 0.98, z, thick / 2) for z in levels]
    return join(prism(0.97 * plan, level), border(plan, height, thick, 0.0), rings)


def crate(rng: Generator):
    """Return a box to carry: of slats, or of boards with holes or a bar to hold, open or with its lid."""
    width, depth, height = rng.uniform(0.3, 0.6), rng.uniform(0.22, 0.42), rng.uniform(0.14, 0.38)
    plan, count = rectangle(width, depth), int(rng.integers(2, 5))
    bands = [border(plan, 0.72 * height / count, 0.01, z) for z in np.arange(count) * height / count]
    corners = [(x * (width / 2 - 0.02), y * (depth / 2 - 0.02)) for x in (-1, 1) for y in (-1, 1)]
    posts = [box(0.025, 0.025, height - 0.01, x=x, y=y) for x, y in corners]
    grip = arch([[-width / 2 + 0.01, 0, height - 0.05], [-width / 2 + 0.01, 0, height + 0.12]], 2)
    lid = box(width + 0.01, depth + 0.01, 0.015, z=height - 0.012)
    extra = [[tube(grip, 0.012, sections=8)], [lid], []][int(rng.integers(3))]
    ears = [box(0.02, 0.12, 0.03, x=x * (width / 2 + 0.008), z=0.8 * height) for x in (-1, 1)]
    return join(box(width, depth, 0.012), bands, posts, extra, ears)


def chest(rng: Generator):
    """Return a closed case: a toolbox with its bar, a trunk with a domed lid, or a cool box with a bow."""
    width, depth, height = rng.uniform(0.3, 0.7), rng.uniform(0.2, 0.4), rng.uniform(0.16, 0.4)
    lid = cushion(1.02 * width, 1.02 * depth, 0.08, z=height - 0.01, crown=rng.uniform(0.0, 0.05), rounding=0.02)
    bow = arch([[-0.4 * width, 0, height], [-0.35 * width, 0, height + 0.14]], 2)
    ears = [box(0.03, 0.14, 0.03, x=x * width / 2, z=0.7 * height) for x in (-1, 1)]
    return join(box(width, depth, height), lid, [tube(bow, 0.012, sections=8)] if rng.uniform() < 0.6 else ears)


def basin(rng: Generator):
    """Return a sink or a deep laundry trough, on a cabinet or a foot, with its tap."""
    width, depth, height = rng.uniform(0.4, 0.9), rng.uniform(0.34, 0.55), rng.uniform(0.78, 0.92)
    plan, deep = rounded_rectangle(width, depth, 0.08), rng.uniform(0.1, 0.28)
    rings = [(0.7, height - deep - 0.04), (0.95, height - 0.4 * deep), (1, height), (0.88, height)]
    rings += [(0.8, height - 0.6 * deep), (0.4, height - deep), (0.01, height - deep - 0.004)]
    on_floor = rng.uniform() < 0.5
    size = (0.9 * width, 0.85 * depth, height - deep - 0.03) if on_floor else (0.16, 0.14, height - deep - 0.02)
    bends = [(0.42, height - 0.02), (0.42, height + 0.2), (0.1, height + 0.15)]
    tap = rounded([[0, y * depth, z] for y, z in bends], 2)
    return join(stacked(plan, rings), box(*size), tube(tap, 0.012))


def grill(rng: Generator):
    """Return a barbecue: a bowl or a box with a grate on legs."""
    height, wide = rng.uniform(0.6, 0.85), rng.uniform(0.22, 0.34)
    outside = [(0.02, height - 0.2), (0.7 * wide, height - 0.14), (wide, height)]
    bowl = lathe([*outside, (wide - 0.006, height), (0.68 * wide, height - 0.13), (0.02, height - 0.19)])
    places = np.arange(-0.9 * wide, 0.91 * wide, 0.025)
    ends = [(x, np.sqrt(wide**2 - x**2) - 0.01) for x in places]
    bars = [rod([x, -y, height - 0.02], [x, y, height - 0.02], 0.003, 4) for x, y in ends]
    legs = [rod([*(1.3 * wide * d), 0], [*(0.6 * wide * d), height - 0.12], 0.012) for d in circle(1.0, 3)]
    return join(bowl, bars, legs)


def barrow(rng: Generator):
    """Return a wheelbarrow."""
    width, length, height = rng.uniform(0.4, 0.55), rng.uniform(0.6, 0.9), rng.uniform(0.32, 0.5)
    rings = [(0.6, 0.25), (1, 0.25 + height), (0.98, 0.25 + height), (0.58, 0.27), (0.01, 0.27)]
    tray = stacked(rectangle(width, length), rings)
    wheel = shift(turn(prism(circle(0.16, 24), 0.05), "y", 90), -0.025, -0.55 * length, 0.16)
    bends = [[(x * 0.06, -0.55, 0.16), (x * 0.25 * width, 0, 0.26), (x * 0.5 * width, 0.9, 0.5)] for x in (-1, 1)]
    shafts = [tube([[x, y * length, z] for x, y, z in path], 0.016, sections=8) for path in bends]
    feet = [(x * 0.3 * width, x * 0.4 * width) for x in (-1, 1)]
    legs = [rod([top, 0.3 * length, 0.3], [foot, 0.35 * length, 0], 0.015, 8) for top, foot in feet]
    return join(tray, wheel, shafts, legs, rail(0.16, -0.55 * length, 0.16, 0.012, 10))


def ball_or_log(rng: Generator):
    """Return what is round and lies: an exercise ball, a rolled mat, a log, a bolster."""
    width = rng.uniform(0.12, 0.7)
    if rng.uniform() < 0.5:
        return ellipsoid(width, width, rng.uniform(0.6, 1.0) * width, sections=28)
    return turn(prism(circle(0.3 * width, 28), rng.uniform(0.4, 1.2)), "x", 90)


def pet_bed(rng: Generator):
    """Return a bed for a dog or a cat: a cushion within a low bolster, or a basket."""
    width, height = rng.uniform(0.45, 0.95), rng.uniform(0.1, 0.22)
    plan = outline(str(rng.choice(["round", "oval", "rounded"])), width, 0.75 * width)
    bolster = tube(at_height(plan * 0.88, height / 2), height / 2, sections=10, loop=True)
    return join(bolster, prism(0.85 * plan, rng.uniform(0.03, 0.5 * height)))


FIXTURES = [
    *[family(f"{kind}_lamp", lamp, 2, kind=kind) for kind in ("uplight", "branched")],
    *[family(f"{kind}_lamp", lamp, kind=kind) for kind in ("globe", "tripod")],
    family("aquarium", aquarium, 3),
    family("espresso_machine", coffee_machine, 2),
    *[family(kind, barred_bed, kind=kind) for kind in ("crib", "playpen", "cage")],
    *[family(build.__name__, build, 2) for build in (pool, crate, chest, basin)],
    *families(toaster, grill, barrow, ball_or_log, pet_bed),
]
