"""Other contents of rooms, with none of the three functions: beds, shelves, sills, cartons, piles, clutter.

They are a catalogue of their own, ``surroundings``, from which rooms are made lifelike (`lived_in`). People do sit on
beds, and a sill carries objects, but nobody would call them a seat or a table.
"""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.random import Generator

from ..household.parts.legs import CatalogueObject, draw_objects, family
from ..household.parts.solids import box, cushion, ellipsoid, join, shift, turn

BED, SHELF, SILL, CARTON, PILE, CLUTTER = "bed", "open_shelf", "window_sill", "carton", "pile", "clutter"


def bed(rng: Generator, *, width: float) -> trimesh.Trimesh:
    """Return a made bed: frame, mattress, headboard, pillows, and an uneven blanket; its head to +y."""
    length, level = rng.uniform(1.9, 2.1), rng.uniform(0.4, 0.55)
    width *= rng.uniform(0.95, 1.05)
    frame = box(width, length, level - 0.2, z=0.06)
    corners = [(x * (width / 2 - 0.05), y * (length / 2 - 0.05)) for x in (-1, 1) for y in (-1, 1)]
    feet = [box(0.06, 0.06, 0.06, x=x, y=y) for x, y in corners]
    mattress = cushion(0.97 * width, 0.97 * length, 0.2, z=level - 0.18, rounding=0.04, corner=0.06)
    head = box(width, 0.05, rng.uniform(0.75, 1.15), y=length / 2 + 0.025)
    count = 1 if width < 1.2 else 2
    places = [(k - (count - 1) / 2) * 0.7 for k in range(count)]
    pillows = [cushion(0.6, 0.4, 0.12, x=x, y=length / 2 - 0.3, z=level + 0.01, crown=0.03) for x in places]
    spots = zip(rng.uniform(-0.3, 0.3, 4) * width, rng.uniform(-0.4, 0.15, 4) * length, strict=True)
    sizes = ((x, y, rng.uniform([0.3, 0.3, 0.06], [0.7, 0.9, 0.16])) for x, y in spots)
    folds = [ellipsoid(*size, x=x, y=y, z=level) for x, y, size in sizes]
    return join(frame, feet, mattress, head, pillows, folds)


def open_shelf(rng: Generator, *, back: bool) -> trimesh.Trimesh:
    """Return a standing shelf of boards between two sides, with or without a back; its front to -y."""
    width, depth, height = rng.uniform(0.6, 1.1), rng.uniform(0.28, 0.4), rng.uniform(0.9, 2.0)
    count = max(3, round(height / rng.uniform(0.3, 0.42)) + 1)
    boards = [box(width, depth, 0.02, z=z) for z in np.linspace(0.04, height - 0.02, count)]
    sides = [box(0.02, depth, height, x=x * (width / 2 + 0.01)) for x in (-1, 1)]
    return join(boards, sides, [box(width, 0.01, height, y=depth / 2 + 0.005)] if back else [])


def window_sill(rng: Generator) -> trimesh.Trimesh:
    """Return a board that sticks out of a wall on two brackets, with a strip below; its front to -y."""
    width, depth = rng.uniform(1.0, 1.8), rng.uniform(0.18, 0.34)
    board = box(width, depth, 0.03, z=0.12)
    brackets = [box(0.03, 0.6 * depth, 0.12, x=x * 0.35 * width, y=0.2 * depth) for x in (-1, 1)]
    return join(board, brackets, box(width, 0.01, 0.06, y=depth / 2 - 0.005, z=0.06))


def carton(rng: Generator) -> trimesh.Trimesh:
    """Return a closed moving carton."""
    return box(*rng.uniform([0.3, 0.28, 0.25], [0.62, 0.42, 0.55]))


def heap(rng: Generator, *, soft: bool) -> trimesh.Trimesh:
    """Return a heap on the floor: clothes and cushions if soft, else boxes and books, at random headings."""
    parts, level = [], 0.0
    for share in np.linspace(1.0, 0.45, int(rng.integers(5, 10))):
        width, depth, height = rng.uniform([0.25, 0.2, 0.06], [0.5, 0.4, 0.16]) * [share, share, 1.0]
        x, y = rng.uniform(-0.16, 0.16, 2) * share
        part = ellipsoid(width, depth, 1.4 * height, z=0.5 * height) if soft else box(width, depth, height)
        parts.append(shift(turn(part, "z", rng.uniform(0, 180)), x, y, level))
        level += height * rng.uniform(0.35, 0.8)
    return join(parts)


def cushion_on_seat(rng: Generator) -> trimesh.Trimesh:
    """Return a cushion."""
    side = rng.uniform(0.3, 0.42)
    return cushion(side, side, rng.uniform(0.06, 0.14), crown=0.03)


def bag(rng: Generator) -> trimesh.Trimesh:
    """Return a bag, upright and bulging."""
    width, depth, height = rng.uniform([0.24, 0.12, 0.2], [0.38, 0.2, 0.36])
    return join(cushion(width, depth, height, rounding=0.05, crown=0.02), box(0.5 * width, 0.02, 0.06, z=height))


def papers(rng: Generator) -> trimesh.Trimesh:
    """Return books and papers on top of each other, not quite in line."""
    parts, level = [], 0.0
    for _ in range(int(rng.integers(2, 7))):
        height = rng.uniform(0.012, 0.05)
        page = box(rng.uniform(0.16, 0.24), rng.uniform(0.2, 0.31), height)
        parts.append(shift(turn(page, "z", rng.uniform(-20, 20)), *rng.uniform(-0.02, 0.02, 2), level))
        level += height
    return join(parts)


FAMILIES = [
    family(BED, bed, 3, also="sittable", width=0.95),
    family(BED, bed, 3, also="sittable", width=1.5),
    family(SHELF, open_shelf, 4, back=False),
    family(SHELF, open_shelf, 4, back=True),
    family(SILL, window_sill, 5),
    family(CARTON, carton, 12),
    family(PILE, heap, 4, soft=True),
    family(PILE, heap, 4, soft=False),
    family(CLUTTER, cushion_on_seat, 3),
    family(CLUTTER, bag, 4),
    family(CLUTTER, papers, 4),
]


def surrounding_objects(seed: int = 0) -> list[CatalogueObject]:
    """Return the objects of the catalogue; the same seed gives the same meshes, bit for bit."""
    return list(draw_objects(FAMILIES, "none", seed))
