"""What every simulator's spheres and every baseline say of the objects of a comparison, by one method."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from spherefunc_bullet.console import say
from spherefunc_bullet.datasets.dataset import Dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.method import AnyMethod, Method, find_method

from ..evaluation.evaluation import Evaluation, trial_again
from ..evaluation.features import SPHERES, distances_again
from ..evaluation.impaired import Shares, impaired_copies, impaired_shares
from ..evaluation.protocol import Labels, Split, Splits
from ..evaluation.readings import baselines_read, evaluations, shapes_read, spheres_profiled, spheres_read
from .entries import ComparedRun, Comparison, dropped_twice
from .experiment import Experiment

ALWAYS_NO = "always_no"
ALONE = "leave_one_out"
RADIUS_TRIALS = 3  # of each radius alone, by resting profiles: with all of them that would be half of all learning


def evaluate_features(
    comparison: Comparison, labels: Labels, method: AnyMethod, splits: Splits
) -> dict[str, Evaluation]:
    """Return the evaluation of every simulator and every baseline, all by one method.

    Baselines may choose from the radii of all simulators together. Points are read as resting profiles are, and asked
    beside these alone.
    """
    evaluations = {entry.name: evaluate_entry(entry, labels, method, splits) for entry in comparison.entries}
    radii = tuple(sorted(set().union(*(entry.radii for entry in comparison.entries))))
    read = shapes_read if isinstance(method, Method) else baselines_read
    baselines = read(comparison.simulated, radii, method)
    evaluations |= {name: baseline.evaluation(splits) for name, baseline in baselines.items()}
    return evaluations | {ALWAYS_NO: evaluations["bounding_box"].always_negative()}


def shares_of_copies(comparison: Comparison, experiment: Experiment, dataset: Dataset, *, jobs: int) -> Shares:
    """Return the shares of impaired copies that every simulator's spheres and every baseline still call useful.

    Kinds that one of the simulators has no copy of, such as points where a shape needs a mesh, are left out of all.
    """
    shares: Shares = {}
    method, entries = find_method(experiment.methods[0]), comparison.entries
    learnt, drop_configs = [entry.simulated for entry in entries], [entry.candidate for entry in entries]
    how = {"copied": experiment.copied, "jobs": jobs, "failed": say_left_out}
    for entry, impaired in zip(entries, impaired_copies(learnt, dataset, drop_configs, **how), strict=True):
        add_shares(shares, impaired_shares(impaired, entry.candidate, method, baselines=not shares), entry.name)
    names = {entry.name for entry in entries}
    return {
        function: {kind: row for kind, row in kinds.items() if row["share"].keys() >= names}
        for function, kinds in shares.items()
    }


def say_left_out(error: InputError):
    """Say why a copy is left out; nobody's file is at fault."""
    say(f"{error}; this copy is left out")


def add_shares(shares: Shares, copies: Shares, name: str):
    """Add what one simulator's spheres say of copies, under its name, and of baselines what there is."""
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
    """Return the same of one simulator's drops, read as resting profiles.

    What fell with the second seed is asked about behind all objects, each by who has learnt all others.
    """
    count, again = len(labels), dropped_twice(entry)
    rows = np.array([*range(count), *again])
    whole = spheres_profiled(entry.simulated, labels, entry.radii)
    twice = whole.classifier.profiles([record.settled for record in again.values()])
    both = replace(
        whole, profiles=np.vstack([whole.profiles, twice]), labels=labels.of(rows), checks=whole.checks.of(rows)
    )
    all_splits = Splits(halves=splits.halves, left_out={ALONE: repeated_evaluation(splits.left_out[ALONE], rows)})
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


def repeated_evaluation(splits: Sequence[Split], rows: np.ndarray) -> list[Split]:
    """Return splits that test, with each object, the rows (R,) behind all objects that are it once more."""
    return [Split(split.train, np.flatnonzero(np.isin(rows, split.test))) for split in splits]
