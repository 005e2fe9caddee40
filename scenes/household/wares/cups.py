"""Drinking vessels: hollow, open at the top, with a wall and a floor of real thickness."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike

from ..parts.legs import families, family
from ..parts.outlines import circle, rounded
from ..parts.solids import join, lathe, shift, stacked, tube


def vessel(outside: ArrayLike, wall: float, floor: float, *, sections: int = 36):
    """Return a vessel of revolution.

    Parameters
    ----------
    outside : array_like (K, 2)
        Radius and height of its outer wall, metres, from the foot's edge up to the rim.
    wall : float
        Thickness of the wall, metres.
    floor : float
        Height of the inner floor above z = 0, metres: the foot or stem below it is solid.
    """
    outside = np.asarray(outside, dtype=float)
    inner = np.column_stack([outside[:, 0] - wall, outside[:, 1]])
    heights = np.concatenate([[floor], inner[inner[:, 1] > floor + 1e-4, 1]])
    inside = np.column_stack([np.interp(heights, outside[:, 1], inner[:, 0]), heights])
    rim = [(outside[-1, 0] - wall / 2, outside[-1, 1] + 0.3 * wall)]
    profile = [(0, outside[0, 1]), *outside, *rim, *inside[::-1], (0, floor)]
    return lathe(profile, sections=sections)


def shell(outside: Sequence[tuple[float, float]]):
    """Return a vessel of a single surface, as many hand-made models are: no wall thickness."""
    return lathe([(0, outside[0][1]), *outside], sections=36, capped=False)


def wall_profile(foot: float, rim: float, height: float, *, belly: float = 0.0, rounding: float = 0.006):
    """Return an outer wall (K, 2) from foot radius to rim radius, bulging by ``belly`` metres midway."""
    t = np.linspace(0, 1, 9)
    radius = foot + (rim - foot) * t + belly * np.sin(np.pi * t)
    return [(foot - rounding, 0.0), *zip(radius, rounding + t * (height - rounding), strict=True)]


def handle(radius_low: float, radius_high: float, low: float, high: float, reach: float, thickness: float):
    """Return an ear from the wall at height ``high`` out to +x by ``reach`` and back at ``low``, metres."""
    upper = [[radius_high - 0.003, 0, high], [radius_high + reach, 0, high]]
    lower = [[radius_low + 0.9 * reach, 0, low], [radius_low - 0.003, 0, low]]
    return tube(rounded([*upper, *lower], rounds=3), thickness, sections=8)


def mug(rng: Generator, *, open_shell: bool = False):
    """Return a mug with a handle, 8 to 12 cm high."""
    height, radius = rng.uniform(0.08, 0.115), rng.uniform(0.036, 0.047)
    foot = radius * rng.uniform(0.8, 1.0)
    outside = wall_profile(foot, radius, height, belly=rng.choice([0, 0, 0.004]))
    wall = rng.uniform(0.003, 0.005)
    body = shell(outside) if open_shell else vessel(outside, wall, rng.uniform(0.004, 0.008))
    low, high = height * rng.uniform(0.15, 0.28), height * rng.uniform(0.75, 0.9)
    ear = handle(*np.interp([low, high], [0, height], [foot, radius]), low, high, rng.uniform(0.025, 0.036), 0.005)
    return join(body, ear)


def tumbler(rng: Generator):
    """Return a straight or slightly conical water glass, 8 to 15 cm high."""
    height, rim = rng.uniform(0.08, 0.15), rng.uniform(0.032, 0.043)
    outside = wall_profile(rim * rng.uniform(0.72, 1.0), rim, height, rounding=0.003)
    return vessel(outside, rng.uniform(0.0015, 0.003), rng.uniform(0.005, 0.012))


def tumbler_shell(rng: Generator):
    """Return a glass whose wall is a single surface."""
    height, rim = rng.uniform(0.08, 0.13), rng.uniform(0.03, 0.042)
    return shell(wall_profile(rim * rng.uniform(0.75, 1.0), rim, height, rounding=0.002))


def faceted_glass(rng: Generator):
    """Return a heavy whisky glass with eight to twelve flat sides."""
    rim = rng.uniform(0.038, 0.046)
    outside = wall_profile(rim * 0.9, rim, rng.uniform(0.08, 0.1), rounding=0.004)
    return vessel(outside, rng.uniform(0.003, 0.005), rng.uniform(0.012, 0.018), sections=int(rng.integers(8, 13)))


def stemmed(rng: Generator, bowl: Sequence[tuple[float, float]], *, stem: float, foot: float, wall: float = 0.0018):
    """Return a glass whose bowl, (K, 2) radius and height above its lowest point, stands on a stem."""
    thickness = rng.uniform(0.0035, 0.005)
    base = [(foot, 0), (foot, 0.002), (0.4 * foot, 0.006), (thickness, 0.02), (thickness, stem - 0.006)]
    outside = base + [(radius, stem + height) for radius, height in bowl]
    return vessel(outside, wall, stem + 0.006)


def wine_glass(rng: Generator):
    """Return a wine glass, 17 to 23 cm high, widest below the middle of its bowl."""
    wide, tall = rng.uniform(0.033, 0.045), rng.uniform(0.085, 0.115)
    t = np.linspace(0.04, 1, 10)
    radius = wide * np.sqrt(np.sin(np.pi * (0.04 + rng.uniform(0.55, 0.72) * t))) * np.minimum(1, (t / 0.2) ** 0.5)
    bowl = list(zip(radius, t * tall, strict=True))
    return stemmed(rng, bowl, stem=rng.uniform(0.075, 0.11), foot=rng.uniform(0.03, 0.04))


def champagne_flute(rng: Generator):
    """Return a flute, 20 to 24 cm high."""
    wide, tall = rng.uniform(0.023, 0.029), rng.uniform(0.12, 0.15)
    t = np.linspace(0.05, 1, 9)
    bowl = list(zip(wide * np.minimum(1.0, t**0.45), t * tall, strict=True))
    return stemmed(rng, bowl, stem=rng.uniform(0.07, 0.09), foot=0.032)


def cocktail_glass(rng: Generator):
    """Return a martini glass: a cone on a stem."""
    wide, tall = rng.uniform(0.045, 0.058), rng.uniform(0.05, 0.07)
    t = np.linspace(0.12, 1, 7)
    bowl = list(zip(wide * t, t * tall, strict=True))
    return stemmed(rng, bowl, stem=rng.uniform(0.08, 0.1), foot=0.036)


def goblet(rng: Generator):
    """Return a thick goblet on a short stem, 13 to 17 cm high."""
    wide, tall = rng.uniform(0.036, 0.044), rng.uniform(0.075, 0.095)
    t = np.linspace(0.08, 1, 9)
    bowl = list(zip(wide * t**0.35, t * tall, strict=True))
    return stemmed(rng, bowl, stem=rng.uniform(0.05, 0.07), foot=0.034, wall=0.003)


def beer_mug(rng: Generator):
    """Return a beer mug of thick glass with a large handle."""
    height, radius = rng.uniform(0.13, 0.17), rng.uniform(0.042, 0.052)
    body = vessel(wall_profile(radius, radius * rng.uniform(0.92, 1.0), height), 0.005, rng.uniform(0.012, 0.02))
    return join(body, handle(radius, radius * 0.95, 0.18 * height, 0.82 * height, 0.045, 0.008))


def beer_glass(rng: Generator):
    """Return a tall glass that widens upward, or a weizen glass with a waist."""
    height, rim = rng.uniform(0.15, 0.22), rng.uniform(0.038, 0.044)
    outside = wall_profile(rim * 0.7, rim, height, belly=rng.uniform(-0.004, 0.004))
    return vessel(outside, 0.003, rng.uniform(0.01, 0.018))


def tea_cup(rng: Generator):
    """Return a wide low tea cup with a foot ring's worth of base and a small handle."""
    height, rim = rng.uniform(0.052, 0.07), rng.uniform(0.042, 0.052)
    t = np.linspace(0, 1, 9)
    radius = 0.5 * rim + 0.5 * rim * t ** rng.uniform(0.35, 0.6)
    outside = [(0.42 * rim, 0), (0.45 * rim, 0.003), *zip(radius, 0.006 + t * (height - 0.006), strict=True)]
    ear = handle(0.72 * rim, 0.97 * rim, 0.3 * height, 0.82 * height, rng.uniform(0.018, 0.026), 0.0035)
    return join(vessel(outside, rng.uniform(0.002, 0.0035), 0.008), ear)


def tea_cup_on_saucer(rng: Generator):
    """Return a tea cup on its saucer."""
    reach = rng.uniform(0.068, 0.08)
    saucer = lathe([(0, 0), (0.4 * reach, 0), (reach, 0.016), (reach, 0.019), (0.45 * reach, 0.006), (0, 0.006)])
    return join(saucer, shift(tea_cup(rng), z=0.0058))


def espresso_cup(rng: Generator):
    """Return an espresso cup, 5 to 6.5 cm high."""
    height, rim = rng.uniform(0.05, 0.065), rng.uniform(0.028, 0.034)
    body = vessel(wall_profile(rim * rng.uniform(0.6, 0.85), rim, height, belly=0.002), 0.004, 0.007)
    return join(body, handle(0.8 * rim, 0.95 * rim, 0.3 * height, 0.8 * height, 0.018, 0.0035))


def shot_glass(rng: Generator):
    """Return a shot glass with a heavy base."""
    rim = rng.uniform(0.021, 0.026)
    outside = wall_profile(rim * 0.75, rim, rng.uniform(0.055, 0.075), rounding=0.002)
    return vessel(outside, 0.003, rng.uniform(0.01, 0.016))


def travel_mug(rng: Generator):
    """Return a tall insulated mug without its lid."""
    height, rim = rng.uniform(0.15, 0.19), rng.uniform(0.039, 0.044)
    lower = 0.4 * height
    outside = [(0.72 * rim, 0), (0.74 * rim, 0.004), (0.8 * rim, lower), (0.97 * rim, lower + 0.02), (rim, height)]
    ear = handle(0.98 * rim, rim, 0.5 * height, 0.9 * height, 0.03, 0.005)
    return join(vessel(outside, 0.004, 0.008), ear)


def paper_cup(rng: Generator):
    """Return a conical paper cup with a recessed floor and a rolled rim."""
    height, rim = rng.uniform(0.085, 0.125), rng.uniform(0.038, 0.045)
    outside = [(rim * 0.7, 0), (rim, height - 0.003), (rim + 0.002, height - 0.001), (rim + 0.0015, height)]
    return vessel(outside, 0.0015, 0.008)


def plastic_cup(rng: Generator):
    """Return a plastic party cup with stepped walls."""
    height, rim = rng.uniform(0.095, 0.12), rng.uniform(0.04, 0.047)
    outside = [
        (0.64 * rim, 0), (0.7 * rim, 0.3 * height), (0.74 * rim, 0.31 * height), (0.85 * rim, 0.65 * height),
        (0.89 * rim, 0.66 * height), (0.98 * rim, height - 0.003), (rim, height),
    ]
    return vessel(outside, 0.0015, 0.003)


def child_cup(rng: Generator):
    """Return a child's cup with two handles and no lid."""
    height, rim = rng.uniform(0.07, 0.09), rng.uniform(0.033, 0.038)
    ear = handle(0.95 * rim, rim, 0.2 * height, 0.75 * height, 0.028, 0.0045)
    other = ear.copy()
    other.vertices = other.vertices * [-1, -1, 1]
    return join(vessel(wall_profile(0.85 * rim, rim, height), 0.0025, 0.004), ear, other)


def square_cup(rng: Generator):
    """Return a handleless beaker with a square, rounded plan."""
    half, height = rng.uniform(0.033, 0.04), rng.uniform(0.08, 0.1)
    plan = circle(1.0, 32)
    plan = np.sign(plan) * np.abs(plan) ** 0.55
    steps = [(0.0, 0), (0.88, 0), (0.94, 0.006), (1.0, height), (0.92, height), (0.85, 0.008), (0.001, 0.008)]
    return stacked(plan * half, [(max(scale, 0.001), z) for scale, z in steps])


CUPS = [
    family("mug", mug, 3),
    family("mug", mug, watertight=False, open_shell=True),
    family("tumbler", tumbler, 2),
    family("tumbler", faceted_glass),
    family("tumbler", tumbler_shell, watertight=False),
    family("wine_glass", wine_glass, 2),
    *families(beer_mug, beer_glass, tea_cup),
    family("tea_cup", tea_cup_on_saucer),
    family("espresso_cup", espresso_cup, 2),
    *families(shot_glass, travel_mug, paper_cup, champagne_flute, cocktail_glass, goblet, plastic_cup),
    family("beaker", square_cup),
    family("child_cup", child_cup),
]
