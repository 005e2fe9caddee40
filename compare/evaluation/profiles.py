"""Resting profiles against cubes: the same spheres read in two ways, and both against the object's own points.

    python -m spherefunc_bullet.compare.evaluation.profiles DATA

Docs/method.md has the tables. ``--ranking`` prints what each quantity adds across sources, ``--classifiers`` what
other classifiers make of the same quantities.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from time import perf_counter
from typing import Annotated

import typer

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, run
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.learning.method import METHODS
from spherefunc_bullet.learning.profile_classifier import ProfileClassifier
from spherefunc_bullet.learning.resting_profile import FIRST

from .alternatives import f_measures, side_by_side
from .evaluation import Evaluation, evaluate
from .features import SPHERES, baseline_distances, sphere_distances
from .fusion import fused
from .profile_choices import print_classifiers, print_ranking
from .profiled import ACROSS, points_as_spheres, profiled, reliability
from .protocol import Protocol, Splits, labels_of
from .related.fixed import related
from .results import Result, results_of
from .sizes import wanted_sizes
from .tables import print_baselines

POINTS = "points, same quantities"
FUSED = "spheres and points"
Radii = Annotated[str, typer.Option(help="Sphere radii, all of which count.")]
Sizes = Annotated[str, typer.Option(help="Training examples on random halves.")]
First = Annotated[str, typer.Option(help="Also with only so many settled spheres a run, such as 30,60,120.")]


def evaluations(simulated: Simulated, radii: tuple[float, ...], splits: Splits) -> dict[str, Evaluation]:
    """Return the evaluation of profiles, of their baselines, and of cubes by today's default method."""
    labels, method = labels_of(simulated), METHODS["default"]
    classifier = ProfileClassifier(radii)
    cubes = {"cubes (default)": sphere_distances(simulated, radii, method)}
    points = [points_as_spheres(record, radii) for record in simulated.records]
    read = {
        SPHERES: profiled(simulated.settled, labels, classifier),
        POINTS: profiled(points, labels, classifier),
    }
    read |= {FUSED: fused(list(read.values()))} | related(simulated.records, labels)
    return {name: feature.evaluation(splits) for name, feature in read.items()} | {
        name: evaluate(distances, labels, method, splits)
        for name, distances in (cubes | baseline_distances(simulated.records, radii)).items()
    }


def few_spheres(
    simulated: Simulated, radii: tuple[float, ...], counts: Sequence[int], splits: Splits
) -> dict[int, dict[str, float]]:
    """Return the F-measures across sources when only so many settled spheres of each run are read."""
    labels, across = labels_of(simulated), Splits(halves={}, left_out=splits.left_out)
    evaluated = {
        count: profiled(simulated.settled, labels, ProfileClassifier(radii, first=count)).evaluation(across)
        for count in counts
    }
    return {count: f_measures(evaluation.left_out_quality(ACROSS)) for count, evaluation in evaluated.items()}


def milliseconds_each(simulated: Simulated, radii: tuple[float, ...]) -> float:
    """Return the milliseconds that the quantities of one object take, all radii together."""
    start = perf_counter()
    ProfileClassifier(radii).profiles(simulated.settled)
    return 1000 * (perf_counter() - start) / len(simulated.records)


def main(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder with manifest.csv, or a catalogue's name.")],
    radii: Radii = "1cm,3cm",
    first: First = f"30,60,120,{FIRST}",
    train_sizes: Sizes = "20,45,100",
    trials: Annotated[int, typer.Option(min=1, help="Random equal splits.")] = 10,
    classifiers: Annotated[bool, typer.Option(help="Compare classifiers instead.")] = False,
    ranking: Annotated[bool, typer.Option(help="Rank quantities by what they add instead.")] = False,
    backend: options.Backend = "fast",
    seed: options.Seed = 0,
    jobs: options.Jobs = -1,
    json: options.Json = False,
):
    """Measure how well functions are told from resting profiles, across sources and on random halves."""
    failures = Failures()
    dropping = options.dropping(backend, None, radii, seed, "z", "m")
    simulated = simulate_dataset(open_dataset(data), dropping, jobs=jobs, failed=failures.add)
    sizes = tuple(wanted_sizes(train_sizes, len(simulated.objects)))
    splits = Protocol(train_sizes=sizes, trials=trials, seed=seed, groups=True).splits(labels_of(simulated))
    if ranking or classifiers:
        (print_ranking if ranking else print_classifiers)(simulated, dropping.radii, splits, json)
    else:
        evaluated = evaluations(simulated, dropping.radii, splits)
        sure = reliability(evaluated[SPHERES].left_out[ACROSS], evaluated[SPHERES].labels)
        counts = few_spheres(simulated, dropping.radii, [int(count) for count in first.split(",")], splits)
        print_all(results_of(evaluated), counts, sure, milliseconds_each(simulated, dropping.radii), json)
    failures.exit()


def print_all(
    results: Sequence[Result],
    counts: Mapping[int, dict[str, float]],
    sure: Sequence[Mapping[str, float]],
    milliseconds: float,
    json: bool,
):
    """Print the results, those with few spheres, what scores are worth, and the cost, as JSON or as tables."""
    if json:
        cost = round(milliseconds, 2)
        print_json({"results": results, "first": counts, "reliability": sure, "milliseconds_per_object": cost})
        return
    for result in results:
        print_baselines(result)
    functions = ", ".join(next(iter(counts.values())))
    rows = [[str(count), side_by_side(row)] for count, row in counts.items()]
    print_table(f"\nacross sources, F-measure of {functions}", ["first settled spheres", "F"], rows)
    bins = [
        [f"{row['from']:g} to {row['to']:g}", str(row["scores"]), f"{row['said']:.3f}", f"{row['true']:.3f}"]
        for row in sure
    ]
    print_table("\nacross sources, scores of all functions", ["score", "how many", "said", "true"], bins)
    print(f"\nquantities of one object: {milliseconds:.1f} ms")


if __name__ == "__main__":
    run(lambda: typer.run(main))
