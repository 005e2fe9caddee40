"""``spherefunc evaluate``: the paper's protocol on a data set (§IV)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import typer

from spherefunc_bullet.commands.options import (
    DEFAULT_RADII,
    Backend,
    Jobs,
    Json,
    Method,
    Radii,
    RunDir,
    Seed,
    Shape,
    Units,
    Up,
    simulator_options,
)
from spherefunc_bullet.console import Failures, print_json, print_table, say
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.lengths import format_length, parse_lengths

TRAIN_SIZES = "20,45,85,half"


@dataclass(frozen=True)
class Options:
    """Which experiments to run."""

    train_sizes: list[int]
    trials: int
    seed: int
    leave_one_out: bool
    groups: bool


def evaluate(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder with manifest.csv, or a catalogue's name.")],
    test: Annotated[str | None, typer.Option(help="Learn on all of DATA and test on this data set.")] = None,
    trials: Annotated[int, typer.Option(min=1, help="Random equal splits.")] = 10,
    train_sizes: Annotated[str, typer.Option(help="Training examples, such as 20,45,half.")] = TRAIN_SIZES,
    leave_one_out: Annotated[bool, typer.Option("--leave-one-out", help="Also test each object on the rest.")] = False,
    groups: Annotated[bool, typer.Option("--groups", help="Also test each source on all others.")] = False,
    alternatives: Annotated[bool, typer.Option(help="Compare what the paper leaves open instead.")] = False,
    backend: Backend = "fast",
    shape: Shape = None,
    method: Method = "default",
    radii: Radii = DEFAULT_RADII,
    seed: Seed = 0,
    up: Up = "z",
    units: Units = "m",
    jobs: Jobs = -1,
    run: RunDir = None,
    json: Json = False,
):
    """Measure how well functions are told, beside baselines that need no spheres."""
    from spherefunc_bullet.dataset import open_dataset
    from spherefunc_bullet.method import find_method
    from spherefunc_bullet.simulation import Loading
    from spherefunc_bullet.simulator import make_simulator
    from spherefunc_bullet.training import simulate_dataset

    failures = Failures()
    lengths, chosen = parse_lengths(radii), find_method(method)
    simulator = make_simulator(backend, **simulator_options(shape))

    def simulated(name):
        """Return a data set by name, simulated."""
        loading = Loading(up=up, units=units)
        dataset = open_dataset(name)
        return simulate_dataset(
            dataset, simulator, lengths, seed=seed, loading=loading, jobs=jobs, run=run, failed=failures.add
        )

    objects = simulated(data)
    if alternatives:
        from .alternatives import print_alternatives

        print_alternatives(objects, lengths, trials, seed, json)
        failures.exit()
        return
    if test is not None:
        results, count = transfer(objects, simulated(test), lengths, chosen), len(objects.objects)
    else:
        sizes = wanted_sizes(train_sizes, len(objects.objects))
        options = Options(sizes, trials, seed, leave_one_out, groups)
        results, count = measured(objects, lengths, chosen, options), len(objects.objects)
    about = {"backend": backend, "method": chosen.name, "data": objects.name, "objects": count, "radii": lengths}
    report(about, results, json)
    failures.exit()


def measured(objects, radii, method, options: Options) -> list[dict]:
    """Return the results of the protocols that were asked for."""
    from .evaluation import all_features, labels_of, protocols

    labels = labels_of(objects)
    features, methods = all_features(objects, radii, method)
    return protocols(features, labels, options, methods)


def transfer(learnt, tested, radii, method) -> list[dict]:
    """Return the result of learning on one data set and testing on another."""
    from spherefunc_bullet.training import Simulated

    from .evaluation import all_features, evaluate_transfer, labels_of

    unknown = set().union(*(each.functions for each in tested.objects)) - labels_of_names(learnt)
    if unknown:
        say(f"{tested.name}: no training object is labelled {', '.join(sorted(unknown))}; those can't be found")
    both = Simulated(learnt.name, learnt.objects + tested.objects, learnt.records + tested.records)
    labels_of(learnt)  # refuses a training set of one label only
    features, methods = all_features(both, radii, method)
    return [evaluate_transfer(features, labels_of(both), len(learnt.objects), methods)]


def labels_of_names(simulated) -> set[str]:
    """Return the functions that a data set's objects have."""
    return set().union(*(each.functions for each in simulated.objects))


def wanted_sizes(text: str, count: int) -> list[int]:
    """Return the training sizes; those of the default list that are too large for the data are left out.

    Raises
    ------
    InputError
        If a size is no number, or one that was asked for is larger than half of the objects.
    """
    half = count // 2
    try:
        sizes = sorted({half if part.strip() == "half" else int(part) for part in text.split(",")})
    except ValueError:
        raise InputError(f"--train-sizes {text}: expected numbers and half, such as {TRAIN_SIZES}") from None
    if text == TRAIN_SIZES:
        sizes = [size for size in sizes if size <= half]
    if not sizes or sizes[0] < 2 or sizes[-1] > half:
        raise InputError(f"--train-sizes {text}: expected from 2 to {half}, half of the {count} objects")
    return sizes


def report(about: dict, results: list[dict], json: bool):
    """Print the results as JSON or as tables."""
    last_split = [each for each in results if each["protocol"] in ("random_splits", "test")][-1]
    if json:
        print_json(about | {"results": results, "baselines": last_split["baselines"]})
        return
    print_table(
        f"{about['data']}, {about['objects']} objects, backend {about['backend']}, method {about['method']}",
        ["protocol", "train", "function", "F", "spread", "F fair", "precision", "recall", "accuracy", "radius"],
        [row for each in results for row in result_rows(each)],
    )
    for each in results if len(results) < 3 else [last_split, *pooled(results)]:
        print_baselines(each)


def pooled(results: list[dict]) -> list[dict]:
    """Return the results in which every object was tested once."""
    return [each for each in results if each["protocol"].startswith("leave")]


def result_rows(each: dict) -> list[list[str]]:
    """Return one result's table rows, a function each."""
    rows = []
    for name, row in each["functions"].items():
        spread = "" if row["f_measure_std"] is None else f"{row['f_measure_std']:.3f}"
        figures = [f"{row[key]:.3f}" for key in ("f_measure_fair", "precision", "recall", "accuracy")]
        start = [each["protocol"].replace("_", " "), str(each["train_size"]), name, f"{row['f_measure']:.3f}", spread]
        rows.append([*start, *figures, format_length(row["radius"])])
    return rows


def print_baselines(each: dict):
    """Print the spheres beside the baselines of one result."""
    table = {"spheres": each["functions"]} | each["baselines"]
    rows = [
        [name.replace("_", " "), *(f"{f['f_measure']:.3f} ({f['f_measure_fair']:.3f})" for f in scores.values())]
        for name, scores in table.items()
    ]
    title = f"\n{each['protocol'].replace('_', ' ')}, {each['train_size']} training objects: F-measure (fair)"
    print_table(title, ["features", *each["functions"]], rows)
