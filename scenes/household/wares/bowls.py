"""Bowls, which the paper counts among drinking vessels (§IV-A): for cereals, soup, rice, coffee and salad."""

from __future__ import annotations

from numpy.random import Generator

from ..parts.family import family
from .cups import vessel


def bowl(rng: Generator, *, width: float, height: float, rim: float = 0.0):
    """Return a round bowl on a foot, about so wide and high, with a flat rim if that is given a width; metres."""
    radius, height = 0.5 * width * rng.uniform(0.93, 1.07), height * rng.uniform(0.92, 1.08)
    inner = radius - rim
    wall = [(0.45, 0), (0.47, 0.08), (0.72, 0.25), (0.88, 0.5), (0.96, 0.75), (1, 1)]
    outside = [(share * inner, z * height) for share, z in wall]
    if rim:
        outside.append((radius, height + 0.004))
    return vessel(outside, 0.004, 0.01)


BOWLS = [
    family("cereal_bowl", bowl, width=0.15, height=0.065),
    family("soup_bowl", bowl, width=0.155, height=0.06, rim=0.012),
    family("rice_bowl", bowl, width=0.115, height=0.06),
    family("coffee_bowl", bowl, width=0.13, height=0.075),
    family("salad_bowl", bowl, width=0.165, height=0.08),
]
