"""A fitted model by resting profiles: what is asked of `FunctionClassifier`, which learns it."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import TYPE_CHECKING, Self

import numpy as np

from ...settling.drops import Length
from ...settling.settling import Settled
from ...simulator import Simulator
from ..function_model import FunctionModel
from .calibration import Kin, Line, calibrated
from .forest import Forest
from .quantities import NAMES, profiles_over

if TYPE_CHECKING:
    from sklearn.base import ClassifierMixin

PROFILE = "profile"  # the method's name


class ProfileModel(FunctionModel):
    """Tell what objects are for from their quantities, with one forest for each function.

    Parameters
    ----------
    simulator : str or Simulator
    radii : sequence of float
        Of the spheres, metres.
    drops : int
        Spheres dropped on an object at each radius.
    seed : int
        Of the drops.

    Attributes
    ----------
    functions_, forests_, lines_, radius_, profiles_, members_, names_, kin_, familiar_
        What was learnt, see `FunctionClassifier`.
    """

    drops: int
    forests_: list[Forest | ClassifierMixin | None]
    lines_: list[Line]
    profiles_: np.ndarray  # (N, R * Q) float
    kin_: Kin
    familiar_: float

    def __init__(self, simulator: str | Simulator, *, radii: Sequence[float], drops: int, seed: int):
        self.simulator = simulator
        self.radii = radii
        self.drops = drops
        self.seed = seed

    @property
    def length(self) -> Length:
        """How long its runs are."""
        return Length(drops=self.drops)

    def profiles(self, settled: Sequence[Settled]) -> np.ndarray:
        """Return the quantities (N, R * Q) of objects, radius by radius; all 0 where no sphere was dropped."""
        return profiles_over(settled, self.radii)

    def quantity_names(self) -> list[str]:
        """Return the name of each column of `profiles`, such as ``level_height at 2 cm``."""
        return [f"{name} at {radius * 100:g} cm" for radius in self.radii for name in NAMES]

    def score_settled(self, settled: Sequence[Settled], *, any_heading: bool = False) -> np.ndarray:
        """Return the scores (N, F) of objects, probabilities where training objects stand for what will be asked.

        ``any_heading`` changes nothing, as quantities do not depend on which way an object faces.
        """
        return self.score_profiles(self.profiles(settled))

    def score_profiles(self, profiles: np.ndarray) -> np.ndarray:
        """Return the scores (N, F) of objects given as quantities (N, R * Q)."""
        scores = np.zeros((len(profiles), len(self.functions_)))
        if not len(profiles):
            return scores
        for column, (one, line) in enumerate(zip(self.forests_, self.lines_, strict=True)):
            if one is None:
                scores[:, column] = self.members_[:, column].all()
            else:
                scores[:, column] = calibrated(votes_of(one, profiles), line)
        return scores

    def chosen_radii(self) -> list[float]:
        """Return the radii, ascending, metres; all of them count."""
        return sorted(self.radii)

    def only(self, name: str) -> Self:
        """Return a fitted copy that is asked for one function alone, by its forest."""
        alone, column = copy(self), self.column_of(name)
        alone.functions_, alone.members_ = (name,), self.members_[:, [column]]
        alone.forests_, alone.lines_ = [self.forests_[column]], [self.lines_[column]]
        alone.radius_ = {name: self.radius_[name]}
        return alone


def votes_of(one: Forest | ClassifierMixin, profiles: np.ndarray) -> np.ndarray:
    """Return what a forest, or another classifier, says of objects (N,) given as quantities."""
    return one.votes(profiles) if isinstance(one, Forest) else one.predict_proba(profiles)[:, 1]
