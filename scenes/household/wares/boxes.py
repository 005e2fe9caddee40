"""Boxes, baskets, buckets and bins, open and closed."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.legs import families, family
from ..parts.outlines import at_height, circle, rectangle, rounded, superellipse
from ..parts.solids import beam, box, cushion, hoop, join, lathe, loft, shift, stacked, tube, turn
from .cups import vessel


def carton(rng: Generator):
    """Return a milk carton with a gable top."""
    width, height = rng.uniform(0.07, 0.095), rng.uniform(0.17, 0.2)
    eaves = at_height(rectangle(width, width), height)
    ridge = at_height(rectangle(width, 0.004), height + 0.45 * width)
    return join(box(width, width, height), loft([eaves, ridge]), box(width, 0.004, 0.02, z=height + 0.44 * width))


def packet(rng: Generator):
    """Return a closed box of about the given size, metres."""
    return box(*np.array([0.16, 0.06, 0.23]) * rng.uniform(0.85, 1.15, 3))


def open_box(rng: Generator):
    """Return a cardboard box whose four flaps hang open."""
    width, depth, height = rng.uniform(0.35, 0.6), rng.uniform(0.28, 0.42), rng.uniform(0.22, 0.36)
    parts = tray_walls(width, depth, height, 0.005)
    for y in (-1, 1):
        flap = [[0, y * depth / 2, height - 0.004], [0, y * (depth / 2 + 0.1), height + 0.08]]
        parts.append(beam(*flap, width, 0.004))
    for x in (-1, 1):
        parts.append(beam([x * width / 2, 0, height - 0.004], [x * (width / 2 + 0.09), 0, height - 0.06], depth, 0.004))
    return join(parts)


def tray_walls(width: float, depth: float, height: float, wall: float):
    """Return a floor and four walls, as a list of boxes."""
    sides = [box(wall, depth, height, x=x * (width - wall) / 2) for x in (-1, 1)]
    ends = [box(width, wall, height, y=y * (depth - wall) / 2) for y in (-1, 1)]
    return [box(width, depth, wall), *sides, *ends]


def tray(rng: Generator):
    """Return a serving tray with a low rim and two grips."""
    width, depth = rng.uniform(0.38, 0.5), rng.uniform(0.26, 0.34)
    parts = tray_walls(width, depth, rng.uniform(0.025, 0.045), 0.006)
    bends = [(-0.06, 0.02), (-0.05, 0.06), (0.05, 0.06), (0.06, 0.02)]
    grips = [rounded([[x * width / 2, y, z] for y, z in bends]) for x in (-1, 1)]
    return join(parts, [tube(grip, 0.005, sections=6) for grip in grips])


def basket(rng: Generator):
    """Return a laundry basket woven from bands."""
    width, depth, height = rng.uniform(0.45, 0.6), rng.uniform(0.32, 0.42), rng.uniform(0.24, 0.32)
    plan = superellipse(1, 1, 4.0, 28)
    parts = [stacked(plan, [(0.84 * width, 0.84 * depth, z) for z in (0, 0.01)])]
    for t in np.linspace(0.08, 1, 6):
        size = np.array([width, depth]) * (0.84 + 0.16 * t)
        parts.append(hoop(plan * size, t * height, 0.012))
    foot, rim = plan[::2] * [0.84 * width, 0.84 * depth], plan[::2] * [width, depth]
    parts += [tube([[*a, 0.005], [*b, height]], 0.007, sections=6) for a, b in zip(foot, rim, strict=True)]
    return join(parts)


def bucket(rng: Generator):
    """Return a bucket with its bail down."""
    rim, height = rng.uniform(0.13, 0.155), rng.uniform(0.24, 0.29)
    outside = [(0.72 * rim, 0), (0.98 * rim, height - 0.02), (1.04 * rim, height - 0.015), (1.04 * rim, height)]
    angles = np.linspace(0, np.pi, 13)
    across, along = 1.03 * rim * np.cos(angles), -1.06 * rim * np.sin(angles)
    bail = np.column_stack([across, along, height - 0.012 - 0.05 * np.sin(angles)])
    return join(vessel(outside, 0.004, 0.006), tube(bail, 0.003, sections=6))


def waste_bin(rng: Generator, *, lid: bool = False):
    """Return a bin: open like an office's, or closed by a dome."""
    rim, height = rng.uniform(0.13, 0.2), rng.uniform(0.28, 0.36)
    if not lid:
        return vessel([(0.8 * rim, 0), (rim, height)], 0.004, 0.006)
    tall = height * rng.uniform(1.6, 2.2)
    dome = [(1.04, 0.81), (0.9, 0.92), (0.5, 0.985)]
    return lathe([(0, 0), (rim, 0), (rim, 0.8 * tall), *((r * rim, z * tall) for r, z in dome), (0, tall)])


def wheelie_bin(rng: Generator):
    """Return a street bin on two wheels, its lid shut."""
    width, depth, height = rng.uniform(0.48, 0.6), rng.uniform(0.52, 0.7), rng.uniform(0.9, 1.05)
    body = loft([at_height(rectangle(0.8 * width, 0.75 * depth), 0.03), at_height(rectangle(width, depth), height)])
    wheel = turn(lathe([(0, -0.025), (0.1, -0.025), (0.1, 0.025), (0, 0.025)], sections=20), "y", 90)
    wheels = [shift(wheel, x * 0.38 * width, 0.4 * depth, 0.1) for x in (-1, 1)]
    return join(body, cushion(1.05 * width, 1.05 * depth, 0.08, z=height - 0.01, crown=0.03), wheels)


def barrel(rng: Generator):
    """Return a closed wooden barrel with hoops."""
    radius, height = rng.uniform(0.25, 0.32), rng.uniform(0.75, 0.95)
    t = np.linspace(0, 1, 9)
    body = [
        (0, 0.02), (0.8 * radius, 0.02), *zip(radius * (0.84 + 0.16 * np.sin(np.pi * t)), t * height, strict=True),
        (0.8 * radius, height - 0.02), (0, height - 0.02),
    ]
    bands = ((0.9, 0.14), (0.9, 0.86), (0.99, 0.38), (0.99, 0.62))
    return join(lathe(body), [hoop(circle(radius * r, 32), z * height, 0.012) for r, z in bands])


BOXES = [
    family("milk_carton", carton),
    family("cereal_box", packet),
    family("open_box", open_box),
    family("laundry_basket", basket),
    family("bucket", bucket),
    family("waste_bin", waste_bin, lid=False),
    family("trash_can", waste_bin, lid=True),
    *families(wheelie_bin, tray, barrel),
]
