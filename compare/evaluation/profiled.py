"""All objects' quantities, under the paper's protocol: those of the spheres, or of their own points in their place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.clouds.thinning import thin
from spherefunc_bullet.learning.calibration import Kin
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.method import DROPS, METHODS
from spherefunc_bullet.settling.drops import as_drops
from spherefunc_bullet.settling.records import ObjectRecord
from spherefunc_bullet.settling.settling import Settled

from .evaluation import FOLDS, Evaluation, Trial
from .features import voxel_centers
from .protocol import Labels, Split, Splits

POINTS = "points"  # by the same quantities
ACROSS = "leave_one_group_out"
BINS = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Profiled:
    """All objects' quantities, and the classifier that learns from them."""

    profiles: np.ndarray  # (N, R * Q) float
    labels: Labels
    classifier: FunctionClassifier
    kin: Kin | None = None  # of the objects, where some are copies of others

    def trial(self, splits: Sequence[Split]) -> Trial:
        """Return what is said of the objects that splits test, each by what that split learns.

        Where splits leave out one object each, a twentieth of them is left out at a time.
        """
        folds = [[split] for split in splits]
        if len(splits) > FOLDS:
            folds = [[splits[k] for k in fold] for fold in np.array_split(np.arange(len(splits)), FOLDS)]
        tests = [np.concatenate([split.test for split in fold]) for fold in folds]
        trains = [
            fold[0].train if len(fold) == 1 else np.setdiff1d(np.arange(len(self.labels)), test)
            for fold, test in zip(folds, tests, strict=True)
        ]
        scores, weights = [], []
        for train, test in zip(trains, tests, strict=True):
            learnt = self.learnt(train)
            scores.append(learnt.score_profiles(self.profiles[test]))
            weights.append([{learnt.radius_[name]: 1.0} for name in self.labels.functions])
        return Trial(
            learnt=round(float(np.mean([len(split.train) for split in splits]))),
            rows=np.concatenate(tests),
            scores=np.concatenate(scores),
            weights=weights,
        )

    def learnt(self, rows: np.ndarray) -> FunctionClassifier:
        """Return the classifier after learning some objects."""
        members, names = self.labels.members[rows], [str(row) for row in rows]
        kin = None if self.kin is None else self.kin.of(rows)
        return self.classifier.fit_profiles(self.profiles[rows], members, self.labels.functions, names, kin)

    def evaluation(self, splits: Splits) -> Evaluation:
        """Return what was said of the objects under a protocol."""
        return Evaluation(
            labels=self.labels,
            method=METHODS["profile"],
            trials={size: [self.trial([split]) for split in trials] for size, trials in splits.halves.items()},
            left_out={name: self.trial(alone) for name, alone in splits.left_out.items()},
        )


def profiled(objects: Sequence[Settled], labels: Labels, classifier: FunctionClassifier) -> Profiled:
    """Return the quantities of objects, each given by its drops at every radius."""
    return Profiled(profiles=classifier.profiles(objects), labels=labels, classifier=classifier)


def spheres_profiled(simulated: Simulated, labels: Labels, radii: tuple[float, ...]) -> Profiled:
    """Return the quantities of the spheres that fell on objects."""
    return profiled(simulated.settled, labels, FunctionClassifier(radii=radii))


def points_profiled(records: Sequence[ObjectRecord], labels: Labels, radii: tuple[float, ...]) -> Profiled:
    """Return the same quantities of the objects' own points: what the spheres have to beat."""
    return profiled([points_as_drops(record, radii) for record in records], labels, FunctionClassifier(radii=radii))


def fused(features: Sequence[Profiled]) -> Profiled:
    """Return the quantities of several features (N, Q1 + Q2 + ...) side by side, as the paper hopes for (§IV-B)."""
    return replace(features[0], profiles=np.hstack([feature.profiles for feature in features]))


def points_as_drops(record: ObjectRecord, radii: Sequence[float], seed: int = 0) -> Settled:
    """Return an object's own points in place of spheres that settled: as far apart as spheres, in random order."""
    points = voxel_centers(record)
    mixed = np.random.default_rng(seed).permutation(points)
    return {radius: as_drops(thin(mixed, 2 * radius)[:DROPS], points, radius) for radius in radii}


def reliability(trial: Trial, labels: Labels) -> list[dict[str, float]]:
    """Return, for scores within each bin, how many there are, their mean, and the share that is true."""
    members, rows = labels.members[trial.rows], []
    bins = np.clip(np.searchsorted(BINS, trial.scores, side="right") - 1, 0, len(BINS) - 2)
    for place in np.unique(bins).tolist():
        here = bins == place
        said, true = float(trial.scores[here].mean()), float(members[here].mean())
        rows.append({"from": BINS[place], "to": BINS[place + 1], "scores": int(here.sum()), "said": said, "true": true})
    return rows
