"""The Bullet world of one run: an object that stands still, spheres in the air, and spheres at rest.

Lengths are in radii, times in sqrt(radius / g) (see `Physics`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from .collision.shape import CollisionShape
from .engine import Engine, Physics, pybullet
from .loading import load_shape, load_spheres, require_arrived

BAKED = 16  # spheres in one compound; createCollisionShapeArray silently drops what exceeds it
MANY = 256  # spheres in a batch from which on its compounds are worth a file each
BAKED_OF_MANY = 64  # spheres in one of those compounds; with 128 a drop costs the same, with 256 more
TWINS = 16  # spheres at rest that are bodies of their own before they are baked; each costs at every step, also unused
MERGED = 4  # batches of one size that are baked anew as one
STILL, UPRIGHT = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
FAR = 1e4  # radii: where bodies wait that are not in use


@dataclass(frozen=True, eq=False)
class BakedSpheres:
    """Settled spheres that were baked at once."""

    centers: np.ndarray  # (S, 3)
    compounds: list[int]  # bodies


class World(Engine):
    """The engine of one run."""

    def __init__(self, physics: Physics):
        super().__init__(
            fixedTimeStep=physics.look,
            numSubSteps=physics.sub_steps,
            numSolverIterations=physics.iterations,
            enableFileCaching=0,
        )
        p, self.physics, self.scale = pybullet(), physics, physics.scale
        p.setGravity(0, 0, -self.scale, **self.engine)
        self.sphere = p.createCollisionShape(p.GEOM_SPHERE, radius=self.scale, **self.engine)
        self.object = None
        self.air: list[int] = []  # bodies that move
        self.twins = self.add_twins()
        self.fresh: list[np.ndarray] = []  # settled centres that are twins
        self.batches: list[BakedSpheres] = []  # the others, larger ones first

    def add_object(self, shape: CollisionShape):
        """Put the object into the world.

        Raises
        ------
        InputError
            If the engine does not hold all of it.
        """
        number = load_shape(shape, self.scale, self.client)
        self.object = self.add_body(number, 0.0, [0, 0, 0])
        require_arrived(shape, self.object, self.scale, self.client)

    def add_spheres(self, count: int):
        """Make spheres that can be dropped; they wait until they are placed."""
        self.air = [self.add_body(self.sphere, 1.0, waiting(i, FAR)) for i in range(count)]

    def add_twins(self) -> list[int]:
        """Return bodies that stand still, far away: made in one call, a sixth of the time of one by one."""
        places = [[self.scale * coordinate for coordinate in waiting(i, -FAR)] for i in range(TWINS)]
        shapes = {"baseCollisionShapeIndex": self.sphere, "baseVisualShapeIndex": self.visual}
        twins = pybullet().createMultiBody(batchPositions=places, useMaximalCoordinates=1, **shapes, **self.engine)
        for body in twins:
            self.set_material(body, moving=False)
        return list(twins)

    def add_body(self, shape: int, mass: float, position: Iterable[float]) -> int:
        """Return a new body with this run's material."""
        place = [self.scale * float(coordinate) for coordinate in position]
        body = pybullet().createMultiBody(
            mass, shape, self.visual, basePosition=place, useMaximalCoordinates=1, **self.engine
        )
        self.set_material(body, moving=mass > 0)
        return body

    def set_material(self, body: int, moving: bool):
        """Give a body this run's friction, and what moves no sleep."""
        p, physics = pybullet(), self.physics
        # The engine multiplies friction of two bodies, and rolling friction of one with friction of the other; with 1
        # for what stands still the sphere's own values hold.
        p.changeDynamics(
            body,
            -1,
            lateralFriction=physics.friction if moving else 1.0,
            rollingFriction=physics.rolling_friction * self.scale if moving else 0.0,
            spinningFriction=0.0,
            restitution=physics.restitution if moving else 1.0,
            linearDamping=0.0,
            angularDamping=0.0,
            **({"activationState": p.ACTIVATION_STATE_DISABLE_SLEEPING} if moving else {}),
            **self.engine,
        )

    def step(self):
        """Advance by ``sub_steps`` time steps."""
        pybullet().stepSimulation(self.client)

    def positions(self) -> np.ndarray:
        """Return where the spheres in the air are, (K, 3) radii."""
        get, client = pybullet().getBasePositionAndOrientation, self.client
        return np.array([get(body, client)[0] for body in self.air]) / self.scale

    def place(self, slot: int, position: Iterable[float]):
        """Put a sphere of the air somewhere, without speed."""
        self._move(self.air[slot], position)
        pybullet().resetBaseVelocity(self.air[slot], STILL, STILL, self.client)

    def park(self, slot: int):
        """Put a sphere of the air where it touches nothing."""
        self.place(slot, waiting(slot, FAR))

    def renew(self, slot: int):
        """Replace a sphere of the air that the engine has lost."""
        pybullet().removeBody(self.air[slot], **self.engine)
        self.air[slot] = self.add_body(self.sphere, 1.0, waiting(slot, FAR))

    def limit_speed(self, slot: int, limit: float):
        """Slow a sphere of the air down to a speed, radii per unit of time."""
        p = pybullet()
        linear, angular = p.getBaseVelocity(self.air[slot], self.client)
        speed = math.sqrt(np.dot(linear, linear)) / self.scale
        if speed > limit:
            p.resetBaseVelocity(self.air[slot], [v * limit / speed for v in linear], angular, **self.engine)

    def contacts(self, slot: int) -> tuple[float, float]:
        """Return the least distance of a sphere in the air from the object, and from anything, in radii.

        Negative where they overlap, infinite where they are not near.
        """
        points = pybullet().getContactPoints(bodyA=self.air[slot], **self.engine)
        distances = [(point[8] / self.scale, point[2] == self.object) for point in points]
        to_object = min((distance for distance, is_object in distances if is_object), default=np.inf)
        return to_object, min((distance for distance, _ in distances), default=np.inf)

    def freeze(self, center: np.ndarray):
        """Let a sphere stand still for ever: a twin at first, part of a compound later."""
        if len(self.fresh) == TWINS:
            self.bake()
        self._move(self.twins[len(self.fresh)], center)
        self.fresh.append(center)

    def bake(self):
        """Turn the twins into a compound, and batches of which there are too many of one size into a larger one.

        Every body costs at every step, whether it moves or not, and every compound is asked by each sphere within
        its box. So compounds hold neighbours: the more a batch has, the nearer they are.
        """
        for i, body in enumerate(self.twins):
            self._move(body, waiting(i, -FAR))
        self.batches.append(self._batch(np.array(self.fresh)))
        self.fresh = []
        while len(self.batches) >= MERGED and len(self.batches[-MERGED].centers) == len(self.batches[-1].centers):
            last, self.batches = self.batches[-MERGED:], self.batches[:-MERGED]
            for batch in last:
                for body in batch.compounds:
                    pybullet().removeBody(body, **self.engine)  # its shape stays until the engine is closed
            self.batches.append(self._batch(np.concatenate([batch.centers for batch in last])))

    def _batch(self, centers: np.ndarray) -> BakedSpheres:
        many = len(centers) >= MANY
        groups = [centers[group] for group in neighbors(centers, BAKED_OF_MANY if many else BAKED)]
        return BakedSpheres(centers, self._files(groups) if many else [self._compound(group) for group in groups])

    def _files(self, groups: Sequence[np.ndarray]) -> list[int]:
        bodies = load_spheres(groups, self.scale, self.client)
        for body in bodies:
            self.set_material(body, moving=False)
        return bodies

    def _compound(self, centers: np.ndarray) -> int:
        shape = pybullet().createCollisionShapeArray(
            shapeTypes=[pybullet().GEOM_SPHERE] * len(centers),
            radii=[self.scale] * len(centers),
            collisionFramePositions=(self.scale * centers).tolist(),
            **self.engine,
        )
        return self.add_body(shape, 0.0, [0, 0, 0])

    def _move(self, body: int, position: Iterable[float]):
        x, y, z = position
        place = (self.scale * x, self.scale * y, self.scale * z)
        pybullet().resetBasePositionAndOrientation(body, place, UPRIGHT, self.client)


def waiting(number: int, x: float) -> list[float]:
    """Return a place far from everything, for a body that is not in use."""
    return [x, 10.0 * number, 0.0]


def neighbors(centers: np.ndarray, most: int) -> list[np.ndarray]:
    """Return indices of centres in groups of at most this many, all near each other: halved along the longest side."""
    groups, stack = [], [np.arange(len(centers))]
    while stack:
        group = stack.pop()
        if len(group) <= most:
            groups.append(group)
            continue
        inside = centers[group]
        axis = np.argmax(inside.max(axis=0) - inside.min(axis=0))
        half = most * ((len(group) + 2 * most - 1) // (2 * most))
        order = group[np.argsort(inside[:, axis], kind="stable")]
        stack += [order[half:], order[:half]]
    return groups
