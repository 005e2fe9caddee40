"""What an answer costs: importing, `classify` in a new process, and each step of a label in one that is up.

    python -m spherefunc_bullet.compare.bench.answers [--backend fast] [--repeats 5]

Processor time, so that other work on the machine counts little.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.console import print_table, run
from spherefunc_bullet.datasets.catalogue import built_catalogue
from spherefunc_bullet.formats.reading import read_geometry
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.settling.settling import settle

OBJECTS = {"mug": "mug_01", "chair": "shell_chair_01", "sofa": "sofa_02"}
IMPORT = "import spherefunc_bullet as sf; sf.load_cloud, sf.make_simulator, sf.load_model"
STEPS = ("reading", "sampling", "simulation", "features", "scores")  # of one label


def label_steps(path: Path, model: FunctionClassifier) -> list[float]:
    """Return the milliseconds of the processor that each of `STEPS` takes, from a file to scores."""
    marks = [process_time()]
    read_geometry(path)
    marks.append(process_time())
    cloud = load_cloud(path)  # reads again, which is taken off
    marks.append(process_time())
    settled = settle(cloud, model.simulator, model.chosen_radii(), model.seed, model.length)
    marks.append(process_time())
    profiles = model.profiles([settled])
    marks.append(process_time())
    model.score_profiles(profiles)
    marks.append(process_time())
    reading, loading, *others = (1000 * np.diff(marks)).tolist()
    return [reading, max(loading - reading, 0.0), *others]


def processor_seconds(command: Sequence[str], cache: Path) -> float:
    """Return the processor time of a command, its children's included, with a cache folder of its own."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = os.environ | {"SPHEREFUNC_CACHE": str(cache)}
    subprocess.run(command, env=environment, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def print_processes(mug: Path):
    """Print the processor time of an import, and of a first and a second `classify` of a mug."""
    with TemporaryDirectory() as folder:
        classify = [sys.executable, "-m", "spherefunc_bullet", "classify", str(mug), "--json"]
        calls = {"python alone": [sys.executable, "-c", ""], "import": [sys.executable, "-c", IMPORT]}
        calls |= {"first classify of a mug": classify, "second classify of it": classify}
        rows = [[name, f"{processor_seconds(command, Path(folder)):.2f}"] for name, command in calls.items()]
    print_table("\nA process of its own, seconds of the processor", ["call", "s"], rows)


def print_labels(backend: str, paths: dict[str, Path], repeats: int):
    """Print the milliseconds of each step of a label in a process that is up, the median of some times."""
    model, rows = load_model(shipped_model(backend)), []
    # The first round compiles and loads what is to be timed.
    rounds = [[label_steps(path, model) for path in paths.values()] for _ in range(1 + repeats)][1:]
    for (title, path), steps in zip(paths.items(), zip(*rounds, strict=True), strict=True):
        medians = np.median(steps, axis=0)
        rows.append([f"{title} ({path.stem})", *(f"{value:.1f}" for value in medians), f"{sum(medians):.1f}"])
    print_table(f"\nA label by {backend} in a process that is up, ms of the processor", ["object", *STEPS, "all"], rows)


def print_answers(
    backend: Annotated[str, typer.Option(help="Whose model, one that ships, is asked.")] = "fast",
    repeats: Annotated[int, typer.Option(min=1, help="Of each label.")] = 5,
):
    """Print what an answer costs."""
    folder = built_catalogue("household").parent
    paths = {title: folder / f"{name}.ply" for title, name in OBJECTS.items()}
    print_processes(paths["mug"])
    print_labels(backend, paths, repeats)


if __name__ == "__main__":
    run(lambda: typer.run(print_answers))
