"""The binary classifier: nearest neighbours weighted by inverse Euclidean distance (paper, §III-C)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.metrics.pairwise import euclidean_distances
from sklearn.utils.multiclass import check_classification_targets, unique_labels
from sklearn.utils.validation import check_is_fitted, validate_data

from ..errors import require_amount

Matrix = ArrayLike | sparse.spmatrix  # (N, D)
NEIGHBOURS = 1
SAME = 1e-6  # spheres: distance below which two histograms are the same; above rounding errors


def inverse_distance_scores(
    distances: np.ndarray, members: np.ndarray, n_neighbors: int | Sequence[int] = NEIGHBOURS
) -> np.ndarray:
    """Return how much nearer each row is to members than to the others, 0 to 1.

    The score is a / (a + b), where a is the mean inverse distance to the ``n_neighbors`` nearest members and b that to
    the same number of nearest non-members. Equal numbers keep a rare function from being outvoted: with the nearest of
    all, the paper's proportions make "none" win.

    Parameters
    ----------
    distances : (Q, N) float
        From each queried object to each example.
    members : (N,) bool
        Which examples have the function.
    n_neighbors : int or sequence of int
        For several numbers, the mean of their scores is returned.

    Returns
    -------
    (Q,) float
        0 if there are no members, 1 if there are only members.
    """
    inside, outside = (mean_inverse_distances(distances[:, side], n_neighbors) for side in (members, ~members))
    total = inside + outside
    return np.divide(inside, total, out=np.zeros_like(total), where=total > 0).mean(axis=1)


def mean_inverse_distances(distances: np.ndarray, n_neighbors: int | Sequence[int]) -> np.ndarray:
    """Return the mean inverse distance (Q, K) to the nearest of (Q, M), for each of K numbers; 0 without columns."""
    counts = np.minimum(np.atleast_1d(n_neighbors), distances.shape[1])
    most = counts.max()
    if most == 0:
        return np.zeros((len(distances), len(counts)))
    nearest = distances.min(axis=1, keepdims=True) if most == 1 else np.partition(distances, range(most), axis=1)
    inverse = 1 / np.maximum(nearest[:, :most], SAME)
    return (np.cumsum(inverse, axis=1) / np.arange(1, most + 1))[:, counts - 1]


def nearest_of_all_scores(
    distances: np.ndarray, members: np.ndarray, n_neighbors: int | Sequence[int] = NEIGHBOURS
) -> np.ndarray:
    """Return the members' share of the inverse distances to the nearest of all examples, 0 to 1 (paper, §III-C).

    A rare function can be outvoted here: with as many neighbours as examples, those without the function win.

    Parameters
    ----------
    distances : (Q, N) float
        From each queried object to each example; of equally near examples the first counts.
    members : (N,) bool
    n_neighbors : int or sequence of int
        For several numbers, the mean of their scores is returned.

    Returns
    -------
    (Q,) float
    """
    counts = np.minimum(np.atleast_1d(n_neighbors), distances.shape[1])
    nearest = np.argsort(distances, axis=1, kind="stable")[:, : counts.max()]
    inverse = 1 / np.maximum(np.take_along_axis(distances, nearest, axis=1), SAME)
    inside, total = (np.cumsum(part, axis=1)[:, counts - 1] for part in (inverse * members[nearest], inverse))
    return (inside / total).mean(axis=1)


class InverseDistanceClassifier(ClassifierMixin, BaseEstimator):
    """Classify rows by the inverse distances to each class's nearest examples.

    For two classes this is the paper's one-against-all classifier, see `inverse_distance_scores`. A single example is
    enough to fit it; `partial_fit` adds more.

    Parameters
    ----------
    n_neighbors : int
        Nearest examples of each class that count.

    Attributes
    ----------
    classes_ : (C,) array
    examples_ : (N, D) array or sparse matrix
    labels_ : (N,) int, index into ``classes_``
    """

    def __init__(self, n_neighbors: int = NEIGHBOURS):
        self.n_neighbors = n_neighbors

    def fit(self, X: Matrix, y: ArrayLike) -> InverseDistanceClassifier:
        """Learn examples X (N, D), dense or sparse, with labels y (N,)."""
        for count in np.atleast_1d(self.n_neighbors):
            require_amount("n_neighbors", count, least=1, whole=True)
        X, y = validate_data(self, X, y, accept_sparse="csr", dtype=np.float64)
        check_classification_targets(y)
        self.classes_, self.labels_ = np.unique(y, return_inverse=True)
        self.examples_ = X
        return self

    def partial_fit(self, X: Matrix, y: ArrayLike, classes: ArrayLike | None = None) -> InverseDistanceClassifier:
        """Learn more examples; ``classes`` are all classes that may occur, as in other scikit-learn estimators."""
        if not hasattr(self, "examples_"):
            self.fit(X, y)
            labels = self.classes_[self.labels_]
        else:
            X, y = validate_data(self, X, y, accept_sparse="csr", dtype=np.float64, reset=False)
            labels = np.concatenate([self.classes_[self.labels_], y])
            stack = sparse.vstack if sparse.issparse(self.examples_) else np.vstack
            self.examples_ = stack([self.examples_, X])
        self.classes_ = unique_labels(labels, *([] if classes is None else [classes]))
        self.labels_ = np.searchsorted(self.classes_, labels)
        return self

    def predict_proba(self, X: Matrix) -> np.ndarray:
        """Return each class's share (Q, C) of the inverse distances."""
        check_is_fitted(self)
        X = validate_data(self, X, accept_sparse="csr", dtype=np.float64, reset=False)
        distances = euclidean_distances(X, self.examples_)
        sides = [distances[:, self.labels_ == label] for label in range(len(self.classes_))]
        nearness = np.column_stack([mean_inverse_distances(side, self.n_neighbors)[:, 0] for side in sides])
        return nearness / nearness.sum(axis=1, keepdims=True)

    def predict(self, X: Matrix) -> np.ndarray:
        """Return the class (Q,) of the largest share."""
        check_is_fitted(self)
        return self.classes_[np.argmax(self.predict_proba(X), axis=1)]

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.input_tags.sparse = True
        return tags
