"""How long a label takes in a process that is up: drops, quantities, forests, and whether it falls over.

Loading and sampling are left out.

    python -m spherefunc_bullet.compare.bench.labels DATA [--backends fast,bullet] [--count 40]
"""

from __future__ import annotations

from dataclasses import dataclass, field
from time import perf_counter
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.classification import decide
from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.console import print_table, progress, run
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.settling.drops import DropsByRadius, RunLimit
from spherefunc_bullet.settling.kept_object import CloudObject


@dataclass(frozen=True, kw_only=True, eq=False)
class TimedObject(CloudObject):
    """A cloud, and the seconds that each run of drops on it has taken."""

    seconds: list[float] = field(default_factory=list)

    def drops(self, length: RunLimit) -> DropsByRadius:
        """Return what becomes of the spheres in runs of some length."""
        start = perf_counter()
        drops = super().drops(length)
        self.seconds.append(perf_counter() - start)
        return drops


def seconds_of(cloud: Cloud, model: CloudClassifier) -> tuple[float, float]:
    """Return the seconds that drops, and then quantities and scores, take on a cloud that is loaded."""
    item = TimedObject(own=cloud, dropping=model.dropping())
    start = perf_counter()
    decide(item, model)
    dropping = sum(item.seconds)
    return dropping, perf_counter() - start - dropping


def main(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder with manifest.csv, or a catalogue's name.")],
    backends: Annotated[str, typer.Option(help="Whose models, those that ship, are asked.")] = "fast,bullet",
    count: Annotated[int, typer.Option(min=1, help="Objects, evenly chosen.")] = 40,
):
    """Print the milliseconds of a label, the median over objects and the mean."""
    objects, rows = open_dataset(data).objects, []
    chosen = [objects[k * len(objects) // count].path for k in range(min(count, len(objects)))]
    for backend in backends.split(","):
        model = load_model(shipped_model(backend))
        seconds_of(load_cloud(chosen[0]), model)  # compiles and loads what is to be timed
        taken = np.array([seconds_of(load_cloud(path), model) for path in progress(chosen, len(chosen), backend)])
        totals, medians = taken.sum(axis=1), np.median(taken, axis=0)
        times = [np.median(totals), totals.mean(), totals.max(), *medians]
        rows.append([backend, str(len(chosen)), *(f"{1000 * time:.1f}" for time in times)])
    head = ["backend", "objects", "median ms", "mean", "longest", "median of drops", "of quantities and scores"]
    print_table(f"a label of the models that ship, objects of {data}, loading and sampling excluded", head, rows)


if __name__ == "__main__":
    run(lambda: typer.run(main))
