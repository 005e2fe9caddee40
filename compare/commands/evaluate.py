"""``spherefunc evaluate``: the paper's protocol on a data set (§IV)."""

from __future__ import annotations

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
from spherefunc_bullet.console import Failures, say
from spherefunc_bullet.quantities import parse_lengths

from ..evaluation.sizes import TRAIN_SIZES, wanted_sizes
from ..evaluation.tables import report


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
    from spherefunc_bullet.batch.simulated import simulate_dataset
    from spherefunc_bullet.datasets.dataset import open_dataset
    from spherefunc_bullet.learning.method import find_method
    from spherefunc_bullet.settling.records import Loading
    from spherefunc_bullet.simulator import make_simulator

    from ..evaluation.evaluation import Options

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
        from ..evaluation.alternatives import print_alternatives

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


def measured(objects, radii, method, options) -> list[dict]:
    """Return the results of the protocols that were asked for."""
    from ..evaluation.evaluation import all_features, labels_of, protocols

    labels = labels_of(objects)
    features, methods = all_features(objects, radii, method)
    return protocols(features, labels, options, methods)


def transfer(learnt, tested, radii, method) -> list[dict]:
    """Return the result of learning on one data set and testing on another."""
    from spherefunc_bullet.batch.simulated import Simulated

    from ..evaluation.evaluation import all_features, evaluate_transfer, labels_of

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
