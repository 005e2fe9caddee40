"""Two models for scans as one: their trees vote together.

Rooms take hours to scan, so a model that has learnt other rooms is worth more as a partner than replaced.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.profiles.calibration import Calibration
from spherefunc_bullet.learning.profiles.forest import LEAF, Forest, SceneForests


def join(model: FunctionClassifier, earlier: FunctionClassifier) -> FunctionClassifier:
    """Have the trees of an earlier model vote beside a model's own; training objects and doubts stay its own.

    Both have to be fitted to scans. Each tree has one vote, and the calibration is the mean of both, in log odds.

    Raises
    ------
    InputError
        If the two do not know the same functions, radii and surroundings, or the earlier one reads quantities that the
        model does not have.
    """
    require_alike(model, earlier)
    names, around = model.quantity_names(), list(model.scene_forests_.names)
    model.forests_ = joined_forests(model.forests_, earlier.forests_, places_of(earlier.quantity_names(), names))
    model.calibrations_ = mean_calibrations(model.calibrations_, earlier.calibrations_)
    places = places_of([*earlier.quantity_names(), *around], [*names, *around])
    model.scene_forests_ = SceneForests(
        names=model.scene_forests_.names,
        forests=joined_forests(model.scene_forests_.forests, earlier.scene_forests_.forests, places),
        calibrations=mean_calibrations(model.scene_forests_.calibrations, earlier.scene_forests_.calibrations),
    )
    return model


def require_alike(model: FunctionClassifier, earlier: FunctionClassifier):
    """Raise InputError if the trees of two models cannot vote together."""
    for what in ("functions_", "radii", "drops"):
        own, other = getattr(model, what), getattr(earlier, what)
        if own != other:
            raise InputError(f"the earlier model: expected {what.rstrip('_')} {own}, as the new one has, got {other}")
    scenes = earlier.scene_forests_
    if scenes is None or scenes.names != model.scene_forests_.names:
        raise InputError("the earlier model: expected one that has learnt the same surroundings of objects in scans")
    unknown = sorted(set(earlier.quantities) - set(model.quantities))
    if unknown:
        raise InputError(f"the earlier model reads quantities that the new one lacks: {', '.join(unknown)}")


def places_of(names: Sequence[str], among: Sequence[str]) -> np.ndarray:
    """Return where each of some names stands among others, (N,) int16."""
    place = {name: number for number, name in enumerate(among)}
    return np.array([place[name] for name in names], np.int16)


def joined_forests(own: Sequence[Forest], earlier: Sequence[Forest], places: np.ndarray) -> list[Forest]:
    """Return for each function one forest of the trees of both; ``places`` (Q,) are the earlier quantities' columns."""
    return [joined(one, reading(other, places)) for one, other in zip(own, earlier, strict=True)]


def reading(forest: Forest, places: np.ndarray) -> Forest:
    """Return a forest that reads the same quantities at other places (Q,)."""
    return replace(forest, feature=np.where(forest.feature == LEAF, np.int16(LEAF), places[forest.feature]))


def joined(one: Forest, other: Forest) -> Forest:
    """Return one forest of the trees of two."""
    start = np.int32(len(one.feature))
    moved = replace(other, roots=other.roots + start, below=other.below + start)
    return Forest(**{name: np.concatenate([values, getattr(moved, name)]) for name, values in one.arrays().items()})


def mean_calibrations(own: Sequence[Calibration], earlier: Sequence[Calibration]) -> list[Calibration]:
    """Return the mean calibration of each function."""
    return [tuple(pair) for pair in np.mean([own, earlier], axis=0).tolist()]
