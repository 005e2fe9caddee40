"""How well functions are told from one feature: over the paper's trials, and with each object left out once (§IV)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.method import Method
from spherefunc_bullet.validation import THRESHOLD, quality

from .baselines import Distances
from .protocol import Labels, Run, Split, leave_one_out, pooled_scores, runs_measured, split_scores, trial_runs


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
