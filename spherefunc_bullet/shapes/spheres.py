"""Spheres on a shape in the engine: where they come to rest, and the cost of a step while they lie on it."""

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

SPHERES, DROPS = 250, 600  # limits of a run
IN_CONTACT = 50
STEPS = 40  # that are timed, after as many that are not
APART = 4, 2  # collision group and mask of spheres that touch static bodies (the engine's group 2), but not each other
FEW = 4  # with fewer spheres in the same place on the object itself, nothing can be concluded
NEAR = 1.25  # radii: a sphere so near to one on the object is in the same place
DEEP = 0.8  # radii: a sphere whose centre is nearer to the surface of the object has sunk into it


@dataclass(frozen=True, kw_only=True, eq=False)
class SettledSpheres:
    """Spheres at rest on a shape."""

    centers: np.ndarray  # (S, 3) metres
    on_object: np.ndarray  # (S,) bool
    step_us: float  # duration of a time step with 50 of them in contact; NaN if it was not measured

    @property
    def touching(self) -> np.ndarray:
        """The centres (K, 3) of the spheres that touch the shape."""
        return self.centers[self.on_object]


def engine_shape(solid: Solid, radius: float) -> CollisionShape:
    """Return a shape as the engine loads it, in radii."""
    return CollisionShape(
        name=solid.name,
        kind="mesh",  # spheres at rest are checked against the surface of the shape only
        vertices=solid.vertices / radius,
        faces=solid.faces.astype(np.int32),
        pieces=None if solid.pieces is None else tuple(piece / radius for piece in solid.pieces),
        columns=dense_points(solid, 0.25 * radius) / radius,
    )


def settle_spheres(solid: Solid, cloud: Cloud, radius: float, seed: int, *, timed: bool = True) -> SettledSpheres:
    """Return where spheres come to rest on a shape if they are dropped over the footprint of its object's cloud.

    Parameters
    ----------
    timed : bool
        Whether to measure the duration of a time step.
    """
    simulator, shape = BulletSimulator(), engine_shape(solid, radius)
    settings = DropSettings(radius=radius, max_spheres=SPHERES, max_drops=DROPS)
    with World(simulator) as world:
        world.add_object(shape)
        run = DropRun(world, shape, cloud, settings, seed)
        run.until_over()
    result = run.result(0.0, {"backend": "", "version": "", "settings": {}, "seed": seed})
    step = step_cost(solid, result.centers[result.on_object], radius) if timed else float("nan")
    return SettledSpheres(centers=result.centers, on_object=result.on_object, step_us=step)


def step_cost(solid: Solid, centers: np.ndarray, radius: float) -> float:
    """Return the duration in microseconds of a time step with 50 spheres on a shape, all awake.

    It is the median of many, measured in processor time, so that other programs have no influence. If fewer spheres
    rest on the shape, several are put in one place; they do not touch each other.
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
    """The resting places of spheres on the object itself."""

    rests: tuple[SettledSpheres, ...]  # by seeds 0, 1
    surface: cKDTree  # of dense points on it
    radius: float

    def matched(self, centers: np.ndarray) -> int:
        """Return the number of centres (S, 3) that are in the place of a sphere of the first seed."""
        first = self.rests[0].centers
        if not len(first) or not len(centers):
            return 0
        return int((cKDTree(first).query(centers)[0] <= NEAR * self.radius).sum())

    @property
    def spread(self) -> float:
        """Share of the spheres of the first seed whose places another seed finds."""
        return self.matched(self.rests[1].centers) / max(1, len(self.rests[0].centers))

    def kept(self, rest: SettledSpheres) -> float:
        """Return the share of the spheres that rest in the same places on a shape as on the object.

        It is 1 if hardly any rest on the object, such as a round one.
        """
        expected = self.matched(self.rests[1].centers)
        return min(1.0, self.matched(rest.centers) / expected) if expected >= FEW else 1.0

    def deeper(self, rest: SettledSpheres) -> int:
        """Return the number of spheres on a shape that have sunk into the surface of the object."""
        return int((self.surface.query(rest.centers)[0] < DEEP * self.radius).sum()) if len(rest.centers) else 0


def moved(seen: ObjectRests, rest: SettledSpheres, surface: cKDTree) -> float:
    """Return how far resting places have moved, metres.

    It is the mean distance by which spheres at rest on the object miss the surface of the shape, and vice versa. The
    distance between the two sets of spheres would also contain the difference between two seeds.
    """
    ways = [(seen.rests[0].touching, surface), (rest.touching, seen.surface)]
    gaps = [np.abs(tree.query(centers)[0] - seen.radius).mean() for centers, tree in ways if len(centers)]
    return float(np.mean(gaps)) if len(gaps) == 2 else float("nan")
