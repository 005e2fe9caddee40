"""Which cubes of an object's histogram speak for a function, and which against it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ...settling.drops import DropsByRadius
from ..cube_classifier import CubeClassifier
from ..histogram import counted_cubes, cube_indices


@dataclass(frozen=True, kw_only=True, eq=False)
class Cubes:
    """Cubes of one grid, and what each holds."""

    side: float  # metres
    corners: np.ndarray  # (V, 3) float, lowest corner, metres, the object's frame
    counts: np.ndarray  # (V,) float, spheres of this object
    members: np.ndarray | None = None  # (V,) float, mean count of the nearest training objects with the function
    others: np.ndarray | None = None  # (V,) float, that of the nearest without it
    speaks_for: np.ndarray | None = None  # (V,) float, spheres squared; below 0 it speaks against


def cube_evidence(classifier: CubeClassifier, settled: DropsByRadius, name: str, radius: float) -> Cubes:
    """Return the cubes in which an object differs from its nearest training objects with and without a function.

    A score compares distances, and a squared distance is a sum over cubes: (count - neighbour's count) squared. A cube
    speaks for the function by the difference between its part of the mean squared distance to the nearest others and
    its part of that to the nearest members, both weighted as the neighbours are in the score. Over all cubes this sums
    exactly to the difference of the two mean squared distances. It does not sum to the score, which takes the inverse
    of each distance before the mean.

    Parameters
    ----------
    settled : dict of float to Drops
        The object's spheres at each radius, metres.
    name : str
        The function.
    radius : float
        One that the function uses, metres.

    Returns
    -------
    Cubes
        Those with spheres of the object or of a neighbour, with ``members``, ``others`` and ``speaks_for``. Cubes in
        which no training object had a sphere speak neither for nor against it.
    """
    histogram, examples = classifier.histograms_[radius], classifier.examples_[radius]
    here = histogram.transform([settled[radius].rests]).toarray()[0, :-1]
    distances = classifier.distances([settled], radius)[0]
    weights = classifier.neighbor_weights(distances, name)
    has = classifier.members_[:, classifier.functions_.index(name)]
    sides = [side_counts(examples, side_weights(weights, side, distances), here) for side in (has, ~has)]
    (inside, to_members), (outside, to_others) = sides
    speaks_for = to_others - to_members
    known = np.flatnonzero((here > 0) | (inside > 0) | (outside > 0))
    keys, counts = counted_cubes(settled[radius].rests, histogram.side)
    new = ~np.isin(keys, histogram.keys_)  # no training object had a sphere there
    members, others, speaks_for = (
        np.append(values[known], np.zeros(new.sum())) for values in (inside, outside, speaks_for)
    )
    return Cubes(
        side=histogram.side,
        corners=corners(np.append(histogram.keys_[known], keys[new]), histogram.side),
        counts=np.append(here[known], counts[new]),
        members=members,
        others=others,
        speaks_for=speaks_for,
    )


def side_weights(weights: np.ndarray, side: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """Return the weights (N,) of one side; if the score uses none of that side, its nearest object gets weight 1."""
    weights_of_side = np.where(side, weights, 0.0)
    if side.any() and not weights_of_side.any():
        weights_of_side[np.flatnonzero(side)[np.argmin(distances[side])]] = 1.0
    return weights_of_side


def side_counts(examples: sparse.csr_matrix, weights: np.ndarray, here: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return one side's weighted mean count of each cube (V,), and mean squared difference to the object (V,)."""
    rows = np.flatnonzero(weights)
    if not len(rows):
        return np.zeros(len(here)), np.zeros(len(here))
    counts = examples[rows].toarray()[:, : len(here)]
    shares = weights[rows] / weights[rows].sum()
    return shares @ counts, shares @ (here - counts) ** 2


def corners(keys: np.ndarray, side: float) -> np.ndarray:
    """Return the lowest corners (V, 3) of cubes (V,) int64 in the object's frame, metres."""
    return (cube_indices(keys) + 0.5) * side + [-side / 2, -side / 2, 0.0] - side / 2


def strongest_cubes(classifier: CubeClassifier, settled: DropsByRadius, name: str, count: int) -> list[dict]:
    """Return the cubes that speak most for and against a function, ready for JSON.

    They are of the radius that counts most, at most ``count`` for and ``count`` against, the strongest first. ``share``
    is a cube's part of all evidence at that radius, for and against together; it is negative for cubes against it.
    """
    radius = classifier.radius_[name]
    cubes = cube_evidence(classifier, settled, name, radius)
    total = np.abs(cubes.speaks_for).sum()
    order = np.argsort(-cubes.speaks_for, kind="stable")
    pro = [i for i in order[:count] if cubes.speaks_for[i] > 0]
    contra = [i for i in order[::-1][:count] if cubes.speaks_for[i] < 0]
    return [
        {
            "radius": radius,
            "side": round(cubes.side, 6),
            "corner": np.round(cubes.corners[i], 6).tolist(),
            "spheres": round(float(cubes.counts[i]), 2),
            "members": round(float(cubes.members[i]), 2),
            "others": round(float(cubes.others[i]), 2),
            "share": round(float(cubes.speaks_for[i] / total), 4),
        }
        for i in [*pro, *contra]
    ]
