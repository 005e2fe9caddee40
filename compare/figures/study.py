"""What the paper's figures are drawn from: one data set under the paper's protocol, every trial kept (§IV-B)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.console import progress
from spherefunc_bullet.datasets.dataset import NONE
from spherefunc_bullet.learning.method import Method
from spherefunc_bullet.settling.records import Loading

from ..evaluation.evaluation import labels_of, sphere_distances
from ..evaluation.protocol import (
    Labels,
    Run,
    leave_one_out,
    pooled_scores,
    random_splits,
    runs_measured,
    trial_runs,
)
from ..evaluation.sizes import require_enough

LADDER = (5, 10, 20, 30, 45, 65, 85, 125, 175, 250, 350, 500, 700, 1000)  # training sizes, the paper's among them
APART = 0.9  # of the last rung: one nearer to it would only crowd the figure


@dataclass(frozen=True, kw_only=True)
class Protocol:
    """How the data set is split."""

    sizes: tuple[int, ...]  # training examples of the confusion matrices, ascending
    trials: int = 10
    seed: int = 0


@dataclass(frozen=True, kw_only=True)
class Study:
    """A data set's objects, what is true of them, and what was said of them when they were not learnt."""

    simulated: Simulated
    labels: Labels
    radii: tuple[float, ...]  # metres
    method: Method
    loading: Loading
    protocol: Protocol
    runs: dict[int, list[Run]]  # training examples -> the trials, by ascending number
    left_out: np.ndarray  # (N, F) scores of each object with all others learnt

    @property
    def half(self) -> int:
        """The largest number of training examples."""
        return max(self.runs)

    def measured(self, size: int) -> dict[str, dict]:
        """Return each function's quality, as `spherefunc evaluate` has it."""
        return runs_measured(self.runs[size], self.labels)


def run_study(simulated: Simulated, radii, method: Method, loading: Loading, protocol: Protocol) -> Study:
    """Return the study of a data set.

    Raises
    ------
    InputError
        If all objects have one label, or there are too few.
    """
    labels, count = labels_of(simulated), len(simulated.objects)
    require_enough(simulated.name, count)
    distances = sphere_distances(simulated, radii, method)
    sizes = ladder(count, protocol.sizes)
    runs = {
        size: trial_runs(distances, labels, random_splits(count, size, protocol.trials, protocol.seed), method)
        for size in progress(sizes, len(sizes), "learning and testing")
    }
    left_out, _ = pooled_scores(distances, labels, leave_one_out(count, protocol.seed), method)
    return Study(
        simulated=simulated,
        labels=labels,
        radii=tuple(radii),
        method=method,
        loading=loading,
        protocol=protocol,
        runs=runs,
        left_out=left_out,
    )


def ladder(count: int, sizes: tuple[int, ...]) -> list[int]:
    """Return the training sizes of the learning curve: up to half of the objects, ``sizes`` among them."""
    half = count // 2
    return sorted({half, *sizes, *(size for size in LADDER if size < APART * half)})


def label_name(functions: frozenset[str]) -> str:
    """Return an object's label as a manifest writes it."""
    return "; ".join(sorted(functions)) or NONE
