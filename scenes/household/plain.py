"""A catalogue by another hand, ``plain``: few parts, boxes and turned profiles, in wide proportions.

`household` is drawn with care and has one to seven objects of a kind; here each kind has eight, as wide, deep and high
as such objects are at all. What is learnt of a kind should not be how one person draws it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import trimesh
from numpy.random import Generator

from .parts.legs import CatalogueObject, draw_objects, family, four_legs, panel_ends, pedestal
from .parts.solids import box, join, lathe, tube
from .wares.cups import handle, vessel

EACH = 8  # objects of a kind
Range = tuple[float, float]  # metres
Legs = Sequence[str]
ANY, WIDE = ("square", "round", "panels", "pedestal"), ("square", "panels")


def legs(rng: Generator, styles: Legs, width: float, depth: float, height: float) -> list[trimesh.Trimesh]:
    """Return what carries a top, in one of some styles."""
    style, thickness = rng.choice(styles), rng.uniform(0.025, 0.06)
    if style == "panels":
        return panel_ends(width, 0.9 * depth, height, 0.025)
    if style == "pedestal":
        return pedestal(height, min(width, depth) * rng.uniform(0.3, 0.45), 0.03)
    return four_legs(width, depth, height, thickness, round_bars=style == "round")


def top(
    rng: Generator, *, width: Range, depth: Range, height: Range, thick: Range = (0.02, 0.05), styles: Legs = ANY
) -> trimesh.Trimesh:
    """Return a board on legs: a stool, or a table."""
    across, along, high, board = (rng.uniform(*of) for of in (width, depth, height, thick))
    return join(box(across, along, board, z=high - board), legs(rng, styles, across, along, high - board))


def disc(rng: Generator, *, radius: Range, height: Range) -> trimesh.Trimesh:
    """Return a round board on a pedestal."""
    across, high = rng.uniform(*radius), rng.uniform(*height)
    board = lathe([(0, high - 0.03), (across, high - 0.03), (across, high), (0, high)])
    return join(board, pedestal(high - 0.03, across * rng.uniform(0.5, 0.8), 0.03))


def seat(
    rng: Generator, *, width: Range, depth: Range, height: Range, back: Range, arms: float = 0.0, styles: Legs = ANY
) -> trimesh.Trimesh:
    """Return a chair: a board on legs, a back that may begin above a gap, arms on a share of them."""
    across, along, high, rises = (rng.uniform(*of) for of in (width, depth, height, back))
    board, gap = rng.uniform(0.02, 0.08), rng.choice([0.0, 0.0, rng.uniform(0.05, 0.2)])
    rear = along / 2 - 0.015
    parts = [box(across, along, board, z=high - board), legs(rng, styles, across, along, high - board)]
    parts.append(box(across, 0.03, rises - gap, y=rear, z=high + gap))
    if gap:
        parts += [box(0.03, 0.03, gap + 0.02, x=x * (across / 2 - 0.015), y=rear, z=high) for x in (-1, 1)]
    if rng.random() < arms:
        rest, side = high + rng.uniform(0.15, 0.25), across / 2 + 0.025
        parts += [box(0.05, along, 0.04, x=x * side, z=rest) for x in (-1, 1)]
        parts += [box(0.05, 0.05, rest, x=x * side, y=y * (along / 2 - 0.03)) for x in (-1, 1) for y in (-1, 1)]
    return join(parts)


def sofa(rng: Generator) -> trimesh.Trimesh:
    """Return a sofa of five boxes."""
    width, depth, level = rng.uniform(1.2, 2.4), rng.uniform(0.7, 0.95), rng.uniform(0.36, 0.46)
    back = box(width, 0.2, rng.uniform(0.35, 0.5), y=depth / 2 - 0.1, z=level)
    high = rng.uniform(0.15, 0.3)
    return join(
        box(width, depth, level), back, [box(0.18, depth, high, x=x * (width / 2 - 0.09), z=level) for x in (-1, 1)]
    )


def ottoman(rng: Generator) -> trimesh.Trimesh:
    """Return an upholstered block."""
    width = rng.uniform(0.45, 0.7)
    return box(width, width * rng.uniform(0.7, 1), rng.uniform(0.36, 0.46))


def desk(rng: Generator) -> trimesh.Trimesh:
    """Return a table with a pedestal of drawers."""
    width, depth, height = rng.uniform(1.1, 1.6), rng.uniform(0.55, 0.8), rng.uniform(0.7, 0.77)
    board = box(width, depth, 0.03, z=height - 0.03)
    drawers = box(0.4, 0.9 * depth, height - 0.04, x=width / 2 - 0.22, z=0.02)
    return join(board, four_legs(width, depth, height - 0.03, rng.uniform(0.03, 0.06)), drawers)


def block(rng: Generator, *, width: Range, depth: Range, height: Range) -> trimesh.Trimesh:
    """Return a closed box: a cabinet, a parcel."""
    return box(*(rng.uniform(*of) for of in (width, depth, height)))


def shelf(rng: Generator) -> trimesh.Trimesh:
    """Return boards between two sides."""
    width, depth, height = rng.uniform(0.6, 1.0), rng.uniform(0.25, 0.4), rng.uniform(1.2, 2.0)
    boards = [box(width, depth, 0.02, z=z) for z in np.linspace(0, height - 0.02, rng.integers(4, 6))]
    return join(boards, [box(0.02, depth, height, x=x * width / 2) for x in (-1, 1)])


def lamp(rng: Generator) -> trimesh.Trimesh:
    """Return a standing lamp: a foot, a pole, a closed shade."""
    height, shade = rng.uniform(1.2, 1.7), rng.uniform(0.12, 0.25)
    foot, pole = (lathe([(0, 0), (r, 0), (r, h), (0, h)]) for r, h in ((0.14, 0.02), (0.012, height)))
    return join(foot, pole, lathe([(0, height - 0.1), (shade, height - 0.1), (0.01, height + 0.15)]))


def open_box(rng: Generator, *, width: Range, depth: Range, height: Range, wall: float = 0.01) -> trimesh.Trimesh:
    """Return a floor with four walls: a crate, a tray."""
    across, along, high = (rng.uniform(*of) for of in (width, depth, height))
    sides = [box(wall, along, high, x=x * (across - wall) / 2) for x in (-1, 1)]
    ends = [box(across, wall, high, y=y * (along - wall) / 2) for y in (-1, 1)]
    return join(box(across, along, wall), sides, ends)


def clothes_rail(rng: Generator) -> trimesh.Trimesh:
    """Return a bar between two posts on feet."""
    width, height = rng.uniform(0.6, 1.2), rng.uniform(1.5, 1.8)
    posts = [box(0.03, 0.03, height, x=x * width / 2) for x in (-1, 1)]
    feet = [box(0.03, 0.4, 0.03, x=x * width / 2) for x in (-1, 1)]
    return join(posts, feet, tube([[-width / 2, 0, height - 0.02], [width / 2, 0, height - 0.02]], 0.0125))


def bed(rng: Generator) -> trimesh.Trimesh:
    """Return a mattress on the floor with a headboard, its head to +y."""
    width, length = rng.uniform(0.85, 1.6), rng.uniform(1.9, 2.1)
    return join(
        box(width, length, rng.uniform(0.4, 0.55)), box(width, 0.05, rng.uniform(0.8, 1.1), y=length / 2 + 0.025)
    )


def beaker(
    rng: Generator, *, radius: Range, height: Range, narrower: float = 0.75, eared: bool = False
) -> trimesh.Trimesh:
    """Return a vessel of straight walls, its foot narrower by a factor at least; with an ear, a mug."""
    rim, high, wall = rng.uniform(*radius), rng.uniform(*height), rng.uniform(0.002, 0.005)
    body = vessel([(rim * rng.uniform(narrower, 1), 0), (rim, high)], wall, wall)
    return join(body, handle(rim, rim, 0.2 * high, 0.8 * high, 0.35 * high, 0.006)) if eared else body


def stemmed(rng: Generator) -> trimesh.Trimesh:
    """Return a wine glass."""
    stem, radius = rng.uniform(0.05, 0.11), rng.uniform(0.025, 0.045)
    outside = [(0.034, 0), (0.034, 0.003), (0.004, 0.006), (0.004, stem), (0.8 * radius, stem + 0.015)]
    return vessel([*outside, (radius, stem + 0.05), (0.85 * radius, stem + 0.09)], 0.002, stem + 0.004)


def bowl(rng: Generator) -> trimesh.Trimesh:
    """Return a bowl to drink from, two thirds of half a sphere."""
    radius, angles = rng.uniform(0.06, 0.085), np.linspace(0.3, np.pi / 2, 14)
    rises = 0.75 * radius * (np.cos(0.3) - np.cos(angles))
    return vessel(np.column_stack([radius * np.sin(angles), rises]), 0.003, 0.003)


def bottle(rng: Generator) -> trimesh.Trimesh:
    """Return a bottle with a narrow neck."""
    radius, high = rng.uniform(0.03, 0.045), rng.uniform(0.18, 0.28)
    return vessel([(radius, 0), (radius, 0.6 * high), (0.012, 0.78 * high), (0.012, high)], 0.003, 0.003)


def plate(rng: Generator) -> trimesh.Trimesh:
    """Return a plate with a raised edge."""
    radius = rng.uniform(0.08, 0.14)
    return lathe(
        [(0, 0), (0.7 * radius, 0), (radius, 0.02), (radius - 0.001, 0.024), (0.7 * radius, 0.004), (0, 0.004)]
    )


ARMCHAIR: dict[str, Any] = {
    "width": (0.45, 0.65),
    "depth": (0.45, 0.6),
    "height": (0.38, 0.48),
    "back": (0.35, 0.7),
    "arms": 1.0,
}
HIGH_BACK: dict[str, Any] = {
    "width": (0.5, 0.75),
    "depth": (0.45, 0.6),
    "height": (0.42, 0.52),
    "back": (0.7, 1.1),
    "arms": 0.5,
}
BENCH: dict[str, Any] = {"width": (1.0, 1.8), "depth": (0.32, 0.48), "height": (0.38, 0.48), "styles": WIDE}
FAMILIES = {
    "sittable": [
        family("chair", seat, EACH, width=(0.38, 0.5), depth=(0.38, 0.5), height=(0.4, 0.48), back=(0.3, 0.6)),
        family("armchair", seat, EACH, **ARMCHAIR),
        family("high_back_chair", seat, EACH, **HIGH_BACK),
        family("bar_chair", seat, EACH, width=(0.36, 0.45), depth=(0.34, 0.45), height=(0.6, 0.78), back=(0.15, 0.4)),
        family("bench_with_back", seat, EACH // 2, **BENCH, back=(0.3, 0.5)),
        family("bench", top, EACH // 2, **BENCH, thick=(0.02, 0.08)),
        family("stool", top, EACH, width=(0.3, 0.45), depth=(0.28, 0.42), height=(0.38, 0.52), thick=(0.02, 0.08)),
        family("bar_stool", top, EACH, width=(0.3, 0.42), depth=(0.3, 0.42), height=(0.62, 0.8), thick=(0.02, 0.08)),
        family("round_stool", disc, EACH, radius=(0.15, 0.21), height=(0.4, 0.5)),
        family("sofa", sofa, EACH),
        family("ottoman", ottoman, EACH),
    ],
    "table": [
        family("dining_table", top, EACH, width=(1.1, 2.2), depth=(0.7, 1.05), height=(0.7, 0.78)),
        family("coffee_table", top, EACH, width=(0.7, 1.3), depth=(0.45, 0.8), height=(0.36, 0.5)),
        family("side_table", top, EACH, width=(0.4, 0.6), depth=(0.4, 0.6), height=(0.5, 0.65)),
        family("bar_table", top, EACH, width=(0.5, 0.8), depth=(0.5, 0.8), height=(0.95, 1.1)),
        family("console", top, EACH, width=(0.9, 1.4), depth=(0.3, 0.4), height=(0.72, 0.85)),
        family("round_table", disc, EACH, radius=(0.4, 0.7), height=(0.7, 0.77)),
        family("desk", desk, EACH),
    ],
    "cup": [
        family("tumbler", beaker, EACH, radius=(0.028, 0.045), height=(0.07, 0.15)),
        family("mug", beaker, EACH, radius=(0.035, 0.05), height=(0.07, 0.11), narrower=0.85, eared=True),
        family("wine_glass", stemmed, EACH),
        family("bowl", bowl, EACH),
    ],
    "none": [
        family("shelf", shelf, EACH),
        family("cabinet", block, EACH, width=(0.4, 1), depth=(0.35, 0.6), height=(0.9, 1.8)),
        family("parcel", block, EACH, width=(0.15, 0.4), depth=(0.1, 0.3), height=(0.05, 0.2)),
        family("lamp", lamp, EACH),
        family("crate", open_box, EACH, width=(0.3, 0.6), depth=(0.25, 0.45), height=(0.2, 0.4)),
        family("tray", open_box, EACH, width=(0.32, 0.52), depth=(0.25, 0.4), height=(0.03, 0.036), wall=0.006),
        family("clothes_rail", clothes_rail, EACH),
        family("bed", bed, EACH, also="sittable"),
        family("bucket", beaker, EACH, radius=(0.12, 0.17), height=(0.22, 0.35), narrower=0.8),
        family("bottle", bottle, EACH),
        family("plate", plate, EACH),
    ],
}


def plain_objects(seed: int = 0) -> list[CatalogueObject]:
    """Return the objects of the catalogue; the same seed gives the same meshes, bit for bit."""
    return [item for label, families in FAMILIES.items() for item in draw_objects(families, label, seed)]
