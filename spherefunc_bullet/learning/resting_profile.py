"""The resting profile as a transformer of scikit-learn; `profiles.quantities` defines it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Unpack

import numpy as np
from sklearn.base import BaseEstimator, TransformerMixin

from ..clouds.conversion import Anything, as_cloud, listed
from ..settling.cached_runs import settle_prepared
from ..settling.drops import DROPS, NO_DROPS, Drops, RunLimit, drops_from_rows
from ..simulator import Simulator
from .classifier import BackendAlias, simulator_argument
from .profiles.quantities import NAMES, profiles_over


class RestingProfile(TransformerMixin, BaseEstimator):
    """Turn objects, or the drops on them, into named quantities at one radius.

    Turning or moving an object on the ground together with its drops changes no more than the last digits. Gaps, which
    are found by comparing spheres of two radii, are 0 here.

    Parameters
    ----------
    radius : float
        Of the spheres, metres.
    simulator, drops, seed, cache
        How spheres are dropped on objects, see `FunctionClassifier`.
    """

    def __init__(
        self,
        radius: float = 0.02,
        *,
        simulator: str | Simulator = "fast",
        drops: int = DROPS,
        seed: int = 0,
        cache: bool = True,
        **alias: Unpack[BackendAlias],
    ):
        self.radius = radius
        self.simulator = simulator_argument(self, simulator, alias)
        self.drops = drops
        self.seed = seed
        self.cache = cache

    def fit(self, X: object = None, y: object = None) -> RestingProfile:
        """Do nothing, since quantities do not depend on training objects."""
        return self

    def transform(self, X: Iterable[Anything]) -> np.ndarray:
        """Return the quantities (N, Q) of objects.

        Parameters
        ----------
        X : sequence of Drops, or of anything that `as_cloud` takes
            The drops of each object, metres, z up, the ground at 0 (or as rows, see `Drops.rows`); or objects, on
            which spheres are dropped.
        """
        return profiles_over([{self.radius: self._dropped(item)} for item in listed(X)], [self.radius])

    def _dropped(self, item: Drops | Anything) -> Drops:
        if isinstance(item, Drops):
            return item
        if isinstance(item, np.ndarray) and item.ndim == 2 and item.shape[1] == NO_DROPS.rows().shape[1]:
            return drops_from_rows(self.radius, item)
        how = self.simulator, [self.radius], self.seed, RunLimit(drops=self.drops)
        return settle_prepared(as_cloud(item), *how, cache=self.cache)[self.radius]

    def get_feature_names_out(self, input_features: object = None) -> np.ndarray:
        """Return the names of the quantities (Q,), see `QUANTITIES`."""
        return np.array(NAMES, dtype=object)

    def __sklearn_is_fitted__(self) -> bool:
        return True
