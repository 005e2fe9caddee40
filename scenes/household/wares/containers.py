"""Containers that nobody drinks from: bottles, jars, vases, pots, dishes, bowls, boxes, baskets and bins."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from ..parts.legs import families, family
from ..parts.outlines import at_height, circle, rectangle, rounded, superellipse
from ..parts.solids import beam, box, cushion, hoop, join, lathe, loft, shift, stacked, tube, turn
from .cups import handle, vessel, wall_profile


def bottle(rng: Generator, *, kind: str = "wine"):
    """Return a closed bottle: wine, plastic, or a squat one of detergent."""
    height = {"wine": rng.uniform(0.28, 0.33), "water": rng.uniform(0.2, 0.26), "squat": rng.uniform(0.15, 0.2)}[kind]
    radius = {"wine": 0.038, "water": rng.uniform(0.03, 0.036), "squat": 0.045}[kind]
    neck = {"wine": 0.014, "water": 0.013, "squat": 0.012}[kind]
    shoulder = {"wine": 0.6, "water": 0.68, "squat": 0.7}[kind] * height
    throat = shoulder + (0.14 if kind == "wine" else 0.16) * height
    profile = [
        (0, 0), (radius - 0.004, 0), (radius, 0.005), (radius, shoulder),
        (0.85 * radius, 0.6 * shoulder + 0.4 * throat), (neck, throat), (neck, height - 0.025),
        (neck + 0.003, height - 0.024), (neck + 0.003, height), (0, height),
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
    *[family(f"{kind}_bottle", bottle, kind=kind) for kind in ("wine", "water")],
    family("mustard_bottle", flat_bottle),
    *families(spray_bottle, jar, tin),
    *[family("vase", vase, kind=kind) for kind in ("narrow", "flared")],
    family("flower_pot", flower_pot),
]


def utensil_pot(rng: Generator):
    """Return a pot crowded with spoons and spatulas."""
    radius, height = rng.uniform(0.05, 0.065), rng.uniform(0.13, 0.16)
    parts = [vessel(wall_profile(radius, radius, height), 0.005, 0.008)]
    for angle in np.linspace(0, 2 * np.pi, 7)[:-1] + rng.uniform(0, 1):
        x, y = np.cos(angle), np.sin(angle)
        tip = np.array([0.085 * x, 0.085 * y, rng.uniform(0.28, 0.34)])
        parts.append(tube([[-0.5 * radius * x, -0.5 * radius * y, 0.009], tip], 0.006, sections=6))
        parts.append(shift(cushion(0.05, 0.01, 0.07, rounding=0.004, corner=0.004), *(tip - [0, 0, 0.02])))
    return join(parts)


def kettle(rng: Generator, *, tea: bool = False):
    """Return a kettle or teapot with its lid on, a spout and a handle."""
    radius, height = rng.uniform(0.07, 0.09), rng.uniform(0.15, 0.2) * (0.75 if tea else 1)
    t = np.linspace(0, 1, 9)
    belly = radius * (np.sin(np.pi * (0.2 + 0.7 * t)) if tea else 1 - 0.3 * t**2)
    profile = [
        (0, 0), *zip(belly, 0.004 + t * 0.85 * height, strict=True), (0.3 * radius, 0.92 * height),
        (0.015, 0.94 * height), (0.018, height), (0, height + 0.004),
    ]
    bends = [(-0.8, 0.35), (-1.3, 0.55), (-1.7, 0.85)]
    spout = tube([[x * radius, 0, z * height] for x, z in bends], 0.018, scale=[1.2, 0.9, 0.6])
    ear = handle(0.85 * radius, 0.7 * radius, 0.2 * height, 0.75 * height, 0.06, 0.009)
    return join(lathe(profile), spout, ear)


def pan(rng: Generator, *, deep: bool = False, lid: bool = False):
    """Return a frying pan, or a pot, with a long handle or two ears; a lid closes it."""
    radius = rng.uniform(0.1, 0.15)
    height = rng.uniform(0.11, 0.15) if deep else rng.uniform(0.035, 0.05)
    low = 0.98 if deep else 0.75
    parts = [vessel([(low * radius - 0.004, 0), (low * radius, 0.004), (radius, height)], 0.003, 0.005)]
    if lid:
        cover = [(0, -0.003), (1.02 * radius, -0.003), (1.02 * radius, 0.002), (0.6 * radius, 0.02)]
        knob = [(0.02, 0.028), (0.022, 0.05), (0, 0.052)]
        parts.append(lathe([(r, height + z) for r, z in cover + knob]))
        ear = handle(radius, radius, 0.7 * height, 0.85 * height, 0.04, 0.006)
        return join(parts, ear, turn(ear, "z", 180))
    return join(parts, tube([[radius - 0.004, 0, 0.8 * height], [radius + 0.18, 0, 0.8 * height + 0.03]], 0.011))


def plate(rng: Generator):
    """Return a dinner plate with a raised rim."""
    reach, rise = rng.uniform(0.09, 0.14), rng.uniform(0.016, 0.026)
    profile = [
        (0, 0), (0.55 * reach, 0), (0.68 * reach, 0.005), (reach, rise), (reach, rise + 0.003), (0.66 * reach, 0.01),
        (0.55 * reach, 0.005), (0, 0.005),
    ]
    return lathe(profile, sections=40)


DISHES = [
    family("utensil_pot", utensil_pot),
    family("kettle", kettle, tea=False),
    family("teapot", kettle, tea=True),
    family("frying_pan", pan, deep=False),
    family("cooking_pot", pan, deep=True, lid=True),
    family("plate", plate),
]


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
