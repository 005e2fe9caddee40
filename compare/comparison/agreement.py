"""Whether two simulators agree: histograms, labels, numbers of settled spheres, and objects on which they differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from statistics import multimode
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import norm

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import format_length
from spherefunc_bullet.learning.histogram import histogram_of
from spherefunc_bullet.learning.method import CUBES
from spherefunc_bullet.learning.validation import THRESHOLD
from spherefunc_bullet.settling.cached_runs import LoadOptions
from spherefunc_bullet.simulator import sphere_limit
from spherefunc_bullet.viewer.data import Layer, Panel, display, sphere_layer
from spherefunc_bullet.viewer.pictures import fitting_radius

from ..evaluation.evaluation import Evaluation
from .entries import ComparedRun, Comparison, dropped_twice
from .significance import Report, paired_differences

MOST = 6  # objects shown, so that the page stays small
MAX_SPHERES = 4000  # of one run that are drawn: the first to settle
Display = dict[str, Any]  # for the viewer, see `viewer.data.display`
SPHERES_ACROSS = 24  # approximate number of radii along the longest side, of the spheres shown at first


def agreements(
    comparison: Comparison, features: Mapping[str, Evaluation], backends: Mapping[str, Report]
) -> list[dict[str, Any]]:
    """Return the agreement of each pair of simulators."""
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
    """Return the distance between two simulators' histograms, and for comparison between two seeds of one simulator.

    An object has four histograms: by A and by B, each with two seeds. ``between`` is the root mean square of the four
    distances across, ``within`` that of A's distance between its seeds and B's. If A and B drew from the same
    distribution, the expected squares would be equal: both are twice the variance. So their ratio is near 1 where
    a change of simulator is no more than a change of seed. Medians over objects, since a sofa's thousands of spheres
    would outweigh all cups in a mean; all of them over the same objects: where no histogram differs from another, as
    where nothing settles, there is no ratio.
    """
    histograms = four_histograms(first, second, radius)
    a, again_a, b, again_b = histograms
    between = np.sqrt(np.mean([norm(x - y, axis=1) ** 2 for x in (a, again_a) for y in (b, again_b)], axis=0))
    seeds = {first.name: norm(a - again_a, axis=1), second.name: norm(b - again_b, axis=1)}
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
    matrix = histogram_of(CUBES, radius).fit_transform(settled)
    count = len(settled) // 4
    return [matrix[i * count : (i + 1) * count] for i in range(4)]


def median_ratio(above: np.ndarray, below: np.ndarray) -> float | None:
    """Return the median of ratios (N,), without those of zero to zero; others to zero are infinite."""
    decided = (above > 0) | (below > 0)
    ratios = np.divide(above[decided], below[decided], out=np.full(decided.sum(), np.inf), where=below[decided] > 0)
    return median(ratios)


def median(values: np.ndarray) -> float | None:
    """Return a median, or None where there is none that is finite."""
    middle = float(np.median(values)) if len(values) else np.inf
    return round(middle, 4) if np.isfinite(middle) else None


def labels_agree(first: Evaluation, second: Evaluation, names: list[str]) -> dict[str, dict[str, Any]]:
    """Return, per function, the share of objects on which both agree, and how many only one classifies correctly."""
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
    """Return, per function, the share of objects dropped on twice on which both seeds agree.

    The agreement of two simulators is to be compared with it.
    """
    again = evaluation.again
    shares = np.mean(again.predicted == evaluation.predicted[again.rows], axis=0)
    return {name: round(float(share), 4) for name, share in zip(evaluation.labels.functions, shares, strict=True)}


@dataclass(frozen=True, kw_only=True)
class Disagreement:
    """One object on which at least two simulators disagree, or nearly so."""

    row: int  # of the report's objects
    function: str  # the one with the largest difference of scores
    difference: float  # of the scores
    labels_differ: bool


def disagreements(per_object: Sequence[Report]) -> list[Disagreement]:
    """Return each object's greatest difference between simulators: different labels first, then by scores."""
    greatest = [greatest_difference(row, item) for row, item in enumerate(per_object) if len(item["backends"]) > 1]
    return sorted(greatest, key=lambda case: (not case.labels_differ, -case.difference, case.row))


def greatest_difference(row: int, item: Report) -> Disagreement:
    """Return one object's greatest difference; different labels count more than different scores."""
    cases = []
    for first, second in combinations([figures["scores"] for figures in item["backends"].values()], 2):
        for function, score in first.items():
            differ = (score > THRESHOLD) != (second[function] > THRESHOLD)
            difference = round(abs(score - second[function]), 4)
            cases.append(Disagreement(row=row, function=function, difference=difference, labels_differ=differ))
    return max(cases, key=lambda case: (case.labels_differ, case.difference))


def clearest(cases: Sequence[Disagreement]) -> list[Disagreement]:
    """Return the greatest disagreements, taking turns between functions, those with different labels first."""
    about: dict[str, list[Disagreement]] = {}
    for case in cases:
        about.setdefault(case.function, []).append(case)
    turns = [(place, case) for own in about.values() for place, case in enumerate(own)]
    order = sorted(turns, key=lambda turn: (not turn[1].labels_differ, turn[0], -turn[1].difference))
    return [case for _, case in order[:MOST]]


def displays_of(
    comparison: Comparison, cases: Sequence[Disagreement], loading: LoadOptions
) -> list[tuple[Disagreement, Display]]:
    """Return some disagreements with their displays; files that no longer exist are left out.

    They begin with the radius at which spheres are seen best, of those that most simulators have.
    """
    displays, common = [], multimode(radius for entry in comparison.entries for radius in entry.radii)
    for case in cases:
        try:
            cloud = load_cloud(comparison.simulated.objects[case.row].path, up=loading.up, units=loading.units)
        except InputError:
            continue
        panels = [panel(entry, case.row) for entry in comparison.entries]
        displays.append((case, display(cloud, panels, fitting_radius(common, cloud.size, SPHERES_ACROSS))))
    return displays


def panel(entry: ComparedRun, row: int) -> Panel:
    """Return one simulator's spheres on one object, to be drawn."""
    return Panel(title=entry.name, layers=[layer(entry, row, radius) for radius in entry.radii])


def layer(entry: ComparedRun, row: int, radius: float) -> Layer:
    """Return one simulator's spheres of one radius on one object, to be drawn."""
    record = entry.records[row]
    everything = record.centers(radius)
    centers, settled = everything[:MAX_SPHERES], len(everything)
    note = f"Spheres of radius {format_length(radius)}: {settled:,} of {record.drops[radius]:,} settled"
    note += f", in {record.seconds[radius]:.3g} s"
    note += f"; the first {len(centers):,} are drawn." if len(centers) < settled else "."
    return sphere_layer(radius, centers, note)
