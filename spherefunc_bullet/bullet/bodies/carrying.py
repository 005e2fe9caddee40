"""Carrying: a filled vessel is tilted to all sides, farther each time, shaken and set down; what does it keep?

In the frame of the object, gravity turns and shakes, so the collision shape on which the spheres settled is used
unchanged. Lengths are in radii, times in sqrt(radius / g), as in `World`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...clouds.flooding import Basin
from ...errors import InputError
from ...processes.compilation import lean_njit
from ...simulator import DropResult, Stop
from ...simulator.mechanics import CarryResult, CarrySettings
from ..collision.shape import CollisionShape
from ..engine import Physics, pybullet
from ..world import World

G = 9.81  # m/s2
INTERVAL = 0.5  # time for which gravity is constant
TURNING = 3.0, 14.0  # slowest and fastest, degrees per unit of time: one turn in 0.6 to 2.7 s at a radius of 5 mm
SPHERES = 20.0  # per degree: with more spheres it turns faster, since slow turns cost much and change little
LEANING = 0.25  # speed of tilting, relative to that of turning
WAITING = 3.0  # time at each angle before and after the turn, and after it is set down
CYCLES = 1  # of shaking along each axis
SUB_STEPS = 4  # steps in the time INTERVAL
MANY, SUB_STEPS_OF_MANY = 150, 3  # the same for more than so many spheres, which cost more
ITERATIONS = 16  # of the solver: with 5, a pile pushes its lowest spheres through the wall
STIFFNESS = 0.5  # share of an overlap that one step removes; with the engine's 0.2, piles overlap by twice as much
DAMPING = 0.1  # share of its speed that a sphere loses per unit of time during tilting, so that none flies over a rim
FINER = 1, 2, 4  # factors of the number of steps, tried in turn until no sphere passes through a wall
UNSEEN = 0.5  # radii that a sphere moves before its path is checked; to pass through a wall it moves farther
ASIDE = 0.6  # radii that a centre may be outside the vessel; on the rim it is farther out
OBJECT, SPHERE = 1, 2  # collision groups, so that rays hit the object only
LEAKS = 0.9  # a vessel that holds a smaller share of what it would hold without holes gets a note


@dataclass(frozen=True, eq=False)
class MotionPhase:
    """A part of the motion."""

    gravity: np.ndarray  # (L, 3) in g
    shaken: bool


def phases(settings: CarrySettings, spheres: int, radius: float) -> Iterator[MotionPhase]:
    """Yield a phase for each angle, and a last one in which the object is upright, shaken and set down.

    At each angle the object leans to every side in turn. The radius is in metres.
    """
    before, wait = 0.0, int(WAITING / INTERVAL)
    pace = settings.haste * min(max(spheres / SPHERES, TURNING[0]), TURNING[1]) * INTERVAL
    for angle in settings.angles_deg:
        lean = np.arange(before, angle, LEANING * pace)
        turn = np.arange(0, 360, pace)
        still = np.full(wait, angle)
        angles = np.concatenate([lean, still, np.full(len(turn), angle), still])
        headings = np.concatenate([np.zeros(len(lean) + wait), turn, np.zeros(wait)])
        yield MotionPhase(tilted(angles, headings), shaken=False)
        before = angle
    back = np.linspace(before, 0, wait)
    yield MotionPhase(np.concatenate([tilted(back, np.zeros(wait)), shaken(settings, radius)]), shaken=True)


def tilted(angle_deg: np.ndarray, heading_deg: np.ndarray) -> np.ndarray:
    """Return the gravity (L, 3) in the frame of an object that leans by angles (L,) towards headings (L,)."""
    angle, heading = np.radians(angle_deg), np.radians(heading_deg)
    level = np.sin(angle)
    return np.column_stack([level * np.cos(heading), level * np.sin(heading), -np.cos(angle)])


def shaken(settings: CarrySettings, radius: float) -> np.ndarray:
    """Return the gravity (L, 3) in the frame of an object that is shaken along x, y and z, and then stands still."""
    down = np.array([0.0, 0.0, -1.0])
    rate = 2 * np.pi * settings.frequency * np.sqrt(radius / G)  # radians per unit of time
    strength = settings.shake * (2 * np.pi * settings.frequency) ** 2 / G
    wave = strength * np.sin(np.arange(0, 2 * np.pi * CYCLES, rate * INTERVAL))
    strokes = [down + np.outer(wave, axis) for axis in np.eye(3)]
    return np.concatenate([*strokes, np.tile(down, (int(WAITING / INTERVAL), 1))])


@dataclass(frozen=True, eq=False)
class Filling:
    """The spheres in a vessel when it is carried."""

    centers: np.ndarray  # (S, 3) radii
    full: int  # number of spheres with which it would be filled if its walls had no holes


@dataclass(frozen=True, eq=False)
class CarryOutcome:
    """The spheres that stayed in the vessel."""

    counts: list[int]  # after each phase
    centers: np.ndarray  # (S, 3) radii
    crossed: int  # number of paths that passed through the object


def filling_of(result: DropResult, radius: float, basin: Basin, fill: float) -> Filling:
    """Return the lowest spheres that settled in a basin, up to a share of what it would hold without holes.

    If there are not enough spheres for the basin, it is filled with all of them. The radius is in metres.
    """
    centers = result.centers / radius
    centers = centers[basin.holds(centers)]
    if not len(centers):
        return Filling(centers, 0)
    reached = 1.0 if result.stop == Stop.MISSES else basin.share_below(float(centers[:, 2].max()))
    full = len(centers) if reached < fill else math.ceil(fill * len(centers) / (reached * basin.fullness))
    lowest = np.sort(np.argsort(centers[:, 2], kind="stable")[:full])
    return Filling(centers[lowest], full)


def carry_filled(
    physics: Physics, shape: CollisionShape, basin: Basin, filling: Filling, settings: CarrySettings, radius: float
) -> CarryOutcome:
    """Return what an object keeps of its filling; the radius is in metres.

    Raises
    ------
    InputError
        If spheres pass through its walls, even in the smallest steps.
    """
    if not len(filling.centers):
        return CarryOutcome([0] * (len(settings.angles_deg) + 1), filling.centers, 0)
    for finer in FINER:
        with World(carrying_physics(physics, settings, len(filling.centers), finer)) as world:
            world.add_object(shape)
            kept = Carriage(world, basin, filling.centers).carried(settings, radius)
        if not kept.crossed:
            return kept
    raise InputError(
        f"{shape.name}: expected spheres to stay on their side of a wall, got {kept.crossed} that went through, "
        f"also in steps {FINER[-1]} times as fine; use a larger radius"
    )


def carrying_physics(physics: Physics, settings: CarrySettings, spheres: int, finer: int) -> Physics:
    """Return the physics of a backend, adapted to carrying a number of spheres.

    There is no rolling friction: it is meant to hold spheres on slopes of 5 degrees, but it holds some on 15, and it
    doubles the work of the solver.
    """
    sub_steps = finer * (SUB_STEPS_OF_MANY if spheres > MANY else SUB_STEPS)
    return Physics(
        friction=settings.friction,
        rolling_friction=0.0,
        restitution=settings.restitution,
        time_step=INTERVAL / sub_steps,
        sub_steps=sub_steps,
        iterations=ITERATIONS,
        scale=physics.scale,
    )


class Carriage:
    """A vessel in motion and the spheres (S, 3), in radii, that are still in it."""

    def __init__(self, world: World, basin: Basin, centers: np.ndarray):
        self.world, self.basin = world, basin
        self.over = basin.over(ASIDE)
        self.seen = centers  # where each was when its path was last checked
        self.crossed = 0
        p, engine = pybullet(), world.engine
        p.setPhysicsEngineParameter(contactERP=STIFFNESS, **engine)
        # Created where they lie: the engine is slow to forget contacts of bodies that waited together elsewhere.
        world.air = [world.add_body(world.sphere, 1.0, center) for center in centers]
        both = OBJECT | SPHERE
        p.setCollisionFilterGroupMask(world.object, -1, OBJECT, both, **engine)
        for body in world.air:
            p.setCollisionFilterGroupMask(body, -1, SPHERE, both, **engine)

    def carried(self, settings: CarrySettings, radius: float) -> CarryOutcome:
        """Carry the vessel and return the spheres that it keeps."""
        counts = []
        for phase in phases(settings, len(self.seen), radius):
            self.damp(0.0 if phase.shaken else DAMPING)
            for gravity in phase.gravity:
                if not self.world.air:
                    break
                self.advance(gravity)
            counts.append(len(self.world.air))
        return CarryOutcome(counts, self.seen if self.world.air else np.empty((0, 3)), self.crossed)

    def damp(self, damping: float):
        """Let spheres lose a share of their speed per unit of time."""
        for body in self.world.air:
            pybullet().changeDynamics(body, -1, linearDamping=damping, **self.world.engine)

    def advance(self, gravity: np.ndarray):
        """Advance by the time INTERVAL; spheres that have left the vessel are removed."""
        world = self.world
        pybullet().setGravity(*(world.scale * gravity).tolist(), **world.engine)
        world.step()
        centers = world.positions()
        lost = ~self.basin.known_of(self.over, centers)
        moved = lost.copy()
        if not mark_moved(centers, self.seen, UNSEEN, moved):
            return
        self.check_paths(centers, moved)
        for slot in np.flatnonzero(lost)[::-1]:
            pybullet().removeBody(world.air.pop(slot), **world.engine)
        self.seen = self.seen[~lost]

    def check_paths(self, centers: np.ndarray, rows: np.ndarray):
        """Count the spheres, among these rows, that have passed through the object since they were last checked."""
        scale = self.world.scale
        hits = pybullet().rayTestBatch(
            (scale * self.seen[rows]).tolist(),
            (scale * centers[rows]).tolist(),
            collisionFilterMask=OBJECT,
            **self.world.engine,
        )
        self.crossed += sum(body >= 0 for body, *_ in hits)
        self.seen = np.where(rows[:, None], centers, self.seen)


@lean_njit(cache=True, error_model="numpy")
def mark_moved(centers, seen, most, rows):
    """Mark the rows that have moved by more than a distance; return whether any row is marked."""
    some = False
    for n in range(len(rows)):
        x, y, z = centers[n, 0] - seen[n, 0], centers[n, 1] - seen[n, 1], centers[n, 2] - seen[n, 2]
        rows[n] |= np.sqrt(x * x + y * y + z * z) > most
        some |= rows[n]
    return some


def carry_result(
    kept: CarryOutcome,
    filling: Filling,
    basin: Basin,
    radius: float,
    settings: CarrySettings,
    seconds: float,
    provenance: dict[str, Any],
) -> CarryResult:
    """Return what an object kept of its filling; the radius is in metres."""
    *shares, shaken_share = (count / max(filling.full, 1) for count in kept.counts)
    return CarryResult(
        filled=len(filling.centers),
        radius=radius,
        holds=basin.fullness,
        angles_deg=settings.angles_deg,
        kept=tuple(shares),
        kept_shaken=shaken_share,
        centers=kept.centers * radius,
        weight=len(kept.centers) * settings.density * 4 / 3 * np.pi * radius**3,
        notes=notes_on(filling, basin),
        seconds=seconds,
        provenance=provenance,
    )


def notes_on(filling: Filling, basin: Basin) -> tuple[str, ...]:
    """Return remarks on a vessel for the user."""
    if not len(filling.centers):
        return ("nothing stays in it",)
    if basin.fullness < LEAKS:
        return (f"has a hole: below it, {100 * basin.fullness:.0f} % of what it would hold without one",)
    return ()
