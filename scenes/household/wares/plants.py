"""Plants in pots."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.random import Generator

from ..parts.family import family
from ..parts.outlines import rounded
from ..parts.solids import join, sheet, shift, stacked, tube, turn
from .containers import flower_pot


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
