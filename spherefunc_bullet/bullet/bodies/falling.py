"""Stable poses of an object that is dropped as a free rigid body, and whether it stands as it is.

For stances it is released on the ground, alone and with a load at one place after another. Many copies move at once,
far apart from each other. On level ground only the convex hull of a body makes contact. Lengths are in units of the
body's largest extent, times in sqrt(extent / g), masses in bodies; the axes of the hull are the principal axes of
inertia, as the engine needs them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ...simulator.mechanics import Material, Pose, PoseSettings, Stance, StandSettings
from ...simulator.statics.body import Body
from ...simulator.statics.facets import at_rest, facets_of, share_of_rests, stable_poses, turned_down
from ...simulator.statics.standing import StandState, stance_at, stance_of_body
from ..engine import Engine, pybullet

STEP = 0.02  # units of time: 6 ms at an extent of 1 m; half of it changes no share by more than another seed does
SUB_STEPS = 5  # between two checks
ITERATIONS = 20  # of the engine's solver
ROLLING = 0.01  # rolling friction, in extents: without it round bodies roll for ever; it also holds a body on an edge
APART = 3.0  # extents between places
REST_SPEED = 0.01  # of the centre, and of the surface due to rotation; a slower body may be at rest
REST_TIME = 1.0  # time for which it has to be so slow
GOLDEN = np.pi * (3 - np.sqrt(5))  # the angle between neighbours in a sunflower
Settled = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class FreeBody:
    """The convex hull of a body as the engine uses it."""

    corners: np.ndarray  # (V, 3) about the centre of mass, along the principal axes
    inertia: np.ndarray  # (3,) about those
    axes: np.ndarray  # (3, 3), from the principal axes to the body's own

    def world_rotation(self, rotations: np.ndarray) -> np.ndarray:
        """Return rotations (N, 3, 3) of the body as rotations of its principal axes."""
        return rotations @ self.axes

    def down(self, turns: np.ndarray) -> np.ndarray:
        """Return the directions (N, 3) of the body that point down for rotations (N, 3, 3) of its principal axes."""
        return -turns[:, 2] @ self.axes.T


def free_body(body: Body) -> FreeBody:
    """Return a body in units of its own size, along its principal axes."""
    moments, axes = np.linalg.eigh(body.inertia / (body.mass * body.extent**2))
    axes = axes * np.sign(np.linalg.det(axes))
    return FreeBody((body.corners - body.center) / body.extent @ axes, np.maximum(moments, 1e-6), axes)


class ParallelDropWorld(Engine):
    """An engine with level ground on which many bodies fall side by side."""

    def __init__(self, matter: Material):
        super().__init__(fixedTimeStep=STEP * SUB_STEPS, numSubSteps=SUB_STEPS, numSolverIterations=ITERATIONS)
        p, self.matter = pybullet(), matter
        p.setGravity(0, 0, -1, **self.engine)
        ground = p.createCollisionShape(p.GEOM_PLANE, **self.engine)
        number = p.createMultiBody(0, ground, self.visual, useMaximalCoordinates=1, **self.engine)
        # The engine multiplies friction and restitution of two bodies; with 1 for the ground, those of the body apply.
        p.changeDynamics(number, -1, lateralFriction=1.0, restitution=1.0, **self.engine)

    def hull(self, body: FreeBody) -> int:
        """Return the number in the engine of the hull of a body."""
        return pybullet().createCollisionShape(pybullet().GEOM_MESH, vertices=body.corners.tolist(), **self.engine)

    def add(
        self, body: FreeBody, hull: int, turn: np.ndarray, clearance: float, place: int, rolling: float = ROLLING
    ) -> int:
        """Return a new body, rotated by (3, 3), with its lowest corner at a height above its place."""
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
            mass=1.0,  # without it the engine ignores the inertia
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

    def until_rest(
        self, bodies: Sequence[FreeBody], numbers: Sequence[int], settled: Settled, limit: float
    ) -> np.ndarray:
        """Let bodies move until each is at rest, or until a time limit; bodies at rest are removed.

        Parameters
        ----------
        settled : callable
            Returns, for body numbers (K,) and the directions that point down (K, 3), whether each body that has stopped
            is at rest and not just balanced, (K,) bool.

        Returns
        -------
        (N, 3)
            The direction of each body that points down at rest; NaN for bodies that never came to rest.
        """
        p, left = pybullet(), np.arange(len(numbers))
        rests, slow = np.full((len(numbers), 3), np.nan), np.zeros(len(numbers))
        places, turns = self.state(numbers, left)
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
            rests[left[ended]] = down[ended]
            for number in left[ended]:
                p.removeBody(numbers[number], **self.engine)
            left, places, turns = left[~ended], places[~ended], turns[~ended]
            if not len(left):
                break
        return rests

    def state(self, numbers: Sequence[int], left: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return positions (K, 3) and rotations (K, 3, 3) of some bodies."""
        get = pybullet().getBasePositionAndOrientation
        rows = [get(numbers[k], **self.engine) for k in left]
        turns = Rotation.from_quat([row[1] for row in rows]).as_matrix() if rows else np.empty((0, 3, 3))
        return np.array([row[0] for row in rows]).reshape(-1, 3), turns


def moved(places: np.ndarray, turns: np.ndarray, new_places: np.ndarray, new_turns: np.ndarray) -> np.ndarray:
    """Return how far bodies or, by rotation, their surfaces have moved, the larger of both, (K,); infinite for NaN."""
    turned = np.linalg.norm((new_turns - turns).reshape(-1, 9), axis=1) / np.sqrt(2)
    return np.nan_to_num(np.maximum(np.linalg.norm(new_places - places, axis=1), turned), nan=np.inf)


def fallen_poses(body: Body, settings: PoseSettings, seed: int) -> tuple[tuple[Pose, ...], int]:
    """Return the poses of a body by drops and by statics, and the number of drops that never came to rest."""
    facets, free = facets_of(body), free_body(body)
    turns = free.world_rotation(even_rotations(settings.drops, seed))
    with ParallelDropWorld(settings.matter) as world:
        hull = world.hull(free)
        numbers = [world.add(free, hull, turn, settings.fall, place) for place, turn in enumerate(turns)]
        bodies = [free] * len(numbers)
        rests = world.until_rest(bodies, numbers, lambda _, down: at_rest(facets, down), settings.time_limit)
    rested = ~np.isnan(rests).any(axis=1)
    return stable_poses(facets, settings, share_of_rests(facets, rests[rested])), int((~rested).sum())


def even_rotations(count: int, seed: int) -> np.ndarray:
    """Return rotations (N, 3, 3) whose downward directions are spread evenly over the sphere, rotated at random.

    Random directions would need ten times as many drops for the same accuracy. The heading of a body does not matter.
    """
    steps = np.arange(count)
    heights = 1 - (2 * steps + 1) / count
    level = np.sqrt(1 - heights**2)
    down = np.column_stack([level * np.cos(GOLDEN * steps), level * np.sin(GOLDEN * steps), heights])
    down = Rotation.random(random_state=seed).apply(down)
    return np.array([turned_down(direction) for direction in down])


def release(bodies: Sequence[Body], settings: StandSettings) -> list[StandState]:
    """Return the stances of bodies that are released on the ground in their given poses, each by itself."""
    frees, facets = [free_body(body) for body in bodies], [facets_of(body) for body in bodies]

    def settled(left: np.ndarray, down: np.ndarray) -> np.ndarray:
        return np.array([at_rest(facets[k], one[None])[0] for k, one in zip(left, down, strict=True)])

    with ParallelDropWorld(settings.matter) as world:
        numbers = []
        for place, (free, of_one) in enumerate(zip(frees, facets, strict=True)):
            # Only round bodies have rolling friction: it would hold a body on an edge although its weight acts beyond.
            rolling = 0.0 if stance_of_body(of_one, settings).flat else ROLLING
            turn = free.world_rotation(np.eye(3)[None])[0]
            numbers.append(world.add(free, world.hull(free), turn, 0.0, place, rolling))
        rests = world.until_rest(frees, numbers, settled, settings.time_limit)
    moves = StandState(stance=Stance.MOVES, tilt_deg=np.nan, down=np.full(3, np.nan), flat=False)
    return [
        moves if np.isnan(down).any() else stance_at(of_one, down, settings)
        for of_one, down in zip(facets, rests, strict=True)
    ]
