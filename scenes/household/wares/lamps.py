"""Lamps that stand on the floor, a table or a desk."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.family import family
from ..parts.outlines import circle
from ..parts.solids import beam, ellipsoid, join, lathe, prism, shift, tube, turn


def shade(low: float, high: float, bottom: float, top: float):
    """Return a lampshade: an open cone 3 mm thick, its radii at heights ``bottom`` and ``top``, metres."""
    rings = [(low, bottom), (high, top), (high - 0.003, top), (low - 0.003, bottom)]
    return lathe(rings, loop=True)


def floor_lamp(rng: Generator):
    """Return a floor lamp with a shade."""
    height, radius = rng.uniform(1.4, 1.75), rng.uniform(0.16, 0.24)
    post = lathe([(0, 0), (0.15, 0), (0.15, 0.02), (0.012, 0.035), (0.012, height - 0.05), (0, height - 0.05)])
    spokes = [beam([0, 0, height - 0.1], [x * (radius - 0.03), 0, height - 0.1], 0.006, 0.006) for x in (-1, 1)]
    bulb = ellipsoid(0.06, 0.06, 0.1, z=height - 0.06)
    return join(post, shade(radius, 0.75 * radius, height - 0.28, height), spokes, bulb)


def table_lamp(rng: Generator):
    """Return a table lamp: a bellied foot and a shade."""
    height, radius = rng.uniform(0.38, 0.6), rng.uniform(0.12, 0.17)
    belly = [(0.06, 0), (0.065, 0.02), (0.075, 0.3 * height), (0.03, 0.5 * height)]
    post = [(0.012, 0.55 * height), (0.012, 0.85 * height), (0, 0.85 * height)]
    foot = lathe([(0, 0), *belly, *post])
    spokes = [beam([0, 0, 0.8 * height], [x * (0.8 * radius), 0, 0.8 * height], 0.005, 0.005) for x in (-1, 1)]
    return join(foot, shade(radius, 0.65 * radius, 0.55 * height, height), spokes)


def desk_lamp(rng: Generator):
    """Return a jointed desk lamp."""
    lower, upper = rng.uniform(0.28, 0.36), rng.uniform(0.26, 0.34)
    knee = np.array([0, 0.45 * lower, 0.9 * lower])
    head = knee + [0, -0.85 * upper, 0.5 * upper]
    base = lathe([(0, 0), (0.085, 0), (0.085, 0.015), (0.02, 0.03), (0, 0.03)])
    cone = lathe([(0.07, -0.1), (0.03, 0), (0.027, 0), (0.067, -0.1)], sections=24, loop=True)
    lid = prism(circle(0.03, 24), 0.02, -0.01)
    arms = [tube([[0, 0, 0.02], knee], 0.008), tube([knee, head], 0.008)]
    return join(base, arms, shift(turn(join(cone, lid), "x", -25), *head))


LAMPS = [family("floor_lamp", floor_lamp), family("table_lamp", table_lamp), family("desk_lamp", desk_lamp)]
