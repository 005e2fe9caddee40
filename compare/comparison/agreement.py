"""Whether two simulators say the same: their histograms, their labels, and how many spheres settle."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from scipy import sparse
from sklearn.metrics.pairwise import euclidean_distances

from spherefunc_bullet.learning.method import Method
from spherefunc_bullet.learning.validation import THRESHOLD
from spherefunc_bullet.settling.records import ObjectRecord
from spherefunc_bullet.simulator import sphere_limit

from ..evaluation.baselines import Distances
from ..evaluation.protocol import Judgement, Labels, Split, scores_of_others
from .costs import settled_share
from .entries import Contest, Entry
from .significance import paired_differences


def agreements(
    contest: Contest, judged: dict[str, Judgement], labels: Labels, split: Split, method: Method
) -> list[dict]:
    """Return the agreement of each pair of simulators; of one alone there is none."""
    if len(contest.entries) == 1:
        return []
    same = {each.contestant.name: seeds_agree(each, judged, labels, method) for each in contest.entries}
    rows = []
    for pair in combinations(contest.entries, 2):
        first, second = names = [each.contestant.name for each in pair]
        radii = [radius for radius in pair[0].contestant.radii if radius in pair[1].contestant.radii]
        functions = [judged[name].functions for name in names]
        rows.append(
            {
                "backends": names,
                "objects_again": contest.repeated,
                "histograms": [histograms_agree(*pair, radius, method) for radius in radii],
                "settled": [settled_beside(pair, radius) for radius in radii],
                "labels": labels_agree(judged[first], judged[second], labels, names),
                "labels_of_two_seeds": {name: same[name] for name in names},
                "f_measures": paired_differences(*functions, len(split.train), len(split.test)),
            }
        )
    return rows


def histograms_agree(first: Entry, second: Entry, radius: float, method: Method) -> dict:
    """Return how far two simulators' histograms lie apart, beside two seeds of one simulator.

    An object has four histograms: by A and by B, each with two seeds. ``between`` is the root mean square of the four
    distances across, ``within`` that of A's distance between its seeds and B's. If A and B drew from the same
    distribution, the expected squares would be equal: both are twice the variance. So their ratio is near 1 where
    a change of simulator is no more than a change of seed. Medians over objects, since a sofa's thousands of spheres
    would outweigh all cups in a mean. Objects on which no histogram differs say nothing and have no ratio.

    Returns
    -------
    dict
        ``ratio`` (to both seeds), ``ratio_to`` (to the seeds of each), ``between``, ``within`` and ``norm`` in
        spheres, ``objects`` that have a ratio. None where it is not finite.
    """
    histograms = four_histograms(first, second, radius, method)
    a, again_a, b, again_b = histograms
    between = np.sqrt(np.mean([apart(x, y) ** 2 for x in (a, again_a) for y in (b, again_b)], axis=0))
    seeds = [apart(a, again_a), apart(b, again_b)]
    within = np.sqrt(np.mean(np.square(seeds), axis=0))
    names = [each.contestant.name for each in (first, second)]
    return {
        "radius": radius,
        "ratio": median_ratio(between, within),
        "ratio_to": {name: median_ratio(between, each) for name, each in zip(names, seeds, strict=True)},
        "between": median(between),
        "within": {name: median(each) for name, each in zip(names, seeds, strict=True)},
        "norm": median(np.sqrt(np.mean([norms(each) ** 2 for each in histograms], axis=0))),
        "objects": int(np.sum((between > 0) | (within > 0))),
    }


def four_histograms(first: Entry, second: Entry, radius: float, method: Method) -> list[sparse.csr_matrix]:
    """Return the histograms of the objects dropped on twice: A's, A's again, B's, B's again, in one space.

    Of the first spheres to settle, as many as either simulator is allowed, since a run that ends sooner differs.
    """
    limit = min(sphere_limit(each.contestant.simulator) for each in (first, second))
    settled = []
    for entry in (first, second):
        twice = [(entry.simulated.records[row], again) for row, again in dropped_twice(entry)]
        settled += [each.settled[radius][:limit] for each, _ in twice]
        settled += [again.settled[radius][:limit] for _, again in twice]
    matrix = method.histogram(radius).fit_transform(settled)
    count = len(settled) // 4
    return [matrix[i * count : (i + 1) * count] for i in range(4)]


def apart(first: sparse.csr_matrix, second: sparse.csr_matrix) -> np.ndarray:
    """Return the distance (N,) between the rows of two matrices."""
    return norms(first - second)


def norms(matrix: sparse.csr_matrix) -> np.ndarray:
    """Return the Euclidean norm (N,) of each row."""
    return np.sqrt(np.asarray(matrix.multiply(matrix).sum(axis=1)).ravel())


def median_ratio(above: np.ndarray, below: np.ndarray) -> float | None:
    """Return the median of ratios (N,); of zero by zero there is none, and of others by zero it is infinite."""
    told = (above > 0) | (below > 0)
    ratios = np.divide(above[told], below[told], out=np.full(told.sum(), np.inf), where=below[told] > 0)
    return median(ratios)


def median(values: np.ndarray) -> float | None:
    """Return a median, or None where there is none that is finite."""
    found = float(np.median(values)) if len(values) else np.inf
    return round(found, 4) if np.isfinite(found) else None


def settled_beside(pair: tuple[Entry, Entry], radius: float) -> dict:
    """Return the share of spheres that settled by each simulator."""
    shares = {each.contestant.name: settled_share(each.simulated.records, [radius]) for each in pair}
    return {"radius": radius, "share": shares}


def labels_agree(first: Judgement, second: Judgement, labels: Labels, names: list[str]) -> dict:
    """Return, per function, the share of objects of which both say the same, and how many one alone has right."""
    rows = {}
    for column, function in enumerate(labels.functions):
        truth = labels.members[:, column]
        right = [each.predicted[:, column] == truth for each in (first, second)]
        rows[function] = {
            "same": round(float(np.mean(first.predicted[:, column] == second.predicted[:, column])), 4),
            "right_alone": {
                name: int(np.sum(mine & ~other))
                for name, mine, other in zip(names, right, reversed(right), strict=True)
            },
        }
    return rows


def seeds_agree(entry: Entry, judged: dict[str, Judgement], labels: Labels, method: Method) -> dict[str, float]:
    """Return, per function, the share of objects dropped on twice of which both seeds say the same.

    Both are compared with the first seed's histograms of all other objects, so that only the object's own spheres
    differ: what two simulators' agreement has to be measured by.
    """
    mine = judged[entry.contestant.name]
    rows = [row for row, _ in dropped_twice(entry)]
    again = scores_of_others(distances_again(entry, method), rows, mine, labels, method) > THRESHOLD
    shares = np.mean(again == mine.predicted[rows], axis=0)
    return {name: round(float(share), 4) for name, share in zip(labels.functions, shares, strict=True)}


def dropped_twice(entry: Entry) -> list[tuple[int, ObjectRecord]]:
    """Return the objects that were dropped on twice: which row they are, and their records of the second seed."""
    again = {each.path: each for each in entry.again.records}
    return [(row, again[each.path]) for row, each in enumerate(entry.simulated.records) if each.path in again]


def distances_again(entry: Entry, method: Method) -> Distances:
    """Return the distances (R, N) from the histograms of the second seed to all of the first, at each radius."""
    distances = {}
    for radius in entry.contestant.radii:
        histogram = method.histogram(radius)
        learnt = histogram.fit_transform([each.settled[radius] for each in entry.simulated.records])
        asked = histogram.transform([again.settled[radius] for _, again in dropped_twice(entry)])
        distances[radius] = euclidean_distances(asked, learnt)
    return distances
