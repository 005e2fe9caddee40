"""Containers that nobody drinks from: bottles, jars, tins, vases and flower pots."""

from __future__ import annotations

from numpy.random import Generator

from ..parts.family import families, family
from ..parts.outlines import superellipse
from ..parts.solids import beam, box, join, lathe, stacked
from .cups import vessel


def bottle(rng: Generator, *, kind: str = "wine"):
    """Return a closed bottle: wine, plastic, or a squat one of detergent."""
    height = {"wine": rng.uniform(0.28, 0.33), "water": rng.uniform(0.2, 0.26), "squat": rng.uniform(0.15, 0.2)}[kind]
    radius = {"wine": 0.038, "water": rng.uniform(0.03, 0.036), "squat": 0.045}[kind]
    neck = {"wine": 0.014, "water": 0.013, "squat": 0.012}[kind]
    shoulder = {"wine": 0.6, "water": 0.68, "squat": 0.7}[kind] * height
    throat = shoulder + (0.14 if kind == "wine" else 0.16) * height
    profile = [
        (0, 0), (radius - 0.004, 0), (radius, 0.005), (radius, shoulder),
        (0.85 * radius, 0.6 * shoulder + 0.4 * throat),
    ]
    profile += [
        (neck, throat), (neck, height - 0.025), (neck + 0.003, height - 0.024), (neck + 0.003, height), (0, height),
    ]
    return lathe(profile)


def flat_bottle(rng: Generator):
    """Return a mustard or shampoo bottle: oval in plan, with a nozzle."""
    width, height = rng.uniform(0.08, 0.1), rng.uniform(0.16, 0.2)
    plan = superellipse(width, 0.6 * width, 2.6, 28)
    steps = [
        (0.9, 0), (1, 0.01), (0.97, 0.6 * height), (0.8, 0.74 * height), (0.4, 0.82 * height), (0.35, 0.86 * height),
        (0.1, height),
    ]
    return stacked(plan, steps)


def spray_bottle(rng: Generator):
    """Return a bottle with a trigger head."""
    height = rng.uniform(0.18, 0.2)
    side = [(0.04, 0), (0.042, 0.01), (0.038, 0.6 * height), (0.014, 0.85 * height), (0.014, height)]
    head = box(0.024, 0.1, 0.03, y=-0.02, z=height - 0.002)
    trigger = beam([0, -0.045, height], [0, -0.055, height - 0.055], 0.012, 0.008)
    return join(lathe([(0, 0), *side, (0, height)]), head, trigger)


def jar(rng: Generator):
    """Return a jar with its lid on."""
    radius, height = rng.uniform(0.035, 0.05), rng.uniform(0.09, 0.15)
    neck = radius * 0.92
    profile = [
        (0, 0), (radius, 0.004), (radius, 0.78 * height), (neck, 0.84 * height), (neck + 0.004, 0.85 * height),
        (neck + 0.004, height), (0, height),
    ]
    return lathe(profile)


def tin(rng: Generator):
    """Return a closed tin can with raised rims."""
    radius, height = rng.uniform(0.033, 0.05), rng.uniform(0.09, 0.14)
    rim = 0.003
    profile = [
        (0, rim), (radius - 2 * rim, rim), (radius - rim, 0), (radius, 0), (radius, height), (radius - rim, height),
        (radius - 2 * rim, height - rim), (0, height - rim),
    ]
    return lathe(profile)


def vase(rng: Generator, *, kind: str = "narrow"):
    """Return an open vase: narrow-necked, or bellied with a flared rim."""
    height = rng.uniform(0.22, 0.38)
    wide = rng.uniform(0.055, 0.085)
    shapes = {
        "narrow": [(0.6, 0), (0.75, 0.05), (1, 0.35), (0.85, 0.55), (0.3, 0.75), (0.28, 0.93), (0.38, 1)],
        "flared": [(0.55, 0), (0.7, 0.1), (0.95, 0.4), (0.7, 0.72), (0.62, 0.82), (0.9, 1)],
    }
    outside = [(radius * wide, z * height) for radius, z in shapes[kind]]
    return vessel(outside, 0.005, 0.015)


def flower_pot(rng: Generator):
    """Return a pot filled with soil to below its rim."""
    rim, height = rng.uniform(0.07, 0.14), rng.uniform(0.12, 0.24)
    outside = [(0.7 * rim, 0), (0.93 * rim, 0.82 * height), (rim, 0.83 * height), (rim, height)]
    return vessel(outside, 0.008, 0.86 * height)


CONTAINERS = [
    family("wine_bottle", bottle, kind="wine"),
    family("water_bottle", bottle, kind="water"),
    family("mustard_bottle", flat_bottle),
    *families(spray_bottle, jar, tin),
    family("vase", vase, kind="narrow"),
    family("vase", vase, kind="flared"),
    family("flower_pot", flower_pot),
]
