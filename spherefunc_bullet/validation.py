"""How good a membership is, and which radius serves a function best (paper, §III-C and §IV)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from sklearn.metrics import precision_recall_fscore_support
from sklearn.model_selection import ShuffleSplit, StratifiedShuffleSplit

from .classifier import NEIGHBOURS, inverse_distance_scores

THRESHOLD = 0.5  # score above which an object is a member
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
    precision, recall, f_measure, _ = precision_recall_fscore_support(
        members, predicted, average="binary", pos_label=True, zero_division=0
    )
    return Quality(float(f_measure), float(precision), float(recall), float(np.mean(members == predicted)))


def validation_splits(members: np.ndarray, splits: int, random_state: int):
    """Yield train and validation indices, 70 to 30, with members (N,) bool on both sides where possible."""
    smallest = min(members.sum(), (~members).sum())
    if smallest >= 2 and len(members) >= 4:
        splitter = StratifiedShuffleSplit(splits, test_size=HELD_OUT, random_state=random_state)
    else:
        splitter = ShuffleSplit(splits, test_size=HELD_OUT, random_state=random_state)
    yield from splitter.split(members, members)


def validated_f_measure(distances, members, *, splits, n_neighbors, random_state) -> float:
    """Return the F-measure of one function over validation splits of its training set, all counted together.

    Parameters
    ----------
    distances : (N, N) float
        Between the training objects' histograms.
    members : (N,) bool
    """
    truth, predicted = [], []
    for train, held_out in validation_splits(members, splits, random_state):
        scores = inverse_distance_scores(distances[np.ix_(held_out, train)], members[train], n_neighbors)
        truth.append(members[held_out])
        predicted.append(scores > THRESHOLD)
    return quality(np.concatenate(truth), np.concatenate(predicted)).f_measure


def best_radius(
    distances: dict[float, np.ndarray],
    members: np.ndarray,
    *,
    splits: int = 5,
    n_neighbors: int = NEIGHBOURS,
    random_state: int = 0,
) -> float:
    """Return the radius (metres) with the best validated F-measure, of equals the largest: it is the cheapest.

    Parameters
    ----------
    distances : dict of radius to (N, N) float
    members : (N,) bool
    """
    radii = sorted(distances, reverse=True)
    if len(members) < 3 or members.all() or not members.any():
        return radii[0]
    options = {"splits": splits, "n_neighbors": n_neighbors, "random_state": random_state}
    return max(radii, key=lambda radius: round(validated_f_measure(distances[radius], members, **options), 9))
