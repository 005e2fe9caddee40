"""What a thing is for among others: by the drops over its own box, of which those count that it carries itself."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from spherefunc_bullet.learning.function_model import FunctionModel, Membership, of_nobody
from spherefunc_bullet.settling.drops import NO_DROPS, WIDTH, Length, as_drops
from spherefunc_bullet.settling.settling import DENSE, FINE, HANDHELD, Settled, drop_settings, settle
from spherefunc_bullet.simulator import Simulator, make_simulator
from spherefunc_bullet.simulator.statics.falling_over import falls_over

from .falls import Falls, surroundings
from .placing import PlacedThing


def functions_alone(thing: PlacedThing, model: FunctionModel) -> dict[str, Membership]:
    """Return what a thing is for by itself, as `classify` says it."""
    drop = partial(settle, thing.own, model.simulator, model.chosen_radii(), model.seed)
    told = model.memberships_of([model.settled_by(drop)])[0]
    return of_nobody(told) if model.serves_nobody(told, lambda: falls_over(thing.own)) else told


def functions_among(things: Sequence[PlacedThing], number: int, model: FunctionModel) -> dict[str, Membership]:
    """Return what one of some things is for where they stand together."""
    simulator = make_simulator(model.simulator)

    def drop(length: Length) -> Settled:
        radii = model.chosen_radii()
        return {radius: drops_for(things, number, simulator, radius, model.seed, length) for radius in radii}

    return model.memberships_of([model.settled_by(drop)])[0]


def drops_for(
    things: Sequence[PlacedThing], number: int, simulator: Simulator, radius: float, seed: int, length: Length
) -> np.ndarray:
    """Return the drops (D, 6) of one radius, or the centres (S, 3) where a run has no stated number of them.

    In the thing's own frame, metres; what another thing carries did not settle.
    """
    own = things[number].own
    counted = length.drops is not None
    too_fine = counted and radius < FINE and own.size.max() > HANDHELD
    if too_fine or radius > own.size.max():
        return NO_DROPS if counted else np.empty((0, 3), np.float32)
    falls = surroundings(things, number, radius).drop(simulator, drop_settings(simulator, radius, length), seed)
    if not counted:
        return things[number].to_own(falls.centers[falls.by(number)]).astype(np.float32)
    return rows_of(falls, things, number)


def rows_of(falls: Falls, things: Sequence[PlacedThing], number: int) -> np.ndarray:
    """Return drops over a thing as rows (D, 6) float32 of its own frame."""
    asked, kept = things[number], falls.by(number)
    around = np.concatenate([asked.to_own(thing.cloud.thinned(DENSE * falls.radius)) for thing in things])
    begun = np.column_stack([falls.columns, np.zeros(len(falls.columns))])
    rows = np.full((len(kept), WIDTH), np.nan)
    rows[kept] = as_drops(asked.to_own(falls.centers[kept]), around, falls.radius)
    rows[:, :2] = asked.to_own(begun)[:, :2]
    return rows.astype(np.float32)
