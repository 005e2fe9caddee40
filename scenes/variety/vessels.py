"""What is as hollow as a cup and not drunk from: necked, lidded, filled, or as large as a tub."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..household.parts.legs import families, family
from ..household.parts.outlines import circle, outline, rounded
from ..household.parts.solids import beam, box, ellipsoid, join, lathe, rod, shift, tube, turn
from .cups import ear, hollow, plan_of, profile


def necked(rng: Generator):
    """Return an open bottle, jar or jug whose neck is narrow."""
    height, wide = rng.uniform(0.12, 0.4), rng.uniform(0.3, 0.7)
    belly = 0.5 * wide * height
    neck = rng.uniform(0.008, 0.02)
    high = rng.uniform(0.5, 0.8)
    t = np.linspace(0, 1, 9)
    sides = [(0.8 * belly, 0), *zip(belly * (0.85 + 0.15 * np.sin(np.pi * t)), (0.02 + high * t) * height, strict=True)]
    sides += [(0.5 * belly + 0.5 * neck, (high + 0.1) * height), (neck, (high + 0.18) * height), (neck, height)]
    return hollow(plan_of(rng), np.array(sides), 0.003, 0.006)


def lidded_pot(rng: Generator):
    """Return a pot, a sugar bowl or a casserole with its lid on and two ears."""
    radius, height = rng.uniform(0.045, 0.15), rng.uniform(0.07, 0.16)
    sides = profile(rng, 0.9 * radius, radius, height)
    rim = sides[-1, 0]
    lid = [(0, -0.004), (rim + 0.003, -0.004), (rim + 0.002, 0.003), (0.5 * rim, 0.02)]
    knob = [(0.012, 0.024), (0.016, 0.045), (0, 0.046)]
    cover = lathe([(r, height + z) for r, z in [*lid, *knob]])
    one = ear(rng, sides)
    return join(hollow(circle(1.0, 36), sides, 0.004, 0.005), cover, one, turn(one, "z", 180))


def ashtray(rng: Generator):
    """Return a low heavy dish with notches in its rim."""
    radius, height = rng.uniform(0.05, 0.09), rng.uniform(0.025, 0.045)
    plan = outline(str(rng.choice(["round", "octagon", "rectangle"])), 2.0, 2.0)
    wall = rng.uniform(0.012, 0.02)
    dish = hollow(plan, np.array([(0.9 * radius, 0), (radius, 0.4 * height), (radius, height)]), wall, 0.008)
    rest, places = box(0.012, 0.004, 0.006, z=height - 0.001), []
    for angle in (45, 135, 225, 315):
        x, y = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        places.append(shift(turn(rest, "z", angle), 0.86 * radius * x, 0.86 * radius * y))
    return join(dish, places)


def candle(rng: Generator):
    """Return a candle: in a glass that it fills, on a stick, or several on one stand."""
    style = str(rng.choice(["glass", "stick", "branched"]))
    wide, height = rng.uniform(0.03, 0.045), rng.uniform(0.07, 0.12)
    if style == "glass":
        wick = rod([0, 0, 0.7 * height], [0, 0, 0.85 * height], 0.0015, 5)
        glass = np.array([(wide, 0), (wide, height)])
        return join(hollow(circle(1.0, 36), glass, 0.003, rng.uniform(0.65, 0.85) * height), wick)
    tall = rng.uniform(0.12, 0.3)
    foot, top = [(0, 0), (0.05, 0), (0.045, 0.01), (0.009, 0.02)], [(0.022, tall + 0.01), (0.022, tall + 0.018)]
    stick = lathe([*foot, (0.009, tall), *top, (0, tall + 0.018)])
    wax = lathe([(0, tall), (0.011, tall), (0.011, tall + 0.15), (0, tall + 0.155)], sections=12)
    if style == "stick":
        return join(stick, wax)
    bends = [[[0, 0, 0.6 * tall], [x * 0.1, 0, 0.6 * tall], [x * 0.1, 0, tall]] for x in (-1, 1)]
    arms = [tube(rounded(path, 2), 0.007, sections=6) for path in bends]
    return join(stick, wax, arms, [shift(wax, x * 0.1) for x in (-1, 1)])


def fruit_bowl(rng: Generator):
    """Return a large dish with fruit in it."""
    reach, rise = rng.uniform(0.11, 0.18), rng.uniform(0.05, 0.09)
    dish = hollow(circle(1.0, 40), np.array([(0.4 * reach, 0), (0.8 * reach, 0.4 * rise), (reach, rise)]), 0.005, 0.008)
    fruits = zip(rng.uniform(-0.5, 0.5, (7, 2)) * reach, rng.uniform(0.055, 0.09, 7), strict=True)
    return join(dish, [ellipsoid(s, s, s, x=x, y=y, z=0.012 + 0.5 * s, sections=14) for (x, y), s in fruits])


def bird_bath(rng: Generator):
    """Return a wide shallow basin on a column, in a garden."""
    height, reach, t = rng.uniform(0.5, 0.95), rng.uniform(0.2, 0.32), np.linspace(0, 1, 6)
    foot, dip = rng.uniform(0.13, 0.2), rng.uniform(0.03, 0.07)
    column = [(0, 0), (foot, 0), (foot, 0.04), (0.06, 0.12), (0.05, height - 0.15), (0.1, height - 0.09)]
    inside = [(reach * (0.9 - 0.89 * s), height - dip * np.sin(np.pi * (0.1 + 0.4 * s))) for s in t]
    return lathe([*column, (reach, height), (reach - 0.02, height), *inside, (0, height - dip)], sections=36)


def planter(rng: Generator, *, plants: bool):
    """Return a trough or tub of soil, or empty; with low plants or none."""
    width, height = rng.uniform(0.25, 0.9), rng.uniform(0.18, 0.6)
    shape = str(rng.choice(["round", "rectangle", "octagon"]))
    plan = outline(shape, 2.0, 2.0 if shape != "rectangle" else rng.uniform(0.5, 1.0) * 2.0)
    half = width / 2 if shape == "rectangle" else min(width, 0.5) / 2
    sides = np.array([(rng.uniform(0.7, 1.0) * half, 0), (half, height)])
    soil = rng.choice([0.02, rng.uniform(0.6, 0.92) * height])
    pot, foot = hollow(plan, sides, rng.uniform(0.008, 0.03), soil), max(soil, 0.5 * height)
    spots = rng.uniform(-0.5, 0.5, (8, 2)) * half if plants else []
    return join(pot, [ellipsoid(0.12, 0.12, rng.uniform(0.1, 0.25), x=x, y=y, z=foot) for x, y in spots])


def umbrella_stand(rng: Generator):
    """Return a tall narrow tub, with umbrellas or empty."""
    radius, height = rng.uniform(0.09, 0.14), rng.uniform(0.42, 0.62)
    tub = hollow(plan_of(rng), np.array([(0.9 * radius, 0), (radius, height)]), 0.006, 0.012)
    lean = [[[-0.5 * radius * x, 0, 0.02], [0.8 * radius * x, 0.02, 0.85]] for x in (-1, 1)]
    return join(tub, [tube(ends, 0.018, scale=[0.4, 1.0], sections=8) for ends in lean] if rng.uniform() < 0.6 else [])


def tub(rng: Generator, *, low: float, high: float, handles: bool = True):
    """Return a pail, a laundry tub, a bin or a crate: wide and open, its height low to high metres."""
    height = rng.uniform(low, high)
    half = rng.uniform(0.11, 0.3)
    shape = str(rng.choice(["round", "rectangle", "rounded", "oval"]))
    plan = outline(shape, 2.0, 2.0 if shape == "round" else rng.uniform(1.2, 2.0))
    sides = np.array([(rng.uniform(0.72, 1.0) * half, 0), (half, height)])
    parts = [hollow(plan, sides, rng.uniform(0.003, 0.012), rng.uniform(0.004, 0.02))]
    if handles and rng.uniform() < 0.6:
        bow = rounded([[-0.06, 0, 0], [-0.05, 0.05, 0.02], [0.05, 0.05, 0.02], [0.06, 0, 0]], 2)
        deep = half * np.abs(plan[:, 1]).max()
        parts += [turn(shift(tube(bow, 0.007, sections=6), 0, deep - 0.006, height - 0.02), "z", a) for a in (0, 180)]
    return join(parts)


def can(rng: Generator):
    """Return a watering can: a can with a bridge over it and a long spout."""
    radius, height = rng.uniform(0.07, 0.12), rng.uniform(0.14, 0.24)
    body = hollow(circle(1.0, 32), np.array([(radius, 0), (0.9 * radius, height)]), 0.003, 0.005)
    spout = tube([[0.9 * radius, 0, 0.2 * height], [2.6 * radius, 0, 1.1 * height]], 0.012, scale=[1.4, 0.9])
    bends = [(-0.9, 0.3), (-1.5, 1.1), (0, 1.5), (0.85, 1)]
    bridge = rounded([[x * radius, 0, z * height] for x, z in bends], 2)
    half = beam([0, -0.5 * radius, height], [0, 0.5 * radius, height], 0.9 * radius, 0.004)
    return join(body, spout, tube(bridge, 0.008, sections=6), shift(half, 0.42 * radius))


HOLLOW = [
    family("necked_vessel", necked, 4),
    family("lidded_pot", lidded_pot, 3),
    family("candle", candle, 3),
    *families(ashtray, fruit_bowl, umbrella_stand, can),
    family("bird_bath", bird_bath, 2),
    family("planter", planter, 2, plants=False),
    family("planted_trough", planter, 2, plants=True),
    family("pail", tub, 2, low=0.2, high=0.34),
    family("bin", tub, 2, low=0.35, high=0.75, handles=False),
    family("wash_tub", tub, low=0.22, high=0.4),
]
