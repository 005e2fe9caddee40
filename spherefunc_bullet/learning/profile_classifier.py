"""What an object is for, from resting profiles: one forest per function, over the quantities of all radii.

Used like `FunctionClassifier` from settled spheres on: `fit_settled`, `score_settled` and `memberships_of` take and
return the same. Which classifier, and what it was measured against, docs/method.md says.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from sklearn.base import BaseEstimator, ClassifierMixin, clone
from sklearn.ensemble import ExtraTreesClassifier
from sklearn.utils.validation import check_is_fitted

from ..settling.settling import Settled
from .calibration import AS_VOTED, Line, calibrated, calibration_line, held_out_votes
from .function_classifier import NO_SPHERES, Label, Membership, as_sets, memberships
from .resting_profile import FIRST, RestingProfile
from .validation import THRESHOLD

PROFILE_RADII = (0.01, 0.03)  # metres
TREES = 300


class ProfileClassifier(BaseEstimator):
    """Learn functions from labelled objects' settled spheres, and tell those of others: several, or none.

    Parameters
    ----------
    radii : sequence of float
        Of the spheres, metres; the quantities of all of them count together.
    first : int
        Settled spheres that are read at each radius, those that settled first.
    estimator : classifier, optional
        One with ``predict_proba``, copied for each function; by default `forest`.
    random_state : int
        Of the forests; with another estimator, its own counts.

    Attributes
    ----------
    functions_ : tuple of str
    estimators_ : list of classifier or None
        One for each function; None where all training objects have it or none has.
    lines_ : list of (float, float)
        What makes a probability of each one's votes, see `calibration`.
    profiles_ : (N, R * Q) float
        The training objects' quantities, radius by radius.
    members_ : (N, F) bool
    names_ : list of str
        What the training objects are called.
    """

    def __init__(
        self,
        radii: Sequence[float] = PROFILE_RADII,
        *,
        first: int = FIRST,
        estimator: ClassifierMixin | None = None,
        random_state: int = 0,
    ):
        self.radii = radii
        self.first = first
        self.estimator = estimator
        self.random_state = random_state

    def fit(self, X: Sequence[Settled], y: Sequence[Label]) -> ProfileClassifier:
        """Learn as `fit_settled` does, from objects that have no names."""
        return self.fit_settled(X, y, [""] * len(X))

    def fit_settled(self, settled: Sequence[Settled], y: Sequence[Label], names: Sequence[str]) -> ProfileClassifier:
        """Learn from settled centres: per object a dict of radius to (S, 3), as `settle` returns it."""
        if not len(settled) == len(y) == len(names):
            raise ValueError(f"got {len(settled)} objects, {len(y)} labels and {len(names)} names")
        labels = as_sets(y)
        functions = tuple(sorted(set().union(*labels)))
        return self.fit_profiles(self.profiles(settled), memberships(labels, functions), functions, names)

    def fit_profiles(
        self, profiles: np.ndarray, members: np.ndarray, functions: Sequence[str], names: Sequence[str]
    ) -> ProfileClassifier:
        """Learn from quantities (N, R * Q), as `profiles` returns them, and who has which function (N, F) bool."""
        self.functions_, self.names_ = tuple(functions), list(names)
        self.profiles_, self.members_ = profiles, members
        base = forest(self.random_state) if self.estimator is None else self.estimator
        self.estimators_ = [
            clone(base).fit(profiles, column) if column.any() and not column.all() else None for column in members.T
        ]
        self.lines_ = [self._line(base, column) for column in members.T]
        return self

    def profiles(self, settled: Sequence[Settled]) -> np.ndarray:
        """Return the quantities (N, R * Q) of objects, radius by radius."""
        return np.hstack(
            [
                RestingProfile(radius, first=self.first).transform(
                    [spheres.get(radius, NO_SPHERES) for spheres in settled]
                )
                for radius in self.radii
            ]
        )

    def quantity_names(self) -> list[str]:
        """Return the name of each column of `profiles`, such as ``level_height at 2 cm``."""
        names = RestingProfile().get_feature_names_out()
        return [f"{name} at {radius * 100:g} cm" for radius in self.radii for name in names]

    def score_settled(self, settled: Sequence[Settled], *, any_heading: bool = False) -> np.ndarray:
        """Return the scores (N, F) of objects, probabilities where training objects stand for what will be asked.

        ``any_heading`` changes nothing, as quantities do not depend on which way an object faces; it is here so that
        this classifier and `FunctionClassifier` can be asked alike.
        """
        check_is_fitted(self)
        return self.score_profiles(self.profiles(settled))

    def score_profiles(self, profiles: np.ndarray) -> np.ndarray:
        """Return the scores (N, F) of objects given as quantities (N, R * Q)."""
        scores = np.zeros((len(profiles), len(self.functions_)))
        if not len(profiles):
            return scores
        for column, (estimator, line) in enumerate(zip(self.estimators_, self.lines_, strict=True)):
            if estimator is None:
                scores[:, column] = self.members_[:, column].all()
            else:
                scores[:, column] = calibrated(estimator.predict_proba(profiles)[:, 1], line)
        return scores

    def memberships_of(self, settled: Sequence[Settled], *, any_heading: bool = False) -> list[dict[str, Membership]]:
        """Return what each object is for, by the function's name; see `score_settled`."""
        radius = self.radius_
        return [
            {
                name: Membership(member=score > THRESHOLD, score=round(score, 4), radius=radius[name])
                for name, score in zip(self.functions_, row, strict=True)
            }
            for row in self.score_settled(settled, any_heading=any_heading).tolist()
        ]

    @property
    def radius_(self) -> dict[str, float]:
        """The radius whose quantities count most for each function, metres; the largest where that is not known."""
        check_is_fitted(self)
        chosen = {}
        for name, estimator in zip(self.functions_, self.estimators_, strict=True):
            weights = getattr(estimator, "feature_importances_", np.zeros(self.profiles_.shape[1]))
            by_radius = dict(zip(self.radii, weights.reshape(len(self.radii), -1).sum(axis=1), strict=True))
            chosen[name] = max(sorted(by_radius, reverse=True), key=by_radius.get)
        return chosen

    def _line(self, base: ClassifierMixin, members: np.ndarray) -> Line:
        """Return what makes probabilities of one function's votes; too few examples leave them as they are."""
        if min(members.sum(), (~members).sum()) < 2:
            return AS_VOTED
        return calibration_line(held_out_votes(base, self.profiles_, members, self.random_state), members)


def forest(random_state: int = 0) -> ExtraTreesClassifier:
    """Return the classifier of one function.

    Members weigh as much as all others together: a rare function's few examples would be outvoted otherwise.
    """
    return ExtraTreesClassifier(TREES, class_weight="balanced", random_state=random_state)
