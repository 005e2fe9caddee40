"""How a vessel is carried: gravity as it turns and shakes in the object's own frame, look by look.

Lengths are in radii, times in sqrt(radius / g), as in `World`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...simulator.mechanics import CarrySettings

G = 9.81  # m/s2
LOOK = 0.5  # of time, in which gravity is the same
TURNING = 3.0, 14.0  # degrees in a unit of time, at least and at most: once around in 0.6 to 2.7 s at a radius of 5 mm
SPHERES = 20.0  # more of them, one degree faster: slower changes little where they are few, and many cost too much
LEANING = 0.25  # of the turning
WAITING = 3.0  # times at each angle before it turns, and after it is set down
CYCLES = 1  # of shaking along each axis


@dataclass(frozen=True, eq=False)
class Phase:
    """A part of the way."""

    gravity: np.ndarray  # (L, 3) in g
    shaken: bool


def phases(settings: CarrySettings, spheres: int, radius: float) -> Iterator[Phase]:
    """Yield a phase for each angle, and the last one: back, shaken, and set down; the radius in metres.

    At each angle the object leans to every side in turn, as one that is tilted about every axis.
    """
    before, wait = 0.0, int(WAITING / LOOK)
    pace = settings.haste * min(max(spheres / SPHERES, TURNING[0]), TURNING[1]) * LOOK
    for angle in settings.angles_deg:
        lean = np.arange(before, angle, LEANING * pace)
        turn = np.arange(0, 360, pace)
        still = np.full(wait, angle)
        angles = np.concatenate([lean, still, np.full(len(turn), angle), still])
        headings = np.concatenate([np.zeros(len(lean) + wait), turn, np.zeros(wait)])
        yield Phase(tilted(angles, headings), shaken=False)
        before = angle
    back = np.linspace(before, 0, wait)
    yield Phase(np.concatenate([tilted(back, np.zeros(wait)), shaken(settings, radius)]), shaken=True)


def tilted(angle_deg: np.ndarray, heading_deg: np.ndarray) -> np.ndarray:
    """Return gravity (L, 3) in the frame of an object that leans by angles (L,) towards headings (L,)."""
    angle, heading = np.radians(angle_deg), np.radians(heading_deg)
    level = np.sin(angle)
    return np.column_stack([level * np.cos(heading), level * np.sin(heading), -np.cos(angle)])


def shaken(settings: CarrySettings, radius: float) -> np.ndarray:
    """Return gravity (L, 3) of an object that is shaken along x, y and z, and then stands still."""
    down = np.array([0.0, 0.0, -1.0])
    rate = 2 * np.pi * settings.frequency * np.sqrt(radius / G)  # radians in a unit of time
    strength = settings.shake * (2 * np.pi * settings.frequency) ** 2 / G
    wave = strength * np.sin(np.arange(0, 2 * np.pi * CYCLES, rate * LOOK))
    strokes = [down + np.outer(wave, axis) for axis in np.eye(3)]
    return np.concatenate([*strokes, np.tile(down, (int(WAITING / LOOK), 1))])
