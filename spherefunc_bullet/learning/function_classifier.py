"""What an object is for: one binary classifier per function, each with the radius that serves it best (§III-C)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from sklearn.base import BaseEstimator
from sklearn.metrics.pairwise import euclidean_distances
from sklearn.utils.validation import check_is_fitted

from ..clouds.cloud import Cloud
from ..datasets.dataset import parse_functions
from ..errors import InputError
from ..settling.settling import Settled, settle
from ..simulator import Simulator
from .histogram import quarter_turns, widened
from .inverse_distance import SAME
from .method import Method, find_method
from .validation import THRESHOLD, radius_weights, remaining_weights, voted_scores

Label = str | Iterable[str]  # an object's functions: a set, a list, ``'table;sittable'`` or ``'none'``
RADII = (0.005, 0.01, 0.02, 0.03, 0.05)  # metres
NO_SPHERES = np.empty((0, 3))


@dataclass(frozen=True, kw_only=True)
class Membership:
    """Whether an object has a function."""

    member: bool
    score: float  # 0 to 1, to four places
    radius: float  # of the spheres that count most, metres


class FunctionClassifier(BaseEstimator):
    """Learn functions from labelled clouds, and tell those of others: several, or none.

    Parameters
    ----------
    simulator : str or Simulator
        A registered backend's name, or a simulator.
    radii : sequence of float
        Sphere radii to choose from, metres.
    method : {'default', 'paper'} or Method
    seed : int
        Of the drops.
    random_state : int
        Of the validation splits.

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
        method: str | Method = "default",
        seed: int = 0,
        random_state: int = 0,
    ):
        self.simulator = simulator
        self.radii = radii
        self.method = method
        self.seed = seed
        self.random_state = random_state

    def fit(self, X: Sequence[Cloud], y: Sequence[Label]) -> FunctionClassifier:
        """Learn from clouds X and their functions y (each a set, a list, or ``'table;sittable'``, or ``'none'``)."""
        return self.fit_settled(self._settled(X), y, [cloud.name for cloud in X])

    def partial_fit(self, X: Sequence[Cloud], y: Sequence[Label]) -> FunctionClassifier:
        """Learn from more clouds: earlier examples stay, and the radii are chosen anew."""
        if not hasattr(self, "examples_"):
            return self.fit(X, y)
        return self.add_settled(self._settled(X), y, [cloud.name for cloud in X])

    def fit_settled(self, settled: Sequence[Settled], y: Sequence[Label], names: Sequence[str]) -> FunctionClassifier:
        """Learn from settled centres: per object a dict of radius to (S, 3), as `settle` returns it."""
        labels = as_sets(y)
        if not len(settled) == len(labels) == len(names):
            raise ValueError(f"got {len(settled)} objects, {len(labels)} labels and {len(names)} names")
        method = find_method(self.method)
        self.functions_ = tuple(sorted(set().union(*labels)))
        self.members_ = memberships(labels, self.functions_)
        self.names_ = list(names)
        self.histograms_, self.examples_ = {}, {}
        for radius in self.radii:
            self.histograms_[radius] = method.histogram(radius)
            self.examples_[radius] = self.histograms_[radius].fit_transform([spheres[radius] for spheres in settled])
        return self._choose_radii()

    def add_settled(self, settled: Sequence[Settled], y: Sequence[Label], names: Sequence[str]) -> FunctionClassifier:
        """Learn from more settled centres."""
        from scipy import sparse

        check_is_fitted(self)
        labels = as_sets(y)
        functions = tuple(sorted(set(self.functions_).union(*labels)))
        known = [self.functions_.index(name) if name in self.functions_ else None for name in functions]
        old = np.column_stack([self.members_[:, k] if k is not None else self._no_members() for k in known])
        self.functions_, self.members_ = functions, np.vstack([old, memberships(labels, functions)])
        self.names_ = [*self.names_, *names]
        for radius, histogram in self.histograms_.items():
            centers = [spheres[radius] for spheres in settled]
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
    def to_the_end(self) -> bool:
        """Whether runs end by the paper's rule alone; see `Method`."""
        return find_method(self.method).to_the_end

    def predict_proba(self, X: Sequence[Cloud]) -> np.ndarray:
        """Return a score from 0 to 1 for each cloud and function (N, F), in the order of ``functions_``."""
        return self.score_settled(self._settled(X, self.chosen_radii()))

    def predict(self, X: Sequence[Cloud]) -> list[frozenset[str]]:
        """Return the functions of each cloud, an empty set for none."""
        return [
            frozenset(name for name, score in zip(self.functions_, row, strict=True) if score > THRESHOLD)
            for row in self.predict_proba(X)
        ]

    def score_settled(self, settled: Sequence[Settled], *, any_heading: bool = False) -> np.ndarray:
        """Return the scores (N, F) of objects given as settled centres.

        Parameters
        ----------
        settled : sequence of dict of radius in metres to (S, 3) float, metres
            At the chosen radii. Where spheres of one were not dropped, the others vote alone.
        any_heading : bool
            Whether an object may face any way, as in a scan: its distance to a training object is then that at the
            best of four quarter turns.
        """
        check_is_fitted(self)
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
                scores[rows, column] = voted_scores(known, members, weights, find_method(self.method))
        return scores

    def memberships_of(self, settled: Sequence[Settled], *, any_heading: bool = False) -> list[dict[str, Membership]]:
        """Return what each object is for, by the function's name; see `score_settled`."""
        return [
            {
                name: Membership(member=score > THRESHOLD, score=round(score, 4), radius=self.radius_[name])
                for name, score in zip(self.functions_, row, strict=True)
            }
            for row in self.score_settled(settled, any_heading=any_heading).tolist()
        ]

    def distances(self, settled: Sequence[Settled], radius: float) -> np.ndarray:
        """Return the Euclidean distances (Q, N) from objects to the training examples."""
        features = self.histograms_[radius].transform([spheres.get(radius, NO_SPHERES) for spheres in settled])
        return euclidean_distances(features, self.examples_[radius])

    def turned_distances(self, settled: Sequence[Settled], radius: float) -> np.ndarray:
        """Return the distances (Q, N) to the training examples, each object turned by quarters to be nearest."""
        turns = [[{radius: quarter_turns(spheres.get(radius, NO_SPHERES), k)} for spheres in settled] for k in range(4)]
        return np.min([self.distances(turned, radius) for turned in turns], axis=0)

    def neighbors(self, settled: Settled, name: str) -> list[dict]:
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
        method = find_method(self.method)
        counts, weights = method.neighbors, np.zeros(len(members))
        sides = (np.arange(len(members)),) if method.of_all else both_sides(members)
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

    def _choose_radii(self) -> FunctionClassifier:
        distances = {radius: euclidean_distances(matrix) for radius, matrix in self.examples_.items()}
        self.weights_ = {
            name: radius_weights(distances, members, find_method(self.method), self.random_state)
            for name, members in zip(self.functions_, self.members_.T, strict=True)
        }
        return self

    def _no_members(self) -> np.ndarray:
        return np.zeros(len(self.members_), bool)

    def _settled(self, clouds: Sequence[Cloud], radii: Sequence[float] | None = None) -> list[Settled]:
        how = self.simulator, radii or self.radii, self.seed, self.to_the_end
        return [settle(cloud, *how) for cloud in clouds]


def as_sets(labels: Sequence[Label]) -> list[frozenset[str]]:
    """Return each label as a set of functions.

    Examples
    --------
    >>> [sorted(functions) for functions in as_sets(["cup", "none", {"table", "sittable"}])]
    [['cup'], [], ['sittable', 'table']]
    """
    sets = [parse_functions(label) if isinstance(label, str) else frozenset(label) for label in labels]
    if not sets:
        raise InputError("training set: expected at least one labelled object, got none")
    return sets


def by_radii(settled: Sequence[Settled]) -> dict[frozenset[float], list[int]]:
    """Return which objects had spheres dropped at which radii: the rows of each such set."""
    rows: dict[frozenset[float], list[int]] = {}
    for row, spheres in enumerate(settled):
        rows.setdefault(frozenset(spheres), []).append(row)
    return rows


def both_sides(members: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows with and the rows without the function."""
    return np.flatnonzero(members), np.flatnonzero(~members)


def memberships(labels: Sequence[frozenset[str]], functions: Sequence[str]) -> np.ndarray:
    """Return which object has which function, (N, F) bool."""
    return np.array([[name in label for name in functions] for label in labels], bool).reshape(len(labels), -1)
