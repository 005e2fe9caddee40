"""The paper's experiments (§IV) on distances between objects: which train, which test, and how well.

Distances between histograms do not depend on which objects train, so each feature's are computed once, and a
trial only chooses rows and columns.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.method import Method
from spherefunc_bullet.learning.validation import THRESHOLD, quality, radius_weights, voted_scores

from .baselines import Distances

FOLDS = 20  # of leave-one-out, for the choice of the radius
PAPER = {"cup": 0.80, "sittable": 0.74, "table": 0.85}  # F-measures on its authors' own 200 models


@dataclass(frozen=True)
class Labels:
    """What is true of the objects."""

    functions: tuple[str, ...]
    members: np.ndarray  # (N, F) bool, the primary function
    also: np.ndarray  # (N, F) bool, true as well, so not counted in the fair score
    groups: np.ndarray  # (N,) str, the sources


@dataclass(frozen=True)
class Split:
    """One trial: rows that train, rows that are tested."""

    train: np.ndarray
    test: np.ndarray


def random_splits(count: int, train_size: int, trials: int, seed: int) -> list[Split]:
    """Return the paper's trials: half of the objects at random, of which the first ``train_size`` train.

    The same seed gives the same halves whatever the training size, so that sizes can be compared.

    Raises
    ------
    InputError
        If the half is smaller than the training set.
    """
    half = count // 2
    if not 0 < train_size <= half:
        raise InputError(f"training size {train_size}: expected at most {half}, half of the {count} objects")
    orders = [np.random.default_rng([seed, trial]).permutation(count) for trial in range(trials)]
    return [Split(order[:train_size], order[half:]) for order in orders]


def leave_one_out(count: int, seed: int) -> list[Split]:
    """Return splits that leave out one object each, grouped in folds by `trial_scores`."""
    order = np.random.default_rng([seed, count]).permutation(count)
    return [Split(np.delete(np.arange(count), i), np.array([i])) for i in order]


def leave_one_group_out(groups: np.ndarray) -> list[Split]:
    """Return splits that leave out all objects of one source each.

    Raises
    ------
    InputError
        If there are not at least two sources.
    """
    names = sorted(set(groups.tolist()))
    if len(names) < 2:
        raise InputError("--groups: expected a manifest with a column group that names at least two sources")
    return [Split(np.flatnonzero(groups != name), np.flatnonzero(groups == name)) for name in names]


def split_scores(distances: Distances, labels: Labels, split: Split, method: Method, weights=None):
    """Return the scores (T, F) of a split's test objects, and each function's radius weights."""
    across = {radius: matrix[np.ix_(split.test, split.train)] for radius, matrix in distances.items()}
    if weights is None:
        inside = {radius: matrix[np.ix_(split.train, split.train)] for radius, matrix in distances.items()}
        weights = [radius_weights(inside, members, method) for members in labels.members[split.train].T]
    columns = [
        voted_scores(across, members, chosen, method)
        for members, chosen in zip(labels.members[split.train].T, weights, strict=True)
    ]
    return np.stack(columns, axis=1), weights


def pooled_scores(distances: Distances, labels: Labels, splits: Sequence[Split], method: Method):
    """Return the scores (N, F) of all objects, each tested once, and each split's weights.

    Where splits leave out one object each, the radius is chosen once for every twentieth of them, without all
    objects of that twentieth: never with the help of a tested object, at a twentieth of the cost.
    """
    scores = np.zeros(labels.members.shape)
    chosen = []
    for fold in np.array_split(np.arange(len(splits)), min(FOLDS, len(splits))):
        weights = None
        if len(fold) > 1:
            train = np.setdiff1d(np.arange(len(scores)), np.concatenate([splits[i].test for i in fold]))
            weights = split_scores(distances, labels, Split(train, splits[fold[0]].test), method)[1]
        for i in fold:
            scores[splits[i].test], weights_used = split_scores(distances, labels, splits[i], method, weights)
            chosen.append(weights_used)
    return scores, chosen


@dataclass(frozen=True, eq=False)
class Run:
    """What came of one trial."""

    scores: np.ndarray  # (T, F) of the objects that were tested
    weights: list[dict[float, float]]  # of each function: radius in metres -> how much it counts
    test: np.ndarray  # (T,) int, which objects those were


def trial_runs(distances: Distances, labels: Labels, splits: Sequence[Split], method: Method) -> list[Run]:
    """Return what came of each trial."""
    return [Run(*split_scores(distances, labels, split, method), split.test) for split in splits]


def runs_measured(runs: Sequence[Run], labels: Labels) -> dict:
    """Return each function's mean quality over runs, with spread and the radius chosen most often."""
    return {name: _summary(runs, labels, column) for column, name in enumerate(labels.functions)}


def trials_measured(distances: Distances, labels: Labels, splits: Sequence[Split], method: Method) -> dict:
    """Return each function's mean quality over trials, with spread and the radius chosen most often."""
    return runs_measured(trial_runs(distances, labels, splits, method), labels)


def pooled_measured(distances: Distances, labels: Labels, splits: Sequence[Split], method: Method) -> dict:
    """Return each function's quality with every object tested once and all counted together."""
    scores, chosen = pooled_scores(distances, labels, splits, method)
    everything = np.arange(len(scores))
    measured = {}
    for column, name in enumerate(labels.functions):
        row = _summary([Run(scores, chosen[0], everything)], labels, column)
        row["radius"] = _most_common(weights[column] for weights in chosen)
        measured[name] = row
    return measured


def _summary(runs: Sequence[Run], labels: Labels, column: int) -> dict:
    strict, fair = [], []
    for run in runs:
        predicted = run.scores[:, column] > THRESHOLD
        members = labels.members[run.test, column]
        strict.append(quality(members, predicted))
        fair.append(quality(members, predicted, ~labels.also[run.test, column]).f_measure)
    return {
        "f_measure": _mean(each.f_measure for each in strict),
        # One run has no spread.
        "f_measure_std": round(float(np.std([each.f_measure for each in strict])), 4) if len(strict) > 1 else None,
        "f_measure_fair": _mean(fair),
        "precision": _mean(each.precision for each in strict),
        "recall": _mean(each.recall for each in strict),
        "accuracy": _mean(each.accuracy for each in strict),
        "radius": _most_common(run.weights[column] for run in runs),
    }


def _mean(values) -> float:
    return round(float(np.mean(list(values))), 4)


def _most_common(weights: Iterator[dict[float, float]]) -> float:
    """Return the radius that most trials gave the largest weight."""
    return Counter(max(each, key=each.get) for each in weights).most_common(1)[0][0]


@dataclass(frozen=True, kw_only=True, eq=False)
class Judgement:
    """What was said of objects that were not learnt."""

    functions: dict[str, dict]  # quality over trials, as `spherefunc evaluate` has it, with every trial's F-measure
    left_out: dict[str, dict]  # quality with every object left out once
    scores: np.ndarray  # (N, F) with all other objects learnt
    weights: list  # per object, its radius weights for each function

    @property
    def predicted(self) -> np.ndarray:
        """Which object was said to have which function, (N, F) bool."""
        return self.scores > THRESHOLD


def judge(distances: Distances, labels: Labels, splits: Sequence[Split], seed: int, method: Method) -> Judgement:
    """Judge one feature."""
    count = len(labels.members)
    runs = trial_runs(distances, labels, splits, method)
    order = leave_one_out(count, seed)
    scores, chosen = pooled_scores(distances, labels, order, method)
    weights = {int(split.test[0]): each for split, each in zip(order, chosen, strict=True)}
    return judgement(runs, labels, scores, [weights[i] for i in range(count)])


def always_no(labels: Labels, splits: Sequence[Split]) -> Judgement:
    """Return the judgement of a classifier that says no to everything: what an accuracy is worth."""
    functions = len(labels.functions)
    nothing = [{np.nan: 1.0}] * functions
    runs = [Run(np.zeros((len(split.test), functions)), nothing, split.test) for split in splits]
    return judgement(runs, labels, np.zeros(labels.members.shape), [nothing] * len(labels.members))


def judgement(runs: Sequence[Run], labels: Labels, scores: np.ndarray, weights: list) -> Judgement:
    """Return the judgement from trials and from scores (N, F) of left-out objects."""
    functions = runs_measured(runs, labels)
    left_out = runs_measured([Run(scores, weights[0], np.arange(len(scores)))], labels)
    for column, name in enumerate(labels.functions):
        functions[name]["f_measures"] = [round(f_measure(run, labels, column), 4) for run in runs]
        # The radius is chosen by trials; a spread over one round there is none.
        left_out[name] = {key: left_out[name][key] for key in left_out[name] if key not in ("radius", "f_measure_std")}
        if not np.isfinite(functions[name]["radius"]):
            functions[name]["radius"] = None
    return Judgement(functions=functions, left_out=left_out, scores=scores, weights=weights)


def f_measure(run: Run, labels: Labels, column: int) -> float:
    """Return one trial's F-measure of one function."""
    return quality(labels.members[run.test, column], run.scores[:, column] > THRESHOLD).f_measure


def scores_of_others(across: Distances, rows: Sequence[int], judged: Judgement, labels: Labels, method: Method):
    """Return the scores (R, F) that other histograms of the same objects get, each with its object left out.

    Parameters
    ----------
    across : dict of radius in metres to (R, N) float
        From the other histograms to those that were judged.
    rows : (R,) int
        Which objects they are of.
    """
    everything = np.arange(len(labels.members))
    scores = np.zeros((len(rows), len(labels.functions)))
    for place, row in enumerate(rows):
        # The rows of the one object alone are looked at: its distances to all others.
        moved = {radius: np.broadcast_to(each[place], (each.shape[1],) * 2) for radius, each in across.items()}
        split = Split(np.delete(everything, row), np.array([row]))
        scores[place] = split_scores(moved, labels, split, method, judged.weights[row])[0][0]
    return scores
