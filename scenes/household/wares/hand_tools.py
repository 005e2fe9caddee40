"""Tools, lying or standing as they are left."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.family import families
from ..parts.outlines import arc, at_height, rectangle, rounded
from ..parts.solids import beam, box, join, lathe, shift, sweep, tube, turn


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
