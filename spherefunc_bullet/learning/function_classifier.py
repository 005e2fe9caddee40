"""What an object is for, from resting profiles: one forest per function, over the quantities of all radii.

Which classifier, and what it was measured against, docs/studies.md says.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Unpack

import numpy as np
from sklearn.base import ClassifierMixin, clone
from sklearn.utils.validation import check_is_fitted

from ..errors import warn_renamed
from ..function_model import THRESHOLD
from ..settling.drops import DROPS, EARLY_DROPS, DropsByRadius, first_drops, typed_drops
from ..simulator import Simulator
from .classifier import Alias, CloudClassifier, require_alike, simulator_named
from .labels import Label, as_sets, memberships, more_members
from .method import PROFILE_RADII
from .profiles.calibration import (
    AS_VOTED,
    UNSURE,
    Band,
    CopyGroups,
    Line,
    calibrated,
    calibration_line,
    even_sources,
    group_copies,
    grown_on,
    held_out_votes,
    unsure_band,
)
from .profiles.forest import Forest, SceneForests, forest_of
from .profiles.profile_model import ProfileModel
from .validation import quality

if TYPE_CHECKING:
    from sklearn.ensemble import ExtraTreesClassifier

TREES = 200


class FunctionClassifier(ProfileModel, CloudClassifier):
    """Learn functions from labelled clouds, and tell those of others: several, or none.

    Parameters
    ----------
    simulator : str or Simulator
        A registered backend's name, or a simulator; ``backend=`` is the same.
    radii : sequence of float
        Of the spheres, metres; the quantities of all of them count together.
    drops : int
        Spheres dropped on an object at each radius.
    early_drops : int
        Spheres after which an answer is given if it is sure, without dropping the others; 0: always drop all.
    estimator : classifier, optional
        One with ``predict_proba``, copied for each function; by default `forest`.
    seed : int
        Of the drops.
    random_state : int
        Of the forests; with another estimator, its own counts.
    cache : bool
        Whether spheres that have fallen on the same cloud before are looked up in the user's cache.

    Attributes
    ----------
    functions_ : tuple of str
    forests_ : list of Forest, classifier or None
        One for each function, a classifier where ``estimator`` is none of extremely random trees; None where all
        training objects have the function or none has.
    lines_ : list of (float, float)
        What makes a probability of each one's votes, see `calibration`.
    radius_ : dict of str to float
        The radius whose quantities count most for each function, metres; the largest where that is not known.
    profiles_ : (N, R * Q) float
        The training objects' quantities, radius by radius.
    members_ : (N, F) bool
    names_ : list of str
        What the training objects are called.
    copy_groups_ : CopyGroups
        Which of them are changed copies of others.
    early_ : FunctionClassifier or None
        What was learnt from the first drops alone, by `fit` and `fit_settled`.
    familiar_ : float
        How far from all training objects an object may be to count as one of their kind; see `Ranks`.
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
        **alias: Unpack[Alias],
    ):
        self.simulator = simulator_named(simulator, **alias)
        self.radii = radii
        self.drops = drops
        self.early_drops = early_drops
        self.estimator = estimator
        self.seed = seed
        self.random_state = random_state
        self.cache = cache

    @property
    def kin_(self) -> CopyGroups:
        """The same as ``copy_groups_``, under its old name."""
        warn_renamed("FunctionClassifier.kin_", "copy_groups_")
        return self.copy_groups_

    def fit_settled(
        self,
        settled: Sequence[DropsByRadius],
        y: Sequence[Label],
        names: Sequence[str],
        originals: Sequence[str] | None = None,
        sources: Sequence[str] | None = None,
    ) -> FunctionClassifier:
        """Learn from drops: per object those of each radius, as `settle` returns them.

        Parameters
        ----------
        originals : sequence of str, optional
            What each object is a changed copy of, by its name in ``names``; empty for what is no copy. Copies count
            a tenth, and never tell how sure to be of their original.
        sources : sequence of str, optional
            Who made each object, empty for what is always learnt. How sure to be is then known from the objects of each
            source, and copies of them, when nothing of that source is learnt.
        """
        settled, labels = typed_drops(settled), as_sets(y)
        require_alike(settled, labels, names)
        functions = tuple(sorted(set().union(*labels)))
        copy_groups = group_copies(names, originals or [""] * len(names), sources)
        self.fit_profiles(self.profiles(settled), memberships(labels, functions), functions, names, copy_groups)
        if 0 < self.early_drops < self.drops:
            first = [first_drops(one, self.early_drops) for one in settled]
            self.early_ = self.of_drops(self.early_drops).fit_settled(first, labels, names, originals, sources)
        return self._know()

    def add_settled(
        self, settled: Sequence[DropsByRadius], y: Sequence[Label], names: Sequence[str]
    ) -> FunctionClassifier:
        """Learn from more objects: all examples are kept, and forests are grown anew from all of them.

        What was learnt of scans is given up, since nothing surrounds these.
        """
        check_is_fitted(self, "members_")
        self.in_scenes_, settled = None, typed_drops(settled)
        functions, members = more_members(self.functions_, self.members_, as_sets(y))
        profiles = np.vstack([self.profiles_, self.profiles(settled)])
        copy_groups = self.copy_groups_.with_more(len(names))
        self.fit_profiles(profiles, members, functions, [*self.names_, *names], copy_groups)
        if self.early_ is not None:
            self.early_.add_settled([first_drops(one, self.early_.drops) for one in settled], y, names)
        return self._know()

    def of_drops(self, count: int) -> FunctionClassifier:
        """Return one that is not fitted, of so many drops, that tells nothing sooner."""
        return clone(self).set_params(drops=count, early_drops=0)

    def fit_profiles(
        self,
        profiles: np.ndarray,
        members: np.ndarray,
        functions: Sequence[str],
        names: Sequence[str],
        copy_groups: CopyGroups | None = None,
        taught: np.ndarray | None = None,
    ) -> FunctionClassifier:
        """Learn from quantities (N, R * Q), as `profiles` returns them, and who has which function (N, F) bool.

        Parameters
        ----------
        taught : (N, F) bool, optional
            Which object is an example of which function's members or others; without it, each is of all.
        """
        from sklearn.ensemble import ExtraTreesClassifier

        self.functions_, self.names_ = tuple(functions), list(names)
        self.profiles_, self.members_ = profiles, members
        self.copy_groups_ = group_copies(self.names_, [""] * len(self.names_)) if copy_groups is None else copy_groups
        base = forest(self.random_state) if self.estimator is None else self.estimator
        columns = list(zip(members.T, (np.ones_like(members) if taught is None else taught).T, strict=True))
        grown = [self._grown(base, *column) for column in columns]
        self.forests_ = [forest_of(one) if isinstance(one, ExtraTreesClassifier) else one for one in grown]
        held_out = [self._held_out(base, *column) for column in columns]
        self.lines_ = [self._line(votes, column) for votes, column in zip(held_out, members.T, strict=True)]
        self.held_out_ = held_out
        self.bands_ = {
            name: self._band(votes, line, column)
            for name, votes, line, column in zip(self.functions_, held_out, self.lines_, members.T, strict=True)
        }
        self.radius_ = {name: self._radius(one) for name, one in zip(self.functions_, grown, strict=True)}
        return self

    def fit_in_scenes(
        self, beside: np.ndarray, names: Sequence[str], members: np.ndarray, taught: np.ndarray
    ) -> FunctionClassifier:
        """Learn from what surrounds the training objects (N, S), by its names, as well; see `ProfileModel`.

        Parameters
        ----------
        members, taught : (N, F) bool
            See `fit_profiles`, which comes first.
        """
        both = clone(self).fit_profiles(
            np.hstack([self.profiles_, beside]), members, self.functions_, self.names_, self.copy_groups_, taught
        )
        forests = [one.to_float32() for one in both.forests_ if isinstance(one, Forest)]
        if len(forests) == len(self.functions_):  # else some function is all examples', or none's
            self.in_scenes_ = SceneForests(names=tuple(names), forests=forests, lines=both.lines_)
        return self

    def score_settled(self, settled: Sequence[DropsByRadius], *, any_heading: bool = False) -> np.ndarray:
        """Return the scores (N, F) of objects; see `ProfileModel`."""
        check_is_fitted(self, "members_")
        return super().score_settled(typed_drops(settled), any_heading=any_heading)

    def _radius(self, grown: ClassifierMixin | None) -> float:
        """Return the radius whose quantities count most in a classifier, metres."""
        count = len(self.radii) * len(self.quantities)  # what surrounds objects, which comes after, is of no radius
        weights = getattr(grown, "feature_importances_", np.zeros(count))[:count]
        by_radius = dict(zip(self.radii, weights.reshape(len(self.radii), -1).sum(axis=1), strict=True))
        return max(sorted(by_radius, reverse=True), key=by_radius.get)

    def held_out_f_measures(self) -> dict[str, float | None]:
        """Return each function's F-measure on training objects held out in three folds; None of too few examples.

        Only a classifier that was fitted in this process knows; of one that was read from a file there are none.
        """
        held_out = getattr(self, "held_out_", [None] * len(self.functions_))
        return {
            name: None if votes is None else self._f_measure(calibrated(votes, line), column)
            for name, votes, line, column in zip(self.functions_, held_out, self.lines_, self.members_.T, strict=True)
        }

    def _grown(self, base: ClassifierMixin, members: np.ndarray, taught: np.ndarray) -> ClassifierMixin | None:
        """Return a classifier of one function, grown on its examples; None where all have it or none has."""
        own = np.flatnonzero(taught)
        if members[own].all() or not members[own].any():
            return None
        return grown_on(base, self.profiles_[own], members[own], self.copy_groups_.of(own))

    def _held_out(self, base: ClassifierMixin, members: np.ndarray, taught: np.ndarray) -> np.ndarray | None:
        """Return the votes (N,) for one function of those who have not learnt the object; None for too few examples.

        What is no example of the function has none: not a number.
        """
        own = np.flatnonzero(taught)
        copy_groups = self.copy_groups_.of(own)
        if min(len(set(copy_groups.groups[of_kind])) for of_kind in (members[own], ~members[own])) < 2:
            return None
        votes = np.full(len(members), np.nan)
        votes[own] = held_out_votes(base, self.profiles_[own], members[own], copy_groups, self.random_state)
        return votes

    def _line(self, votes: np.ndarray | None, members: np.ndarray) -> Line:
        """Return what makes probabilities of one function's votes; too few examples leave them as they are."""
        if votes is None:
            return AS_VOTED
        asked = ((self.copy_groups_.weights == 1) | self.copy_groups_.has_sources) & ~np.isnan(votes)
        return calibration_line(votes[asked], members[asked])

    def _band(self, votes: np.ndarray | None, line: Line, members: np.ndarray) -> Band:
        """Return between which scores one function is unsure: what is known where sources can be left out.

        Of these each counts alike, whoever made many objects.
        """
        if votes is None or not self.copy_groups_.has_sources:
            return UNSURE
        asked = ~np.isnan(votes)
        weights = even_sources(self.copy_groups_.sources[asked])
        return unsure_band(calibrated(votes[asked], line), members[asked], weights)

    def _f_measure(self, scores: np.ndarray, members: np.ndarray) -> float:
        """Return the F-measure of scores (N,) on the training objects that are no copies."""
        whole = (self.copy_groups_.weights == 1) & ~np.isnan(scores)
        return quality(members[whole], scores[whole] > THRESHOLD).f_measure


def forest(random_state: int) -> ExtraTreesClassifier:
    """Return the classifier of one function."""
    from .profiles.trees import PlainForest

    return PlainForest(TREES, random_state=random_state)
