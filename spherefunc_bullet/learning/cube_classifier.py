"""What an object is for: one binary classifier per function, each with the radius that serves it best (§III-C).

And a fitted one as the arrays of its file.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import asdict
from typing import Any, Unpack

import numpy as np
from scipy import sparse
from sklearn.utils.validation import check_is_fitted

from ..settling.drops import NO_DROPS, DropsByRadius, RunLimit, typed_drops
from ..simulator import Simulator
from .classifier import BackendAlias, CloudClassifier, require_alike, simulator_argument
from .histogram import quarter_turns, widened
from .inverse_distance import SAME
from .labels import Label, as_sets, memberships, more_members
from .method import CUBES, RADII, Method, find_cube_method
from .validation import THRESHOLD, quality, radius_weights, remaining_weights, voted_scores


class CubeClassifier(CloudClassifier):
    """Learn functions from labelled clouds, and tell those of others: several, or none.

    Parameters
    ----------
    simulator : str or Simulator
        A registered backend's name, or a simulator; ``backend=`` is the same.
    radii : sequence of float
        Sphere radii to choose from, metres.
    method : {'cubes', 'paper'} or Method
    seed : int
        Of the drops.
    random_state : int
        Of the validation splits.
    cache : bool
        Whether spheres that have fallen on the same cloud before are looked up in the user's cache.

    Attributes
    ----------
    functions_ : tuple of str
    weights_ : dict of str to dict of float to float
        For each function, the radii in metres that count and how much; one alone where the method takes the best.
    histograms_ : dict of float to CubeHistogram
    examples_ : dict of float to (N, V + 1) sparse matrix
        The training objects' features at each radius.
    members_ : (N, F) bool
    names_ : list of str
        What the training objects are called.
    """

    def __init__(
        self,
        simulator: str | Simulator = "fast",
        *,
        radii: Sequence[float] = RADII,
        method: str | Method = "cubes",
        seed: int = 0,
        random_state: int = 0,
        cache: bool = True,
        **alias: Unpack[BackendAlias],
    ):
        self.simulator = simulator_argument(simulator, **alias)
        self.radii = radii
        self.method = method
        self.seed = seed
        self.random_state = random_state
        self.cache = cache

    def fit_settled(self, settled: Sequence[DropsByRadius], y: Sequence[Label], names: Sequence[str]) -> CubeClassifier:
        """Learn from settled centres: per object the drops of each radius, as `settle` returns them."""
        settled, labels = typed_drops(settled), as_sets(y)
        require_alike(settled, labels, names)
        method = find_cube_method(self.method)
        self.functions_ = tuple(sorted(set().union(*labels)))
        self.members_ = memberships(labels, self.functions_)
        self.names_ = list(names)
        self.histograms_, self.examples_ = {}, {}
        for radius in self.radii:
            self.histograms_[radius] = method.histogram(radius)
            self.examples_[radius] = self.histograms_[radius].fit_transform([drops[radius].rests for drops in settled])
        return self._choose_radii()

    def add_settled(self, settled: Sequence[DropsByRadius], y: Sequence[Label], names: Sequence[str]) -> CubeClassifier:
        """Learn from more settled centres."""
        from scipy import sparse

        check_is_fitted(self)
        settled = typed_drops(settled)
        self.functions_, self.members_ = more_members(self.functions_, self.members_, as_sets(y))
        self.names_ = [*self.names_, *names]
        for radius, histogram in self.histograms_.items():
            centers = [drops[radius].rests for drops in settled]
            before = histogram.keys_
            histogram.partial_fit(centers)
            old = widened(self.examples_[radius], before, histogram.keys_)
            self.examples_[radius] = sparse.vstack([old, histogram.transform(centers)]).tocsr()
        return self._choose_radii()

    @property
    def radius_(self) -> dict[str, float]:
        """The radius that counts most for each function, metres."""
        return {name: max(weights, key=weights.get) for name, weights in self.weights_.items()}

    @property
    def run_limit(self) -> RunLimit:
        """How long its runs are."""
        return find_cube_method(self.method).run_limit

    def score_settled(self, settled: Sequence[DropsByRadius], *, any_heading: bool = False) -> np.ndarray:
        """Return the scores (N, F) of objects given as settled centres.

        Parameters
        ----------
        settled : sequence of dict of radius in metres to Drops
            At the chosen radii. Where spheres of one were not dropped, the others vote alone.
        any_heading : bool
            Whether an object may face any way, as in a scan: its distance to a training object is then that at the
            best of four quarter turns.
        """
        check_is_fitted(self)
        settled = typed_drops(settled)
        scores = np.zeros((len(settled), len(self.functions_)))
        if not len(settled):
            return scores
        measure = self.turned_distances if any_heading else self.distances
        distances = {radius: measure(settled, radius) for radius in self.chosen_radii()}
        for radii, rows in by_radii(settled).items():
            known = {radius: matrix[rows] for radius, matrix in distances.items() if radius in radii}
            for column, name in enumerate(self.functions_):
                weights = remaining_weights(self.weights_[name], radii)
                members = self.members_[:, column]
                scores[rows, column] = voted_scores(known, members, weights, find_cube_method(self.method))
        return scores

    def distances(self, settled: Sequence[DropsByRadius], radius: float) -> np.ndarray:
        """Return the Euclidean distances (Q, N) from objects to the training examples."""
        return self._distances(rests_of(settled, radius), radius)

    def _distances(self, centers: Sequence[np.ndarray], radius: float) -> np.ndarray:
        """Return the same for settled centres (S, 3)."""
        from sklearn.metrics.pairwise import euclidean_distances

        features = self.histograms_[radius].transform(centers)
        return euclidean_distances(features, self.examples_[radius])

    def turned_distances(self, settled: Sequence[DropsByRadius], radius: float) -> np.ndarray:
        """Return the distances (Q, N) to the training examples, each object turned by quarters to be nearest."""
        turns = [[quarter_turns(centers, k) for centers in rests_of(settled, radius)] for k in range(4)]
        return np.min([self._distances(turned, radius) for turned in turns], axis=0)

    def neighbors(self, settled: DropsByRadius, name: str) -> list[dict]:
        """Return the training objects that decide one object's membership, by radius and nearest first.

        The weights of those that have the function sum to its score.
        """
        rows = []
        for radius, share in self.weights_[name].items():
            distances = self.distances([settled], radius)[0]
            rows += [row | {"radius": radius} for row in self._nearest(distances, name, share)]
        return rows

    def neighbor_weights(self, distances: np.ndarray, name: str) -> np.ndarray:
        """Return the share (N,) of each training object in one radius's score; that of the members sums to it.

        Parameters
        ----------
        distances : (N,) float
            From one object to the training examples, at one radius.
        """
        members = self.members_[:, self.functions_.index(name)]
        method = find_cube_method(self.method)
        counts, weights = method.neighbors, np.zeros(len(members))
        sides = (np.arange(len(members)),) if method.of_all else (np.flatnonzero(members), np.flatnonzero(~members))
        for count in counts:
            nearest = [rows[np.argsort(distances[rows], kind="stable")[:count]] for rows in sides]
            inverse = [1 / np.maximum(distances[rows], SAME) / max(len(rows), 1) for rows in nearest]
            total = sum(rows.sum() for rows in inverse)
            for rows, values in zip(nearest, inverse, strict=True):
                weights[rows] += values / total / len(counts)
        return weights

    def _nearest(self, distances: np.ndarray, name: str, share: float) -> list[dict]:
        members = self.members_[:, self.functions_.index(name)]
        weights = share * self.neighbor_weights(distances, name)
        return [
            {
                "name": self.names_[i],
                "member": bool(members[i]),
                "distance": round(float(distances[i]), 4),
                "weight": round(float(weights[i]), 4),
            }
            for i in np.flatnonzero(weights)[np.argsort(-weights[weights > 0], kind="stable")]
        ]

    def chosen_radii(self) -> list[float]:
        """Return the radii that some function uses, ascending, metres."""
        check_is_fitted(self)
        return sorted(set().union(*self.weights_.values()))

    def only(self, name: str) -> CubeClassifier:
        """Return a fitted copy that is asked for one function alone, so that its radius alone is run."""
        alone, column = copy(self), self.column_of(name)
        alone.functions_, alone.members_ = (name,), self.members_[:, [column]]
        alone.weights_ = {name: self.weights_[name]}
        return alone

    def held_out_f_measures(self) -> dict[str, float | None]:
        """Return each function's F-measure on training objects, each left out; None of too few examples."""
        from sklearn.metrics.pairwise import euclidean_distances

        measured: dict[str, float | None] = dict.fromkeys(self.functions_)
        distances = {radius: euclidean_distances(self.examples_[radius]) for radius in self.chosen_radii()}
        others = ~np.eye(len(self.members_), dtype=bool)
        for name, members in zip(self.functions_, self.members_.T, strict=True):
            if min(members.sum(), (~members).sum()) < 2:
                continue
            weights, method = self.weights_[name], find_cube_method(self.method)
            scores = []
            for i, rest in enumerate(others):
                to_others = {radius: distances[radius][[i]][:, rest] for radius in weights}
                scores.append(voted_scores(to_others, members[rest], weights, method))
            measured[name] = quality(members, np.concatenate(scores) > THRESHOLD).f_measure
        return measured

    def _choose_radii(self) -> CubeClassifier:
        from sklearn.metrics.pairwise import euclidean_distances

        distances = {radius: euclidean_distances(matrix) for radius, matrix in self.examples_.items()}
        self.weights_ = {
            name: radius_weights(distances, members, find_cube_method(self.method), self.random_state)
            for name, members in zip(self.functions_, self.members_.T, strict=True)
        }
        return self


def rests_of(settled: Sequence[DropsByRadius], radius: float) -> list[np.ndarray]:
    """Return where the spheres of a radius rest on each object, (S, 3), metres."""
    return [drops.get(radius, NO_DROPS).rests for drops in settled]


def by_radii(settled: Sequence[DropsByRadius]) -> dict[frozenset[float], list[int]]:
    """Return which objects had spheres dropped at which radii: the rows of each such set."""
    rows: dict[frozenset[float], list[int]] = {}
    for row, spheres in enumerate(settled):
        rows.setdefault(frozenset(spheres), []).append(row)
    return rows


def cube_parts(model: CubeClassifier) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return what is kept of a classifier by cubes beside what is kept of all."""
    arrays = {}
    for i, radius in enumerate(model.radii):
        matrix = model.examples_[radius]
        arrays[f"keys_{i}"] = model.histograms_[radius].keys_
        arrays[f"data_{i}"], arrays[f"indices_{i}"], arrays[f"indptr_{i}"] = matrix.data, matrix.indices, matrix.indptr
    weights = {name: list(weights.items()) for name, weights in model.weights_.items()}
    return {"method": asdict(find_cube_method(model.method)), "weights": weights}, arrays


def rebuilt_method(about: dict[str, Any]) -> Method:
    """Return the method that a model file describes; of what earlier versions could vary, only the default is left."""
    fixed = {"anchor": "centre", "heading": "as_given", "counts": "raw"}
    about = about | {"neighbors": tuple(about["neighbors"])}
    if any(about.pop(name, value) != value for name, value in fixed.items()):
        raise ValueError("a method of an earlier version")
    if about["name"] == "default":  # what earlier versions called it
        about["name"] = CUBES.name
    return Method(**about)


def fill_cubes(model: CubeClassifier, about: dict[str, Any], arrays: dict[str, np.ndarray]):
    """Give a classifier by cubes what its file holds."""
    model.weights_ = {
        name: {radius: weight for radius, weight in about["weights"][name]} for name in about["functions"]
    }
    if not all(weights and set(weights) <= set(model.radii) for weights in model.weights_.values()):
        raise ValueError("a function's radius is none of the model's")
    model.histograms_, model.examples_ = {}, {}
    for i, radius in enumerate(model.radii):
        histogram = model.method.histogram(radius)
        histogram.keys_ = arrays[f"keys_{i}"].astype(np.int64)
        parts = arrays[f"data_{i}"], arrays[f"indices_{i}"], arrays[f"indptr_{i}"]
        matrix = sparse.csr_matrix(parts, shape=(len(arrays["names"]), len(histogram.keys_) + 1))
        matrix.check_format(full_check=True)
        model.histograms_[radius], model.examples_[radius] = histogram, matrix
