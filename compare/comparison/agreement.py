"""Whether two simulators say the same: their histograms, their labels, and how many spheres settle."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import norm

from spherefunc_bullet.learning.method import CUBES
from spherefunc_bullet.simulator import sphere_limit

from ..evaluation.evaluation import Evaluation
from .entries import ComparedRun, Comparison, dropped_twice
from .significance import Report, paired_differences


def agreements(
    comparison: Comparison, features: Mapping[str, Evaluation], backends: Mapping[str, Report]
) -> list[dict[str, Any]]:
    """Return the agreement of each pair of simulators; of one alone there is none."""
    if len(comparison.entries) == 1:
        return []
    reports = []
    for pair in combinations(comparison.entries, 2):
        names = [entry.name for entry in pair]
        radii = [radius for radius in pair[0].radii if radius in pair[1].radii]
        shares = {name: {row["radius"]: row["settled_share"] for row in backends[name]["by_radius"]} for name in names}
        first, second = (features[name] for name in names)
        reports.append(
            {
                "backends": names,
                "objects_again": comparison.repeated,
                "histograms": [histograms_agree(*pair, radius) for radius in radii],
                "settled": [{"radius": r, "share": {name: shares[name][r] for name in names}} for r in radii],
                "labels": labels_agree(first, second, names),
                "labels_of_two_seeds": {name: seeds_agree(features[name]) for name in names},
                "f_measures": paired_differences(*(backends[name]["functions"] for name in names), *first.halves),
            }
        )
    return reports


def histograms_agree(first: ComparedRun, second: ComparedRun, radius: float) -> dict[str, Any]:
    """Return how far two simulators' histograms lie apart, beside two seeds of one simulator.

    An object has four histograms: by A and by B, each with two seeds. ``between`` is the root mean square of the four
    distances across, ``within`` that of A's distance between its seeds and B's. If A and B drew from the same
    distribution, the expected squares would be equal: both are twice the variance. So their ratio is near 1 where
    a change of simulator is no more than a change of seed. Medians over objects, since a sofa's thousands of spheres
    would outweigh all cups in a mean; all of them over the same objects: where no histogram differs from another, as
    where nothing settles, there is no ratio.
    """
    histograms = four_histograms(first, second, radius)
    a, again_a, b, again_b = histograms
    between = np.sqrt(np.mean([apart(x, y) ** 2 for x in (a, again_a) for y in (b, again_b)], axis=0))
    seeds = {first.name: apart(a, again_a), second.name: apart(b, again_b)}
    within = np.sqrt(np.mean(np.square(list(seeds.values())), axis=0))
    norms = np.sqrt(np.mean([norm(histogram, axis=1) ** 2 for histogram in histograms], axis=0))
    differ = (between > 0) | (within > 0)
    return {
        "radius": radius,
        "ratio": median_ratio(between, within),
        "ratio_to": {name: median_ratio(between, between_seeds) for name, between_seeds in seeds.items()},
        "between": median(between[differ]),
        "within": {name: median(between_seeds[differ]) for name, between_seeds in seeds.items()},
        "norm": median(norms[differ]),
        "objects": int(np.sum(differ)),
    }


def four_histograms(first: ComparedRun, second: ComparedRun, radius: float) -> list[sparse.csr_matrix]:
    """Return the histograms of the objects dropped on twice: A's, A's again, B's, B's again, in one space.

    Of the first spheres to settle, as many as either simulator is allowed, since a run that ends sooner differs.
    """
    limit = min(sphere_limit(entry.candidate.simulator) for entry in (first, second))
    settled = []
    for entry in (first, second):
        twice = dropped_twice(entry)
        settled += [entry.records[row].centers(radius)[:limit] for row in twice]
        settled += [again.centers(radius)[:limit] for again in twice.values()]
    matrix = CUBES.histogram(radius).fit_transform(settled)
    count = len(settled) // 4
    return [matrix[i * count : (i + 1) * count] for i in range(4)]


def apart(first: sparse.csr_matrix, second: sparse.csr_matrix) -> np.ndarray:
    """Return the distance (N,) between the rows of two matrices."""
    return norm(first - second, axis=1)


def median_ratio(above: np.ndarray, below: np.ndarray) -> float | None:
    """Return the median of ratios (N,); of zero by zero there is none, and of others by zero it is infinite."""
    decided = (above > 0) | (below > 0)
    ratios = np.divide(above[decided], below[decided], out=np.full(decided.sum(), np.inf), where=below[decided] > 0)
    return median(ratios)


def median(values: np.ndarray) -> float | None:
    """Return a median, or None where there is none that is finite."""
    middle = float(np.median(values)) if len(values) else np.inf
    return round(middle, 4) if np.isfinite(middle) else None


def labels_agree(first: Evaluation, second: Evaluation, names: list[str]) -> dict[str, dict[str, Any]]:
    """Return, per function, the share of objects of which both say the same, and how many one alone has right."""
    same = np.mean(first.predicted == second.predicted, axis=0)
    right, also_right = (evaluation.predicted == evaluation.labels.members for evaluation in (first, second))
    alone = np.sum(right & ~also_right, axis=0), np.sum(also_right & ~right, axis=0)
    return {
        function: {
            "same": round(float(same[column]), 4),
            "right_alone": {name: int(counts[column]) for name, counts in zip(names, alone, strict=True)},
        }
        for column, function in enumerate(first.labels.functions)
    }


def seeds_agree(evaluation: Evaluation) -> dict[str, float]:
    """Return, per function, the share of objects dropped on twice of which both seeds say the same.

    What two simulators' agreement has to be measured by.
    """
    again = evaluation.again
    shares = np.mean(again.predicted == evaluation.predicted[again.rows], axis=0)
    return {name: round(float(share), 4) for name, share in zip(evaluation.labels.functions, shares, strict=True)}
