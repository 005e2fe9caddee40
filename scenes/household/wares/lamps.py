"""Lamps that stand on the floor, a table or a desk."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.random import Generator

from ..parts.legs import families, family
from ..parts.outlines import arc, at_height, circle, rectangle, rounded
from ..parts.solids import beam, box, ellipsoid, join, lathe, prism, sheet, shift, stacked, sweep, tube, turn
from .containers import flower_pot


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


def leaf(root: Iterable[float], bearing_deg: float, length: float, width: float, rise: float, droop: float):
    """Return one arched leaf from its root, metres; it rises and then droops along its bearing."""
    t = np.linspace(0, 1, 7)
    out = np.column_stack([t * length, np.zeros(7), rise * np.sin(np.pi * t * 0.6) - droop * t**2])
    half = width / 2 * np.sin(np.pi * (0.08 + 0.88 * t))
    grid = out[:, None, :] + half[:, None, None] * np.array([[0, -1, 0.2], [0, 0, 0], [0, 1, 0.2]])[None]
    return shift(turn(sheet(grid, 0.002), "z", bearing_deg), *root)


def potted_plant(rng: Generator):
    """Return a pot of arching leaves."""
    pot = flower_pot(rng)
    top, reach = pot.bounds[1, 2] * 0.85, rng.uniform(0.25, 0.45)
    leaves = []
    for bearing in np.arange(16) * 137.5:
        length, width = reach * rng.uniform(0.7, 1.1), rng.uniform(0.05, 0.1)
        rise, droop = reach * rng.uniform(0.6, 1.3), reach * rng.uniform(0.1, 0.5)
        leaves.append(leaf([0, 0, top], bearing, length, width, rise, droop))
    return join(pot, leaves)


def tree(rng: Generator):
    """Return a small tree in a pot: a trunk, and twigs with leaves along them."""
    pot, height = flower_pot(rng), rng.uniform(1.2, 1.9)
    parts = [pot, tube([[0, 0, 0.1], [0, 0, 0.5 * height], [0, 0, 0.9 * height]], 0.02, scale=[1.2, 1, 0.4])]
    for number in range(12):
        bearing, rise = number * 137.5, rng.uniform(0.05, 0.25)
        root = np.array([0, 0, height * rng.uniform(0.55, 0.88)])
        reach = rng.uniform(0.2, 0.38) * np.array([np.cos(np.radians(bearing)), np.sin(np.radians(bearing)), 0])
        parts.append(tube([root, root + reach + [0, 0, rise]], 0.006, sections=5))
        for along in (0.4, 0.7, 1.0):
            spot = root + along * (reach + [0, 0, rise])
            parts.append(leaf(spot, bearing + rng.uniform(-80, 80), 0.14, 0.07, 0.03, 0.04))
    return join(parts)


def cactus(rng: Generator):
    """Return a cactus with two arms in a pot."""
    pot, height = flower_pot(rng), rng.uniform(0.3, 0.55)
    low = pot.bounds[1, 2] * 0.8
    angles = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ribs = np.column_stack([np.cos(angles), np.sin(angles)]) * (0.045 * (1 + 0.12 * np.cos(10 * angles)))[:, None]
    steps = [(0.8, 0), (1, 0.3), (1, 0.8), (0.75, 0.95), (0.2, 1)]
    body = stacked(ribs, [(scale, low + z * height) for scale, z in steps])
    bases = ((0.1, low + 0.35 * height), (-0.09, low + 0.5 * height))
    arms = [tube(rounded([[0, 0, z], [x, 0, z], [x, 0, z + 0.14]]), 0.02) for x, z in bases]
    return join(pot, body, arms)


PLANTS = [family("potted_plant", potted_plant), family("tree", tree), family("cactus", cactus)]


def hammer(rng: Generator):
    """Return a hammer lying on its side."""
    length = rng.uniform(0.28, 0.34)
    face = tube([[-0.06, length / 2, 0.015], [0.03, length / 2, 0.015]], 0.014)
    peen = beam([0.03, length / 2, 0.015], [0.09, length / 2, 0.014], 0.026, 0.02, taper=0.3)
    grip = tube([[0, y, 0.015] for y in (-length / 2, 0.1, length / 2)], 0.014, scale=[1.1, 0.8, 0.8])
    return join(face, peen, grip)


def wrench(rng: Generator):
    """Return an open-ended wrench lying flat."""
    length = rng.uniform(0.18, 0.28)
    jaws = []
    for y in (-1, 1):
        hook = arc(0.02, -60, 240, 12) if y < 0 else arc(0.02, 120, 420, 12)
        path = at_height(hook + [0, y * (length / 2 + 0.014)], 0.005)
        jaws.append(sweep(path, rectangle(0.012, 0.01)))
    return join(jaws, box(0.02, length, 0.01))


def fork(rng: Generator):
    """Return a table fork."""
    length = rng.uniform(0.17, 0.2)
    path = [(-0.5, 0.003), (0, 0.005), (0.2, 0.01), (0.27, 0.006)]
    stem = sweep(rounded([[0, y * length, z] for y, z in path]), rectangle(0.014, 0.0024))
    bends = [(0.26, 0.006), (0.38, 0.003), (0.5, 0.007)]
    tines = [rounded([[x, y * length, z] for y, z in bends]) for x in np.linspace(-0.01, 0.01, 4)]
    tines = [tube(tine, 0.0013, sections=6) for tine in tines]
    return join(stem, box(0.023, 0.012, 0.0025, y=0.27 * length, z=0.0045), tines)


def flashlight(rng: Generator):
    """Return a flashlight lying down."""
    length = rng.uniform(0.14, 0.2)
    profile = [(0, 0), (0.014, 0), (0.014, 0.7 * length), (0.024, 0.8 * length), (0.024, length), (0, length)]
    return turn(lathe(profile, sections=20), "x", 90)


def drill(rng: Generator):
    """Return a cordless drill standing on its battery."""
    grip = beam([0, 0.04, 0.04], [0, 0.01, 0.16], 0.036, 0.05)
    motor = [(0, -0.09), (0.03, -0.09), (0.034, -0.02), (0.032, 0.06), (0.02, 0.08)]
    chuck = [(0.018, 0.12), (0.004, 0.125), (0.004, 0.19), (0, 0.19)]
    body = shift(turn(lathe(motor + chuck, sections=18), "x", 90), z=rng.uniform(0.175, 0.19))
    return join(box(0.075, 0.12, 0.05, y=0.03), grip, body)


TOOLS = families(hammer, wrench, fork, flashlight, drill)
