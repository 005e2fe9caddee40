"""Devices: screens, computers, radios, fans and kitchen appliances."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.legs import families, family
from ..parts.outlines import arch, circle
from ..parts.solids import beam, box, cushion, join, lathe, prism, shift, stacked, sweep, tube, turn
from .cups import handle


def screen(rng: Generator, *, width: float = 1.0):
    """Return a television or monitor on a foot; ``width`` is its middle width, metres."""
    width = width * rng.uniform(0.85, 1.15)
    height, gap = 0.58 * width, 0.06 + 0.05 * rng.uniform()
    panel = cushion(width, 0.05, height, z=gap, rounding=0.01, corner=0.01)
    foot = box(0.45 * width, 0.3 * width, 0.015, y=0.03)
    return join(panel, foot, box(0.12 * width, 0.04, gap + 0.2 * height, y=0.03))


def laptop(rng: Generator):
    """Return an open laptop."""
    width, depth = rng.uniform(0.3, 0.38), rng.uniform(0.21, 0.26)
    lid = turn(box(width, depth, 0.008, y=depth / 2), "x", rng.uniform(65, 80))
    return join(box(width, depth, 0.018), shift(lid, y=depth / 2, z=0.012))


def desktop_computer(rng: Generator):
    """Return the tower of a desktop computer, with a drive's flap and a button."""
    width, depth, height = rng.uniform(0.17, 0.22), rng.uniform(0.4, 0.5), rng.uniform(0.38, 0.47)
    flap = box(0.8 * width, 0.01, 0.045, y=-depth / 2, z=0.82 * height)
    button = box(0.03, 0.012, 0.03, y=-depth / 2, z=0.66 * height)
    return join(cushion(width, depth, height, rounding=0.008, corner=0.012), flap, button)


def vacuum(rng: Generator):
    """Return a vacuum cleaner on wheels, its hose and wand leading to a nozzle on the floor."""
    length, width, height = rng.uniform(0.36, 0.44), rng.uniform(0.24, 0.3), rng.uniform(0.2, 0.25)
    body = cushion(width, length, height, z=0.015, rounding=0.05, corner=0.08)
    wheel = turn(prism(circle(0.06), 0.03), "y", 90)
    wheels = [shift(wheel, x - 0.015, 0.3 * length, 0.06) for x in (-width / 2, width / 2)]
    top = [0.1, -0.5 * length - 0.25, rng.uniform(0.7, 0.85)]
    hose = tube([[0, -0.4 * length, 0.6 * height], [0.05, -0.5 * length - 0.1, 0.5], top], 0.02)
    nozzle = [0.2, -0.5 * length - 0.75, 0.03]
    return join(body, wheels, hose, tube([top, nozzle], 0.016), box(0.28, 0.09, 0.045, x=nozzle[0], y=nozzle[1]))


def keyboard(rng: Generator):
    """Return a keyboard with rows of keys."""
    width, depth = rng.uniform(0.38, 0.46), rng.uniform(0.13, 0.16)
    parts = [cushion(width, depth, 0.018, rounding=0.006, corner=0.01)]
    for y in np.linspace(-0.36, 0.36, 5) * depth:
        parts += [box(0.022, 0.017, 0.008, x=x, y=y, z=0.016) for x in np.linspace(-0.45, 0.45, 12) * width]
    return join(parts)


def telephone(rng: Generator):
    """Return a desk telephone with its handset on the cradle."""
    width, depth = rng.uniform(0.16, 0.2), rng.uniform(0.18, 0.22)
    side = [[-depth / 2, 0], [depth / 2, 0], [depth / 2, 0.07], [-depth / 2, 0.03]]
    wedge = sweep([[-width / 2, 0, 0], [width / 2, 0, 0]], side)
    x = -0.3 * width
    receiver = [box(0.045, 0.05, 0.04, x=x, y=y * 0.34 * depth, z=0.045 + y * 0.01) for y in (-1, 1)]
    return join(wedge, receiver, beam([x, -0.4 * depth, 0.08], [x, 0.4 * depth, 0.095], 0.035, 0.02))


def radio(rng: Generator):
    """Return a portable radio with a handle and an aerial."""
    width, depth, height = rng.uniform(0.24, 0.34), rng.uniform(0.08, 0.12), rng.uniform(0.15, 0.2)
    grip = arch([[-0.4 * width, 0, height - 0.01], [-0.38 * width, 0, height + 0.05]], rounds=0)
    dial = turn(lathe([(0, 0), (0.022, 0), (0.02, 0.015), (0, 0.015)], sections=16), "x", 90)
    foot, tip = [0.42 * width, 0.3 * depth, height - 0.01], [0.3 * width, 0.3 * depth, height + 0.2]
    aerial = tube([foot, tip], 0.003, sections=6)
    body = cushion(width, depth, height, rounding=0.012, corner=0.015)
    return join(body, tube(grip, 0.007, sections=6), aerial, shift(dial, 0.3 * width, -depth / 2 + 0.003, 0.6 * height))


def speaker(rng: Generator):
    """Return a loudspeaker: a bookshelf box or a floor-standing tower."""
    height = rng.choice([rng.uniform(0.28, 0.4), rng.uniform(0.85, 1.1)])
    width, depth = 0.2 * rng.uniform(0.85, 1.2), 0.26 * rng.uniform(0.85, 1.2)
    profile = [(0, -0.01), (0.07, -0.01), (0.075, 0.006), (0.06, 0.006), (0.02, -0.006), (0, -0.004)]
    cone = turn(lathe(profile, sections=20), "x", 90)
    return join(box(width, depth, height), [shift(cone, 0, -depth / 2, height - drop) for drop in (0.1, 0.2)])


def fan(rng: Generator):
    """Return a standing fan: a caged propeller on a column."""
    height, reach = rng.uniform(0.9, 1.25), rng.uniform(0.18, 0.23)
    parts = [lathe([(0, 0), (0.19, 0), (0.19, 0.02), (0.02, 0.05), (0.015, height), (0, height)])]
    parts.append(cushion(0.1, 0.2, 0.11, z=height - 0.03, rounding=0.03))
    ring = np.column_stack([circle(reach, 24)[:, 0], np.full(24, -0.13), circle(reach, 24)[:, 1] + height + 0.025])
    parts.append(tube(ring, 0.006, loop=True, sections=6))
    hub = np.array([0, -0.16, height + 0.025])
    parts += [tube([hub, rim], 0.002, sections=4) for rim in ring]
    parts += [tube([[0, -0.08, height + 0.025], rim], 0.002, sections=4) for rim in ring]
    for angle in np.radians([20, 140, 260]):
        tip = hub + [0.85 * reach * np.cos(angle), 0.03, 0.85 * reach * np.sin(angle)]
        parts.append(beam(hub + [0, 0.03, 0], tip, 0.05, 0.004, taper=2.0))
    return join(parts, turn(prism(circle(0.03, 12), 0.09), "x", 90).apply_translation([0, -0.08, height + 0.025]))


def printer(rng: Generator):
    """Return an office printer with a paper tray at the back and one in front."""
    width, depth, height = rng.uniform(0.38, 0.46), rng.uniform(0.32, 0.4), rng.uniform(0.18, 0.28)
    body = cushion(width, depth, height, rounding=0.02, corner=0.03)
    tray = box(0.24, 0.16, 0.012, y=-depth / 2 - 0.06, z=0.05)
    return join(body, tray, beam([0, 0.38 * depth, height - 0.02], [0, 0.55 * depth, height + 0.16], 0.25, 0.01))


def coffee_maker(rng: Generator):
    """Return a filter machine with its jug under the brewer."""
    width, depth, height = rng.uniform(0.16, 0.2), rng.uniform(0.2, 0.26), rng.uniform(0.28, 0.35)
    jug = lathe([(0, 0.03), (0.055, 0.03), (0.062, 0.08), (0.045, 0.14), (0.045, 0.15), (0, 0.15)], sections=20)
    parts = [box(width, depth, 0.035), box(width, 0.08, height, y=depth / 2 - 0.04)]
    parts.append(cushion(width, depth, height - 0.19, z=0.19, rounding=0.015))
    ear = turn(handle(0.06, 0.05, 0.05, 0.13, 0.035, 0.006), "z", -90)
    return join(parts, shift(jug, y=-0.2 * depth), shift(ear, y=-0.2 * depth))


def blender(rng: Generator):
    """Return a kitchen blender with its lid on."""
    height = rng.uniform(0.34, 0.42)
    base = lathe([(0, 0), (0.085, 0), (0.08, 0.05), (0.055, 0.14), (0, 0.14)], sections=24)
    lid = [(0.07, height - 0.03), (0.072, height - 0.01), (0.03, height), (0, height)]
    jug = lathe([(0, 0.135), (0.045, 0.135), *lid], sections=16)
    return join(base, jug, handle(0.055, 0.068, 0.18, height - 0.05, 0.05, 0.008))


def iron(rng: Generator):
    """Return a clothes iron lying on its sole."""
    length = rng.uniform(0.24, 0.29)
    t = np.linspace(0, 1, 12)
    half = 0.055 * np.sqrt(1 - t**2) ** 0.9
    outline = np.concatenate([np.column_stack([half, t * length]), np.column_stack([-half, t * length])[-2::-1]])
    outline -= [0, 0.4 * length]
    body = stacked(outline, [(1, 0), (1, 0.015), (0.9, 0.03), (0.55, 0.07)])
    grip = [[0, -0.28 * length, 0.05], [0, -0.3 * length, 0.12], [0, 0.15 * length, 0.12], [0, 0.24 * length, 0.06]]
    return join(body, tube(grip, 0.015))


DEVICES = [
    family("tv", screen, width=1.0),
    family("monitor", screen, width=0.52),
    *families(laptop, desktop_computer, vacuum, keyboard, telephone, radio),
    *families(speaker, fan, printer, coffee_maker, blender, iron),
]
