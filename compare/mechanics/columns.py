"""Do standing and keeping help to tell functions? As columns beside the resting profile, across sources.

    python -m spherefunc_bullet.compare.mechanics.columns DATA

The same forests learn from the quantities of the spheres alone and with more columns. It takes a quarter of an hour.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.batch.simulated import simulate_dataset
from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, progress, run
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.processes.tasks import run_tasks
from spherefunc_bullet.settling.places import resting_places
from spherefunc_bullet.simulator import Simulator, isolated, make_simulator
from spherefunc_bullet.simulator.mechanics import CarrySettings, Matter, Stance, StandSettings, require_ability
from spherefunc_bullet.simulator.statics.body import body_of

from ..evaluation.alternatives import f_measures
from ..evaluation.protocol import Protocol, labels_of
from ..evaluation.readings import ACROSS, Profiled, spheres_profiled

PLACES = 60
NOT_KNOWN = (-1.0, -1.0, -1.0)  # of what cannot be asked: a flat sheet does not stand
SPHERES, KEPT, STANDING = "spheres", "kept at 15, 30 and 45 degrees", "stands, share of places that carry, margin"


def kept_columns(path: Path, simulator: Simulator) -> tuple[float, ...]:
    """Return the share that a file's object keeps at each angle."""
    return simulator.carry(load_cloud(path), CarrySettings(), 0).kept


def standing_columns(path: Path, simulator: Simulator) -> tuple[float, ...]:
    """Return whether a file's object stands, its share of places that carry its own weight, and its margin in extents.

    A margin has no lower limit where nothing supports; then it is minus its largest extent.
    """
    cloud = load_cloud(path)
    body = body_of(cloud, Matter())
    settings = StandSettings(load=body.mass, most_places=PLACES)
    result = simulator.stands(cloud, settings, resting_places(cloud), 0)
    margin = max(result.margin / body.extent, -1.0)
    return float(result.stance is Stance.STANDS), result.share if result.share is not None else 0.0, margin


def columns(paths: Sequence[Path], simulator: Simulator, ability: str) -> np.ndarray:
    """Return three columns (N, 3) of files' objects, by what a simulator can do."""
    question = kept_columns if ability == "carry" else standing_columns
    rows: list[tuple[float, ...]] = [NOT_KNOWN] * len(paths)
    tasks = [(path, require_ability(simulator, ability)) for path in paths]
    for index, outcome in progress(run_tasks(question, tasks, paths, isolate=isolated(simulator)), len(paths), ability):
        rows[index] = NOT_KNOWN if isinstance(outcome, InputError) else outcome
    return np.array(rows)


def across_sources(base: Profiled, more: np.ndarray, seeds: int) -> list[dict[str, float]]:
    """Return the F-measures across sources with each seed of the forests, with columns (N, C) beside the profile."""
    splits = Protocol(groups=True).splits(base.labels)
    wide = np.hstack([base.profiles, more])
    rows = []
    for seed in range(seeds):
        classifier = FunctionClassifier(radii=base.classifier.radii, random_state=seed)
        asked = replace(base, profiles=wide, classifier=classifier)
        rows.append(f_measures(asked.evaluation(splits).left_out_quality(ACROSS)))
    return rows


def main(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder with manifest.csv that names sources.")],
    seeds: Annotated[int, typer.Option(min=1, help="Forests.")] = 5,
    json: options.Json = False,
):
    """Measure what columns of keeping and standing add to the resting profile."""
    failures, dataset = Failures(), open_dataset(data)
    simulated = simulate_dataset(dataset, options.dropping("fast", None, None, 0, "z", "m"), failed=failures.add)
    base = spheres_profiled(simulated, labels_of(simulated), tuple(simulated.records[0].settled))
    paths = [item.path for item in simulated.objects]
    kept = columns(paths, make_simulator("bullet"), "carry")
    stands = columns(paths, make_simulator("fast"), "stands")
    nothing = np.empty((len(paths), 0))
    features = {SPHERES: nothing, f"and {KEPT}": kept, f"and {STANDING}": stands, "and all": np.hstack([kept, stands])}
    results = {name: across_sources(base, more, seeds) for name, more in features.items()}
    print_json(results) if json else print_rows(results, dataset.name)
    failures.exit()


def print_rows(results: dict[str, list[dict[str, float]]], data: str):
    """Print the mean F-measure of each function, and its spread over the forests."""
    functions = list(next(iter(results.values()))[0])
    table = []
    for name, rows in results.items():
        columns = [[row[one] for row in rows] for one in functions]
        table.append([name, *(f"{np.mean(column):.3f} ± {np.std(column):.3f}" for column in columns)])
    print_table(f"{data}: F-measures across sources, mean and spread of the forests", ["columns", *functions], table)


if __name__ == "__main__":
    run(lambda: typer.run(main))
