"""What an object is for among others: by the drops over its own box, of which those count that it carries itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from spherefunc_bullet.classification import decide
from spherefunc_bullet.function_model import FunctionModel, Membership
from spherefunc_bullet.settling.drops import LOST, Drops, DropsByRadius, RunLimit, fallen_where_they_rest, resting_drops
from spherefunc_bullet.settling.kept_object import CloudObject
from spherefunc_bullet.settling.settling import DENSE, drop_settings, no_drops, too_fine
from spherefunc_bullet.simulator import Outcome, Simulator, make_simulator

from .falls import Falls, surroundings
from .placing import ArrangedObject


def functions_alone(item: ArrangedObject, model: FunctionModel) -> dict[str, Membership]:
    """Return what an object is for by itself, as `classify` says it."""
    return decide(CloudObject(own=item.own, dropping=model.dropping()), model).memberships


def functions_among(objects: Sequence[ArrangedObject], number: int, model: FunctionModel) -> dict[str, Membership]:
    """Return what one of some objects is for where they stand together."""
    simulator = make_simulator(model.simulator)

    def drop(length: RunLimit) -> DropsByRadius:
        radii = model.chosen_radii()
        return {radius: drops_for(objects, number, simulator, radius, model.seed, length) for radius in radii}

    return model.memberships_by(model.read(drop).scores[None])[0]


def drops_for(
    objects: Sequence[ArrangedObject], number: int, simulator: Simulator, radius: float, seed: int, length: RunLimit
) -> Drops:
    """Return the drops of one radius in the object's own frame; what another object carries did not settle."""
    own = objects[number].own
    if too_fine(radius, own, length) or radius > own.size.max():
        return no_drops(radius, length)
    falls = surroundings(objects, number, radius).drop(simulator, drop_settings(simulator, radius, length), seed)
    if length.drops is None:
        return resting_drops(radius, objects[number].to_own(falls.centers[falls.by(number)]).astype(np.float32))
    return own_drops(falls, objects, number)


def own_drops(falls: Falls, objects: Sequence[ArrangedObject], number: int) -> Drops:
    """Return all drops over an object in its own frame."""
    asked, kept = objects[number], falls.by(number)
    around = np.concatenate([asked.to_own(item.cloud.thinned(DENSE * falls.radius)) for item in objects])
    begun = np.column_stack([falls.columns, np.zeros(len(falls.columns))])
    settled = fallen_where_they_rest(asked.to_own(falls.centers[kept]), around, falls.radius)
    return replace(
        settled,
        places=asked.to_own(begun)[:, :2].astype(np.float32),
        outcomes=np.where(kept, np.int8(Outcome.SETTLED), np.int8(LOST)),
        rests=settled.rests.astype(np.float32),
        walled_in=settled.walled_in.astype(np.float32),
    )
