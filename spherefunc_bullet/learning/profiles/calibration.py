"""From a classifier's votes to probabilities, so that 0.5 means what it says (Platt, 1999)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from sklearn.base import ClassifierMixin

COPY_WEIGHT = 0.1  # of a changed copy in learning: ten count as their original
FOLDS = 3  # of the cross-validation whose votes are looked at
SURE = 0.01  # votes beyond this are as good as unanimous: a forest of 300 trees cannot distinguish them
STIFFNESS = 3.0  # nats that an e-fold change of the slope or of the odds costs; least log loss over training sizes
LOWEST = -700.0  # log odds: below, their exponential is none that floats hold
UNCERTAIN_MARGIN, WIDEST = 0.1, 0.4  # score either side of the threshold that is no answer: at least, at most
ERROR = 0.003  # of all answers about one function that may be wrong and sure, either way; about a tenth is then unsure
Band = tuple[float, float]  # scores between which one is unsure
UNSURE: Band = (0.5 - UNCERTAIN_MARGIN, 0.5 + UNCERTAIN_MARGIN)
Line = tuple[float, float]  # slope, and what is added to the log odds
AS_VOTED: Line = (1.0, 0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class CopyGroups:
    """Which training objects are changed copies of others, and so count less and are never apart from them."""

    weights: np.ndarray  # (N,) float, 1 for what is no copy
    groups: np.ndarray  # (N,) int, the same for an object and its copies
    sources: np.ndarray | None = None  # (N,) int, who made it where that is known, else -1; None: of nobody

    @property
    def has_sources(self) -> bool:
        """Whether there are objects of several sources, so that each can be left out."""
        return self.sources is not None and len(set(self.sources[self.sources >= 0].tolist())) > 1

    def with_more(self, count: int) -> CopyGroups:
        """Return the same with so many objects more that are no copies."""
        fresh = self.groups.max(initial=-1) + 1 + np.arange(count)
        sources = None if self.sources is None else np.append(self.sources, np.full(count, -1))
        weights = np.append(self.weights, np.ones(count))
        return CopyGroups(weights=weights, groups=np.append(self.groups, fresh), sources=sources)

    def of(self, rows: np.ndarray) -> CopyGroups:
        """Return those of some objects."""
        sources = None if self.sources is None else self.sources[rows]
        return CopyGroups(weights=self.weights[rows], groups=self.groups[rows], sources=sources)


def group_copies(names: Sequence[str], originals: Sequence[str], sources: Sequence[str] | None = None) -> CopyGroups:
    """Return who is a copy of whom, by names, and who made them; an empty name is nobody's."""
    place = {name: row for row, name in enumerate(names) if not originals[row]}
    groups = [place.setdefault(of, len(names) + len(place)) if of else row for row, of in enumerate(originals)]
    weights = np.where([bool(of) for of in originals], COPY_WEIGHT, 1.0)
    makers = {name: number for number, name in enumerate(sorted(set(sources or ()) - {""}))}
    numbers = None if sources is None else np.array([makers.get(name, -1) for name in sources], int)
    return CopyGroups(weights=weights, groups=np.array(groups, int), sources=numbers)


def grown_on(
    estimator: ClassifierMixin, X: np.ndarray, members: np.ndarray, copy_groups: CopyGroups
) -> ClassifierMixin:
    """Return a classifier fitted to objects (N, D) and who is a member (N,) bool.

    Members weigh as much as all others together: a rare function's few examples would be outvoted otherwise. One that
    knows no weights, such as nearest neighbours, takes objects as they are.
    """
    from sklearn.base import clone
    from sklearn.utils.validation import has_fit_parameter

    if not has_fit_parameter(estimator, "sample_weight"):
        return clone(estimator).fit(X, members)
    weights = copy_groups.weights.copy()
    for side in (members, ~members):
        weights[side] *= 0.5 * copy_groups.weights.sum() / copy_groups.weights[side].sum()
    return clone(estimator).fit(X, members, sample_weight=weights)


def held_out_votes(
    estimator: ClassifierMixin, X: np.ndarray, members: np.ndarray, copy_groups: CopyGroups, random_state: int
) -> np.ndarray:
    """Return what a classifier says of each of its training objects (N,) when it and its copies are not learnt.

    Where it is known who made them, nothing of the same source is; what is of no source is always learnt, never asked.

    Parameters
    ----------
    X : (N, D) float
    members : (N,) bool
        At least two of either kind.
    """
    votes = np.full(len(X), np.nan)
    for train, test in held_out_splits(members, copy_groups, random_state):
        if members[train].any() and not members[train].all():
            grown = grown_on(estimator, X[train], members[train], copy_groups.of(train))
            votes[test] = grown.predict_proba(X[test])[:, 1]
        elif not copy_groups.has_sources:
            votes[test] = float(members[train][0])
    return votes


def held_out_splits(members: np.ndarray, copy_groups: CopyGroups, random_state: int) -> Iterable[Sequence[np.ndarray]]:
    """Return which objects learn and which are asked: those of each source in turn, else folds that part no copies."""
    if copy_groups.has_sources:
        makers = copy_groups.sources
        own = [makers == one for one in np.unique(makers[makers >= 0])]
        return [(np.flatnonzero(~one), np.flatnonzero(one)) for one in own]
    from sklearn.model_selection import StratifiedGroupKFold

    folds = min(FOLDS, *(len(set(copy_groups.groups[side])) for side in (members, ~members)))
    splits = StratifiedGroupKFold(folds, shuffle=True, random_state=random_state)
    return splits.split(members, members, copy_groups.groups)


def unsure_band(scores: np.ndarray, members: np.ndarray, weights: np.ndarray | None = None) -> Band:
    """Return between which two scores one function is unsure, by held-out scores (N,) and members (N,) bool.

    No wider than it takes for the answers beyond it to be wrong in no more than `ERROR` of all on either side, and no
    narrower than `UNCERTAIN_MARGIN`, nor wider than `WIDEST`: beyond that, an answer says more than a doubt.

    Parameters
    ----------
    weights : (N,) float
        How much each counts among all; without them, all alike.
    """
    weights = np.ones(len(scores)) if weights is None else weights / weights.mean()
    low = first_beyond(scores[members], weights[members], ERROR * len(scores))
    high = -first_beyond(-scores[~members], weights[~members], ERROR * len(scores))
    return float(np.clip(low, 0.5 - WIDEST, 0.5 - UNCERTAIN_MARGIN)), float(
        np.clip(high, 0.5 + UNCERTAIN_MARGIN, 0.5 + WIDEST)
    )


def first_beyond(scores: np.ndarray, weights: np.ndarray, allowed: float) -> float:
    """Return the lowest score (N,) with which the weights (N,) up to it are more than allowed; infinity if none is."""
    order = np.argsort(scores, kind="stable")
    place = np.searchsorted(np.cumsum(weights[order]), allowed, side="right")
    return float(np.append(scores[order], np.inf)[place])


def even_sources(sources: np.ndarray) -> np.ndarray:
    """Return weights (N,) with which all sources (N,) count alike: the next one may be like any of them."""
    return 1 / np.bincount(sources)[sources]


def calibration_line(votes: np.ndarray, members: np.ndarray) -> Line:
    """Return the line through log odds that makes held-out votes (N,) the likeliest for members (N,) bool.

    We differ from Platt in that leaving votes as they are costs nothing, and any change does: few examples
    change little.
    """
    from scipy.optimize import minimize

    odds, signs = log_odds(votes), np.where(members, 1.0, -1.0)

    def cost(line: np.ndarray) -> float:
        slope, offset = line
        misses = np.logaddexp(0, -signs * (np.exp(slope) * odds + offset)).sum()
        return float(misses + STIFFNESS * (slope**2 + offset**2))

    slope, offset = minimize(cost, [0.0, 0.0], method="BFGS").x
    return float(np.exp(slope)), float(offset)


def calibrated(votes: np.ndarray, line: Line) -> np.ndarray:
    """Return probabilities (N,) from votes (N,)."""
    slope, offset = line
    odds = np.maximum(slope * log_odds(votes) + offset, LOWEST)
    return np.array([1 / (1 + math.exp(-value)) for value in odds.tolist()], float)


def log_odds(votes: np.ndarray) -> np.ndarray:
    """Return the logarithm of the odds of votes from 0 to 1, the unanimous brought to finite ones."""
    return np.array([logit(vote) for vote in np.clip(votes, SURE, 1 - SURE).tolist()], float)


def logit(share: float) -> float:
    """Return the logarithm of the odds of a share, as `scipy.special` does to the last bit, near a half too."""
    if 0.3 <= share <= 0.65:
        return math.log1p(2 * (share - 0.5)) - math.log1p(-2 * (share - 0.5))
    return math.log(share / (1 - share))
