"""The classifier by resting profiles: one forest per function, over the quantities of all radii.

The choice of classifier, and what it was compared with, is in docs/studies.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Unpack

import numpy as np
from sklearn.base import ClassifierMixin, clone
from sklearn.utils.validation import check_is_fitted

from ..errors import renamed, require_amount
from ..function_model import THRESHOLD
from ..settling.drops import DROPS, EARLY_DROPS, DropsByRadius, first_drops, typed_drops
from ..simulator import Simulator
from .classifier import BackendAlias, CloudClassifier, require_alike, simulator_argument
from .labels import Label, as_sets, memberships, more_members
from .method import PROFILE_RADII
from .profiles.calibration import (
    DEFAULT_UNSURE_RANGE,
    UNCALIBRATED,
    Calibration,
    CopyGroups,
    ScoreRange,
    calibrated,
    equal_source_weights,
    fit_calibration,
    fit_weighted,
    group_copies,
    held_out_votes,
    unsure_range,
)
from .profiles.forest import Forest, SceneForests, forest_from_sklearn
from .profiles.profile_model import ProfileModel
from .validation import quality

if TYPE_CHECKING:
    from sklearn.ensemble import ExtraTreesClassifier

TREES = 200


class FunctionClassifier(ProfileModel, CloudClassifier):
    """Learn functions from labelled clouds and predict those of others: several, or none.

    Parameters
    ----------
    simulator : str or Simulator
        A registered backend's name, or a simulator; ``backend=`` is the same.
    radii : sequence of float
        Of the spheres, metres; the forests use the quantities of all radii together.
    drops : int
        Spheres dropped on an object at each radius.
    early_drops : int
        Spheres after which an answer is given if it is sure, without dropping the rest; 0: always drop all.
    estimator : classifier, optional
        One with ``predict_proba``, copied for each function; by default `forest`.
    seed : int
        Of the drops.
    random_state : int
        Of the forests; another estimator has its own.
    cache : bool
        Whether spheres that have fallen on the same cloud before are looked up in the user's cache.

    Attributes
    ----------
    functions_ : tuple of str
    forests_ : list of Forest, classifier or None
        One for each function; the fitted estimator where ``estimator`` is no `ExtraTreesClassifier`; None where all
        training objects have the function, or none has.
    calibrations_ : list of (float, float)
        Slope and offset that turn the votes of each forest into probabilities, see `fit_calibration`.
    radius_ : dict of str to float
        The radius whose quantities are most important for each function, metres; the largest where that is unknown.
    profiles_ : (N, R * Q) float
        Quantities of the training objects, radius by radius.
    members_ : (N, F) bool
    names_ : list of str
        Names of the training objects.
    copy_groups_ : CopyGroups
        Which of them are copies of others.
    early_ : FunctionClassifier or None
        The classifier fitted to the first drops alone, by `fit` and `fit_settled`.
    familiar_distance_ : float
        Largest distance to the nearest training object at which an object counts as familiar; see `Ranks`.
    """

    def __init__(
        self,
        simulator: str | Simulator = "fast",
        *,
        radii: Sequence[float] = PROFILE_RADII,
        drops: int = DROPS,
        early_drops: int = EARLY_DROPS,
        estimator: ClassifierMixin | None = None,
        seed: int = 0,
        random_state: int = 0,
        cache: bool = True,
        **alias: Unpack[BackendAlias],
    ):
        self.simulator = simulator_argument(self, simulator, alias)
        self.radii = radii
        self.drops = drops
        self.early_drops = early_drops
        self.estimator = estimator
        self.seed = seed
        self.random_state = random_state
        self.cache = cache

    kin_ = renamed("FunctionClassifier.kin_", "copy_groups_")
    lines_ = renamed("FunctionClassifier.lines_", "calibrations_")
    familiar_ = renamed("FunctionClassifier.familiar_", "familiar_distance_")

    def fit_settled(
        self,
        settled: Sequence[DropsByRadius],
        y: Sequence[Label],
        names: Sequence[str],
        originals: Sequence[str] | None = None,
        sources: Sequence[str] | None = None,
    ) -> FunctionClassifier:
        """Learn from the drops of each object by radius, as `settle` returns them.

        Parameters
        ----------
        originals : sequence of str, optional
            Name in ``names`` of the object that each is a copy of; empty for originals. Copies weigh a tenth, and do
            not take part in the calibration.
        sources : sequence of str, optional
            Source of each object, empty for objects that are always learnt. The calibration then holds out one source
            after another, with all copies of its objects.
        """
        require_amount("drops", self.drops, least=1, whole=True)
        require_amount("early_drops", self.early_drops, whole=True)
        settled, labels = typed_drops(settled), as_sets(y)
        require_alike(settled, labels, names)
        functions = tuple(sorted(set().union(*labels)))
        copy_groups = group_copies(names, originals or [""] * len(names), sources)
        self.fit_profiles(self.profiles(settled), memberships(labels, functions), functions, names, copy_groups)
        if 0 < self.early_drops < self.drops:
            first = [first_drops(drops, self.early_drops) for drops in settled]
            self.early_ = self.of_drops(self.early_drops).fit_settled(first, labels, names, originals, sources)
        return self._set_familiar_distance()

    def add_settled(
        self, settled: Sequence[DropsByRadius], y: Sequence[Label], names: Sequence[str]
    ) -> FunctionClassifier:
        """Learn from more objects: the forests are fitted again to all examples.

        The forests for scans are discarded, since these objects have no surroundings.
        """
        self.require_fitted()
        self.scene_forests_, settled = None, typed_drops(settled)
        functions, members = more_members(self.functions_, self.members_, as_sets(y))
        profiles = np.vstack([self.profiles_, self.profiles(settled)])
        copy_groups = self.copy_groups_.with_more(len(names))
        self.fit_profiles(profiles, members, functions, [*self.names_, *names], copy_groups)
        if self.early_ is not None:
            self.early_.add_settled([first_drops(drops, self.early_.drops) for drops in settled], y, names)
        return self._set_familiar_distance()

    def of_drops(self, count: int) -> FunctionClassifier:
        """Return an unfitted copy for this number of drops, without early answers."""
        return clone(self).set_params(drops=count, early_drops=0)

    def fit_profiles(
        self,
        profiles: np.ndarray,
        members: np.ndarray,
        functions: Sequence[str],
        names: Sequence[str],
        copy_groups: CopyGroups | None = None,
        labelled: np.ndarray | None = None,
    ) -> FunctionClassifier:
        """Learn from quantities (N, R * Q), as `profiles` returns them, and memberships (N, F) bool.

        Parameters
        ----------
        labelled : (N, F) bool, optional
            Whether it is known if an object has a function; by default it is known of all.
        """
        from sklearn.ensemble import ExtraTreesClassifier

        self.radii_, self.functions_, self.names_ = tuple(self.radii), tuple(functions), list(names)
        self.profiles_, self.members_ = profiles, members
        self.copy_groups_ = group_copies(self.names_, [""] * len(self.names_)) if copy_groups is None else copy_groups
        labelled = np.ones_like(members) if labelled is None else labelled
        self.forests_, self.held_out_, self.calibrations_ = [], [], []
        self.unsure_ranges_, self.radius_ = {}, {}
        for name, column, known in zip(functions, members.T, labelled.T, strict=True):
            fitted, votes = self._fit_function(column, np.flatnonzero(known))
            calibration, self.unsure_ranges_[name] = self._calibrate(votes, column)
            self.forests_.append(forest_from_sklearn(fitted) if isinstance(fitted, ExtraTreesClassifier) else fitted)
            self.held_out_.append(votes)
            self.calibrations_.append(calibration)
            self.radius_[name] = self._radius(fitted)
        return self

    def fit_scene_forests(
        self, surroundings: np.ndarray, names: Sequence[str], members: np.ndarray, labelled: np.ndarray
    ) -> FunctionClassifier:
        """Fit forests that also use the surroundings (N, S) of the training objects; see `ProfileModel`.

        Parameters
        ----------
        members, labelled : (N, F) bool
            See `fit_profiles`, which must be called first.
        """
        features = np.hstack([self.profiles_, surroundings])
        how = self.functions_, self.names_, self.copy_groups_, labelled
        both = clone(self).fit_profiles(features, members, *how)
        forests = [each.to_float32() for each in both.forests_ if isinstance(each, Forest)]
        if len(forests) == len(self.functions_):  # else all examples have some function, or none has
            self.scene_forests_ = SceneForests(names=tuple(names), forests=forests, calibrations=both.calibrations_)
        return self

    def score_settled(self, settled: Sequence[DropsByRadius], *, any_heading: bool = False) -> np.ndarray:
        """Return the scores (N, F) of objects; see `ProfileModel`."""
        check_is_fitted(self, "members_")
        return super().score_settled(typed_drops(settled), any_heading=any_heading)

    def _radius(self, fitted: ClassifierMixin | None) -> float:
        """Return the radius whose quantities are most important to a classifier, metres."""
        count = len(self.radii) * len(self.quantities)  # the surroundings, which follow, belong to no radius
        weights = getattr(fitted, "feature_importances_", np.zeros(count))[:count]
        by_radius = dict(zip(self.radii, weights.reshape(len(self.radii), -1).sum(axis=1), strict=True))
        return max(sorted(by_radius, reverse=True), key=by_radius.get)

    def held_out_f_measures(self) -> dict[str, float | None]:
        """Return the F-measure of each function on held-out training objects, in three folds; None of too few examples.

        Only a classifier that was fitted in this process has them, not one that was read from a file.
        """
        held_out = getattr(self, "held_out_", [None] * len(self.functions_))
        return {
            name: None if votes is None else self._f_measure(calibrated(votes, calibration), column)
            for name, votes, calibration, column in zip(
                self.functions_, held_out, self.calibrations_, self.members_.T, strict=True
            )
        }

    def _fit_function(self, members: np.ndarray, rows: np.ndarray) -> tuple[ClassifierMixin | None, np.ndarray | None]:
        """Return a classifier fitted to the labelled rows of one function, and its held-out votes (N,).

        The classifier is None where all of them have the function, or none has; the votes are None for too few
        examples, and NaN for those that are not labelled.
        """
        base = forest(self.random_state) if self.estimator is None else self.estimator
        profiles, has, copy_groups = self.profiles_[rows], members[rows], self.copy_groups_.of(rows)
        if has.all() or not has.any():
            return None, None
        fitted = fit_weighted(base, profiles, has, copy_groups)
        if min(len(set(copy_groups.groups[side])) for side in (has, ~has)) < 2:
            return fitted, None
        votes = np.full(len(members), np.nan)
        votes[rows] = held_out_votes(base, profiles, has, copy_groups, self.random_state)
        return fitted, votes

    def _calibrate(self, votes: np.ndarray | None, members: np.ndarray) -> tuple[Calibration, ScoreRange]:
        """Return the calibration of the votes (N,) for one function, and the range of scores in which it is unsure.

        The range is measured where sources can be held out; all sources count equally, however many objects they have.
        """
        if votes is None:
            return UNCALIBRATED, DEFAULT_UNSURE_RANGE
        copy_groups, voted = self.copy_groups_, ~np.isnan(votes)
        rows = voted & ((copy_groups.weights == 1) | copy_groups.has_sources)
        calibration = fit_calibration(votes[rows], members[rows])
        if not copy_groups.has_sources:
            return calibration, DEFAULT_UNSURE_RANGE
        weights = equal_source_weights(copy_groups.sources[voted])
        return calibration, unsure_range(calibrated(votes[voted], calibration), members[voted], weights)

    def _f_measure(self, scores: np.ndarray, members: np.ndarray) -> float:
        """Return the F-measure of scores (N,) on the original training objects."""
        originals = (self.copy_groups_.weights == 1) & ~np.isnan(scores)
        return quality(members[originals], scores[originals] > THRESHOLD).f_measure


def forest(random_state: int) -> ExtraTreesClassifier:
    """Return the classifier of one function."""
    from .profiles.trees import PlainForest

    return PlainForest(TREES, random_state=random_state)
