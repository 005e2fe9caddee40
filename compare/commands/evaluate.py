"""``spherefunc evaluate``: the paper's protocol on a data set (§IV)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, say
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.files import prepare_folder, require_place

from ..evaluation import TRAIN_SIZES

if TYPE_CHECKING:
    from spherefunc_bullet.batch.simulated import Simulated
    from spherefunc_bullet.datasets.dataset import Dataset


def evaluate(
    data: Annotated[
        list[str],
        typer.Argument(metavar="DATA...", help="Folders with manifest.csv, or catalogues; several with --test."),
    ],
    test: Annotated[str | None, typer.Option(help="Train on all of DATA and test on this data set.")] = None,
    trials: Annotated[int | None, typer.Option(min=1, help="Number of random equal splits. Default: 10.")] = None,
    train_sizes: Annotated[
        str | None, typer.Option(help=f"Numbers of training examples. Default: {TRAIN_SIZES}.")
    ] = None,
    leave_one_out: Annotated[bool, typer.Option("--leave-one-out", help="Also test each object on the rest.")] = False,
    groups: Annotated[bool, typer.Option("--groups", help="Also test each source on all others.")] = False,
    impaired: Annotated[
        bool, typer.Option("--impaired", help="Also test impaired copies: objects that look right and do not work.")
    ] = False,
    corruptions: Annotated[
        bool, typer.Option("--corruptions", help="Also test clouds as sensors give them: noise, few points, one view.")
    ] = False,
    copied: Annotated[
        int | None, typer.Option(min=1, help="With --impaired, --corruptions: objects per function. Default: all.")
    ] = None,
    confusion: Annotated[
        bool, typer.Option("--confusion", help="Also print the confusion matrix and the chosen radii (JSON has them).")
    ] = False,
    picture: Annotated[
        Path | None, typer.Option(help="With --impaired or --corruptions: draw it as .png or .svg.")
    ] = None,
    tasks: Annotated[str, typer.Option(help="Tasks: labels, and also poses, standing, keeping, places.")] = "labels",
    task_objects: Annotated[
        int | None, typer.Option(min=1, help="Maximum number of objects of each task but labels. Default: 100.")
    ] = None,
    backend: options.Backend = "fast",
    shape: options.Shape = None,
    method: options.Method = options.DEFAULT_METHOD,
    radii: options.Radii = None,
    seed: options.Seed = 0,
    miss_limit: options.MissLimit = None,
    up: options.Up = options.BY_FILE,
    units: options.Units = "m",
    jobs: options.Jobs = -1,
    run: options.RunDir = None,
    json: options.Json = False,
):
    """Measure the accuracy of classification, and of baselines that need no spheres."""
    from spherefunc_bullet.batch.simulated import simulate_dataset
    from spherefunc_bullet.datasets.agreement import require_agreement
    from spherefunc_bullet.datasets.dataset import joined_datasets, open_dataset
    from spherefunc_bullet.learning.method import find_method

    from ..comparison.experiment import LABELS
    from ..evaluation.impaired import impaired_copies, impaired_shares
    from ..evaluation.protocol import Protocol, labels_of, repeated_objects, wanted_sizes
    from ..evaluation.robustness.corruptions import corruption_rates
    from ..evaluation.tables import evaluate_features, print_results, results_of, transfer_result
    from ..figures.impaired_picture import draw_corruptions, draw_impaired
    from ..mechanics.measures import TaskOptions, measured, task_reports
    from .compare import parse_tasks
    from .mechanics import print_measured

    splits = {"--leave-one-out": leave_one_out or None, "--groups": groups or None, "--trials": trials}
    options.require_beside("--test", test is not None, splits | {"--train-sizes": train_sizes}, {})
    options.require_beside("--impaired or --corruptions", impaired or corruptions, {}, {"--copied": copied})
    require_sensible(data, test, impaired, corruptions, picture)
    failures, dataset = Failures(), joined_datasets([open_dataset(name) for name in data])
    other = None if test is None else open_dataset(test)
    task_names, chosen = parse_tasks(tasks), find_method(method)
    others, train_sizes = [name for name in task_names if name != LABELS], train_sizes or TRAIN_SIZES
    options.require_beside("--tasks other than labels", bool(others), {}, {"--task-objects": task_objects})
    drop_config = options.drop_config(backend, shape, radii, seed, up, units, method, miss_limit)

    def simulated(some: Dataset) -> Simulated:
        """Return the runs on a data set."""
        return simulate_dataset(some, drop_config, jobs=jobs, run=run, failed=failures.add)

    lengths, labels = drop_config.radii, labels_of(dataset)
    protocol = Protocol(trials=trials or 10, seed=seed, leave_one_out=leave_one_out, groups=groups)
    if other is None:  # what cannot be evaluated is refused before spheres fall, which may take hours
        replace(protocol, train_sizes=tuple(wanted_sizes(train_sizes, len(labels)))).splits(labels)
    require_agreement(dataset)
    learnt = simulated(dataset)
    tested = None if other is None else simulated(other)
    if repeated := repeated_objects(learnt, tested or learnt):
        say(f"spherefunc: {repeated}")
    if tested is not None:
        results = [transfer_result(learnt, tested, lengths, chosen)]
    else:
        protocol = replace(protocol, train_sizes=tuple(wanted_sizes(train_sizes, len(learnt.objects))))
        results = results_of(evaluate_features(learnt, lengths, chosen, protocol))
    about = dict(backend=backend, method=chosen.name, data=learnt.name, objects=len(learnt.objects), radii=lengths)
    shares, rates, how = None, None, {"copied": copied, "jobs": jobs, "failed": failures.add}
    if impaired:
        [copies] = impaired_copies([learnt], dataset, [drop_config], **how)
        shares = impaired_shares(copies, drop_config, chosen, unseen_kinds=True)
    if corruptions:
        rates = corruption_rates(learnt, tested, drop_config, chosen, **how)
    if picture is not None:
        draw_impaired(shares, picture) if impaired else draw_corruptions(rates, picture)
    mechanics, asked = None, TaskOptions(count=task_objects or 100, loading=drop_config.loading, failed=failures.add)
    if others:
        mechanics = measured(dataset.objects, {backend: drop_config.simulator}, others, None, asked)
    print_results(about, results, json, shares, confusion, mechanics and task_reports(mechanics), rates)
    if mechanics and not json:
        print_measured(mechanics)
    failures.exit()


def require_sensible(data: list[str], test: str | None, impaired: bool, corruptions: bool, picture: Path | None):
    """Raise InputError for incompatible options, before the simulation, which may take hours."""
    from ..figures.impaired_picture import require_ending

    if picture is not None and impaired == corruptions:
        raise InputError(f"--picture {picture}: expected with --impaired or --corruptions, one of which it shows")
    if picture is not None:
        require_ending(picture)
        prepare_folder(picture.parent)
        require_place(picture)
    if len(data) > 1 and test is None:
        raise InputError(f"{' '.join(data)}: expected one data set, or --test with one that is not learnt")
