"""Calibration: from the votes of a classifier to probabilities (Platt, 1999), and the range of unsure scores."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from sklearn.base import ClassifierMixin

COPY_WEIGHT = 0.1  # sample weight of a training copy: ten count as much as their original
FOLDS = 3  # of the cross-validation that gives the held-out votes
VOTE_MARGIN = 0.01  # votes nearer to 0 or 1 count as unanimous: some hundred trees cannot distinguish them
STIFFNESS = 3.0  # nats, penalty of an e-fold change of slope or odds; chosen by log loss over training sizes
LOWEST_LOG_ODDS = -700.0  # below this the exponential overflows a float
UNCERTAIN_MARGIN, WIDEST_MARGIN = 0.1, 0.4  # score difference to the threshold that is unsure: at least, at most
ALLOWED_ERROR = 0.003  # share of answers that may be wrong and sure, on either side; about a tenth is then unsure
ScoreRange = tuple[float, float]  # lowest and highest score
DEFAULT_UNSURE_RANGE: ScoreRange = (0.5 - UNCERTAIN_MARGIN, 0.5 + UNCERTAIN_MARGIN)
Calibration = tuple[float, float]  # slope and offset of the log odds
UNCALIBRATED: Calibration = (1.0, 0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class CopyGroups:
    """Which training objects are copies of others: copies weigh less, and a split never separates them."""

    weights: np.ndarray  # (N,) float, sample weight; 1 for an original
    groups: np.ndarray  # (N,) int, one number for an object and its copies
    sources: np.ndarray | None = None  # (N,) int, source of each object, -1: unknown; None: of all unknown

    @property
    def has_sources(self) -> bool:
        """Whether there are several sources, so that each can be held out."""
        return self.sources is not None and len(set(self.sources[self.sources >= 0].tolist())) > 1

    def with_more(self, count: int) -> CopyGroups:
        """Return these groups extended by a number of originals."""
        new_groups = self.groups.max(initial=-1) + 1 + np.arange(count)
        sources = None if self.sources is None else np.append(self.sources, np.full(count, -1))
        weights = np.append(self.weights, np.ones(count))
        return CopyGroups(weights=weights, groups=np.append(self.groups, new_groups), sources=sources)

    def of(self, rows: np.ndarray) -> CopyGroups:
        """Return the groups of the objects in these rows."""
        sources = None if self.sources is None else self.sources[rows]
        return CopyGroups(weights=self.weights[rows], groups=self.groups[rows], sources=sources)


def group_copies(names: Sequence[str], originals: Sequence[str], sources: Sequence[str] | None = None) -> CopyGroups:
    """Return the copy groups of objects, from the name of each one's original and of its source; empty: none."""
    row_of = {name: row for row, name in enumerate(names) if not originals[row]}
    groups = [row_of.setdefault(of, len(names) + len(row_of)) if of else row for row, of in enumerate(originals)]
    weights = np.where([bool(original) for original in originals], COPY_WEIGHT, 1.0)
    numbers = {name: number for number, name in enumerate(sorted(set(sources or ()) - {""}))}
    source_of = None if sources is None else np.array([numbers.get(name, -1) for name in sources], int)
    return CopyGroups(weights=weights, groups=np.array(groups, int), sources=source_of)


def fit_weighted(
    estimator: ClassifierMixin, X: np.ndarray, members: np.ndarray, copy_groups: CopyGroups
) -> ClassifierMixin:
    """Return a copy of a classifier, fitted to objects (N, D) and their membership (N,) bool.

    Members weigh as much as all others together: the few examples of a rare function would be outvoted otherwise. A
    classifier without sample weights, such as nearest neighbours, is fitted without them.
    """
    from sklearn.base import clone
    from sklearn.utils.validation import has_fit_parameter

    if not has_fit_parameter(estimator, "sample_weight"):
        return clone(estimator).fit(X, members)
    weights = copy_groups.weights.copy()
    for rows in (members, ~members):
        weights[rows] *= 0.5 * copy_groups.weights.sum() / copy_groups.weights[rows].sum()
    return clone(estimator).fit(X, members, sample_weight=weights)


def held_out_votes(
    estimator: ClassifierMixin, X: np.ndarray, members: np.ndarray, copy_groups: CopyGroups, random_state: int
) -> np.ndarray:
    """Return a vote (N,) for each training object, from a classifier fitted without the object and its copies.

    If sources are known, the classifier is fitted without all objects of the same source; an object of unknown source
    always takes part in the fit and gets no vote (NaN).

    Parameters
    ----------
    X : (N, D) float
    members : (N,) bool
        At least two members and two others.
    """
    votes = np.full(len(X), np.nan)
    for train, test in held_out_splits(members, copy_groups, random_state):
        if members[train].any() and not members[train].all():
            fitted = fit_weighted(estimator, X[train], members[train], copy_groups.of(train))
            votes[test] = fitted.predict_proba(X[test])[:, 1]
        elif not copy_groups.has_sources:
            votes[test] = float(members[train][0])
    return votes


def held_out_splits(members: np.ndarray, copy_groups: CopyGroups, random_state: int) -> Iterable[Sequence[np.ndarray]]:
    """Return indices of training and held-out objects: one source after another, else folds that separate no copies."""
    if copy_groups.has_sources:
        sources = copy_groups.sources
        held_out = [sources == source for source in np.unique(sources[sources >= 0])]
        return [(np.flatnonzero(~rows), np.flatnonzero(rows)) for rows in held_out]
    from sklearn.model_selection import StratifiedGroupKFold

    folds = min(FOLDS, *(len(set(copy_groups.groups[side])) for side in (members, ~members)))
    splits = StratifiedGroupKFold(folds, shuffle=True, random_state=random_state)
    return splits.split(members, members, copy_groups.groups)


def uncertainty(name: str, score: float, between: ScoreRange) -> str:
    """Return the sentence that a function is uncertain, since its score is in a range."""
    low, high = between
    return f"{name} is uncertain: its score {score:.2f} is between {low:.2f} and {high:.2f}"


def unsure_range(scores: np.ndarray, members: np.ndarray, weights: np.ndarray | None = None) -> ScoreRange:
    """Return the range of scores in which a function is unsure, from held-out scores (N,) and members (N,) bool.

    It is the narrowest for which wrong answers outside it are at most `ALLOWED_ERROR` of all on either side, but at
    least `UNCERTAIN_MARGIN` and at most `WIDEST_MARGIN` to either side of the threshold.

    Parameters
    ----------
    weights : (N,) float
        Sample weights; by default all equal.
    """
    weights = np.ones(len(scores)) if weights is None else weights / weights.mean()
    low = score_at_weight(scores[members], weights[members], ALLOWED_ERROR * len(scores))
    high = -score_at_weight(-scores[~members], weights[~members], ALLOWED_ERROR * len(scores))
    low = np.clip(low, 0.5 - WIDEST_MARGIN, 0.5 - UNCERTAIN_MARGIN)
    return float(low), float(np.clip(high, 0.5 + UNCERTAIN_MARGIN, 0.5 + WIDEST_MARGIN))


def score_at_weight(scores: np.ndarray, weights: np.ndarray, allowed: float) -> float:
    """Return the lowest score of (N,) up to which the weights (N,) sum to more than allowed; infinity if none does."""
    order = np.argsort(scores, kind="stable")
    index = np.searchsorted(np.cumsum(weights[order]), allowed, side="right")
    return float(np.append(scores[order], np.inf)[index])


def equal_source_weights(sources: np.ndarray) -> np.ndarray:
    """Return weights (N,) with which all sources (N,) count equally."""
    return 1 / np.bincount(sources)[sources]


def fit_calibration(votes: np.ndarray, members: np.ndarray) -> Calibration:
    """Return slope and offset of the log odds with the greatest likelihood of members (N,) bool given votes (N,).

    Unlike Platt's, the fit is regularised towards unchanged votes: few examples change little.
    """
    from scipy.optimize import minimize

    odds, signs = log_odds(votes), np.where(members, 1.0, -1.0)

    def cost(calibration: np.ndarray) -> float:
        slope, offset = calibration
        misses = np.logaddexp(0, -signs * (np.exp(slope) * odds + offset)).sum()
        return float(misses + STIFFNESS * (slope**2 + offset**2))

    slope, offset = minimize(cost, [0.0, 0.0], method="BFGS").x
    return float(np.exp(slope)), float(offset)


def calibrated(votes: np.ndarray, calibration: Calibration) -> np.ndarray:
    """Return probabilities (N,) from votes (N,) of 0 to 1."""
    slope, offset = calibration
    odds = np.maximum(slope * log_odds(votes) + offset, LOWEST_LOG_ODDS)
    return np.array([1 / (1 + math.exp(-value)) for value in odds.tolist()], float)


def log_odds(votes: np.ndarray) -> np.ndarray:
    """Return the log odds of votes from 0 to 1; unanimous votes are clipped to finite odds."""
    return np.array([logit(vote) for vote in np.clip(votes, VOTE_MARGIN, 1 - VOTE_MARGIN).tolist()], float)


def logit(share: float) -> float:
    """Return the log odds of a share, bit for bit equal to `scipy.special.logit`, also near 0.5."""
    if 0.3 <= share <= 0.65:
        return math.log1p(2 * (share - 0.5)) - math.log1p(-2 * (share - 0.5))
    return math.log(share / (1 - share))
