"""Cups of other makes: fluted, faceted, waisted, on stems and rings, with bows and squares for handles."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.random import Generator

from ..household.parts.legs import family
from ..household.parts.outlines import circle, rounded
from ..household.parts.solids import join, lathe, stacked, tube, turn

WAVES = {"plain": (0, 0.0), "fluted": (12, 0.03), "lobed": (6, 0.06), "faceted": (0, 0.0)}


def hollow(plan: np.ndarray, sides: np.ndarray, wall: float, floor: float) -> trimesh.Trimesh:
    """Return a vessel over a plan (N, 2) of radius one.

    Parameters
    ----------
    sides : array_like (K, 2)
        Radius and height of its outside, metres, from the foot to the rim; heights ascend.
    wall, floor : float
        Thickness of the wall, and height of the inner floor, metres.
    """
    sides = np.asarray(sides, float)
    heights = np.concatenate([[floor], sides[sides[:, 1] > floor + 1e-3, 1]])
    radii = np.maximum(np.interp(heights, sides[:, 1], sides[:, 0]) - wall, 1e-3)
    inside = list(zip(radii, heights, strict=True))[::-1]
    return stacked(plan, [(1e-3, sides[0, 1]), *map(tuple, sides), *inside, (1e-3, floor)])


def profile(rng: Generator, foot: float, rim: float, height: float) -> np.ndarray:
    """Return the outside of a vessel (K, 2): straight, bellied, waisted, flared at its lip, or round below."""
    t = np.linspace(0, 1, 12)
    straight = foot + (rim - foot) * t
    style = str(rng.choice(["straight", "belly", "waist", "lip", "round"]))
    radius = {
        "straight": lambda: straight,
        "belly": lambda: straight + rng.uniform(0.05, 0.22) * rim * np.sin(np.pi * t),
        "waist": lambda: straight - rng.uniform(0.05, 0.14) * rim * np.sin(np.pi * t),
        "lip": lambda: straight + 0.12 * rim * np.clip(t - 0.8, 0, 1) / 0.2,
        "round": lambda: foot + (rim - foot) * np.sqrt(1 - (1 - t) ** 2),
    }[style]()
    return np.column_stack([radius, t * height])


def plan_of(rng: Generator) -> np.ndarray:
    """Return the plan of a vessel (N, 2), of radius one: round, fluted, lobed, or with some flat sides."""
    style = str(rng.choice(list(WAVES), p=[0.6, 0.15, 0.1, 0.15]))
    if style == "faceted":
        return circle(1.0, int(rng.integers(6, 11)))
    count, depth = WAVES[style]
    plan = circle(1.0, 48)
    return plan * (1 + depth * np.cos(count * np.arctan2(plan[:, 1], plan[:, 0])))[:, None]


def ear(rng: Generator, sides: np.ndarray):
    """Return a handle for an outside (K, 2): a bow, a square of straight bars, or a ring near the rim."""
    height, style = sides[-1, 1], str(rng.choice(["bow", "square", "ring"]))
    low, high = (0.2, 0.85) if style != "ring" else (0.5, 0.85)
    ends = [(np.interp(z * height, sides[:, 1], sides[:, 0]) - 0.002, z * height) for z in (high, low)]
    reach, thick = rng.uniform(0.018, 0.045), rng.uniform(0.003, 0.007)
    outer = max(ends[0][0], ends[1][0]) + reach
    path = [[ends[0][0], 0, ends[0][1]], [outer, 0, ends[0][1]], [outer, 0, ends[1][1]], [ends[1][0], 0, ends[1][1]]]
    return tube(path if style == "square" else rounded(path, 3), thick, sections=6)


def cup(rng: Generator, *, least: float, most: float, handles: int = 0, wide: tuple[float, float] = (0.32, 0.6)):
    """Return a cup from least to most high, its rim's radius a share of that; metres."""
    height = rng.uniform(least, most)
    rim = height * rng.uniform(*wide)
    sides = profile(rng, rim * rng.uniform(0.55, 1.0), rim, height)
    wall = rng.uniform(0.0015, 0.006)
    parts = [hollow(plan_of(rng), sides, wall, rng.uniform(0.003, 0.012))]
    if handles:
        one = ear(rng, sides)
        parts += [turn(one, "z", 180 * number) for number in range(handles)]
    return join(parts)


def stemmed_cup(rng: Generator):
    """Return a cup on a stem or a foot: a chalice, a coupe or a glass for ice."""
    rim, bowl, stem = rng.uniform(0.032, 0.055), rng.uniform(0.05, 0.12), rng.uniform(0.02, 0.11)
    thick, foot, t = rng.uniform(0.004, 0.012), rim * rng.uniform(0.7, 1.0), np.linspace(0.06, 1, 10)
    belly = rim * np.minimum(1, t ** rng.uniform(0.2, 0.6)) * (1 + rng.uniform(-0.05, 0.2) * np.sin(np.pi * t))
    sides = [(foot, 0), (foot, 0.004), (thick, 0.012), (thick, stem), *zip(belly, stem + t * bowl, strict=True)]
    return hollow(circle(1.0, 40), np.array(sides), rng.uniform(0.0015, 0.004), stem + 0.008)


def coarse_cup(rng: Generator):
    """Return a cup of few faces whose wall is a single surface, as in games."""
    height = rng.uniform(0.08, 0.14)
    rim = height * rng.uniform(0.3, 0.45)
    foot, sections = rim * rng.uniform(0.6, 1.0), int(rng.integers(7, 13))
    body = lathe([(0, 0), (foot, 0), (rim, height)], sections=sections, capped=False)
    loop = [[0.9 * rim, 0, 0.8 * height], [1.8 * rim, 0, 0.7 * height], [0.9 * foot, 0, 0.25 * height]]
    return join(body, tube(loop, 0.005, sections=5)) if rng.uniform() < 0.6 else body


def jar_mug(rng: Generator):
    """Return a jar with a thread that is drunk from, with a handle."""
    radius, height = rng.uniform(0.034, 0.043), rng.uniform(0.11, 0.14)
    sides = [(0.9 * radius, 0), (radius, 0.008), (radius, 0.74 * height), (0.84 * radius, 0.84 * height)]
    sides += [(0.88 * radius, 0.88 * height), (0.84 * radius, 0.92 * height), (0.85 * radius, height)]
    return join(hollow(circle(1.0, 40), np.array(sides), 0.003, 0.006), ear(rng, np.array(sides)))


def footed_cup(rng: Generator):
    """Return a bowl-shaped tea cup on a ring, without a handle."""
    height = rng.uniform(0.048, 0.085)
    rim = rng.uniform(0.038, 0.058)
    t = np.linspace(0, 1, 10)
    ring = [(0.45 * rim, 0), (0.45 * rim, 0.006)]
    sides = [*ring, *zip(0.5 * rim + 0.5 * rim * t**0.6, 0.008 + t * (height - 0.008), strict=True)]
    return hollow(plan_of(rng), np.array(sides), rng.uniform(0.002, 0.004), 0.012)


CUPS = [
    family("handled_cup", cup, 5, handles=1, least=0.07, most=0.13),
    family("two_handled_cup", cup, handles=2, least=0.07, most=0.1),
    family("handleless_cup", cup, 4, least=0.07, most=0.13),
    family("tall_glass", cup, 3, least=0.13, most=0.21, wide=(0.19, 0.27)),
    family("small_cup", cup, 2, least=0.045, most=0.065, wide=(0.42, 0.6)),
    family("footed_cup", footed_cup, 2),
    family("stemmed_cup", stemmed_cup, 3),
    family("coarse_cup", coarse_cup, 2, watertight=False),
    family("jar_mug", jar_mug),
]
