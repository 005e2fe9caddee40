"""Does it keep what it holds? The filled object is tilted to all sides, farther each time, shaken and set down.

In the object's own frame that is gravity that turns and shakes, so the shape on which spheres settled serves as it is.
Lengths are in radii, times in sqrt(radius / g), as in `World`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...simulator.mechanics import CarryResult, CarrySettings
from ..engine import pybullet
from ..physics import Physics
from ..world import World

G = 9.81  # m/s2
TILTING = 2.0  # degrees in a unit of time: 90 degrees a second at a radius of 5 mm
TURNING = 24.0  # degrees in a unit of time, about the vertical: once around in 0.3 s at a radius of 5 mm
WAITING = 4.0  # times at each angle before it turns, and after it is set down
CYCLES = 1  # of shaking along each axis
OUT = 1.0  # radii that a whole sphere must be beyond the box of object and filling to be lost
LOOK = 0.5  # of time, in which gravity is the same
SUB_STEPS = 2  # of a look: what lies in a pile is slow, and with twice as many no share changes by more than 0.02
FINE_SUB_STEPS = 5  # where spheres are few: at 2 one alone goes over a rim some 6 degrees too early, at 5 some 3
FEW = 40  # spheres
EVERY = 4  # looks, one at what is gone: it falls, and meets nothing on its way
ITERATIONS = 5  # of the solver


@dataclass(frozen=True, eq=False)
class Phase:
    """A part of the way: gravity as it is seen from the object, look by look."""

    gravity: np.ndarray  # (L, 3) in g


def carrying_physics(physics: Physics, settings: CarrySettings, spheres: int) -> Physics:
    """Return a backend's physics as it is for carrying.

    Without friction of rolling: it is there to hold what has settled on 5 degrees, but at these steps it holds some
    spheres on 15, and it doubles what the solver has to do.
    """
    sub_steps = FINE_SUB_STEPS if spheres <= FEW else SUB_STEPS
    return Physics(
        friction=settings.friction,
        rolling_friction=0.0,
        restitution=settings.restitution,
        time_step=LOOK / sub_steps,
        sub_steps=sub_steps,
        iterations=ITERATIONS,
        scale=physics.scale,
    )


def tilted(angle_deg: np.ndarray, heading_deg: np.ndarray) -> np.ndarray:
    """Return gravity (L, 3) in the frame of an object that leans by angles (L,) towards headings (L,)."""
    angle, heading = np.radians(angle_deg), np.radians(heading_deg)
    level = np.sin(angle)
    return np.column_stack([level * np.cos(heading), level * np.sin(heading), -np.cos(angle)])


def phases(settings: CarrySettings, radius: float, look: float) -> Iterator[Phase]:
    """Yield a phase for each angle, and the last one: back, shaken, and set down.

    At each angle the object leans to every side in turn, as one that is tilted about every axis.
    """
    before = 0.0
    for angle in settings.angles_deg:
        lean = np.arange(before, angle, settings.haste * TILTING * look)
        turn = np.arange(0, 360, settings.haste * TURNING * look)
        wait = np.full(int(WAITING / look), angle)
        angles = np.concatenate([lean, wait, np.full(len(turn), angle), wait])
        headings = np.concatenate([np.zeros(len(lean) + len(wait)), turn, np.zeros(len(wait))])
        yield Phase(tilted(angles, headings))
        before = angle
    back = np.linspace(before, 0, int(WAITING / look))
    yield Phase(np.concatenate([tilted(back, np.zeros(len(back))), shaken(settings, radius, look)]))


def shaken(settings: CarrySettings, radius: float, look: float) -> np.ndarray:
    """Return gravity (L, 3) of an object that is shaken along x, y and z, and then stands still."""
    down = np.array([0.0, 0.0, -1.0])
    rate = 2 * np.pi * settings.frequency * np.sqrt(radius / G)  # radians in a unit of time
    strength = settings.shake * (2 * np.pi * settings.frequency) ** 2 / G
    wave = strength * np.sin(np.arange(0, 2 * np.pi * CYCLES, rate * look))
    strokes = [down + np.outer(wave, axis) for axis in np.eye(3)]
    return np.concatenate([*strokes, np.tile(down, (int(WAITING / look), 1))])


@dataclass(frozen=True, eq=False)
class Kept:
    """What stayed."""

    counts: list[int]  # after each phase
    centers: np.ndarray  # (S, 3) radii


def carry_filled(world: World, centers: np.ndarray, bounds: np.ndarray, settings: CarrySettings, radius: float) -> Kept:
    """Return what an object in a world keeps of spheres (S, 3) that lie on it.

    Parameters
    ----------
    centers : (S, 3) float64, radii
    bounds : (2, 3) float64, radii
        Of the object.
    radius : float, metres
        Which says how fast a frequency in Hz is.
    """
    low = np.minimum(bounds[0], (centers - 1).min(axis=0)) - 1 - OUT
    high = np.maximum(bounds[1], (centers + 1).max(axis=0)) + 1 + OUT
    world.add_spheres(len(centers))
    for slot, center in enumerate(centers):
        world.place(slot, center)
    counts = []
    for phase in phases(settings, radius, world.physics.look):
        for number, gravity in enumerate(phase.gravity):
            if not world.air:
                break
            pybullet().setGravity(*(world.scale * gravity).tolist(), **world.engine)
            world.step()
            if number % EVERY == 0:
                lose(world, low, high)
        lose(world, low, high)
        counts.append(len(world.air))
    return Kept(counts, world.positions() if world.air else np.empty((0, 3)))


def lose(world: World, low: np.ndarray, high: np.ndarray):
    """Take away the spheres that have left a box."""
    if not world.air:
        return
    places = world.positions()
    inside = ((places > low) & (places < high)).all(axis=1)
    for slot in np.flatnonzero(~inside)[::-1]:
        pybullet().removeBody(world.air.pop(slot), **world.engine)


def carry_result(
    kept: Kept | None,
    filled: int,
    radius: float,
    settings: CarrySettings,
    seconds: float,
    provenance: dict[str, Any],
) -> CarryResult:
    """Return what an object kept of so many spheres, or of none; the radius in metres."""
    shares = [0.0] * (len(settings.angles_deg) + 1) if kept is None else [count / filled for count in kept.counts]
    centers = np.empty((0, 3)) if kept is None else kept.centers * radius
    return CarryResult(
        filled=filled,
        radius=radius,
        angles_deg=settings.angles_deg,
        kept=tuple(shares[:-1]),
        kept_shaken=shares[-1],
        centers=centers,
        weight=len(centers) * settings.density * 4 / 3 * np.pi * radius**3,
        notes=() if filled else ("nothing stays on it",),
        seconds=seconds,
        provenance=provenance,
    )
