"""How well one feature classifies functions (§IV): trial by trial, with every object left out, and what is confused.

Distances between histograms do not depend on which objects train, so each feature's are computed once, and a
trial only chooses rows and columns.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from spherefunc_bullet.datasets.dataset import NONE
from spherefunc_bullet.learning.method import AnyMethod, Method
from spherefunc_bullet.learning.validation import THRESHOLD, Quality, quality, radius_weights, voted_scores

from .features import Distances
from .protocol import Labels, Split, Splits

FOLDS = 20  # of leave-one-out, for the choice of the radius
Weights = Mapping[float, float]  # radius in metres -> how much it counts
FunctionQuality = dict[str, Any]  # how well one function is classified, see `mean_quality`
Qualities = dict[str, FunctionQuality]  # by function


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """The scores of objects that were not learnt."""

    learnt: int  # number of objects
    rows: np.ndarray  # (T,) int, the objects that were tested
    scores: np.ndarray  # (T, F)
    weights: Sequence[Sequence[Weights]]  # of every split, each function's
    unsure: np.ndarray | None = None  # (T,) bool, the answers that are unsure, where that was learnt

    @classmethod
    def joined(cls, trials: Sequence[Trial], splits: Sequence[Split] = ()) -> Trial:
        """Return several trials as one, with the mean number of objects learnt: of splits, where these are given."""
        sizes = [len(split.train) for split in splits] or [trial.learnt for trial in trials]
        unsure = [trial.unsure for trial in trials if trial.unsure is not None]
        return cls(
            learnt=round(float(np.mean(sizes))),
            rows=np.concatenate([trial.rows for trial in trials]),
            scores=np.concatenate([trial.scores for trial in trials]),
            weights=[weights for trial in trials for weights in trial.weights],
            unsure=np.concatenate(unsure) if unsure else None,
        )

    @property
    def predicted(self) -> np.ndarray:
        """The predicted functions of each object, (T, F) bool."""
        return self.scores > THRESHOLD

    def quality(self, labels: Labels, column: int) -> tuple[Quality, float]:
        """Return how well one function was classified, and its fair F-measure."""
        members, predicted = labels.members[self.rows, column], self.predicted[:, column]
        fair = quality(members, predicted, ~labels.also[self.rows, column])
        return quality(members, predicted), fair.f_measure

    def wrong(self, labels: Labels) -> np.ndarray:
        """Return which answers are wrong in some function (T,) bool; a second function that is true as well is not."""
        members, also = labels.members[self.rows], labels.also[self.rows]
        return ((self.predicted != members) & ~(also & self.predicted)).any(axis=1)

    def kept(self, which: np.ndarray) -> Trial:
        """Return the trial of some of its objects (T,) bool."""
        unsure = None if self.unsure is None else self.unsure[which]
        return replace(self, rows=self.rows[which], scores=self.scores[which], unsure=unsure)


@dataclass(frozen=True, kw_only=True, eq=False)
class Evaluation:
    """The results of one feature and method on a data set's objects when they were not learnt."""

    labels: Labels
    method: Method
    trials: Mapping[int, Sequence[Trial]]  # training size in objects -> the trials, ascending
    left_out: Mapping[str, Trial]  # every object tested once: leave_one_out, leave_one_group_out
    again: Trial | None = None  # some of the objects by other spheres on them, with all others learnt
    by_radius: Mapping[float, Evaluation] = field(default_factory=dict)  # the trials with each radius alone, metres

    def quality(self, train_size: int, every_trial: bool = False) -> Qualities:
        """Return each function's mean quality over the trials of a training size; also of each, if wanted."""
        return mean_quality(self.trials[train_size], self.labels, every_trial)

    def left_out_quality(self, protocol: str = "leave_one_out") -> Qualities:
        """Return each function's quality with every object tested once and all counted together."""
        return mean_quality([self.left_out[protocol]], self.labels)

    @property
    def halves(self) -> tuple[int, int]:
        """The largest number of objects that the trials learn, and the number that they test."""
        largest = max(self.trials)
        return largest, len(self.trials[largest][0].rows)

    @cached_property
    def scores(self) -> np.ndarray:
        """The scores of every object with all others learnt, (N, F)."""
        alone = self.left_out["leave_one_out"]
        return alone.scores[np.argsort(alone.rows)]

    @property
    def predicted(self) -> np.ndarray:
        """The predicted functions of every object with all others learnt, (N, F) bool."""
        return self.scores > THRESHOLD

    def always_negative(self) -> Evaluation:
        """Return the evaluation of a classifier that says no to everything, with which an accuracy is compared."""

        def negative(trial: Trial) -> Trial:
            return replace(trial, scores=np.zeros_like(trial.scores), weights=(), unsure=None)

        trials = {size: list(map(negative, trials)) for size, trials in self.trials.items()}
        left_out = {name: negative(trial) for name, trial in self.left_out.items()}
        return replace(self, trials=trials, left_out=left_out, again=None, by_radius={})


class FeatureMethod(Protocol):
    """One way to classify objects by function, prepared for the objects of a data set."""

    labels: Labels
    method: AnyMethod

    def trials(self, splits_of_trials: Sequence[Sequence[Split]]) -> list[Trial]:
        """Return several trials; in each, every one of its splits is learnt and tested."""

    def evaluation(self, splits: Splits) -> Evaluation:
        """Return the evaluation of the objects under a protocol."""
        return evaluation_of(self, splits, iter(self.trials(splits_of_protocol(splits))))


def splits_of_protocol(splits: Splits) -> list[Sequence[Split]]:
    """Return the splits of each trial of a protocol."""
    return [*([split] for trials in splits.halves.values() for split in trials), *splits.left_out.values()]


def evaluation_of(read: FeatureMethod, splits: Splits, results: Iterator[Trial]) -> Evaluation:
    """Return an evaluation from the trials of `splits_of_protocol`, in their order."""
    return Evaluation(
        labels=read.labels,
        method=read.method,
        trials={size: [next(results) for _ in trials] for size, trials in splits.halves.items()},
        left_out={name: next(results) for name in splits.left_out},
    )


def trial_again(distances: Distances, rows: Sequence[int], left_out: Trial, labels: Labels, method: Method) -> Trial:
    """Return the trial of some objects (R,) by other spheres on them, each left out as it was at first.

    Both are compared with the first histograms of all other objects, so that only the object's own spheres differ.

    Parameters
    ----------
    distances : of each radius (R, N)
        From the other spheres to the first ones of all objects.
    """
    weights = dict(zip(left_out.rows.tolist(), left_out.weights, strict=True))
    scores = np.zeros((len(rows), len(labels.functions)))
    for place, row in enumerate(rows):
        train = np.delete(np.arange(len(labels)), row)
        across = {radius: matrix[[place]][:, train] for radius, matrix in distances.items()}
        scores[place] = function_scores(across, labels.members[train], weights[row], method)[0]
    return Trial(learnt=left_out.learnt, rows=np.array(rows, int), scores=scores, weights=())


def run_trial(
    distances: Distances, labels: Labels, split: Split, method: Method, weights: Sequence[Weights] | None = None
) -> Trial:
    """Return the trial of one split; without weights, its training objects choose the radii."""
    members = labels.members[split.train]
    if weights is None:
        inside = {radius: matrix[np.ix_(split.train, split.train)] for radius, matrix in distances.items()}
        weights = [radius_weights(inside, column, method) for column in members.T]
    across = {radius: matrix[np.ix_(split.test, split.train)] for radius, matrix in distances.items()}
    scores = function_scores(across, members, weights, method)
    return Trial(learnt=len(split.train), rows=split.test, scores=scores, weights=[weights])


def function_scores(across: Distances, members: np.ndarray, weights: Sequence[Weights], method: Method) -> np.ndarray:
    """Return scores (T, F) from distances (T, L) to learnt objects with members (L, F), all radii together."""
    columns = zip(members.T, weights, strict=True)
    return np.stack([voted_scores(across, column, chosen, method) for column, chosen in columns], axis=1)


def pooled_trial(distances: Distances, labels: Labels, splits: Sequence[Split], method: Method) -> Trial:
    """Return one trial of several splits, such as those that leave out one object each.

    The radius is chosen once for every twentieth of these, without all objects of that twentieth: never with the help
    of a tested object, at a twentieth of the cost.
    """
    trials: list[Trial] = []
    for fold in np.array_split(np.arange(len(splits)), min(FOLDS, len(splits))):
        weights = None
        if len(fold) > 1:
            train = np.setdiff1d(np.arange(len(labels)), np.concatenate([splits[i].test for i in fold]))
            weights = run_trial(distances, labels, Split(train, splits[fold[0]].test), method).weights[0]
        trials += [run_trial(distances, labels, splits[i], method, weights) for i in fold]
    return Trial.joined(trials)


def mean_quality(trials: Sequence[Trial], labels: Labels, every_trial: bool = False) -> Qualities:
    """Return each function's mean quality over trials, with spread and the radius chosen most often."""
    rows: Qualities = {}
    for column, name in enumerate(labels.functions):
        strict, fair = zip(*(trial.quality(labels, column) for trial in trials), strict=True)
        f_measures = [row.f_measure for row in strict]
        rows[name] = {
            "f_measure": mean(f_measures),
            "f_measure_std": round(float(np.std(f_measures)), 4) if len(trials) > 1 else None,  # of one, none
            "f_measure_fair": mean(fair),  # without the objects of which it is true as well
            "precision": mean([row.precision for row in strict]),
            "recall": mean([row.recall for row in strict]),
            "accuracy": mean([row.accuracy for row in strict]),
            "radius": max(counts := radius_counts(trials, column), key=counts.get, default=None),
        }
        if every_trial:
            rows[name]["f_measures"] = [round(f_measure, 4) for f_measure in f_measures]
    return rows


def radius_counts(trials: Iterable[Trial], column: int) -> Counter[float]:
    """Return how often each radius had the largest weight for a function."""
    chosen = [weights[column] for trial in trials for weights in trial.weights]
    return Counter(max(weights, key=weights.get) for weights in chosen)


def mean(values: Sequence[float]) -> float:
    """Return a mean to four places."""
    return round(float(np.mean(values)), 4)


@dataclass(frozen=True, eq=False)
class Confusion:
    """Counts of objects by label and by predicted function; the last of either is none."""

    labels: tuple[str, ...]  # (F + 1,)
    objects: np.ndarray  # (F + 1,) number of objects with the label
    counts: np.ndarray  # (F + 1, F + 1) number of these that were predicted to have the function


def count_confusion(labels: Labels, *trials: Trial) -> Confusion:
    """Return the confusion matrix of all trials together; an object counts each time it was tested."""

    def with_none(members: np.ndarray) -> np.ndarray:
        return np.column_stack([members, ~members.any(axis=1)])

    true = with_none(np.concatenate([labels.members[trial.rows] for trial in trials]))
    predicted = with_none(np.concatenate([trial.predicted for trial in trials]))
    return Confusion((*labels.functions, NONE), true.sum(axis=0), true.T.astype(int) @ predicted.astype(int))


def confusion_report(labels: Labels, trials: Sequence[Trial]) -> dict[str, Any]:
    """Return the confusion matrix of all trials together for JSON, with numbers of memberships and chosen radii."""
    confusion, names = count_confusion(labels, *trials), labels.functions
    several = np.minimum(np.concatenate([trial.predicted.sum(axis=1) for trial in trials]), 2)
    memberships = dict(zip(("none", "one", "several"), np.bincount(several, minlength=3).tolist(), strict=True))
    rows = [dict(zip(confusion.labels, row, strict=True)) for row in confusion.counts.tolist()]
    radii = {name: sorted(radius_counts(trials, column).items()) for column, name in enumerate(names)}
    return {
        "tested": len(several),
        "memberships": memberships,  # number of the tested objects with no, one, or several predicted functions
        "confusion": dict(zip(confusion.labels, rows, strict=True)),  # label -> function -> number of objects
        # Function -> radius in metres -> how often it had the largest weight.
        "radii": {name: {f"{radius:g}": count for radius, count in chosen} for name, chosen in radii.items()},
    }
