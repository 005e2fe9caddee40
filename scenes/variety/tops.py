"""What tables of the catalogue share: tops with rims, gaps and bumps, and the stands under them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import trimesh
from numpy.random import Generator

from ..household.parts.legs import apron, cross_foot, crossed_legs, four_legs, panel_ends, pedestal, sled, trestles
from ..household.parts.outlines import arch, at_height, circle
from ..household.parts.solids import box, crossbar, lathe, loft, prism, rod, sheet, shift, tube

SHAPES = ("rectangle", "rounded", "round", "oval", "octagon")
STANDS = ("four", "splayed", "crossed", "column", "cross", "sled", "panels", "trestles", "tripod", "hairpins")


def border(plan: np.ndarray, height: float, thickness: float, z: float, *, flare: float = 0.0) -> trimesh.Trimesh:
    """Return a wall along a plan (N, 2) on z, that leans outwards by ``flare`` at its upper edge; metres."""
    half = np.abs(plan).max(axis=0)
    inner, wider = 1 - thickness / half, 1 + flare / half
    rings = [(1.0, z), (wider, z + height), (inner * wider, z + height), (inner, z)]
    return loft([at_height(plan * scale, level) for scale, level in rings], loop=True)


def grips(rng: Generator, width: float, depth: float, z: float):
    """Return two bowed handles over the ends of a tray whose upper edge is at z, metres."""
    span, rise, thick = rng.uniform(0.09, 0.14), rng.uniform(0.025, 0.06), rng.uniform(0.004, 0.008)
    bow = arch([[-span / 2, 0, z - 0.008], [-0.45 * span, 0, z + rise]], rounds=2)[:, [1, 0, 2]]
    return [tube(bow + [x * (width / 2 - thick), 0, 0], thick, sections=6) for x in (-1, 1)]


def slats(rng: Generator, plan: np.ndarray, thickness: float, height: float, *, gap: float, uneven: float = 0.0):
    """Return boards along x side by side that fill a plan (N, 2), their upper faces at ``height``, and two rails.

    ``gap`` is between boards, ``uneven`` by how much one may lie below the others, metres.
    """
    half = np.abs(plan).max(axis=0)
    count = max(3, round(2 * half[1] / rng.uniform(0.06, 0.13)))
    pitch, boards = 2 * half[1] / count, []
    for y in (np.arange(count) + 0.5) * pitch - half[1]:
        reach = min(half_chord(plan, y - pitch / 2), half_chord(plan, y + pitch / 2))
        low = height - thickness - rng.uniform(0, uneven)
        boards.append(box(2 * max(reach, 0.62 * half[0]), pitch - gap, thickness, y=y, z=low))
    rails = [box(0.05, 1.9 * half[1], 0.025, x=x * 0.45 * half[0], z=height - thickness - 0.023) for x in (-1, 1)]
    return [*boards, rails]


def half_chord(plan: np.ndarray, y: float) -> float:
    """Return how far a convex plan (N, 2) about the origin reaches in x at y."""
    right = plan[plan[:, 0] >= 0]
    order = np.argsort(right[:, 1])
    return float(np.interp(y, right[order, 1], right[order, 0]))


def rough_slab(rng: Generator, width: float, depth: float, thickness: float, height: float) -> trimesh.Trimesh:
    """Return a slab with an irregular edge whose top is uneven by one to five millimetres."""
    rows, columns = 33, 25
    across, along = np.linspace(-1, 1, columns), np.linspace(-1, 1, rows)
    edge = 1 + bumps(rng, along, 0.12)[:, None] * np.abs(across)[None]
    grid = np.empty((rows, columns, 3))
    grid[..., 0] = along[:, None] * width / 2
    grid[..., 1] = across[None] * depth / 2 * edge
    waves = bumps(rng, along, 1.0)[:, None] + bumps(rng, across, 1.0)[None]
    grid[..., 2] = height + rng.uniform(0.0005, 0.0025) * waves
    return sheet(grid, thickness)


def bumps(rng: Generator, along: np.ndarray, size: float) -> np.ndarray:
    """Return a smooth irregular line within about -size to size over points from -1 to 1."""
    waves = [rng.uniform(0.2, 0.5) * np.sin(np.pi * k * along + rng.uniform(0, 2 * np.pi)) for k in (1, 2, 3, 5)]
    return size * np.sum(waves, axis=0) / 1.4


def stand_under(
    rng: Generator, kinds: Sequence[str], width: float, depth: float, under: float
) -> list[trimesh.Trimesh | list[trimesh.Trimesh]]:
    """Return one of some stands, drawn at random, for a top of this size whose lower face is at ``under``, metres."""
    w, d = rng.uniform(0.6, 0.92) * width, rng.uniform(0.6, 0.92) * depth
    bar, short = rng.uniform(0.022, 0.07) * (0.6 + 0.4 * min(1.0, width)), min(width, depth)
    foot = rng.uniform(0.5, 0.8) * short / 2
    stands: dict[str, Callable[[], list]] = {
        "four": lambda: [
            four_legs(w, d, under, bar, taper=rng.uniform(0.6, 1.0), splay=rng.choice([0, 0.02, 0.05])),
            apron(w - bar / 2, d - bar / 2, rng.uniform(0.04, 0.1), 0.018, under),
        ],
        "splayed": lambda: [
            four_legs(0.75 * w, 0.75 * d, under, bar, splay=0.1 * short, taper=0.6, round_bars=True),
            [crossbar(0.74 * w, y * 0.32 * d, under - 0.01, 0.04, 0.025) for y in (-1, 1)],
        ],
        "crossed": lambda: crossed_legs(0.85 * w, d, under, min(bar, 0.04)),
        "column": lambda: column(rng, under, foot),
        "cross": lambda: cross_foot(under, foot, rng.uniform(0.015, 0.04)),
        "sled": lambda: sled(w, d, under, rng.uniform(0.008, 0.02)),
        "panels": lambda: panel_ends(w, d, under, rng.uniform(0.02, 0.06)),
        "trestles": lambda: trestles(0.8 * w, d, under, min(bar, 0.06)),
        "tripod": lambda: tripod(under, foot, rng.uniform(0.012, 0.022)),
        "hairpins": lambda: hairpins(w, d, under, rng.uniform(0.005, 0.008)),
    }
    return stands[str(rng.choice(list(kinds)))]()


def column(rng: Generator, height: float, foot: float):
    """Return a column: turned on a round foot, like the stem of a tulip, or a straight drum."""
    style, thin = str(rng.choice(["turned", "tulip", "drum"])), rng.uniform(0.025, 0.05)
    if style == "turned":
        return pedestal(height, foot, thin)
    if style == "drum":
        return [lathe([(0, 0), (0.7 * foot, 0), (0.6 * foot, height), (0, height)])]
    t = np.linspace(0, 1, 10)
    flare = thin + (foot - thin) * (1 - t) ** 5 + 0.6 * foot * t**9
    return [lathe([(0, 0), *zip(flare, t * height, strict=True), (0, height)])]


def tripod(height: float, reach: float, thick: float):
    """Return three legs that meet under a top, joined half way up."""
    feet = [np.array([np.cos(a), np.sin(a)]) * reach for a in np.radians([90, 210, 330])]
    legs = [rod([*foot, 0], [*(0.35 * foot), height], thick, 8) for foot in feet]
    hub = prism(circle(0.75 * reach, 12), 0.015, 0.45 * height)
    return [*legs, hub, prism(circle(0.4 * reach + thick, 12), 0.02, height - 0.02)]


def hairpins(width: float, depth: float, height: float, thick: float):
    """Return four bent rods at the corners."""
    pins = []
    for x, y in [(x * width, y * depth) for x in (-1, 1) for y in (-1, 1)]:
        ends = [[0.47 * x, 0.3 * y, height], [0.3 * x, 0.47 * y, height]]
        pins += [rod([0.47 * x, 0.47 * y, thick], end, thick) for end in ends]
    return pins


def around(mesh: trimesh.Trimesh, turns: int, reach: float):
    """Return copies of what stands at the origin, its front to -y, placed about it and facing inwards, metres."""
    copies = []
    for angle in np.arange(turns) * 2 * np.pi / turns:
        cos, sin = np.cos(angle), np.sin(angle)
        turned = mesh.copy()
        turned.vertices = mesh.vertices @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
        copies.append(shift(turned, -reach * sin, reach * cos))
    return copies
