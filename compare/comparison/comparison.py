"""The comparison: everything that `spherefunc compare` reports, computed from what the simulators did."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from spherefunc_bullet.datasets.dataset import Dataset
from spherefunc_bullet.learning.method import find_method
from spherefunc_bullet.simulator import sphere_limit

from ..evaluation.evaluation import Evaluation
from ..evaluation.impaired import Shares
from ..evaluation.protocol import Protocol, labels_of
from ..machine import machine
from ..mechanics.measures import measured, task_reports
from .agreement import agreements
from .entries import ComparedRun, Comparison, Runs
from .evaluations import evaluate_features
from .experiment import LABELS, ComparedSimulator, Experiment
from .significance import Report, answer

Tasks = dict[str, dict[str, Any]]  # by task, see `mechanics.measures.task_reports`
TIMING = (
    "Wall time of the simulation alone, without loading, sampling and compilation, taken when each run was first made "
    "and kept with it, with as many runs at once as there were worker processes. A run from the cache has the time of "
    "the machine that made it."
)


def compare_entries(
    comparison: Comparison, experiment: Experiment, copies: Shares | None = None, tasks: Tasks | None = None
) -> Report:
    """Return the report of a comparison, ready for JSON; with impaired copies and other tasks where they were asked."""
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
    if copies:
        report["impaired"] = copies
    if tasks:
        report["tasks"] = tasks
    return {"answer": answer(report)} | report


def tasks_of(experiment: Experiment, compared: Sequence[ComparedSimulator], dataset: Dataset) -> Tasks | None:
    """Return what backends do of the tasks besides labels; None where none is asked. Shapes do not matter to them."""
    tasks = [name for name in experiment.tasks if name != LABELS]
    if not tasks:
        return None
    simulators = {item.backend: item.simulator for item in reversed(compared)}
    simulators = {item.backend: simulators[item.backend] for item in compared}
    return task_reports(measured(dataset.objects, simulators, tasks, experiment.task_objects, None, experiment.loading))


def feature_report(evaluation: Evaluation) -> dict[str, Any]:
    """Return a feature's quality, over trials and with each object left out: there, no radius and no spread."""
    [half] = evaluation.trials
    alone = {
        name: {key: value for key, value in row.items() if key not in ("radius", "f_measure_std")}
        for name, row in evaluation.left_out_quality().items()
    }
    return {"functions": evaluation.quality(half, True), "leave_one_out": alone}


def backend_report(entry: ComparedRun, quality: Report, by_radius: Mapping[float, Evaluation]) -> dict[str, Any]:
    """Return everything of one simulator."""
    memory = [bytes_ for record in (*entry.records, *entry.again.records) for bytes_ in record.memory.values()]
    simulator = entry.candidate.simulator
    report = {
        "settled_share": entry.runs.settled_share,  # of all spheres dropped
        "peak_memory": max(memory, default=None),  # bytes of a whole process, interpreter and libraries included
        "peak_memory_runs": len(memory),  # of how many runs it is known: those of an older cache lack it
        "failed": len(entry.failed),
        "reasons": list(entry.failed),
        "radii": list(entry.radii),  # metres
        "by_radius": [radius_report(radius, entry.runs.alone(radius), by_radius[radius]) for radius in entry.radii],
        "backend": entry.candidate.backend,
        "version": simulator.version,
        "options": simulator.options(),
        "sphere_limit": sphere_limit(simulator),  # settled spheres at which a run ends
    }
    return quality | entry.runs.timing() | report


def radius_report(radius: float, runs: Runs, alone: Evaluation) -> dict[str, Any]:
    """Return what one radius alone gives and costs."""
    [functions] = map(alone.quality, alone.trials)
    return {"radius": radius, "functions": functions} | runs.timing() | {"settled_share": runs.settled_share}


def object_reports(comparison: Comparison, features: Mapping[str, Evaluation]) -> list[dict[str, Any]]:
    """Return what every simulator made of each object, with all others learnt."""
    figures = {entry.name: entry.object_figures(features[entry.name]) for entry in comparison.entries}
    return [
        {
            "file": item.path.name,
            "functions": sorted(item.functions),
            "also": sorted(item.also),
            "group": item.group,
            "backends": {name: rows[index] for name, rows in figures.items()},
        }
        for index, item in enumerate(comparison.simulated.objects)
    ]
