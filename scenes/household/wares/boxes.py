"""Boxes, baskets, buckets and bins, open and closed."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.family import family
from ..parts.outlines import at_height, circle, rectangle, rounded, superellipse
from ..parts.solids import beam, box, cushion, hoop, join, lathe, loft, shift, stacked, tube, turn
from .cups import vessel


def carton(rng: Generator):
    """Return a milk carton with a gable top."""
    width, height = rng.uniform(0.07, 0.095), rng.uniform(0.17, 0.2)
    gable = loft(
        [at_height(rectangle(width, width), height), at_height(rectangle(width, 0.004), height + 0.45 * width)]
    )
    return join(box(width, width, height), gable, box(width, 0.004, 0.02, z=height + 0.44 * width))


def packet(rng: Generator, *, size: tuple[float, float, float] = (0.16, 0.06, 0.23)):
    """Return a closed box of about the given size, metres."""
    width, depth, height = np.asarray(size) * rng.uniform(0.85, 1.15, 3)
    return box(width, depth, height)


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
    grips = [
        tube(
            rounded(
                [
                    [x * width / 2, -0.06, 0.02], [x * width / 2, -0.05, 0.06], [x * width / 2, 0.05, 0.06],
                    [x * width / 2, 0.06, 0.02],
                ]
            ),
            0.005,
            sections=6,
        )
        for x in (-1, 1)
    ]
    return join(parts, grips)


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
    body = vessel(
        [(0.72 * rim, 0), (0.98 * rim, height - 0.02), (1.04 * rim, height - 0.015), (1.04 * rim, height)], 0.004, 0.006
    )
    angles = np.linspace(0, np.pi, 13)
    bail = np.column_stack(
        [1.03 * rim * np.cos(angles), -1.06 * rim * np.sin(angles), height - 0.012 - 0.05 * np.sin(angles)]
    )
    return join(body, tube(bail, 0.003, sections=6))


def waste_bin(rng: Generator, *, lid: bool = False):
    """Return a bin: open like an office's, or closed by a dome."""
    rim, height = rng.uniform(0.13, 0.2), rng.uniform(0.28, 0.36)
    if not lid:
        return vessel([(0.8 * rim, 0), (rim, height)], 0.004, 0.006)
    tall = height * rng.uniform(1.6, 2.2)
    return lathe(
        [
            (0, 0), (rim, 0), (rim, 0.8 * tall), (1.04 * rim, 0.81 * tall), (0.9 * rim, 0.92 * tall),
            (0.5 * rim, 0.985 * tall), (0, tall),
        ]
    )


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
    hoops = [
        hoop(circle(radius * r, 32), z * height, 0.012)
        for r, z in ((0.9, 0.14), (0.9, 0.86), (0.99, 0.38), (0.99, 0.62))
    ]
    return join(lathe(body), hoops)


BOXES = [
    family("milk_carton", carton),
    family("cereal_box", packet, size=(0.16, 0.06, 0.23)),
    family("open_box", open_box),
    family("laundry_basket", basket),
    family("bucket", bucket),
    family("waste_bin", waste_bin, lid=False),
    family("trash_can", waste_bin, lid=True),
    family("wheelie_bin", wheelie_bin),
    family("tray", tray),
    family("barrel", barrel),
]
