"""All objects' quantities, under the paper's protocol: those of the spheres, or of their own points in their place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.clouds.thinning import thin
from spherefunc_bullet.learning.method import METHODS
from spherefunc_bullet.learning.profile_classifier import ProfileClassifier
from spherefunc_bullet.settling.records import ObjectRecord

from .evaluation import Evaluation, Trial
from .features import voxel_centers
from .protocol import Labels, Split, Splits

ACROSS = "leave_one_group_out"
BINS = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Profiled:
    """All objects' quantities, and the classifier that learns from them."""

    profiles: np.ndarray  # (N, R * Q) float
    labels: Labels
    classifier: ProfileClassifier

    def trial(self, splits: Sequence[Split]) -> Trial:
        """Return what is said of the objects that splits test, each by what that split learns."""
        return Trial(
            learnt=round(float(np.mean([len(split.train) for split in splits]))),
            rows=np.concatenate([split.test for split in splits]),
            scores=np.concatenate(
                [self.learnt(split.train).score_profiles(self.profiles[split.test]) for split in splits]
            ),
            weights=(),
        )

    def learnt(self, rows: np.ndarray) -> ProfileClassifier:
        """Return the classifier after learning some objects."""
        members, names = self.labels.members[rows], [str(row) for row in rows]
        return self.classifier.fit_profiles(self.profiles[rows], members, self.labels.functions, names)

    def evaluation(self, splits: Splits) -> Evaluation:
        """Return what was said of the objects under a protocol."""
        return Evaluation(
            labels=self.labels,
            method=METHODS["default"],
            trials={size: [self.trial([split]) for split in trials] for size, trials in splits.halves.items()},
            left_out={name: self.trial(alone) for name, alone in splits.left_out.items()},
        )


def profiled(objects: Sequence[Mapping[float, np.ndarray]], labels: Labels, classifier: ProfileClassifier) -> Profiled:
    """Return the quantities of objects, each a mapping of radius in metres to spheres (S, 3), or points as such."""
    return Profiled(profiles=classifier.profiles(objects), labels=labels, classifier=classifier)


def points_as_spheres(record: ObjectRecord, radii: Sequence[float], seed: int = 0) -> dict[float, np.ndarray]:
    """Return an object's own points (S, 3) in place of spheres: as far apart as spheres, in random order."""
    points = np.random.default_rng(seed).permutation(voxel_centers(record))
    return {radius: thin(points, 2 * radius) for radius in radii}


def reliability(trial: Trial, labels: Labels) -> list[dict[str, float]]:
    """Return, for scores within each bin, how many there are, their mean, and the share that is true."""
    members, rows = labels.members[trial.rows], []
    bins = np.clip(np.searchsorted(BINS, trial.scores, side="right") - 1, 0, len(BINS) - 2)
    for place in np.unique(bins).tolist():
        here = bins == place
        said, true = float(trial.scores[here].mean()), float(members[here].mean())
        rows.append({"from": BINS[place], "to": BINS[place + 1], "scores": int(here.sum()), "said": said, "true": true})
    return rows
