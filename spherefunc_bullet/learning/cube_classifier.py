"""The classifier by cubes: one binary classifier per function, each with the radius that suits it best (§III-C).

Also its fitted attributes as the arrays of a model file, and back.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import asdict
from typing import Any, Unpack

import numpy as np
from scipy import sparse
from sklearn.metrics.pairwise import euclidean_distances
from sklearn.utils.validation import check_is_fitted

from ..settling.drops import NO_DROPS, DropsByRadius, RunLimit, typed_drops
from ..simulator import Simulator
from .classifier import BackendAlias, CloudClassifier, require_alike, simulator_argument
from .histogram import histogram_of, quarter_turns, widened
from .inverse_distance import SAME
from .labels import Label, as_sets, memberships, more_members
from .method import CUBES, RADII, Method, find_cube_method
from .validation import THRESHOLD, quality, radius_weights, remaining_weights, voted_scores


class CubeClassifier(CloudClassifier):
    """Learn functions from labelled clouds and predict those of others: several, or none.

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
        For each function, the radii in metres that count and their weights; a single one where the method takes the
        best.
    histograms_ : dict of float to CubeHistogram
    examples_ : dict of float to (N, V + 1) sparse matrix
        The training objects' features at each radius.
    members_ : (N, F) bool
    names_ : list of str
        Names of the training objects.
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
        self.simulator = simulator_argument(self, simulator, alias)
        self.radii = radii
        self.method = method
        self.seed = seed
        self.random_state = random_state
        self.cache = cache

    def fit_settled(self, settled: Sequence[DropsByRadius], y: Sequence[Label], names: Sequence[str]) -> CubeClassifier:
        """Learn from the drops of each object by radius, as `settle` returns them."""
        settled, labels = typed_drops(settled), as_sets(y)
        require_alike(settled, labels, names)
        method = find_cube_method(self.method)
        self.radii_, self.functions_ = tuple(self.radii), tuple(sorted(set().union(*labels)))
        self.members_ = memberships(labels, self.functions_)
        self.names_ = list(names)
        self.histograms_, self.examples_ = {}, {}
        for radius in self.radii:
            self.histograms_[radius] = histogram_of(method, radius)
            self.examples_[radius] = self.histograms_[radius].fit_transform([drops[radius].rests for drops in settled])
        return self._choose_radii()

    def add_settled(self, settled: Sequence[DropsByRadius], y: Sequence[Label], names: Sequence[str]) -> CubeClassifier:
        """Learn from more objects, in addition to earlier ones."""
        self.require_fitted()
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
        """The limit of its runs."""
        return find_cube_method(self.method).run_limit

    def score_settled(self, settled: Sequence[DropsByRadius], *, any_heading: bool = False) -> np.ndarray:
        """Return the scores (N, F) of objects from their drops.

        Parameters
        ----------
        settled : sequence of dict of radius in metres to Drops
            At the chosen radii. Where no spheres of a radius were dropped, the other radii vote alone.
        any_heading : bool
            Whether an object may have any heading, as in a scan: its distance to a training object is then that at the
            best of four quarter turns.
        """
        check_is_fitted(self)
        settled = typed_drops(settled)
        scores, method = np.zeros((len(settled), len(self.functions_))), find_cube_method(self.method)
        for dropped in {frozenset(drops) for drops in settled}:  # the radii at which spheres were dropped
            rows = [row for row, drops in enumerate(settled) if drops.keys() == dropped]
            objects = [settled[row] for row in rows]
            radii = [radius for radius in self.chosen_radii() if radius in dropped]
            distances = {radius: self.distances(objects, radius, any_heading=any_heading) for radius in radii}
            for column, name in enumerate(self.functions_):
                weights = remaining_weights(self.weights_[name], dropped)
                scores[rows, column] = voted_scores(distances, self.members_[:, column], weights, method)
        return scores

    def distances(self, settled: Sequence[DropsByRadius], radius: float, *, any_heading: bool = False) -> np.ndarray:
        """Return the Euclidean distances (Q, N) from objects to the training examples; see `score_settled`."""
        rests = [drops.get(radius, NO_DROPS).rests for drops in settled]
        turns = [[quarter_turns(centers, k) for centers in rests] for k in range(4 if any_heading else 1)]
        features = [self.histograms_[radius].transform(turned) for turned in turns]
        return np.min([euclidean_distances(counts, self.examples_[radius]) for counts in features], axis=0)

    def neighbors(self, settled: DropsByRadius, name: str) -> list[dict]:
        """Return the training objects that decide one object's membership, by radius and nearest first.

        The weights of those that have the function sum to its score.
        """
        rows, members = [], self.members_[:, self.functions_.index(name)]
        for radius, share in self.weights_[name].items():
            distances = self.distances([settled], radius)[0]
            weights = share * self.neighbor_weights(distances, name)
            rows += [
                {
                    "name": self.names_[i],
                    "member": bool(members[i]),
                    "distance": round(float(distances[i]), 4),
                    "weight": round(float(weights[i]), 4),
                    "radius": radius,
                }
                for i in np.flatnonzero(weights)[np.argsort(-weights[weights > 0], kind="stable")]
            ]
        return rows

    def neighbor_weights(self, distances: np.ndarray, name: str) -> np.ndarray:
        """Return the share (N,) of each training object in one radius's score; those of the members sum to the score.

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

    def chosen_radii(self) -> list[float]:
        """Return the radii that some function uses, ascending, metres."""
        check_is_fitted(self)
        return sorted(set().union(*self.weights_.values()))

    def only(self, name: str) -> CubeClassifier:
        """Return a fitted copy for one function only, so that spheres of its radii alone are dropped."""
        alone, column = copy(self), self.column_of(name)
        alone.functions_, alone.members_ = (name,), self.members_[:, [column]]
        alone.weights_ = {name: self.weights_[name]}
        return alone

    def held_out_f_measures(self) -> dict[str, float | None]:
        """Return each function's F-measure on training objects, leaving one out at a time; None for too few."""
        measured: dict[str, float | None] = dict.fromkeys(self.functions_)
        distances = {radius: euclidean_distances(self.examples_[radius]) for radius in self.chosen_radii()}
        others, method = ~np.eye(len(self.members_), dtype=bool), find_cube_method(self.method)
        for name, members in zip(self.functions_, self.members_.T, strict=True):
            if min(members.sum(), (~members).sum()) < 2:
                continue
            weights, scores = self.weights_[name], []
            for i, rest in enumerate(others):
                to_others = {radius: distances[radius][[i]][:, rest] for radius in weights}
                scores.append(voted_scores(to_others, members[rest], weights, method))
            measured[name] = quality(members, np.concatenate(scores) > THRESHOLD).f_measure
        return measured

    def _choose_radii(self) -> CubeClassifier:
        distances = {radius: euclidean_distances(matrix) for radius, matrix in self.examples_.items()}
        self.weights_ = {
            name: radius_weights(distances, members, find_cube_method(self.method), self.random_state)
            for name, members in zip(self.functions_, self.members_.T, strict=True)
        }
        return self


def cube_parts(model: CubeClassifier) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return header entries and arrays that the file of a model by cubes has besides those of all models."""
    arrays = {}
    for i, radius in enumerate(model.radii):
        matrix = model.examples_[radius]
        arrays[f"keys_{i}"] = model.histograms_[radius].keys_
        arrays[f"data_{i}"], arrays[f"indices_{i}"], arrays[f"indptr_{i}"] = matrix.data, matrix.indices, matrix.indptr
    weights = {name: list(weights.items()) for name, weights in model.weights_.items()}
    return {"method": asdict(find_cube_method(model.method)), "weights": weights}, arrays


def rebuilt_method(about: dict[str, Any]) -> Method:
    """Return the method that a model file describes.

    Earlier versions had options that are gone; a file with other than their default values is refused.
    """
    fixed = {"anchor": "centre", "heading": "as_given", "counts": "raw"}
    about = about | {"neighbors": tuple(about["neighbors"])}
    if any(about.pop(name, value) != value for name, value in fixed.items()):
        raise ValueError("a method of an earlier version")
    if about["name"] == "default":  # what earlier versions called it
        about["name"] = CUBES.name
    return Method(**about)


def fill_cubes(model: CubeClassifier, about: dict[str, Any], arrays: dict[str, np.ndarray]):
    """Set the attributes of a classifier by cubes from its file."""
    model.weights_ = {name: {radius: weight for radius, weight in about["weights"][name]} for name in model.functions_}
    if not all(weights and set(weights) <= set(model.radii) for weights in model.weights_.values()):
        raise ValueError("a function's radius is none of the model's")
    model.histograms_, model.examples_ = {}, {}
    for i, radius in enumerate(model.radii):
        histogram = histogram_of(model.method, radius)
        histogram.keys_ = arrays[f"keys_{i}"].astype(np.int64)
        parts = arrays[f"data_{i}"], arrays[f"indices_{i}"], arrays[f"indptr_{i}"]
        matrix = sparse.csr_matrix(parts, shape=(len(arrays["names"]), len(histogram.keys_) + 1))
        matrix.check_format(full_check=True)
        if not np.isfinite(matrix.data).all():
            raise ValueError("examples that are not finite")
        model.histograms_[radius], model.examples_[radius] = histogram, matrix
