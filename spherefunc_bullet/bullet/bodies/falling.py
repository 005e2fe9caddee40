"""How an object can lie: dropped as a free rigid body from many directions, and let come to rest."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from ...simulator.mechanics import Pose, PoseSettings
from ...simulator.statics.body import Body
from ...simulator.statics.facets import at_rest, counted, facets_of, stable_poses, turned_down
from .parallel_drops import ParallelDropWorld, free_body

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
    counts = counted(facets, rests.down[rests.rested])
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
