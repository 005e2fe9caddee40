"""Stools, low and as high as a bar, with and without backs."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.family import family
from ..parts.legs import four_legs, stretchers
from ..parts.outlines import arc, at_height, circle, superellipse
from ..parts.solids import crossbar, cushion, hoop, join, lathe, prism, sheet, tube


def stool(rng: Generator, *, shape: str = "round", legs: int = 4, height: tuple[float, float] = (0.42, 0.48)):
    """Return a stool without a back."""
    width, seat = rng.uniform(0.3, 0.4), rng.uniform(*height)
    top = circle(width / 2, 32) if shape == "round" else superellipse(width, 0.85 * width, 6.0, 32)
    parts = [prism(top, 0.03, seat - 0.03)]
    if legs == 3:
        for angle in np.radians([90, 210, 330]):
            x, y = np.cos(angle), np.sin(angle)
            foot = [0.5 * width * x, 0.5 * width * y, 0]
            parts.append(tube([[0.3 * width * x, 0.3 * width * y, seat - 0.02], foot], 0.018))
        return join(parts)
    splay = 0.03 + 0.06 * (seat > 0.6)
    round_bars = shape == "round"
    parts += four_legs(0.68 * width, 0.6 * width, seat - 0.02, 0.034, splay=splay, taper=0.8, round_bars=round_bars)
    inner = 0.68 * width - 0.034 + splay
    return join(parts, stretchers(inner, inner - 0.08 * width, 0.42 * seat, 0.018))


def bar_chair(rng: Generator, *, back: bool = True):
    """Return a bar stool on a column with a disc foot and a footrest, its seat dished or backed."""
    radius, seat = rng.uniform(0.17, 0.2), rng.uniform(0.65, 0.8)
    parts = [lathe([(0, 0), (0.2, 0), (0.2, 0.012), (0.03, 0.03), (0.025, seat - 0.05), (0, seat - 0.05)])]
    parts += [hoop(circle(0.16, 20), 0.3 * seat, 0.009), crossbar(0.32, 0, 0.3 * seat, 0.02, 0.015)]
    parts.append(cushion(2 * radius, 2 * radius, 0.07, z=seat - 0.07, corner=radius * 0.98, crown=0.01))
    if back:
        rim = arc(radius + 0.01, 10, 170, 14)
        rows = [at_height(rim * s, seat + z) for s, z in ((0.88, -0.05), (1.03, 0.1), (1.12, 0.24))]
        parts.append(sheet(rows, 0.018))
    return join(parts)


STOOLS = [
    family("stool", stool, shape="round", legs=3, also="table"),
    family("stool", stool, shape="square", also="table"),
    family("bar_stool", stool, shape="square", height=(0.68, 0.8)),
    family("bar_stool", bar_chair, back=True),
    family("bar_stool", bar_chair, back=False),
]
