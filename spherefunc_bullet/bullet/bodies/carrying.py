"""Does it keep what it holds? The filled vessel is tilted to all sides, farther each time, shaken and set down.

In the object's own frame that is gravity that turns and shakes, so the shape on which spheres settled serves as it is.
Lengths are in radii, times in sqrt(radius / g), as in `World`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...clouds.flooding import Basin
from ...errors import InputError
from ...simulator import DropResult, Stop
from ...simulator.mechanics import CarryResult, CarrySettings
from ..collision.shape import CollisionShape
from ..engine import Physics, pybullet
from ..world import World

G = 9.81  # m/s2
LOOK = 0.5  # of time, in which gravity is the same
TURNING = 3.0, 14.0  # degrees in a unit of time, at least and at most: once around in 0.6 to 2.7 s at a radius of 5 mm
SPHERES = 20.0  # more of them, one degree faster: slower changes little where they are few, and many cost too much
LEANING = 0.25  # of the turning
WAITING = 3.0  # times at each angle before it turns, and after it is set down
CYCLES = 1  # of shaking along each axis


@dataclass(frozen=True, eq=False)
class MotionPhase:
    """A part of the way."""

    gravity: np.ndarray  # (L, 3) in g
    shaken: bool


def phases(settings: CarrySettings, spheres: int, radius: float) -> Iterator[MotionPhase]:
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
        yield MotionPhase(tilted(angles, headings), shaken=False)
        before = angle
    back = np.linspace(before, 0, wait)
    yield MotionPhase(np.concatenate([tilted(back, np.zeros(wait)), shaken(settings, radius)]), shaken=True)


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


SUB_STEPS = 4  # of a look
MANY, SUB_STEPS_OF_MANY = 150, 3  # spheres from which on each costs more
ITERATIONS = 16  # of the solver: with 5 a pile squeezes its lowest spheres through the wall
STIFFNESS = 0.5  # share of an overlap that a step takes away; by the engine's 0.2 piles overlap by twice as much
DAMPING = 0.1  # share of its speed that a sphere loses in a unit of time while it is tilted: none flies over a rim
FINER = 1, 2, 4  # times as many steps, tried in turn until no sphere goes through a wall
UNSEEN = 0.5  # radii that a sphere moves before its way is looked at: what goes through a wall moves farther
ASIDE = 0.6  # radii that a centre may be beside the vessel: on the rim it is farther out
OBJECT, SPHERE = 1, 2  # collision groups, so that rays can meet the object alone
LEAKS = 0.9  # of what a vessel would hold without holes: if it holds less, the answer says so


@dataclass(frozen=True, eq=False)
class Filling:
    """The spheres with which a vessel is carried."""

    centers: np.ndarray  # (S, 3) radii
    full: int  # spheres that it would be filled with if its walls had no holes


@dataclass(frozen=True, eq=False)
class CarryOutcome:
    """What stayed."""

    counts: list[int]  # after each phase
    centers: np.ndarray  # (S, 3) radii
    crossed: int  # ways of spheres that went through the object


def filling_of(result: DropResult, radius: float, basin: Basin, fill: float) -> Filling:
    """Return the lowest of the spheres that settled in a basin, up to a share of what it would hold without holes.

    A basin for which there were not enough spheres is filled with all of them.

    Parameters
    ----------
    radius : float, metres
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
    """Return what an object keeps of its filling; the radius in metres, which says how fast a frequency in Hz is.

    Raises
    ------
    InputError
        If spheres go through its walls, however small the steps.
    """
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
    """Return a backend's physics as it is for carrying this many spheres.

    Without friction of rolling: it is there to hold what has settled on 5 degrees, but it holds some spheres on 15, and
    it doubles what the solver has to do.
    """
    sub_steps = finer * (SUB_STEPS_OF_MANY if spheres > MANY else SUB_STEPS)
    return Physics(
        friction=settings.friction,
        rolling_friction=0.0,
        restitution=settings.restitution,
        time_step=LOOK / sub_steps,
        sub_steps=sub_steps,
        iterations=ITERATIONS,
        scale=physics.scale,
    )


class Carriage:
    """A vessel on its way with the spheres (S, 3), in radii, that are still in it."""

    def __init__(self, world: World, basin: Basin, centers: np.ndarray):
        self.world, self.basin = world, basin
        self.over = basin.over(ASIDE)
        self.seen = centers  # where each was when its way was last looked at
        self.crossed = 0
        p, engine = pybullet(), world.engine
        p.setPhysicsEngineParameter(contactERP=STIFFNESS, **engine)
        # Made where they lie: the engine forgets only slowly that bodies were together where they waited.
        world.air = [world.add_body(world.sphere, 1.0, center) for center in centers]
        both = OBJECT | SPHERE
        p.setCollisionFilterGroupMask(world.object, -1, OBJECT, both, **engine)
        for body in world.air:
            p.setCollisionFilterGroupMask(body, -1, SPHERE, both, **engine)

    def carried(self, settings: CarrySettings, radius: float) -> CarryOutcome:
        """Return what is kept of the spheres."""
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
        """Have spheres lose a share of their speed in a unit of time."""
        for body in self.world.air:
            pybullet().changeDynamics(body, -1, linearDamping=damping, **self.world.engine)

    def advance(self, gravity: np.ndarray):
        """Go on for one look; what has left the vessel is taken away."""
        world = self.world
        pybullet().setGravity(*(world.scale * gravity).tolist(), **world.engine)
        world.step()
        centers = world.positions()
        lost = ~self.basin.known_of(self.over, centers)
        self.check_paths(centers, lost | (np.linalg.norm(centers - self.seen, axis=1) > UNSEEN))
        for slot in np.flatnonzero(lost)[::-1]:
            pybullet().removeBody(world.air.pop(slot), **world.engine)
        self.seen = self.seen[~lost]

    def check_paths(self, centers: np.ndarray, rows: np.ndarray):
        """Count the centres that have come through the object since they were last seen, of those that are asked."""
        if not rows.any():
            return
        scale = self.world.scale
        hits = pybullet().rayTestBatch(
            (scale * self.seen[rows]).tolist(),
            (scale * centers[rows]).tolist(),
            collisionFilterMask=OBJECT,
            **self.world.engine,
        )
        self.crossed += sum(body >= 0 for body, *_ in hits)
        self.seen = np.where(rows[:, None], centers, self.seen)


def carry_result(
    kept: CarryOutcome | None,
    filling: Filling,
    basin: Basin,
    radius: float,
    settings: CarrySettings,
    seconds: float,
    provenance: dict[str, Any],
) -> CarryResult:
    """Return what an object kept of its filling, or of none; the radius in metres."""
    counts = [0] * (len(settings.angles_deg) + 1) if kept is None else kept.counts
    shares = [count / max(filling.full, 1) for count in counts]
    centers = np.empty((0, 3)) if kept is None else kept.centers * radius
    return CarryResult(
        filled=len(filling.centers),
        radius=radius,
        holds=basin.fullness,
        angles_deg=settings.angles_deg,
        kept=tuple(shares[:-1]),
        kept_shaken=shares[-1],
        centers=centers,
        weight=len(centers) * settings.density * 4 / 3 * np.pi * radius**3,
        notes=notes_on(filling, basin),
        seconds=seconds,
        provenance=provenance,
    )


def notes_on(filling: Filling, basin: Basin) -> tuple[str, ...]:
    """Return what a reader has to know of a vessel."""
    if not len(filling.centers):
        return ("nothing stays in it",)
    if basin.fullness < LEAKS:
        return (f"has a hole: below it, {100 * basin.fullness:.0f} % of what it would hold without one",)
    return ()
