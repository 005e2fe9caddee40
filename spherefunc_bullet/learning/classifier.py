"""What all classifiers of functions share: clouds go in, spheres fall on them, functions come out.

How settled spheres are read is a subclass's: as named quantities (`function_classifier`) or counted in cubes
(`cube_classifier`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from sklearn.base import BaseEstimator

from ..clouds.cloud import Cloud
from ..datasets.dataset import parse_functions
from ..errors import InputError
from ..settling.drops import Length
from ..settling.settling import Settled, settle
from ..simulator import Simulator
from .validation import THRESHOLD

Label = str | Iterable[str]  # an object's functions: a set, a list, ``'table;sittable'`` or ``'none'``


@dataclass(frozen=True, kw_only=True)
class Membership:
    """Whether an object has a function."""

    member: bool
    score: float  # 0 to 1, to four places
    radius: float  # of the spheres that count most, metres


class CloudClassifier(BaseEstimator, ABC):
    """A classifier of clouds by the spheres that fall on them, fitted or not.

    A subclass has the parameters ``simulator``, ``radii`` (metres) and ``seed``, and when fitted the attributes
    ``functions_``, ``names_``, ``members_`` (N, F) bool and ``radius_``.
    """

    simulator: str | Simulator
    radii: Sequence[float]
    seed: int
    functions_: tuple[str, ...]
    names_: list[str]
    members_: np.ndarray
    radius_: dict[str, float]

    @property
    @abstractmethod
    def length(self) -> Length:
        """How long its runs are."""

    @abstractmethod
    def fit_settled(self, settled: Sequence[Settled], y: Sequence[Label], names: Sequence[str]) -> CloudClassifier:
        """Learn from spheres that have fallen: per object what `settle` returns."""

    @abstractmethod
    def add_settled(self, settled: Sequence[Settled], y: Sequence[Label], names: Sequence[str]) -> CloudClassifier:
        """Learn from more objects, beside those that are known."""

    @abstractmethod
    def score_settled(self, settled: Sequence[Settled], *, any_heading: bool = False) -> np.ndarray:
        """Return the scores (N, F) of objects on which spheres have fallen."""

    @abstractmethod
    def chosen_radii(self) -> list[float]:
        """Return the radii that some function uses, ascending, metres."""

    def fit(self, X: Sequence[Cloud], y: Sequence[Label]) -> CloudClassifier:
        """Learn from clouds X and their functions y (each a set, a list, or ``'table;sittable'``, or ``'none'``)."""
        return self.fit_settled(self._settled(X, self.radii), y, [cloud.name for cloud in X])

    def partial_fit(self, X: Sequence[Cloud], y: Sequence[Label]) -> CloudClassifier:
        """Learn from more clouds: earlier examples stay, and all that is chosen is chosen anew."""
        if not hasattr(self, "members_"):
            return self.fit(X, y)
        return self.add_settled(self._settled(X, self.radii), y, [cloud.name for cloud in X])

    def predict_proba(self, X: Sequence[Cloud]) -> np.ndarray:
        """Return a score from 0 to 1 for each cloud and function (N, F), in the order of ``functions_``."""
        return self.score_settled(self._settled(X, self.chosen_radii()))

    def predict(self, X: Sequence[Cloud]) -> list[frozenset[str]]:
        """Return the functions of each cloud, an empty set for none."""
        return [
            frozenset(name for name, score in zip(self.functions_, row, strict=True) if score > THRESHOLD)
            for row in self.predict_proba(X)
        ]

    def memberships_of(self, settled: Sequence[Settled], *, any_heading: bool = False) -> list[dict[str, Membership]]:
        """Return what each object is for, by the function's name; see `score_settled`."""
        scores, radius = self.score_settled(settled, any_heading=any_heading), self.radius_
        return [
            {
                name: Membership(member=score > THRESHOLD, score=round(score, 4), radius=radius[name])
                for name, score in zip(self.functions_, row, strict=True)
            }
            for row in scores.tolist()
        ]

    def _settled(self, clouds: Sequence[Cloud], radii: Sequence[float]) -> list[Settled]:
        return [settle(cloud, self.simulator, radii, self.seed, self.length) for cloud in clouds]


def require_alike(settled: Sequence[Settled], labels: Sequence[frozenset[str]], names: Sequence[str]):
    """Raise ValueError if there are not as many labels and names as objects."""
    if not len(settled) == len(labels) == len(names):
        raise ValueError(f"got {len(settled)} objects, {len(labels)} labels and {len(names)} names")


def as_sets(labels: Sequence[Label]) -> list[frozenset[str]]:
    """Return each label as a set of functions.

    Examples
    --------
    >>> [sorted(functions) for functions in as_sets(["cup", "none", {"table", "sittable"}])]
    [['cup'], [], ['sittable', 'table']]
    """
    sets = [parse_functions(label) if isinstance(label, str) else frozenset(label) for label in labels]
    if not sets:
        raise InputError("training set: expected at least one labelled object, got none")
    return sets


def memberships(labels: Sequence[frozenset[str]], functions: Sequence[str]) -> np.ndarray:
    """Return which object has which function, (N, F) bool."""
    return np.array([[name in label for name in functions] for label in labels], bool).reshape(len(labels), -1)


def more_members(
    known: Sequence[str], members: np.ndarray, labels: Sequence[frozenset[str]]
) -> tuple[tuple[str, ...], np.ndarray]:
    """Return the functions, and who has which, after more objects have come to those known (N, F) bool."""
    functions = tuple(sorted(set(known).union(*labels)))
    nobody = np.zeros(len(members), bool)
    old = [members[:, list(known).index(name)] if name in known else nobody for name in functions]
    return functions, np.vstack([np.column_stack(old), memberships(labels, functions)])
