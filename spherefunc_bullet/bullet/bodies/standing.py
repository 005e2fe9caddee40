"""Does it stand? An object put on the ground as it came, alone and with a load fixed at one place after another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...simulator.mechanics import Stance, StandSettings
from ...simulator.statics.body import Body
from ...simulator.statics.facets import Facets, at_rest, facets_of
from ...simulator.statics.standing import Stand, let_down, stance_at
from .parallel_drops import ROLLING, ParallelDropWorld, Rests, free_body


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
