"""Would a label be as good if drops stopped as soon as the answer is sure? Measured across sources, not built in.

    python -m spherefunc_bullet.compare.evaluation.stopping DATA

A classifier of the first few drops is asked first; where each of its scores is near 0 or 1, its answer stands, and that
of all drops elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, run
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.method import PROFILE
from spherefunc_bullet.learning.validation import THRESHOLD, quality

from .profiled import ACROSS, profiled
from .protocol import Labels, Protocol, labels_of

ERRORS = (0.02, 0.05, 0.1)  # how far from 0 or 1 a score may be to be sure


@dataclass(frozen=True, kw_only=True)
class Stopping:
    """What comes of stopping after so many drops where every score is so near 0 or 1."""

    drops: int  # at each radius
    error: float  # that a score may state at most
    stopped: float  # share of the objects
    wrong: int  # of these, whose functions are not all right
    wrong_to_the_end: int  # of the same objects, after all drops
    f_measures: dict[str, float]  # of all objects, those that go on included


def scores_after(simulated: Simulated, labels: Labels, radii: tuple[float, ...], count: int | None) -> np.ndarray:
    """Return the scores (N, F) across sources when only the first so many drops are read, in learning and asking."""
    first = [{radius: drops[:count] for radius, drops in settled.items()} for settled in simulated.settled]
    splits = Protocol(groups=True).splits(labels).left_out[ACROSS]
    trial = profiled(first, labels, FunctionClassifier(radii=radii)).trial(splits)
    return trial.scores[np.argsort(trial.rows)]


def stopped_at(labels: Labels, early: np.ndarray, late: np.ndarray, drops: int, error: float) -> Stopping:
    """Return what comes of early scores (N, F) that stand where they are sure, and of late ones elsewhere."""
    sure = ((early < error) | (early > 1 - error)).all(axis=1)
    said = np.where(sure[:, None], early, late) > THRESHOLD
    wrong = [int(((scores > THRESHOLD) != labels.members)[sure].any(axis=1).sum()) for scores in (early, late)]
    columns = zip(labels.functions, labels.members.T, said.T, strict=True)
    return Stopping(
        drops=drops,
        error=error,
        stopped=round(float(sure.mean()), 3),
        wrong=wrong[0],
        wrong_to_the_end=wrong[1],
        f_measures={name: round(quality(members, told).f_measure, 4) for name, members, told in columns},
    )


def stoppings(simulated: Simulated, radii: tuple[float, ...], counts: Sequence[int]) -> list[Stopping]:
    """Return what comes of stopping after each number of drops, with each error that may be stated."""
    labels = labels_of(simulated)
    late = scores_after(simulated, labels, radii, None)
    rows = []
    for count in counts:
        early = scores_after(simulated, labels, radii, count)
        rows += [stopped_at(labels, early, late, count, error) for error in ERRORS]
    return rows


def main(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder with manifest.csv that names sources.")],
    counts: Annotated[str, typer.Option(help="Drops at each radius after which to stop.")] = "20,40,80",
    backend: options.Backend = "fast",
    jobs: options.Jobs = -1,
    json: options.Json = False,
):
    """Print how many objects need no more than a few drops, and what labels lose by stopping there."""
    failures = Failures()
    dropping = options.dropping(backend, None, None, 0, "z", "m", PROFILE)
    simulated = simulate_dataset(open_dataset(data), dropping, jobs=jobs, failed=failures.add)
    rows = stoppings(simulated, dropping.radii, [int(count) for count in counts.split(",")])
    if json:
        print_json([asdict(row) for row in rows])
    else:
        table = [
            [str(row.drops), f"{row.error:g}", f"{row.stopped:.3f}", str(row.wrong), str(row.wrong_to_the_end)]
            + [f"{value:.3f}" for value in row.f_measures.values()]
            for row in rows
        ]
        head = ["drops", "error", "stopped", "wrong", "wrong after all", *(f"F {name}" for name in rows[0].f_measures)]
        print_table(f"{simulated.name}, {backend}: stopping where every score is sure, across sources", head, table)
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
