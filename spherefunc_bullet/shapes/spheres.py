"""Spheres on a shape in the engine: where they come to rest, and what a step costs while they lie on it."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..bullet.backend import BulletSimulator
from ..bullet.collision.shape import CollisionShape
from ..bullet.dropping import DropRun
from ..bullet.world import World
from ..clouds.cloud import Cloud
from ..simulator import DropSettings
from .solid import Solid, dense_points

SPHERES, DROPS = 250, 600  # at most, of a run
IN_CONTACT = 50
STEPS = 40  # that are timed, after as many that are not
APART = 4, 2  # group and mask of spheres that meet what stands still, the engine's group 2, and not each other
FEW = 4  # spheres: no more than that rest on an object by chance
NEAR = 1.25  # radii: a sphere so near to one on the object is in its place
DEEP = 0.8  # radii: a centre that is nearer than that to the object's surface has sunk in it


@dataclass(frozen=True, kw_only=True, eq=False)
class SettledSpheres:
    """Spheres at rest on a shape."""

    centers: np.ndarray  # (S, 3) metres
    on_object: np.ndarray  # (S,) bool
    step_us: float  # of a time step with 50 of them in contact

    @property
    def touching(self) -> np.ndarray:
        """The centres (K, 3) of those that rest on the shape, not on other spheres alone."""
        return self.centers[self.on_object]


def engine_shape(solid: Solid, radius: float) -> CollisionShape:
    """Return a shape as the engine loads it, in radii."""
    return CollisionShape(
        name=solid.name,
        kind="mesh",  # spheres that rest on it are held against its own surface alone
        vertices=solid.vertices / radius,
        faces=solid.faces.astype(np.int32),
        pieces=None if solid.pieces is None else tuple(piece / radius for piece in solid.pieces),
        columns=dense_points(solid.vertices, solid.faces, 0.25 * radius) / radius,
    )


def at_rest(solid: Solid, cloud: Cloud, radius: float, seed: int) -> SettledSpheres:
    """Return where spheres come to rest on a shape, which are dropped over the footprint of its object's cloud."""
    simulator, shape = BulletSimulator(), engine_shape(solid, radius)
    settings = DropSettings(radius=radius, max_spheres=SPHERES, max_drops=DROPS)
    with World(simulator) as world:
        world.add_object(shape)
        run = DropRun(world, shape, cloud, settings, seed)
        run.until_over()
    result = run.result(0.0, {"backend": "", "version": "", "settings": {}, "seed": seed})
    step = step_cost(solid, result.centers[result.on_object], radius)
    return SettledSpheres(centers=result.centers, on_object=result.on_object, step_us=step)


def step_cost(solid: Solid, centers: np.ndarray, radius: float) -> float:
    """Return the microseconds of a time step with 50 spheres on a shape, all awake.

    The median of many, by the clock of the processor, so that other programs do not count. Where fewer lie on it, some
    are put into one place twice; they do not touch each other.
    """
    from ..bullet.engine import pybullet

    if not len(centers):
        return float("nan")
    p, simulator, seconds = pybullet(), BulletSimulator(), []
    with World(simulator) as world:
        world.add_object(engine_shape(solid, radius))
        world.add_spheres(IN_CONTACT)
        for slot in range(IN_CONTACT):
            world.place(slot, centers[slot % len(centers)] / radius)
            p.setCollisionFilterGroupMask(world.air[slot], -1, *APART, physicsClientId=world.client)
        for _ in range(2 * STEPS):
            started = time.thread_time()
            world.step()
            seconds.append(time.thread_time() - started)
    return float(np.median(seconds[STEPS:]) / simulator.sub_steps * 1e6)


@dataclass(frozen=True, kw_only=True, eq=False)
class ObjectRests:
    """Where spheres rest on the object itself."""

    rests: tuple[SettledSpheres, ...]  # by seeds 0, 1
    surface: cKDTree  # of dense points on it
    radius: float

    def matched(self, centers: np.ndarray) -> int:
        """Return how many of some centres (S, 3) lie in the place of a sphere of the first seed."""
        first = self.rests[0].centers
        if not len(first) or not len(centers):
            return 0
        return int((cKDTree(first).query(centers)[0] <= NEAR * self.radius).sum())

    @property
    def spread(self) -> float:
        """What another seed keeps of the first's spheres."""
        return self.matched(self.rests[1].centers) / max(1, len(self.rests[0].centers))

    def kept(self, rest: SettledSpheres) -> float:
        """Return the share of the spheres that rest on a shape in the places that they have on the object.

        Where none rests on the object, such as a round one, there is none to keep.
        """
        expected = self.matched(self.rests[1].centers)
        return min(1.0, self.matched(rest.centers) / expected) if expected >= FEW else 1.0

    def deeper(self, rest: SettledSpheres) -> int:
        """Return how many spheres on a shape have sunk into the object's surface."""
        return int((self.surface.query(rest.centers)[0] < DEEP * self.radius).sum()) if len(rest.centers) else 0


def moved(seen: ObjectRests, rest: SettledSpheres, surface: cKDTree) -> float:
    """Return how far resting places moved, metres: the mean of both directions.

    How far each sphere that rests on the object is from touching the shape, and the reverse. The distance from one
    set of spheres to the other would be that, and by how much two seeds differ.
    """
    ways = [(seen.rests[0].touching, surface), (rest.touching, seen.surface)]
    gaps = [np.abs(tree.query(centers)[0] - seen.radius).mean() for centers, tree in ways if len(centers)]
    return float(np.mean(gaps)) if len(gaps) == 2 else float("nan")
