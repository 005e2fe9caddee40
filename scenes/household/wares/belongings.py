"""Belongings: toys, fruit, books, clothes and bags, lying or standing as they are left."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.legs import families
from ..parts.outlines import arc, arch, at_height, rectangle, rounded, superellipse
from ..parts.solids import box, cushion, ellipsoid, join, lathe, loft, shift, stacked, sweep, tube, turn


def ball(rng: Generator):
    """Return a ball: from a tennis ball to a football."""
    size = rng.uniform(0.065, 0.24)
    return ellipsoid(size, size, size, sections=28)


def teddy_bear(rng: Generator):
    """Return a sitting teddy bear."""
    s = rng.uniform(0.26, 0.4)
    parts = [
        ellipsoid(0.5 * s, 0.42 * s, 0.55 * s, z=0.27 * s),
        ellipsoid(0.42 * s, 0.4 * s, 0.38 * s, z=0.68 * s),
        ellipsoid(0.18 * s, 0.16 * s, 0.14 * s, y=-0.2 * s, z=0.63 * s),
    ]
    for x in (-1, 1):
        parts.append(ellipsoid(0.15 * s, 0.08 * s, 0.15 * s, x=x * 0.16 * s, z=0.85 * s))
        leg = turn(ellipsoid(0.17 * s, 0.42 * s, 0.17 * s, y=-0.26 * s), "z", x * 25)
        arm = turn(ellipsoid(0.14 * s, 0.14 * s, 0.36 * s), "y", -x * 35)
        parts += [shift(leg, x * 0.12 * s, 0, 0.09 * s), shift(arm, x * 0.27 * s, -0.06 * s, 0.38 * s)]
    return join(parts)


def toy_car(rng: Generator):
    """Return a toy car."""
    length = rng.uniform(0.12, 0.3)
    width, wheel = 0.45 * length, 0.1 * length
    parts = [cushion(width, length, 0.2 * length, z=0.6 * wheel, rounding=0.02 * length)]
    cabin = 0.85 * width, 0.5 * length, 0.17 * length
    parts.append(cushion(*cabin, y=0.05 * length, z=0.24 * length, rounding=0.05 * length))
    disc = turn(lathe([(0, -0.25), (0.9, -0.25), (1, 0), (0.9, 0.25), (0, 0.25)], sections=20), "y", 90)
    disc.apply_scale(wheel)
    return join(parts, [shift(disc, x * width / 2, y * 0.3 * length, wheel) for x in (-1, 1) for y in (-1, 1)])


def apple(rng: Generator):
    """Return an apple or an orange-sized fruit with a dimple and a stalk."""
    radius = rng.uniform(0.032, 0.042)
    t = np.linspace(0.06, np.pi - 0.1, 14)
    bulge = radius * np.sin(t) * (1 + 0.12 * np.cos(t + 0.4))
    height = -radius * np.cos(t) * (1 - 0.35 * np.exp(-((np.sin(t) / 0.35) ** 2)))
    stalk = tube([[0, 0, 0.5 * radius], [0.004, 0, 0.95 * radius]], 0.0018, sections=6)
    return join(lathe(np.column_stack([bulge, height])), stalk)


def banana(rng: Generator):
    """Return a banana lying on its side."""
    bend = rng.uniform(0.09, 0.13)
    thickness = np.r_[0.3, np.linspace(0.75, 1, 5), 1, np.linspace(1, 0.7, 4), 0.35, 0.3]
    return tube(at_height(arc(bend, 200, 300, 12), 0.018), 0.018, scale=thickness)


def book(rng: Generator):
    """Return a closed book lying flat: two covers, a spine and the block of pages."""
    width, depth, thick = rng.uniform(0.12, 0.22), rng.uniform(0.18, 0.3), rng.uniform(0.015, 0.05)
    covers = [box(width, depth, 0.003, z=z) for z in (0, thick - 0.003)]
    pages = box(width - 0.01, depth - 0.012, thick - 0.004, x=-0.002, z=0.002)
    return join(covers, box(0.003, depth, thick, x=-width / 2), pages)


def _foot_rings(length: float, width: float, steps: list[tuple[float, ...]]) -> list[np.ndarray]:
    """Return outlines of a foot (heel to +y) scaled in length and width and moved back, one per step."""
    t = np.linspace(0, 2 * np.pi, 28, endpoint=False)
    plan = np.column_stack([0.5 * width * np.sin(t) * (1 - 0.16 * np.cos(t)), -0.5 * length * np.cos(t)])
    return [at_height(plan * [w, s] + [0, back * length], z) for s, w, back, z in steps]


def shoe(rng: Generator):
    """Return a low shoe: a sole, an upper, and an opening with an insole."""
    length = rng.uniform(0.24, 0.31)
    width, high = 0.37 * length, rng.uniform(0.08, 0.11)
    outside = [
        (1, 1, 0, 0), (1, 1, 0, 0.025), (0.97, 0.96, 0.01, 0.04), (0.8, 0.85, 0.09, 0.065), (0.5, 0.62, 0.23, high),
    ]
    inside = [(0.47, 0.52, 0.23, high), (0.7, 0.7, 0.11, 0.05), (0.75, 0.75, 0.08, 0.03)]
    return loft(_foot_rings(length, width, outside + inside))


def boot(rng: Generator):
    """Return a boot with an open shaft."""
    length, high = rng.uniform(0.26, 0.31), rng.uniform(0.2, 0.38)
    width = 0.37 * length
    outside = [
        (1, 1, 0, 0), (1, 1, 0, 0.03), (0.93, 0.95, 0.03, 0.06), (0.6, 0.8, 0.19, 0.11), (0.45, 0.85, 0.25, 0.16),
        (0.48, 0.95, 0.25, high),
    ]
    inside = [(0.44, 0.85, 0.25, high), (0.4, 0.75, 0.25, 0.16), (0.5, 0.7, 0.2, 0.08), (0.7, 0.8, 0.1, 0.035)]
    return loft(_foot_rings(length, width, outside + inside))


def hat(rng: Generator):
    """Return a brimmed hat standing on its brim."""
    brim, crown = rng.uniform(0.14, 0.2), rng.uniform(0.1, 0.14)
    inside = [(0, crown - 0.016), (0.03, crown - 0.016), (0.072, crown - 0.006), (0.091, 0.6 * crown)]
    rim = [(0.09, 0.002), (brim, 0.0), (brim, 0.004), (0.1, 0.006)]
    outside = [(0.095, 0.6 * crown), (0.075, crown), (0.03, crown - 0.012), (0, crown - 0.012)]
    return lathe(inside + rim + outside).apply_scale([0.85, 1, 1])


def handbag(rng: Generator):
    """Return a handbag with two loops."""
    width, depth, height = rng.uniform(0.26, 0.36), rng.uniform(0.1, 0.15), rng.uniform(0.2, 0.26)
    plan = superellipse(1, 1, 3.5, 28)
    steps = [(0.95, 0.95, 0), (1, 1, 0.03), (0.95, 0.8, 0.6 * height), (0.85, 0.25, height)]
    body = stacked(plan, [(width * w, depth * d, z) for w, d, z in steps])
    paths = [arch([[-0.22 * width, y, 0.9 * height], [-0.18 * width, y, height + 0.15]], 3) for y in (-0.015, 0.015)]
    return join(body, [tube(path, 0.006, sections=6) for path in paths])


def backpack(rng: Generator):
    """Return a packed backpack with a front pocket, straps behind."""
    width, depth, height = rng.uniform(0.28, 0.34), rng.uniform(0.14, 0.2), rng.uniform(0.4, 0.5)
    parts = [cushion(width, depth, height, rounding=0.07, corner=0.07, crown=0.03)]
    parts.append(cushion(0.7 * width, 0.09, 0.45 * height, y=-depth / 2 - 0.01, z=0.03, rounding=0.03))
    for x in (-0.3 * width, 0.3 * width):
        bends = [(-0.02, 0.9), (0.06, 0.7), (0.05, 0.3), (-0.02, 0.1)]
        path = rounded([[x, depth / 2 + y, z * height] for y, z in bends])
        parts.append(sweep(path, rectangle(0.05, 0.01)))
    grip = arch([[-0.05, 0, height - 0.04], [-0.04, 0, height + 0.03]])
    return join(parts, tube(grip, 0.008, sections=6))


def suitcase(rng: Generator):
    """Return a suitcase standing on its castors, its handle drawn out."""
    width, depth, height = rng.uniform(0.36, 0.5), rng.uniform(0.2, 0.3), rng.uniform(0.52, 0.72)
    parts = [cushion(width, depth, height, z=0.05, rounding=0.04, corner=0.05)]
    corners = [(x * 0.38 * width, y * 0.36 * depth) for x in (-1, 1) for y in (-1, 1)]
    parts += [ellipsoid(0.03, 0.05, 0.06, x, y, 0.03) for x, y in corners]
    pull = arch([[-0.1, depth / 2 - 0.03, height], [-0.1, depth / 2 - 0.03, height + 0.35]])
    return join(parts, tube(pull, 0.009, sections=6))


BELONGINGS = families(ball, teddy_bear, toy_car, apple, banana, book, shoe, boot, hat, handbag, backpack, suitcase)
