"""What is taken for what (paper, Fig. 4): labels against predicted functions, of which an object may have several."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.datasets.dataset import NONE

from .evaluation import Trial
from .protocol import Labels


@dataclass(frozen=True, eq=False)
class Confusion:
    """Counts of objects by label and by predicted function; the last of either is none."""

    labels: tuple[str, ...]  # (F + 1,)
    objects: np.ndarray  # (F + 1,) how many objects have the label
    counts: np.ndarray  # (F + 1, F + 1) of those, how many were said to have the function


def count_confusion(labels: Labels, *trials: Trial) -> Confusion:
    """Count who was taken for what in all trials together; an object counts each time it was tested."""
    true = with_none(np.concatenate([labels.members[trial.rows] for trial in trials]))
    predicted = with_none(np.concatenate([trial.predicted for trial in trials]))
    return Confusion((*labels.functions, NONE), true.sum(axis=0), true.T.astype(int) @ predicted.astype(int))


def with_none(members: np.ndarray) -> np.ndarray:
    """Return memberships (N, F) with one more column: true of objects with no function."""
    return np.column_stack([members, ~members.any(axis=1)])
