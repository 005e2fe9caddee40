"""How an object can lie, dropped from many directions as a free rigid body, and whether it stands as it came.

It is let go on the ground alone, and with a load fixed at one place after another; many times at once, each time in a
place of its own. On level ground only the convex hull of a body is ever met. Lengths are in the body's largest extent,
times in sqrt(extent / g), masses in bodies; the hull's axes are the principal axes of inertia, as the engine wants
them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ...simulator.mechanics import Material, Pose, PoseSettings, Stance, StandSettings
from ...simulator.statics.body import Body
from ...simulator.statics.facets import Facets, at_rest, facets_of, share_of_rests, stable_poses, turned_down
from ...simulator.statics.standing import StandState, stance_at, stance_of_body
from ..engine import Engine, pybullet

STEP = 0.02  # of time: 6 ms at an extent of 1 m; half of it moves no share by more than another seed does
SUB_STEPS = 5  # between two looks
ITERATIONS = 20  # of the engine's solver
ROLLING = 0.01  # friction of rolling, in extents: without it what is round rolls for ever; it holds on an edge, too
APART = 3.0  # extents between places
REST_SPEED = 0.01  # of the centre, and of the surface through turning
REST_TIME = 1.0  # for which it has to be as slow
Settled = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class FreeBody:
    """A body's hull as the engine has it."""

    corners: np.ndarray  # (V, 3) about the centre of mass, along the principal axes
    inertia: np.ndarray  # (3,) about those
    axes: np.ndarray  # (3, 3), from the principal axes to the body's own

    def world_rotation(self, rotations: np.ndarray) -> np.ndarray:
        """Return rotations (N, 3, 3) of the body as rotations of its principal axes."""
        return rotations @ self.axes

    def down(self, turns: np.ndarray) -> np.ndarray:
        """Return which direction (N, 3) of the body points down, its principal axes turned by (N, 3, 3)."""
        return -turns[:, 2] @ self.axes.T


def free_body(body: Body) -> FreeBody:
    """Return a body in its own units and along its principal axes."""
    moments, axes = np.linalg.eigh(body.inertia / (body.mass * body.extent**2))
    axes = axes * np.sign(np.linalg.det(axes))
    return FreeBody((body.corners - body.center) / body.extent @ axes, np.maximum(moments, 1e-6), axes)


@dataclass(frozen=True, eq=False)
class Rests:
    """Where bodies came to rest."""

    down: np.ndarray  # (N, 3), the direction of the body that points down; NaN of what never rested
    rested: np.ndarray  # (N,) bool


class ParallelDropWorld(Engine):
    """An engine with a level ground."""

    def __init__(self, matter: Material):
        super().__init__(fixedTimeStep=STEP * SUB_STEPS, numSubSteps=SUB_STEPS, numSolverIterations=ITERATIONS)
        p, self.matter = pybullet(), matter
        p.setGravity(0, 0, -1, **self.engine)
        ground = p.createCollisionShape(p.GEOM_PLANE, **self.engine)
        number = p.createMultiBody(0, ground, self.visual, useMaximalCoordinates=1, **self.engine)
        # The engine multiplies friction and restitution of two bodies; with 1 for the ground the body's own hold.
        p.changeDynamics(number, -1, lateralFriction=1.0, restitution=1.0, **self.engine)

    def hull(self, body: FreeBody) -> int:
        """Return the engine's number of a body's hull."""
        return pybullet().createCollisionShape(pybullet().GEOM_MESH, vertices=body.corners.tolist(), **self.engine)

    def add(
        self, body: FreeBody, hull: int, turn: np.ndarray, clearance: float, place: int, rolling: float = ROLLING
    ) -> int:
        """Return a new body, turned by (3, 3), its lowest corner at a height over its place; friction in extents."""
        p = pybullet()
        lowest = float((body.corners @ turn[2]).min())
        number = p.createMultiBody(
            1.0,
            hull,
            self.visual,
            basePosition=[APART * (place % 16), APART * (place // 16), clearance - lowest],
            baseOrientation=Rotation.from_matrix(turn).as_quat().tolist(),
            useMaximalCoordinates=1,
            **self.engine,
        )
        p.changeDynamics(
            number,
            -1,
            mass=1.0,  # without it the engine takes the inertia for none
            localInertiaDiagonal=body.inertia.tolist(),
            lateralFriction=self.matter.friction,
            rollingFriction=rolling,
            spinningFriction=rolling,
            restitution=self.matter.restitution,
            linearDamping=0.0,
            angularDamping=0.0,
            activationState=p.ACTIVATION_STATE_DISABLE_SLEEPING,
            **self.engine,
        )
        return number

    def until_rest(self, bodies: Sequence[FreeBody], numbers: Sequence[int], settled: Settled, limit: float) -> Rests:
        """Let bodies move until each is at rest, or a time is over; those at rest are taken away.

        Parameters
        ----------
        settled : callable
            Says of which bodies (K,) and of what points down on each (K, 3) a stop is no moment of balance, (K,) bool.
        """
        p, left = pybullet(), np.arange(len(numbers))
        rests = Rests(np.full((len(numbers), 3), np.nan), np.zeros(len(numbers), bool))
        places, turns = self.state(numbers, left)
        slow = np.zeros(len(numbers))
        for _ in range(int(np.ceil(limit / (STEP * SUB_STEPS)))):
            p.stepSimulation(**self.engine)
            before = places, turns
            places, turns = self.state(numbers, left)
            slow[left] = np.where(moved(*before, places, turns) < REST_SPEED * STEP * SUB_STEPS, slow[left] + 1, 0)
            still = slow[left] * STEP * SUB_STEPS >= REST_TIME
            if not still.any():
                continue
            down = np.array([bodies[k].down(turn[None])[0] for k, turn in zip(left, turns, strict=True)])
            ended = still & settled(left, down)
            rests.down[left[ended]], rests.rested[left[ended]] = down[ended], True
            for number in left[ended]:
                p.removeBody(numbers[number], **self.engine)
            left, places, turns = left[~ended], places[~ended], turns[~ended]
            if not len(left):
                break
        return rests

    def state(self, numbers: Sequence[int], left: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return places (K, 3) and turns (K, 3, 3) of some bodies."""
        get = pybullet().getBasePositionAndOrientation
        rows = [get(numbers[k], **self.engine) for k in left]
        turns = Rotation.from_quat([row[1] for row in rows]).as_matrix() if rows else np.empty((0, 3, 3))
        return np.array([row[0] for row in rows]).reshape(-1, 3), turns


def moved(places: np.ndarray, turns: np.ndarray, new_places: np.ndarray, new_turns: np.ndarray) -> np.ndarray:
    """Return how far bodies have moved, or their surfaces by turning, whichever is more, (K,); unknown is far."""
    turned = np.linalg.norm((new_turns - turns).reshape(-1, 9), axis=1) / np.sqrt(2)
    return np.nan_to_num(np.maximum(np.linalg.norm(new_places - places, axis=1), turned), nan=np.inf)


GOLDEN = np.pi * (3 - np.sqrt(5))  # the angle between neighbours of a sunflower's seeds


def fallen_poses(body: Body, settings: PoseSettings, seed: int) -> tuple[tuple[Pose, ...], int]:
    """Return a body's poses by drops and by statics, and how many drops never came to rest."""
    facets, free = facets_of(body), free_body(body)
    turns = free.world_rotation(even_rotations(settings.drops, seed))
    with ParallelDropWorld(settings.matter) as world:
        hull = world.hull(free)
        numbers = [world.add(free, hull, turn, settings.fall, place) for place, turn in enumerate(turns)]
        bodies = [free] * len(numbers)
        rests = world.until_rest(bodies, numbers, lambda _, down: at_rest(facets, down), settings.time_limit)
    counts = share_of_rests(facets, rests.down[rests.rested])
    return stable_poses(facets, settings, counts), int((~rests.rested).sum())


def even_rotations(count: int, seed: int) -> np.ndarray:
    """Return rotations (N, 3, 3) whose downward directions are spread evenly over the sphere, turned at random.

    Random ones would need ten times as many for the same shares. Which way a body faces does not matter.
    """
    steps = np.arange(count)
    heights = 1 - (2 * steps + 1) / count
    level = np.sqrt(1 - heights**2)
    down = np.column_stack([level * np.cos(GOLDEN * steps), level * np.sin(GOLDEN * steps), heights])
    down = Rotation.random(random_state=seed).apply(down)
    return np.array([turned_down(direction) for direction in down])


def release(bodies: Sequence[Body], settings: StandSettings) -> list[StandState]:
    """Return what becomes of bodies that are let go on the ground in the pose they came in, each by itself."""
    frees, facets = [free_body(body) for body in bodies], [facets_of(body) for body in bodies]

    def settled(left: np.ndarray, down: np.ndarray) -> np.ndarray:
        return np.array([at_rest(facets[k], one[None])[0] for k, one in zip(left, down, strict=True)])

    with ParallelDropWorld(settings.matter) as world:
        numbers = []
        for place, (free, of_one) in enumerate(zip(frees, facets, strict=True)):
            # Friction of rolling would hold what stands on an edge, its weight beyond it: only what is round has it.
            rolling = 0.0 if stance_of_body(of_one, settings).flat else ROLLING
            turn = free.world_rotation(np.eye(3)[None])[0]
            numbers.append(world.add(free, world.hull(free), turn, 0.0, place, rolling))
        rests = world.until_rest(frees, numbers, settled, settings.time_limit)
    return [stand_of(rests, k, of_one, settings) for k, of_one in enumerate(facets)]


def stand_of(rests: Rests, k: int, facets: Facets, settings: StandSettings) -> StandState:
    """Return what became of one body."""
    if not rests.rested[k]:
        return StandState(stance=Stance.MOVES, tilt_deg=np.nan, down=np.full(3, np.nan), flat=False)
    return stance_at(facets, rests.down[k], settings)
