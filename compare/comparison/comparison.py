"""The comparison: everything that `spherefunc compare` reports, computed from the runs of the simulators."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from spherefunc_bullet.console import say
from spherefunc_bullet.datasets.dataset import Dataset
from spherefunc_bullet.learning.method import AnyMethod, Method, find_method
from spherefunc_bullet.simulator import Simulator, sphere_limit

from ..evaluation.evaluation import Evaluation, trial_again
from ..evaluation.features import SPHERES, distances_again
from ..evaluation.impaired import Shares, impaired_copies, impaired_shares
from ..evaluation.protocol import Labels, Protocol, Split, Splits, labels_of
from ..evaluation.readings import baselines_read, evaluations, shapes_read, spheres_profiled, spheres_read
from ..machine import machine
from ..mechanics.measures import measured, task_reports
from ..mechanics.standing import TaskOptions
from .agreement import agreements
from .entries import ComparedRun, Comparison, Runs, dropped_twice
from .experiment import LABELS, ComparedSimulator, Experiment
from .significance import Report, answer

ALWAYS_NO = "always_no"
ALONE = "leave_one_out"
RADIUS_TRIALS = 3  # of each radius alone, by resting profiles: with all of them that would be half of all learning
Tasks = dict[str, dict[str, Any]]  # by task, see `mechanics.measures.task_reports`
TIMING = (
    "Wall time of the simulation alone, without loading, sampling and compilation, taken when each run was first made "
    "and kept with it, with as many runs at once as there were worker processes. A run from the cache has the time of "
    "the machine that made it."
)


def compare_entries(
    comparison: Comparison, experiment: Experiment, copies: Shares | None = None, tasks: Tasks | None = None
) -> Report:
    """Return the report of a comparison for JSON, with impaired copies and other tasks where these were measured."""
    labels = labels_of(comparison.simulated)
    half = len(labels) // 2
    protocol = Protocol(train_sizes=(half,), trials=experiment.trials, seed=experiment.seeds[0], leave_one_out=True)
    splits = protocol.splits(labels)
    methods = {name: evaluate_features(comparison, labels, find_method(name), splits) for name in experiment.methods}
    features = methods[experiment.methods[0]]
    reports = {name: feature_report(evaluation) for name, evaluation in features.items()}
    backends = {
        entry.name: backend_report(entry, reports.pop(entry.name), features[entry.name].by_radius)
        for entry in comparison.entries
    }
    report = {
        "objects": len(labels),
        "backends": backends,
        "agreement": agreements(comparison, features, backends),
        "baselines": reports,
        "methods": {  # by method and feature
            method: {name: evaluation.quality(half, True) for name, evaluation in by_name.items()}
            for method, by_name in methods.items()
        },
        "data": comparison.simulated.name,
        "functions": dict(zip(labels.functions, labels.members.sum(axis=0).tolist(), strict=True)),  # objects with each
        "train_size": half,
        "test_size": len(labels) - half,
        "left_out": [item.path.name for item in comparison.left_out],
        "objects_again": comparison.repeated,
        "experiment": asdict(experiment),
        "machine": machine(),
        "timing": TIMING,
        "per_object": object_reports(comparison, features),
    }
    report |= {name: value for name, value in (("impaired", copies), ("tasks", tasks)) if value}
    return {"answer": answer(report)} | report


def tasks_of(experiment: Experiment, compared: Sequence[ComparedSimulator], dataset: Dataset) -> Tasks | None:
    """Return the results of the tasks other than labels, with the first shape of each backend; None without tasks."""
    tasks = [name for name in experiment.tasks if name != LABELS]
    if not tasks:
        return None
    simulators: dict[str, Simulator] = {}
    for item in compared:
        simulators.setdefault(item.backend, item.simulator)
    options = TaskOptions(count=experiment.task_objects, loading=experiment.loading)
    return task_reports(measured(dataset.objects, simulators, tasks, None, options))


def feature_report(evaluation: Evaluation) -> dict[str, Any]:
    """Return a feature's quality over trials, and without radius and spread with each object left out."""
    [half], alone = evaluation.trials, evaluation.left_out_quality()
    for row in alone.values():
        del row["radius"], row["f_measure_std"]
    return {"functions": evaluation.quality(half, True), "leave_one_out": alone}


def backend_report(entry: ComparedRun, quality: Report, by_radius: Mapping[float, Evaluation]) -> dict[str, Any]:
    """Return the report of one simulator."""
    memory = [peak for record in (*entry.records, *entry.again.records) for peak in record.memory.values()]
    simulator, runs = entry.candidate.simulator, entry.runs
    report = {
        "settled_share": runs.settled_share,  # of all spheres dropped
        "peak_memory": max(memory, default=None),  # bytes of a whole process, interpreter and libraries included
        "peak_memory_runs": len(memory),  # number of runs for which it is known
        "failed": len(entry.failed),
        "reasons": list(entry.failed),
        "radii": list(entry.radii),  # metres
        "by_radius": [radius_report(radius, runs.alone(radius), by_radius[radius]) for radius in entry.radii],
        "backend": entry.candidate.backend,
        "version": simulator.version,
        "options": simulator.options(),
        "sphere_limit": sphere_limit(simulator),  # settled spheres at which a run ends
    }
    return quality | runs.timing() | report


def radius_report(radius: float, runs: Runs, alone: Evaluation) -> dict[str, Any]:
    """Return the quality and the cost of one radius alone."""
    [functions] = map(alone.quality, alone.trials)
    return {"radius": radius, "functions": functions} | runs.timing() | {"settled_share": runs.settled_share}


def object_reports(comparison: Comparison, features: Mapping[str, Evaluation]) -> list[dict[str, Any]]:
    """Return the figures of each object by every simulator, with all others learnt."""
    figures = {entry.name: entry.object_figures(features[entry.name]) for entry in comparison.entries}
    reports = []
    for index, item in enumerate(comparison.simulated.objects):
        about = {"file": item.path.name, "functions": sorted(item.functions), "also": sorted(item.also)}
        backends = {name: rows[index] for name, rows in figures.items()}
        reports.append(about | {"group": item.group, "backends": backends})
    return reports


def evaluate_features(
    comparison: Comparison, labels: Labels, method: AnyMethod, splits: Splits
) -> dict[str, Evaluation]:
    """Return the evaluation of every simulator and every baseline, all by one method.

    Baselines may choose from the radii of all simulators together. The objects' own points, which are read as resting
    profiles, are a baseline for these only.
    """
    evaluations = {entry.name: evaluate_entry(entry, labels, method, splits) for entry in comparison.entries}
    radii = tuple(sorted(set().union(*(entry.radii for entry in comparison.entries))))
    read = shapes_read if isinstance(method, Method) else baselines_read
    baselines = read(comparison.simulated, radii, method)
    evaluations |= {name: baseline.evaluation(splits) for name, baseline in baselines.items()}
    return evaluations | {ALWAYS_NO: evaluations["bounding_box"].always_negative()}


def shares_of_copies(comparison: Comparison, experiment: Experiment, dataset: Dataset, *, jobs: int) -> Shares:
    """Return the shares of impaired copies that every simulator's spheres and every baseline still classify as useful.

    Kinds of which one of the simulators has no copy, such as points where a shape needs a mesh, are left out of all.
    """
    shares: Shares = {}
    method, entries = find_method(experiment.methods[0]), comparison.entries
    learnt, drop_configs = [entry.simulated for entry in entries], [entry.candidate.drop_config for entry in entries]
    # A copy that cannot be used is not a failure, since it is no mistake of the user.
    how = {"copied": experiment.copied, "jobs": jobs, "failed": lambda error: say(f"{error}; this copy is left out")}
    for entry, impaired in zip(entries, impaired_copies(learnt, dataset, drop_configs, **how), strict=True):
        add_shares(shares, impaired_shares(impaired, entry.candidate, method, baselines=not shares), entry.name)
    names = {entry.name for entry in entries}
    return {
        function: {kind: row for kind, row in kinds.items() if row["share"].keys() >= names}
        for function, kinds in shares.items()
    }


def add_shares(shares: Shares, copies: Shares, name: str):
    """Add the shares of one simulator's spheres, under its name, and of the baselines."""
    for function, kinds in copies.items():
        for kind, row in kinds.items():
            named_shares = {re.sub(f"^{SPHERES}", name, key): value for key, value in row["share"].items()}
            known = shares.setdefault(function, {}).setdefault(kind, row | {"share": {}})
            known["share"] |= named_shares


def evaluate_entry(entry: ComparedRun, labels: Labels, method: AnyMethod, splits: Splits) -> Evaluation:
    """Return the evaluation of one simulator, with each radius alone, and with the second seed's spheres."""
    if not isinstance(method, Method):
        return evaluate_profiles(entry, labels, splits)
    read, twice = spheres_read(entry.simulated, entry.radii, method), dropped_twice(entry)
    evaluation, again = read.evaluation(splits), None
    if twice:
        distances = distances_again(entry.simulated, twice, entry.radii, method)
        again = trial_again(distances, list(twice), evaluation.left_out[ALONE], labels, method)
    by_radius = {
        radius: replace(read, distances={radius: matrix}).evaluation(Splits(halves=splits.halves))
        for radius, matrix in read.distances.items()
    }
    return replace(evaluation, again=again, by_radius=by_radius)


def evaluate_profiles(entry: ComparedRun, labels: Labels, splits: Splits) -> Evaluation:
    """Return the same evaluation of one simulator's drops, read as resting profiles.

    The objects with drops of the second seed follow all objects, and are tested with the same objects learnt.
    """
    count, again = len(labels), dropped_twice(entry)
    rows = np.array([*range(count), *again])
    whole = spheres_profiled(entry.simulated, labels, entry.radii)
    twice = whole.classifier.profiles([record.settled for record in again.values()])
    profiles = np.vstack([whole.profiles, twice])
    both = replace(whole, profiles=profiles, labels=labels.of(rows), checks=whole.checks.of(rows))
    # Each object is tested together with its rows of the second seed.
    one_out = [Split(split.train, np.flatnonzero(np.isin(rows, split.test))) for split in splits.left_out[ALONE]]
    all_splits = Splits(halves=splits.halves, left_out={ALONE: one_out})
    first = Splits(halves={size: trials[:RADIUS_TRIALS] for size, trials in splits.halves.items()})
    alone = [spheres_profiled(entry.simulated, labels, (radius,)) for radius in entry.radii]
    evaluation, *by_radius = evaluations([(both, all_splits), *((features, first) for features in alone)])
    everything = evaluation.left_out[ALONE]
    second = everything.kept(everything.rows >= count)
    return replace(
        evaluation,
        labels=labels,
        left_out={ALONE: everything.kept(everything.rows < count)},
        again=replace(second, rows=rows[second.rows]) if again else None,
        by_radius=dict(zip(entry.radii, by_radius, strict=True)),
    )
