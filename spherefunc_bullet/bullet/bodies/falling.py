"""How an object can lie, dropped from many directions as a free rigid body, and whether it stands as it came.

It is let go on the ground alone, and with a load fixed at one place after another.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from ...simulator.mechanics import Pose, PoseSettings, Stance, StandSettings
from ...simulator.statics.body import Body
from ...simulator.statics.facets import Facets, at_rest, counted, facets_of, stable_poses, turned_down
from ...simulator.statics.standing import Stand, let_down, stance_at
from .parallel_drops import ROLLING, ParallelDropWorld, Rests, free_body

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


def let_go(bodies: Sequence[Body], settings: StandSettings) -> list[Stand]:
    """Return what becomes of bodies that are let go on the ground in the pose they came in, each by itself."""
    frees, facets = [free_body(body) for body in bodies], [facets_of(body) for body in bodies]

    def settled(left: np.ndarray, down: np.ndarray) -> np.ndarray:
        return np.array([at_rest(facets[k], one[None])[0] for k, one in zip(left, down, strict=True)])

    with ParallelDropWorld(settings.matter) as world:
        numbers = []
        for place, (free, of_one) in enumerate(zip(frees, facets, strict=True)):
            # Friction of rolling would hold what stands on an edge, its weight beyond it: only what is round has it.
            rolling = 0.0 if let_down(of_one, settings).flat else ROLLING
            turn = free.world_rotation(np.eye(3)[None])[0]
            numbers.append(world.add(free, world.hull(free), turn, 0.0, place, rolling))
        rests = world.until_rest(frees, numbers, settled, settings.time_limit)
    return [stand_of(rests, k, of_one, settings) for k, of_one in enumerate(facets)]


def stand_of(rests: Rests, k: int, facets: Facets, settings: StandSettings) -> Stand:
    """Return what became of one body."""
    if not rests.rested[k]:
        return Stand(stance=Stance.MOVES, tilt_deg=np.nan, down=np.full(3, np.nan), flat=False)
    return stance_at(facets, rests.down[k], settings)
