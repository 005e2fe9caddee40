"""Resting profiles against cubes: the same spheres read in two ways, and both against the object's own points.

    python -m spherefunc_bullet.compare.evaluation.profiles DATA

Docs/method.md has the tables. ``--ranking`` prints what each quantity adds across sources, ``--classifiers`` what
other classifiers make of the same quantities.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import Annotated

import numpy as np
import typer
from sklearn.base import ClassifierMixin
from sklearn.ensemble import ExtraTreesClassifier, HistGradientBoostingClassifier, RandomForestClassifier
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import QuantileTransformer
from sklearn.svm import SVC

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, run, show
from spherefunc_bullet.datasets.dataset import Dataset, open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier, forest
from spherefunc_bullet.learning.method import CUBES, DROPS, ProfileMethod
from spherefunc_bullet.learning.profiles.quantities import NAMES
from spherefunc_bullet.settling.drops import first_drops
from spherefunc_bullet.settling.records import Dropping

from .alternatives import f_measures, print_beside, side_by_side
from .evaluation import Evaluation, Trial
from .features import SPHERES
from .protocol import Labels, Protocol, Splits, labels_of, wanted_sizes
from .readings import ACROSS, POINTS, Profiled, Reading, fused, profiled, readings, reliability, spheres_profiled
from .tables import Result, print_baselines, results_of

SURE = 0.003  # a probability beyond this counts as this much, so that one object cannot decide a mean
TREES = 100  # of the forests that rank quantities


def scaled(classifier: ClassifierMixin) -> ClassifierMixin:
    """Return a classifier of quantities in normal ranks, so that metres and shares can be compared."""
    ranks = QuantileTransformer(n_quantiles=20, output_distribution="normal", random_state=0)
    return make_pipeline(ranks, classifier)


CLASSIFIERS = {
    "extremely random trees": forest(),
    "random forest": RandomForestClassifier(300, random_state=0),
    "boosted trees": HistGradientBoostingClassifier(random_state=0),
    "support vectors": scaled(SVC(C=3, probability=True, random_state=0)),
    "nearest neighbours": scaled(KNeighborsClassifier(3, weights="distance")),
}


def print_classifiers(simulated: Simulated, radii: tuple[float, ...], splits: Splits, json: bool):
    """Print what each classifier makes of the quantities, calibrated alike: across sources and on random halves."""
    labels = labels_of(simulated)
    read = profiled(simulated.settled, labels, FunctionClassifier(radii=radii))
    rows = {}
    for name, estimator in CLASSIFIERS.items():
        classifier = FunctionClassifier(radii=radii, estimator=estimator)
        rows[name] = summary(replace(read, classifier=classifier).evaluation(splits))
    title = f"{simulated.name}: F-measure of {', '.join(labels.functions)}, and the log loss across sources"
    print_beside("classifier", rows, title, json)


def summary(evaluation: Evaluation) -> dict[str, dict[str, float] | float]:
    """Return F-measures across sources and on random halves, and the log loss across sources."""
    halves = {f"{size} train": f_measures(evaluation.quality(size)) for size in sorted(evaluation.trials)[::-1]}
    across = f_measures(evaluation.left_out_quality(ACROSS))
    return {"across sources": across, "log loss": log_loss(evaluation.left_out[ACROSS], evaluation.labels)} | halves


def log_loss(trial: Trial, labels: Labels) -> float:
    """Return the mean over functions and objects of minus the logarithm of what was said of the truth, nats."""
    members, scores = labels.members[trial.rows], np.clip(trial.scores, SURE, 1 - SURE)
    return round(float(-np.log(np.where(members, scores, 1 - scores)).mean()), 5)


def print_ranking(simulated: Simulated, radii: tuple[float, ...], splits: Splits, json: bool):
    """Print how much worse a forest does across sources without each quantity, at all radii, the most needed first.

    The log loss, because an F-measure moves only when an object crosses 0.5. Differences of less than its change
    with another seed, which is printed too, say nothing.
    """
    labels, names = labels_of(simulated), list(NAMES)
    everything = profiled(simulated.settled, labels, ranking_classifier(radii))
    full = loss_without(everything, splits)
    noise = [loss_without(everything, splits, seed=seed) for seed in range(1, 6)]
    added = {name: loss_without(everything, splits, [name]) - full for name in names}
    ranked = {name: round(added[name], 5) for name in sorted(names, key=added.get, reverse=True)}
    spread = round(float(np.std([full, *noise])), 5)
    if json:
        print_json({"log_loss": full, "spread_of_seeds": spread, "added_without": ranked})
        return
    title = f"{simulated.name}: log loss across sources {full:.4f}, {spread:.4f} from seed to seed"
    print_table(title, ["quantity", "more without it"], [[name, f"{value:+.5f}"] for name, value in ranked.items()])


def ranking_classifier(radii: Sequence[float], seed: int = 0) -> FunctionClassifier:
    """Return a quicker classifier, to be learnt some hundred times."""
    trees = ExtraTreesClassifier(TREES, random_state=seed)
    return FunctionClassifier(radii=radii, estimator=trees, random_state=seed)


def loss_without(read: Profiled, splits: Splits, left: Sequence[str] = (), seed: int = 0) -> float:
    """Return the log loss across sources when quantities are left out at every radius."""
    radii = read.classifier.radii
    kept = np.tile([name not in left for name in NAMES], len(radii))
    some = replace(read, profiles=read.profiles[:, kept], classifier=ranking_classifier(radii, seed))
    return log_loss(some.trial(splits.left_out[ACROSS]), read.labels)


FUSED = "spheres and points"
CUBES_READ = "spheres, cubes"
FIRST = f"10,20,40,80,120,{DROPS}"


def all_readings(
    simulated: Simulated, radii: tuple[float, ...], counted: Simulated | None, cubes_radii: tuple[float, ...]
) -> dict[str, Reading]:
    """Return profiles of the spheres and all baselines: points, both together, cubes on runs of their own, shapes."""
    read = readings(simulated, radii, ProfileMethod(radii=radii))
    read[FUSED] = fused([spheres_profiled(simulated, labels_of(simulated), radii), read[POINTS]])
    if counted is not None:
        read[CUBES_READ] = readings(counted, cubes_radii, CUBES)[SPHERES]
    return read


def few_drops(
    simulated: Simulated, radii: tuple[float, ...], counts: Sequence[int], splits: Splits
) -> dict[int, dict[str, float]]:
    """Return the F-measures across sources when only the first so many drops are read, in learning and in asking."""
    labels, across = labels_of(simulated), Splits(halves={}, left_out=splits.left_out)
    classifier, rows = FunctionClassifier(radii=radii), {}
    for count in counts:
        first = [first_drops(settled, count) for settled in simulated.settled]
        rows[count] = f_measures(profiled(first, labels, classifier).evaluation(across).left_out_quality(ACROSS))
    return rows


def over_seeds(
    dataset: Dataset, dropping: Dropping, seeds: int, jobs: int, failed: Callable[[InputError], None]
) -> list[dict[str, float]]:
    """Return the F-measures across sources with each seed of the drops, of which the forests have the same."""
    rows = []
    for seed in range(seeds):
        simulated = simulate_dataset(dataset, replace(dropping, seed=seed), jobs=jobs, failed=failed)
        labels = labels_of(simulated)
        splits = Protocol(groups=True).splits(labels)
        classifier = FunctionClassifier(radii=dropping.radii, random_state=seed)
        evaluation = profiled(simulated.settled, labels, classifier).evaluation(splits)
        rows.append(f_measures(evaluation.left_out_quality(ACROSS)))
    return rows


def print_seeds(rows: Sequence[dict[str, float]], title: str, json: bool):
    """Print the F-measures of each seed, their means and standard deviations."""
    functions = list(rows[0])
    columns = [[row[name] for row in rows] for name in functions]
    summary = [f"{np.mean(column):.3f} ± {np.std(column):.3f}" for column in columns]
    if json:
        print_json({"seeds": rows})
        return
    table = [[str(seed), *(f"{row[name]:.3f}" for name in functions)] for seed, row in enumerate(rows)]
    print_table(title, ["seed", *functions], [*table, ["mean ± std", *summary]])


def milliseconds_each(simulated: Simulated, radii: tuple[float, ...]) -> float:
    """Return the milliseconds that the quantities of one object take, all radii together."""
    classifier = FunctionClassifier(radii=radii)
    classifier.profiles(simulated.settled[:1])
    start = perf_counter()
    classifier.profiles(simulated.settled)
    return 1000 * (perf_counter() - start) / len(simulated.records)


def main(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder with manifest.csv, or a catalogue's name.")],
    radii: Annotated[str | None, typer.Option(help="Sphere radii, all of which count.")] = None,
    first: Annotated[str, typer.Option(help="Also with only the first so many drops at each radius.")] = FIRST,
    train_sizes: Annotated[str, typer.Option(help="Training examples on random halves.")] = "20,45,100",
    trials: Annotated[int, typer.Option(min=1, help="Random equal splits.")] = 10,
    classifiers: Annotated[bool, typer.Option(help="Compare classifiers instead.")] = False,
    cubes: Annotated[bool, typer.Option(help="Also count spheres of full runs in cubes, which takes long.")] = False,
    ranking: Annotated[bool, typer.Option(help="Rank quantities by what they add instead.")] = False,
    seeds: Annotated[int, typer.Option(min=0, help="Repeat the drops and forests with so many seeds instead.")] = 0,
    backend: options.Backend = "fast",
    seed: options.Seed = 0,
    jobs: options.Jobs = -1,
    json: options.Json = False,
):
    """Measure how well functions are classified from resting profiles, across sources and on random halves."""
    failures = Failures()
    dropping = options.dropping(backend, None, radii, seed, "z", "m")
    dataset = open_dataset(data)
    if seeds:
        rows = over_seeds(dataset, dropping, seeds, jobs, failures.add)
        print_seeds(rows, f"{dataset.name}, {backend}: F-measures across sources", json)
        failures.exit()
        return
    simulated = simulate_dataset(dataset, dropping, jobs=jobs, failed=failures.add)
    sizes = tuple(wanted_sizes(train_sizes, len(simulated.objects)))
    splits = Protocol(train_sizes=sizes, trials=trials, seed=seed, groups=True).splits(labels_of(simulated))
    if ranking or classifiers:
        (print_ranking if ranking else print_classifiers)(simulated, dropping.radii, splits, json)
    else:
        how, counted = options.dropping(backend, None, None, seed, "z", "m", CUBES.name), None
        if cubes:
            counted = simulate_dataset(dataset, how, jobs=jobs, failed=failures.add)
        read = all_readings(simulated, dropping.radii, counted, how.radii)
        evaluated = {name: reading.evaluation(splits) for name, reading in read.items()}
        sure = reliability(evaluated[SPHERES].left_out[ACROSS], evaluated[SPHERES].labels)
        counts = few_drops(simulated, dropping.radii, [int(count) for count in first.split(",")], splits)
        print_all(results_of(evaluated), counts, sure, milliseconds_each(simulated, dropping.radii), json)
    failures.exit()


def print_all(
    results: Sequence[Result],
    counts: Mapping[int, dict[str, float]],
    sure: Sequence[Mapping[str, float]],
    milliseconds: float,
    json: bool,
):
    """Print the results, those with few drops, what scores are worth, and the cost, as JSON or as tables."""
    if json:
        cost = round(milliseconds, 2)
        print_json({"results": results, "first": counts, "reliability": sure, "milliseconds_per_object": cost})
        return
    for result in results:
        print_baselines(result)
    functions = ", ".join(next(iter(counts.values())))
    rows = [[str(count), side_by_side(row)] for count, row in counts.items()]
    print_table(f"\nacross sources, F-measure of {functions}", ["drops at each radius", "F"], rows)
    bins = [
        [f"{row['from']:g} to {row['to']:g}", str(row["scores"]), f"{row['said']:.3f}", f"{row['true']:.3f}"]
        for row in sure
    ]
    print_table("\nacross sources, scores of all functions", ["score", "how many", "said", "true"], bins)
    show(f"\nquantities of one object: {milliseconds:.1f} ms")


if __name__ == "__main__":
    run(lambda: typer.run(main))
