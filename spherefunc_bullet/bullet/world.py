"""The Bullet world of one run: a static object, spheres in the air, and spheres at rest.

Lengths are in radii, times in sqrt(radius / g) (see `Physics`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from .collision.shape import CollisionShape
from .engine import Engine, Physics, pybullet
from .loading import load_shape, load_spheres, require_arrived

BAKED = 16  # spheres in one compound; createCollisionShapeArray silently drops any more
MANY = 256  # spheres in a batch from which on each of its compounds is loaded from a file
BAKED_OF_MANY = 64  # spheres in one of those compounds; with 128 a drop costs the same, with 256 more
TWINS = 16  # bodies for settled spheres that are not baked yet; each costs time at every step, even if unused
MERGED = 4  # number of batches of one size that are merged
STILL, UPRIGHT = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
FAR = 1e4  # radii: where bodies wait that are not in use


@dataclass(frozen=True, eq=False)
class BakedSpheres:
    """Settled spheres that were combined to compounds together."""

    centers: np.ndarray  # (S, 3)
    compounds: list[int]  # bodies


class World(Engine):
    """The engine of one run."""

    def __init__(self, physics: Physics):
        super().__init__(
            fixedTimeStep=physics.check_interval,
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
        self.batches: list[BakedSpheres] = []  # the others, larger batches first

    def add_object(self, shape: CollisionShape):
        """Add the object to the world.

        Raises
        ------
        InputError
            If the engine does not hold the whole shape.
        """
        number = load_shape(shape, self.scale, self.client)
        self.object = self.add_body(number, 0.0, [0, 0, 0])
        require_arrived(shape, self.object, self.scale, self.client)

    def add_spheres(self, count: int):
        """Create spheres to be dropped; they wait until they are placed."""
        self.air = [self.add_body(self.sphere, 1.0, waiting(i, FAR)) for i in range(count)]

    def add_twins(self) -> list[int]:
        """Return static bodies far away, created in one call, which takes a sixth of the time of separate calls."""
        places = [[self.scale * coordinate for coordinate in waiting(i, -FAR)] for i in range(TWINS)]
        shapes = {"baseCollisionShapeIndex": self.sphere, "baseVisualShapeIndex": self.visual}
        twins = pybullet().createMultiBody(batchPositions=places, useMaximalCoordinates=1, **shapes, **self.engine)
        for body in twins:
            self.set_material(body, moving=False)
        return list(twins)

    def add_body(self, shape: int, mass: float, position: Iterable[float]) -> int:
        """Return a new body with the material of this run."""
        place = [self.scale * float(coordinate) for coordinate in position]
        body = pybullet().createMultiBody(
            mass, shape, self.visual, basePosition=place, useMaximalCoordinates=1, **self.engine
        )
        self.set_material(body, moving=mass > 0)
        return body

    def set_material(self, body: int, moving: bool):
        """Set the friction and restitution of a body; moving bodies never sleep."""
        p, physics = pybullet(), self.physics
        # The engine multiplies the friction of two bodies, and the rolling friction of one with the friction of the
        # other; with 1 for static bodies, the values of the sphere apply.
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
        """Return the positions of the spheres in the air, (K, 3) radii."""
        get, client = pybullet().getBasePositionAndOrientation, self.client
        return np.array([get(body, client)[0] for body in self.air]) / self.scale

    def place(self, slot: int, position: Iterable[float]):
        """Move a sphere in the air to a position, at rest."""
        self._move(self.air[slot], position)
        pybullet().resetBaseVelocity(self.air[slot], STILL, STILL, self.client)

    def park(self, slot: int):
        """Move a sphere in the air to where it touches nothing."""
        self.place(slot, waiting(slot, FAR))

    def renew(self, slot: int):
        """Replace a sphere in the air whose position is no longer finite."""
        pybullet().removeBody(self.air[slot], **self.engine)
        self.air[slot] = self.add_body(self.sphere, 1.0, waiting(slot, FAR))

    def limit_speed(self, slot: int, limit: float):
        """Limit the speed of a sphere in the air, in radii per unit of time."""
        p = pybullet()
        linear, angular = p.getBaseVelocity(self.air[slot], self.client)
        speed = math.sqrt(np.dot(linear, linear)) / self.scale
        if speed > limit:
            p.resetBaseVelocity(self.air[slot], [v * limit / speed for v in linear], angular, **self.engine)

    def contacts(self, slot: int) -> tuple[float, float]:
        """Return the distances in radii of a sphere in the air from the object, and from the nearest body of all.

        They are negative for an overlap, and infinite if nothing is near.
        """
        points = pybullet().getContactPoints(bodyA=self.air[slot], **self.engine)
        distances = [(point[8] / self.scale, point[2] == self.object) for point in points]
        to_object = min((distance for distance, is_object in distances if is_object), default=np.inf)
        return to_object, min((distance for distance, _ in distances), default=np.inf)

    def freeze(self, center: np.ndarray):
        """Add a settled sphere, which is static for ever: at first a body of its own, later a part of a compound."""
        if len(self.fresh) == TWINS:
            self.bake()
        self._move(self.twins[len(self.fresh)], center)
        self.fresh.append(center)

    def bake(self):
        """Combine the settled spheres with bodies of their own to a batch of compounds, and merge batches of one size.

        Every body costs time at every step, moving or not, and every compound is tested against each sphere within its
        bounding box. So compounds contain neighbours, which are nearer to each other in larger batches.
        """
        for i, body in enumerate(self.twins):
            self._move(body, waiting(i, -FAR))
        self.batches.append(self._batch(np.array(self.fresh)))
        self.fresh = []
        while len(self.batches) >= MERGED and len(self.batches[-MERGED].centers) == len(self.batches[-1].centers):
            last, self.batches = self.batches[-MERGED:], self.batches[:-MERGED]
            for body in (body for batch in last for body in batch.compounds):
                pybullet().removeBody(body, **self.engine)  # its shape stays until the engine is closed
            self.batches.append(self._batch(np.concatenate([batch.centers for batch in last])))

    def _batch(self, centers: np.ndarray) -> BakedSpheres:
        if len(centers) < MANY:
            return BakedSpheres(centers, [self._compound(centers[group]) for group in neighbors(centers, BAKED)])
        groups = [centers[group] for group in neighbors(centers, BAKED_OF_MANY)]
        compounds = load_spheres(groups, self.scale, self.client)
        for body in compounds:
            self.set_material(body, moving=False)
        return BakedSpheres(centers, compounds)

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
    """Return a position far from everything, for a body that is not in use."""
    return [x, 10.0 * number, 0.0]


def neighbors(centers: np.ndarray, most: int) -> list[np.ndarray]:
    """Return the indices of centres in groups of at most ``most`` neighbours, by halving along the longest side."""
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
