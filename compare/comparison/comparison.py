"""The comparison: everything that `spherefunc compare` reports, computed from what the simulators did."""

from __future__ import annotations

from dataclasses import asdict

from spherefunc_bullet.learning.method import Method, find_method
from spherefunc_bullet.simulator import sphere_limit

from ..evaluation.baselines import Distances, baseline_distances
from ..evaluation.evaluation import labels_of, sphere_distances
from ..evaluation.protocol import Judgement, Labels, Split, always_no, judge, random_splits, trials_measured
from ..machine import machine
from .agreement import agreements
from .costs import costs, object_seconds, settled_share, timing
from .entries import Contest, Entry
from .experiment import Experiment
from .significance import answer

ALWAYS_NO = "always_no"
TIMING = (
    "Wall time of the simulation alone, without loading, sampling and compilation, taken when each run was first made "
    "and kept with it, with as many runs at once as there were worker processes. A run from the cache has the time of "
    "the machine that made it."
)


def compare_entries(contest: Contest, experiment: Experiment) -> dict:
    """Return the report of a contest, ready for JSON."""
    labels = labels_of(contest.entries[0].simulated)
    count = len(labels.members)
    splits = random_splits(count, count // 2, experiment.trials, experiment.seeds[0])
    judged = {name: judge_all(contest, labels, splits, experiment, find_method(name)) for name in experiment.methods}
    method, main = find_method(experiment.methods[0]), judged[experiment.methods[0]]
    names = [each.contestant.name for each in contest.entries]
    report = {
        "objects": count,
        "backends": {each.contestant.name: backend_row(each, main, labels, splits, method) for each in contest.entries},
        "agreement": agreements(contest, main, labels, splits[0], method),
        "baselines": {name: quality_row(each) for name, each in main.items() if name not in names},
        "methods": {
            name: {feature: each.functions for feature, each in every.items()} for name, every in judged.items()
        },
        "data": contest.entries[0].simulated.name,
        "functions": dict(zip(labels.functions, labels.members.sum(axis=0).tolist(), strict=True)),
        "train_size": len(splits[0].train),
        "test_size": len(splits[0].test),
        "left_out": [each.path.name for each in contest.left_out],
        "objects_again": contest.repeated,
        "experiment": asdict(experiment),
        "machine": machine(),
        "timing": TIMING,
    }
    report["per_object"] = [object_row(contest, main, labels, row) for row in range(count)]
    return {"answer": answer(report)} | report


def judge_all(contest: Contest, labels: Labels, splits, experiment: Experiment, method: Method) -> dict[str, Judgement]:
    """Return the judgement of every simulator and every baseline, all by one method."""
    features = {
        each.contestant.name: sphere_distances(each.simulated, each.contestant.radii, method)
        for each in contest.entries
    }
    features |= baselines(contest)
    judged = {name: judge(each, labels, splits, experiment.seeds[0], method) for name, each in features.items()}
    return judged | {ALWAYS_NO: always_no(labels, splits)}


def baselines(contest: Contest) -> dict[str, Distances]:
    """Return the baselines' distances; they may choose from the radii of all simulators together."""
    radii = sorted(set().union(*(each.contestant.radii for each in contest.entries)))
    return baseline_distances(contest.entries[0].simulated.records, radii)


def quality_row(judged: Judgement) -> dict:
    """Return a feature's quality, over trials and with each object left out."""
    return {"functions": judged.functions, "leave_one_out": judged.left_out}


def backend_row(entry: Entry, judged, labels: Labels, splits: list[Split], method: Method) -> dict:
    """Return everything of one simulator."""
    contestant = entry.contestant
    return (
        quality_row(judged[contestant.name])
        | costs(entry)
        | {
            "reasons": list(entry.failed),
            "radii": list(contestant.radii),
            "by_radius": [radius_row(entry, radius, labels, splits, method) for radius in contestant.radii],
            "backend": contestant.backend,
            "version": contestant.simulator.version,
            "options": contestant.simulator.options(),
            "sphere_limit": sphere_limit(contestant.simulator),  # settled spheres at which a run ends
        }
    )


def radius_row(entry: Entry, radius: float, labels: Labels, splits: list[Split], method: Method) -> dict:
    """Return what one radius alone gives and costs."""
    distances = sphere_distances(entry.simulated, [radius], method)
    functions = trials_measured(distances, labels, splits, method)
    share = {"settled_share": settled_share(entry.simulated.records, [radius])}
    return {"radius": radius, "functions": functions} | timing(entry.simulated.records, [radius]) | share


def object_row(contest: Contest, judged: dict[str, Judgement], labels: Labels, row: int) -> dict:
    """Return what every simulator made of one object, with all others learnt."""
    item = contest.objects[row]
    return {
        "file": item.path.name,
        "functions": sorted(item.functions),
        "also": sorted(item.also),
        "group": item.group,
        "backends": {
            each.contestant.name: object_figures(each, judged[each.contestant.name], labels, row)
            for each in contest.entries
        },
    }


def object_figures(entry: Entry, judged: Judgement, labels: Labels, row: int) -> dict:
    """Return one object's seconds, drops, settled spheres and scores by one simulator."""
    record, radii = entry.simulated.records[row], entry.contestant.radii
    return {
        "seconds": round(object_seconds(record, radii), 6),
        "drops": sum(record.drops[radius] for radius in radii),
        "settled": sum(len(record.settled[radius]) for radius in radii),
        "scores": {
            name: round(float(score), 4) for name, score in zip(labels.functions, judged.scores[row], strict=True)
        },
    }
