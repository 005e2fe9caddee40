"""The base class of classifiers: it drops spheres on clouds and predicts functions.

Subclasses read the drops as named quantities (`function_classifier`) or count them in cubes (`cube_classifier`).
The forms of labels are in `labels`.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from typing import TypedDict

import numpy as np
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.validation import check_is_fitted

from ..classification import decide
from ..clouds.conversion import Anything, as_clouds
from ..errors import InputError
from ..function_model import THRESHOLD, FunctionModel
from ..settling.cached_runs import CloudObject, DropConfig, LoadOptions, settle_prepared
from ..settling.drops import DropsByRadius
from ..settling.settling import checked_radii
from ..simulator import Simulator
from .labels import Label, Labels, columns_of_indicator, in_columns, labels_of_indicator, require_names, sets_of


class BackendAlias(TypedDict, total=False):
    """Other names of estimators' parameters."""

    backend: str | Simulator  # the same as ``simulator``


def simulator_argument(owner: object, simulator: str | Simulator, alias: BackendAlias) -> str | Simulator:
    """Return the simulator that an object of this package was given as ``simulator`` or as ``backend``."""
    if odd := set(alias) - {"backend"}:
        raise TypeError(f"{type(owner).__name__}() got an unexpected keyword argument {min(odd)!r}")
    return simulator if alias.get("backend") is None else alias["backend"]


class CloudClassifier(ClassifierMixin, BaseEstimator, FunctionModel):
    """A classifier of clouds by the spheres that are dropped on them, fitted or not.

    An object may have several functions, or none: multilabel classification. Objects X are anything that
    `as_cloud` takes, in metres with z up. Labels y are one of

    - a set of functions' names for each object (or a list, ``'table;sittable'`` or ``'none'``): `predict` returns sets;
    - an indicator (N, F) of 0 and 1, as ``MultiLabelBinarizer`` makes it: `predict` returns an indicator, and what
      scikit-learn measures (``scoring="f1_macro"``) can be used. Functions are named by the columns of a data frame,
      else by column numbers.

    A subclass has the parameters ``simulator``, ``radii`` (metres), ``seed`` and ``cache`` (whether drops on
    the same cloud are read from the cache of the user), and when fitted the attributes ``functions_``,
    ``names_``, ``members_`` (N, F) bool and ``radius_``.
    """

    cache: bool
    radii_: tuple[float, ...] | None = None  # that were learnt, metres
    columns_: tuple[str, ...] | None = None  # names of the columns of the indicator that y was, if it was one

    @abstractmethod
    def fit_settled(
        self, settled: Sequence[DropsByRadius], y: Sequence[Label], names: Sequence[str]
    ) -> CloudClassifier:
        """Learn from the drops of each object by radius, as `settle` returns them."""

    @abstractmethod
    def add_settled(
        self, settled: Sequence[DropsByRadius], y: Sequence[Label], names: Sequence[str]
    ) -> CloudClassifier:
        """Learn from more objects, in addition to earlier ones."""

    @abstractmethod
    def held_out_f_measures(self) -> dict[str, float | None]:
        """Return the F-measure of each function on held-out training objects; None for too few examples."""

    @property
    def classes_(self) -> np.ndarray:
        """The functions (F,), in the order of the columns of `predict_proba`."""
        check_is_fitted(self, "members_")
        return np.array(self._columns())

    def require_fitted(self):
        """Raise NotFittedError before `fit`, and InputError if `radii` were changed after it."""
        check_is_fitted(self, "members_")
        if self.radii_ not in (None, tuple(self.radii)):
            learnt, now = (", ".join(f"{radius:g}" for radius in radii) for radii in (self.radii_, self.radii))
            raise InputError(f"radii: expected {learnt} m, which were learnt, got {now} m; call fit again")

    def drop_config(self, loading: LoadOptions | None = None) -> DropConfig:
        """Return how spheres are dropped on the objects that it classifies; see `FunctionModel`."""
        self.require_fitted()
        return super().drop_config(loading)

    def fit(self, X: Iterable[Anything], y: Labels) -> CloudClassifier:
        """Learn from objects X and their functions y, a set for each or an indicator (N, F)."""
        columns = columns_of_indicator(y)
        self.fit_settled(*self._training_data(X, y, columns))
        self.columns_ = columns
        return self

    def partial_fit(self, X: Iterable[Anything], y: Labels) -> CloudClassifier:
        """Learn from more objects in addition to earlier ones; the model is fitted again to all."""
        if not hasattr(self, "members_"):
            return self.fit(X, y)
        if self.columns_ is None and not hasattr(y, "columns"):
            require_names(y)
        return self.add_settled(*self._training_data(X, y, columns_of_indicator(y, self.columns_), self.columns_))

    def predict_proba(self, X: Iterable[Anything]) -> np.ndarray:
        """Return a score from 0 to 1 for each object and function (N, F), in the order of ``classes_``."""
        drop_config = self.drop_config()
        objects = (CloudObject(raw_cloud=cloud, drop_config=drop_config, cache=self.cache) for cloud in as_clouds(X))
        scores = [decide(item, self).scores for item in objects]
        return in_columns(np.reshape(scores, (len(scores), len(self.functions_))), self.functions_, self._columns())

    def predict(self, X: Iterable[Anything]) -> list[frozenset[str]] | np.ndarray:
        """Return the functions of each object: a set, empty for none; or an indicator (N, F) where y was one."""
        members = self.predict_proba(X) > THRESHOLD
        if self.columns_ is not None:
            return members.astype(int)
        return [frozenset(name for name, has in zip(self.functions_, row, strict=True) if has) for row in members]

    def score(self, X: Iterable[Anything], y: Labels, sample_weight: np.ndarray | None = None) -> float:
        """Return the share of objects whose functions are all correct, as scikit-learn does for multilabel data."""
        columns = self.columns_
        if columns is None:
            require_names(y)
        labels, found = (
            sets_of(each) if columns is None else labels_of_indicator(each, columns) for each in (y, self.predict(X))
        )
        require_as_many(found, labels)
        correct = [functions == label for functions, label in zip(found, labels, strict=True)]
        return float(np.average(correct, weights=sample_weight))

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.input_tags.two_d_array = False
        tags.classifier_tags.multi_label = True
        tags.target_tags.multi_output = True
        return tags

    def _columns(self) -> tuple[str, ...]:
        return self.functions_ if self.columns_ is None else self.columns_

    def _training_data(
        self, X: Iterable[Anything], y: Labels, columns: tuple[str, ...] | None, known: tuple[str, ...] | None = None
    ) -> tuple[list[DropsByRadius], list[Label], list[str]]:
        """Return the drops, the labels and the names of objects; ``columns`` are those of an indicator y.

        Labels may be of ``known`` functions only, if these are given.
        """
        if len(checked_radii(self.radii)) == 0:
            raise InputError("radii: expected at least one, got none")
        X = list(X) if isinstance(X, Iterator) else X
        clouds = as_clouds(X)
        labels = list(y) if columns is None else labels_of_indicator(y, columns)
        require_as_many(X, labels)
        if known is not None and (others := set().union(*sets_of(labels)) - set(known)):
            raise InputError(f"labels: expected functions of the columns {', '.join(known)}, got {min(others)!r}")
        how = self.simulator, self.radii, self.seed, self.run_limit
        named = [(cloud.name, settle_prepared(cloud, *how, cache=self.cache)) for cloud in clouds]
        return [settled for _, settled in named], labels, [name for name, _ in named]


def require_as_many(objects: Sequence, labels: Sequence):
    """Raise InputError if objects and labels differ in number."""
    if len(objects) != len(labels):
        raise InputError(f"expected as many labels as objects, got {len(objects)} objects and {len(labels)} labels")


def require_alike(settled: Sequence[DropsByRadius], labels: Sequence[frozenset[str]], names: Sequence[str]):
    """Raise InputError if objects, labels and names differ in number."""
    if not len(settled) == len(labels) == len(names):
        raise InputError(f"got {len(settled)} objects, {len(labels)} labels and {len(names)} names")
