"""What objects of each label were said to be: how many were said to have which function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from spherefunc_bullet.datasets.dataset import NONE

from .evaluation import Trial, radius_counts
from .protocol import Labels


@dataclass(frozen=True, eq=False)
class Confusion:
    """Counts of objects by label and by predicted function; the last of either is none."""

    labels: tuple[str, ...]  # (F + 1,)
    objects: np.ndarray  # (F + 1,) how many objects have the label
    counts: np.ndarray  # (F + 1, F + 1) of those, how many were said to have the function


def confusion_report(labels: Labels, trials: Sequence[Trial]) -> dict[str, Any]:
    """Return who was taken for what in all trials together, and by which radii.

    An object counts each time it was tested.
    """
    confusion, columns = count_confusion(labels, *trials), range(len(labels.functions))
    several = np.minimum(np.concatenate([trial.predicted.sum(axis=1) for trial in trials]), 2)
    none, one, more = np.bincount(several, minlength=3).tolist()
    rows = [dict(zip(confusion.labels, row, strict=True)) for row in confusion.counts.tolist()]
    return {
        "tested": len(several),
        "memberships": {"none": none, "one": one, "several": more},  # of those tested, how many were said to have
        "confusion": dict(zip(confusion.labels, rows, strict=True)),  # label -> function -> how many
        "radii": {  # function -> radius in metres -> how often it counted most
            labels.functions[k]: {f"{radius:g}": n for radius, n in sorted(radius_counts(trials, k).items())}
            for k in columns
        },
    }


def count_confusion(labels: Labels, *trials: Trial) -> Confusion:
    """Count who was taken for what in all trials together; an object counts each time it was tested."""
    true = with_none(np.concatenate([labels.members[trial.rows] for trial in trials]))
    predicted = with_none(np.concatenate([trial.predicted for trial in trials]))
    return Confusion((*labels.functions, NONE), true.sum(axis=0), true.T.astype(int) @ predicted.astype(int))


def with_none(members: np.ndarray) -> np.ndarray:
    """Return memberships (N, F) with one more column: true of objects with no function."""
    return np.column_stack([members, ~members.any(axis=1)])
