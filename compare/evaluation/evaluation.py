"""`spherefunc evaluate`: sphere features and baselines through the paper's protocol, in one report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from sklearn.metrics.pairwise import euclidean_distances

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import memberships
from spherefunc_bullet.learning.method import Method

from .baselines import Distances, baseline_distances
from .protocol import (
    Labels,
    Split,
    leave_one_group_out,
    leave_one_out,
    pooled_measured,
    random_splits,
    trials_measured,
)


def sphere_distances(simulated: Simulated, radii: Sequence[float], method: Method) -> Distances:
    """Return the distances between all objects' sphere histograms at each radius."""
    return {
        radius: euclidean_distances(
            method.histogram(radius).fit_transform([each[radius] for each in simulated.settled])
        )
        for radius in radii
    }


def labels_of(simulated: Simulated) -> Labels:
    """Return what is true of a data set's objects.

    Raises
    ------
    InputError
        If all objects have the same label, so that there is nothing to tell apart.
    """
    functions = tuple(sorted(set().union(*(each.functions for each in simulated.objects))))
    members = memberships([each.functions for each in simulated.objects], functions)
    if not functions or len(np.unique(members, axis=0)) < 2:
        raise InputError(f"{simulated.name}: expected objects of at least two labels, got one only")
    also = memberships([each.also - each.functions for each in simulated.objects], functions)
    return Labels(functions, members, also, np.array([each.group for each in simulated.objects]))


def evaluate_splits(features: dict[str, Distances], labels, train_sizes, trials, seed, methods) -> list[dict]:
    """Return one result per training size: the paper's equal splits (§IV-B)."""
    count = len(labels.members)
    results = []
    for size in train_sizes:
        splits = random_splits(count, size, trials, seed)
        measured = {
            name: trials_measured(distances, labels, splits, methods[name]) for name, distances in features.items()
        }
        results.append(result("random_splits", size, measured) | {"trials": trials})
    return results


def evaluate_pooled(features: dict[str, Distances], labels, protocol, splits, methods) -> dict:
    """Return the result of a protocol that tests every object once."""
    measured = {
        name: pooled_measured(distances, labels, splits, methods[name]) for name, distances in features.items()
    }
    train_size = round(float(np.mean([len(split.train) for split in splits])))
    return result(protocol, train_size, measured)


def evaluate_transfer(features, labels, train_count: int, methods) -> dict:
    """Return the result of learning on the first ``train_count`` objects and testing on all others."""
    split = Split(np.arange(train_count), np.arange(train_count, len(labels.members)))
    measured = {
        name: trials_measured(distances, labels, [split], methods[name]) for name, distances in features.items()
    }
    return result("test", train_count, measured)


def result(protocol: str, train_size: int, measured: dict[str, dict]) -> dict:
    """Return one entry of the report's ``results``: the spheres' figures, and the baselines' beside them."""
    baselines = {name: functions for name, functions in measured.items() if name != "spheres"}
    return {
        "protocol": protocol,
        "train_size": train_size,
        "functions": measured["spheres"],
        "baselines": baselines,
    }


def all_features(simulated: Simulated, radii, method: Method) -> tuple[dict[str, Distances], dict[str, Method]]:
    """Return the distances of the spheres and of every baseline, and the method that scores each.

    Baselines are scored with the same neighbours, votes and choice of radius as the spheres.
    """
    spheres = {"spheres": sphere_distances(simulated, radii, method)}
    features = spheres | baseline_distances(simulated.records, radii)
    return features, dict.fromkeys(features, method)


def protocols(features, labels, options, methods) -> list[dict]:
    """Return the results of all protocols that were asked for."""
    results = evaluate_splits(features, labels, options.train_sizes, options.trials, options.seed, methods)
    if options.leave_one_out:
        splits = leave_one_out(len(labels.members), options.seed)
        results.append(evaluate_pooled(features, labels, "leave_one_out", splits, methods))
    if options.groups:
        splits = leave_one_group_out(labels.groups)
        results.append(evaluate_pooled(features, labels, "leave_one_group_out", splits, methods))
    return results


@dataclass(frozen=True)
class Options:
    """Which experiments to run."""

    train_sizes: list[int]
    trials: int
    seed: int
    leave_one_out: bool
    groups: bool
