"""House and bathroom fittings, instruments, and other large objects that stand in rooms."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.legs import families, family
from ..parts.outlines import arch, at_height, circle, rounded, superellipse
from ..parts.solids import beam, box, crossbar, cushion, join, lathe, loft, prism, shift, stacked, tube, turn


def radiator(rng: Generator):
    """Return a ribbed radiator on two feet."""
    count, height = int(rng.integers(8, 16)), rng.uniform(0.5, 0.7)
    places = [(n - count / 2) * 0.055 for n in range(count)]
    ribs = [cushion(0.045, 0.1, height, x=x, z=0.08, rounding=0.015, corner=0.02) for x in places]
    pipes = [tube([[-(count / 2) * 0.055, 0, z], [(count / 2 - 1) * 0.055, 0, z]], 0.016) for z in (0.14, height)]
    return join(ribs, pipes, [box(0.03, 0.14, 0.1, x=x * count * 0.022 - 0.027) for x in (-1, 1)])


def door(rng: Generator):
    """Return a door in its frame, shut."""
    width, height = rng.uniform(0.75, 0.95), rng.uniform(1.95, 2.1)
    frame = [box(0.06, 0.12, height + 0.06, x=x * (width / 2 + 0.03)) for x in (-1, 1)]
    bends = [(0.4, 0.015), (0.4, 0.06), (0.28, 0.06)]
    knobs = [tube([[x * width, side * y, 1.02] for x, y in bends], 0.009, sections=8) for side in (-1, 1)]
    return join(frame, box(width + 0.12, 0.12, 0.06, z=height), box(width, 0.04, height, z=0.004), knobs)


def ladder(rng: Generator):
    """Return an A-shaped ladder, open."""
    height, width, spread = rng.uniform(1.2, 2.0), rng.uniform(0.38, 0.48), rng.uniform(0.35, 0.5)
    parts = [box(width, 0.12, 0.05, z=height - 0.03)]
    for x in (-1, 1):
        parts.append(beam([x * width / 2, -spread, 0.01], [x * 0.42 * width, -0.03, height], 0.025, 0.06))
        parts.append(beam([x * width / 2, spread, 0.01], [x * 0.42 * width, 0.03, height], 0.02, 0.04))
    steps = np.arange(0.25, height - 0.15, 0.25)
    for z in steps:
        span = width * (1 - 0.16 * z / height)
        parts.append(box(span, 0.07, 0.025, y=-spread + (spread - 0.03) * z / height, z=z))
    return join(parts, crossbar(width, 0.8 * spread, 0.3, 0.02, 0.03))


def bathtub(rng: Generator):
    """Return a bathtub."""
    width, depth, height = rng.uniform(1.5, 1.8), rng.uniform(0.7, 0.8), rng.uniform(0.52, 0.6)
    plan = superellipse(1, 1, 5.0, 40)
    steps = [
        (0.96, 0.94, 0), (1, 1, 0.1), (1, 1, height), (0.92, 0.82, height), (0.88, 0.76, 0.6 * height),
        (0.78, 0.62, 0.18), (0.6, 0.45, 0.14),
    ]
    return stacked(plan, [(width * w, depth * d, z) for w, d, z in steps])


def washbasin(rng: Generator):
    """Return a washbasin on a pedestal with a tap."""
    width, depth, height = rng.uniform(0.5, 0.62), rng.uniform(0.42, 0.5), rng.uniform(0.8, 0.88)
    plan = superellipse(1, 1, 3.0, 40)
    steps = [
        (0.4, 0.4, -0.2), (0.8, 0.8, -0.12), (1, 1, -0.03), (1, 1, 0), (0.88, 0.84, 0), (0.8, 0.74, -0.06),
        (0.5, 0.45, -0.13),
    ]
    bowl = stacked(plan, [(width * w, depth * d, height + z) for w, d, z in steps])
    rings = ((1, 0), (0.75, 0.2), (0.8, height - 0.15))
    foot = loft([at_height(plan * s * [0.22, 0.2] + [0, 0.05], z) for s, z in rings])
    bends = [(0.45, -0.01), (0.45, 0.14), (0.2, 0.1)]
    tap = rounded([[0, y * depth, height + z] for y, z in bends])
    return join(bowl, foot, tube(tap, 0.012))


def wheel(radius: float, y: float):
    """Return an upright spoked wheel in the plane x = 0 whose hub is at (0, y, radius)."""
    rim = np.column_stack([np.zeros(32), circle(radius - 0.018, 32)])
    hub = tube([[-0.04, 0, 0], [0.04, 0, 0]], 0.02, sections=8)
    spokes = [tube([[0, 0, 0], point], 0.002, sections=4) for point in rim[::2]]
    return shift(join(tube(rim, 0.018, sections=8, loop=True), hub, spokes), 0, y, radius)


def bicycle(rng: Generator):
    """Return a bicycle standing upright, its front wheel to -y."""
    radius = rng.uniform(0.28, 0.34)
    base = 3.05 * radius
    front, rear, crank = [0, -base / 2, radius], [0, base / 2, radius], [0, 0.1, 0.9 * radius]
    head, seat = [0, -0.29 * base, 2.6 * radius], [0, 0.2 * base, 2.5 * radius]
    bars = [(crank, head), (crank, seat), (seat, rear), (crank, rear), (head, seat), (head, front)]
    frame = [tube([a, b], 0.015, sections=8) for a, b in bars]
    handlebar = tube(arch([[-0.28, -0.2 * base, 2.9 * radius], [-0.1, -0.3 * base, 2.85 * radius]]), 0.012, sections=8)
    saddle = loft([at_height(superellipse(w, 0.27, 2.2, 20), z) for w, z in ((0.04, -0.03), (0.15, 0.0), (0.12, 0.02))])
    post = tube([seat, [0, 0.215 * base, 2.75 * radius]], 0.012, sections=8)
    stem = tube([head, [0, -0.3 * base, 2.86 * radius]], 0.013, sections=8)
    pedals = [box(0.08, 0.05, 0.02, x=x * 0.12, y=0.1 + x * 0.16, z=0.9 * radius - 0.01) for x in (-1, 1)]
    arms = [([x * 0.06, 0.1, 0.9 * radius], [x * 0.09, 0.1 + x * 0.16, 0.9 * radius]) for x in (-1, 1)]
    axle = tube([[-0.07, 0.1, 0.9 * radius], [0.07, 0.1, 0.9 * radius]], 0.015, sections=8)
    cranks = [beam(*arm, 0.02, 0.02) for arm in arms]
    wheels = [wheel(radius, y) for y in (-base / 2, base / 2)]
    saddle = shift(saddle, 0, 0.22 * base, 2.77 * radius)
    return join(wheels, frame, handlebar, saddle, post, stem, pedals, cranks, axle)


def guitar(rng: Generator):
    """Return a guitar leaning back on a stand, seen from the front."""
    scale = rng.uniform(0.95, 1.08)
    t = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    waist = 0.16 + 0.03 * np.cos(t) - 0.045 * np.exp(-((np.cos(t) + 0.15) ** 2) / 0.05)
    half = waist * np.sin(t) / np.maximum(np.abs(np.sin(t)) ** 0.3, 0.3)
    body = prism(np.column_stack([half, -0.24 * np.cos(t)]) * scale, 0.09)
    neck = [box(0.055, 0.48, 0.025, y=0.42, z=0.085), box(0.075, 0.16, 0.018, y=0.73, z=0.08)]
    lying = join(body, neck, box(0.14, 0.02, 0.012, y=-0.1, z=0.088))
    upright = shift(turn(lying, "x", 75), 0, 0, 0.34)
    feet = [beam([0, 0.06, 0.35], [x * 0.2, y, 0], 0.02, 0.02) for x, y in ((-1, -0.16), (1, -0.16), (0, 0.35))]
    return join(upright, feet, box(0.26, 0.16, 0.03, y=-0.05, z=0.09))


def piano(rng: Generator):
    """Return an upright piano, its lid open over the keys."""
    width, depth, height = rng.uniform(1.4, 1.52), rng.uniform(0.55, 0.63), rng.uniform(1.08, 1.3)
    lid = box(width + 0.02, 0.34, 0.025, y=depth / 2 - 0.16, z=height - 0.02)
    parts = [box(width, 0.3, height, y=depth / 2 - 0.15), lid]
    parts += [box(width, depth - 0.28, 0.1, y=-0.14, z=0.6), box(width - 0.16, 0.15, 0.02, y=-depth / 2 + 0.1, z=0.7)]
    parts += [box(0.06, depth - 0.02, 0.75, x=x * (width / 2 - 0.03), z=0.0) for x in (-1, 1)]
    return join(parts, [box(0.06, depth, 0.06, x=x * (width / 2 - 0.03), y=-0.01) for x in (-1, 1)])


def whiteboard(rng: Generator):
    """Return a whiteboard on a wheeled frame."""
    width, height = rng.uniform(1.0, 1.6), rng.uniform(1.6, 1.9)
    posts = [box(0.04, 0.04, height - 0.03, x=x * (width / 2 + 0.02), z=0.03) for x in (-1, 1)]
    feet = [box(0.04, 0.55, 0.04, x=x * (width / 2 + 0.02), z=0.0) for x in (-1, 1)]
    board = box(width + 0.02, 0.02, 0.5 * height, z=0.48 * height)
    return join(posts, feet, board, box(0.5 * width, 0.07, 0.015, y=-0.03, z=0.48 * height))


def extinguisher(rng: Generator):
    """Return a fire extinguisher with its valve and hose."""
    radius, height = rng.uniform(0.06, 0.085), rng.uniform(0.42, 0.52)
    neck = [(0.7 * radius, 0.84 * height), (0.02, 0.88 * height), (0.02, 0.95 * height), (0, 0.95 * height)]
    body = lathe([(0, 0), (radius, 0), (radius, 0.75 * height), *neck])
    lever = [beam([0, 0.02, 0.94 * height], [0, -0.1, z * height], 0.022, 0.012) for z in (0.92, 1.0)]
    bends = [(0, 0.01, 0.92), (1.1, 0.02, 0.85), (1.25, 0.02, 0.5), (1.2, 0.02, 0.25)]
    hose = rounded([[x * radius, y, z * height] for x, y, z in bends])
    return join(body, lever, tube(hose, 0.011))


FIXTURES = [
    *families(radiator, door, ladder, bathtub, washbasin, bicycle, guitar, piano, whiteboard),
    family("fire_extinguisher", extinguisher),
]
