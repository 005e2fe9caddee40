"""Backends beside each other on some objects, by the default method: speed, spheres kept, and how well they tell.

python -m spherefunc_bullet.compare.bench.backends household --backends fast,bullet,mujoco [--count 40]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np
import typer
from sklearn.metrics import f1_score

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.console import Failures, print_table, run
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.learning.method import METHODS, PROFILE, PROFILE_RADII
from spherefunc_bullet.settling.records import Dropping

from ..comparison.entries import evenly
from ..evaluation.profiled import spheres_profiled
from ..evaluation.protocol import labels_of, leave_one_out

HEAD = ["backend", "objects", "drops", "drops/s", "median ms an object", "spheres kept"]


def table_row(backend: str, simulated: Simulated) -> tuple[list[str], dict[str, float]]:
    """Return a backend's row of the table, and its F-measure of each function, leaving one object out."""
    records = simulated.records
    drops = sum(sum(record.drops.values()) for record in records)
    seconds = np.array([sum(record.seconds.values()) for record in records])
    kept = sum(len(drops.rests) for record in records for drops in record.settled.values())
    row = [backend, str(len(records)), str(drops), f"{drops / seconds.sum():.0f}", f"{1e3 * np.median(seconds):.0f}"]
    return [*row, f"{kept / drops:.2f}"], left_out_f_measures(simulated)


def left_out_f_measures(simulated: Simulated) -> dict[str, float]:
    """Return the F-measure of each function, every object classified by a model of all others."""
    labels = labels_of(simulated)
    trial = spheres_profiled(simulated, labels, PROFILE_RADII).trial(leave_one_out(len(labels), 0))
    said, true = trial.scores > 0.5, labels.members[trial.rows]
    return {name: float(f1_score(true[:, k], said[:, k], zero_division=0.0)) for k, name in enumerate(labels.functions)}


def print_backends(data: str, backends: Sequence[str], count: int):
    """Print one row for each backend."""
    dataset, rows, functions = open_dataset(data), [], []
    some = replace(dataset, objects=evenly(dataset.objects, count))  # so in the data set's proportions
    for backend in backends:
        dropping = Dropping(simulator=backend, radii=PROFILE_RADII, length=METHODS[PROFILE].length)
        row, f_measures = table_row(backend, simulate_dataset(some, dropping, jobs=1, failed=Failures().add))
        functions = [f"F {name}" for name in f_measures]
        rows.append([*row, *(f"{value:.2f}" for value in f_measures.values())])
    print_table(f"backends on {data}: 200 drops at each radius, one process, leaving one out", HEAD + functions, rows)


def main(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder with manifest.csv, or a catalogue's name.")],
    backends: Annotated[str, typer.Option(help="Those to compare.")] = "fast,bullet",
    count: Annotated[int, typer.Option(min=4, help="Objects, evenly chosen.")] = 40,
):
    """Print the table of docs/backends.md."""
    print_backends(data, backends.split(","), count)


if __name__ == "__main__":
    run(lambda: typer.run(main))
