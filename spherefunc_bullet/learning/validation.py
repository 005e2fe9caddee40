"""How good predicted memberships are, and which radius suits a function best (paper, §III-C and §IV)."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..function_model import THRESHOLD
from .inverse_distance import inverse_distance_scores, nearest_of_all_scores
from .method import Method

HELD_OUT = 0.3  # share of the training set that validates the radius (paper, §III-C)


@dataclass(frozen=True)
class Quality:
    """How well predicted membership in one function agrees with the labels."""

    f_measure: float
    precision: float
    recall: float
    accuracy: float


def quality(members: np.ndarray, predicted: np.ndarray, counted: np.ndarray | None = None) -> Quality:
    """Return the quality of predicted membership (N,) bool, over the objects that are ``counted`` (N,) bool."""
    if counted is not None:
        members, predicted = members[counted], predicted[counted]
    true, positive, right = int(members.sum()), int(predicted.sum()), int((members & predicted).sum())
    accuracy = float(np.mean(members == predicted))
    return Quality(share(2 * right, true + positive), share(right, positive), share(right, true), accuracy)


def share(part: int, whole: int) -> float:
    """Return the share that a part is of a whole; 0 if the whole is 0."""
    return part / whole if whole else 0.0


def validation_splits(members: np.ndarray, splits: int, random_state: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return train and validation indices, 70 to 30, with members (N,) bool on both sides where possible."""
    return list(known_splits(members.tobytes(), splits, random_state))


@lru_cache(maxsize=256)  # features and baselines are validated on the same members in turn
def known_splits(packed: bytes, splits: int, random_state: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the splits of members (N,) bool, given as bytes."""
    from sklearn.model_selection import ShuffleSplit, StratifiedShuffleSplit

    members = np.frombuffer(packed, bool)
    smallest = min(members.sum(), (~members).sum())
    kind = StratifiedShuffleSplit if smallest >= 2 and len(members) >= 4 else ShuffleSplit
    return list(kind(splits, test_size=HELD_OUT, random_state=random_state).split(members, members))


def member_scores(distances: np.ndarray, members: np.ndarray, method: Method) -> np.ndarray:
    """Return one function's scores (Q,) at one radius, from distances (Q, N) to examples that are members (N,) bool."""
    scores = nearest_of_all_scores if method.of_all else inverse_distance_scores
    return scores(distances, members, method.neighbors)


def validated_f_measure(
    distances: np.ndarray, members: np.ndarray, splits: Sequence[tuple[np.ndarray, np.ndarray]], method: Method
) -> float:
    """Return the F-measure of one function over validation splits of its training set, all counted together.

    Parameters
    ----------
    distances : (N, N) float
        Between the training objects' histograms.
    members : (N,) bool
    splits : list of (train, validation) indices
    """
    truth, predicted = [], []
    for train, held_out in splits:
        scores = member_scores(distances[np.ix_(held_out, train)], members[train], method)
        truth.append(members[held_out])
        predicted.append(scores > THRESHOLD)
    return quality(np.concatenate(truth), np.concatenate(predicted)).f_measure


def radius_weights(
    distances: dict[float, np.ndarray], members: np.ndarray, method: Method, random_state: int = 0
) -> dict[float, float]:
    """Return the weight of each radius for one function; radii without weight are left out.

    The paper takes the radius with the best validated F-measure (§III-C); ``method.tied`` says which of equally good
    ones (the largest is the cheapest). With ``method.vote`` the weight of a radius is the square of how far its
    F-measure is above one half.

    Parameters
    ----------
    distances : dict of radius in metres to (N, N) float
        Between the training objects' histograms.
    members : (N,) bool
    """
    radii = sorted(distances, reverse=method.tied == "largest")
    if len(radii) == 1 or len(members) < 3 or members.all() or not members.any():
        return {radii[0]: 1.0}
    splits = validation_splits(members, method.splits, random_state)
    measured = {r: round(validated_f_measure(distances[r], members, splits, method), 9) for r in radii}
    best = max(radii, key=measured.get)
    votes = {radius: (f_measure - 0.5) ** 2 for radius, f_measure in measured.items() if f_measure > 0.5}
    if not method.vote or best not in votes:
        return {best: 1.0}
    # The radius with the largest weight is the function's radius; the order of ``radii`` decides ties here as well.
    return {radius: votes[radius] / sum(votes.values()) for radius in radii if radius in votes}


def remaining_weights(weights: dict[float, float], radii: Collection[float]) -> dict[float, float]:
    """Return the weights of these radii, scaled to sum to one; empty if none of them has a weight."""
    if weights.keys() <= set(radii):
        return weights
    left = {radius: weight for radius, weight in weights.items() if radius in radii}
    return {radius: weight / sum(left.values()) for radius, weight in left.items()}


def voted_scores(
    distances: dict[float, np.ndarray], members: np.ndarray, weights: dict[float, float], method: Method
) -> np.ndarray:
    """Return one function's scores (Q,), the weighted mean over radii.

    Parameters
    ----------
    distances : dict of radius in metres to (Q, N) float
        From the queried objects to the training objects.
    members : (N,) bool
    weights : dict of radius to float
        Summing to one.
    """
    scores = [weight * member_scores(distances[radius], members, method) for radius, weight in weights.items()]
    return np.sum(scores, axis=0)
