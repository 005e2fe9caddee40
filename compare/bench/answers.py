"""The cost of answers: a process, an answer and its steps, questions of mechanics, and the stages of a scan.

    python -m spherefunc_bullet.compare.bench answers [--repeats 5]
    python -m spherefunc_bullet.compare.bench labels DATA
    python -m spherefunc_bullet.compare.bench mechanics [--repeats 3]
    python -m spherefunc_bullet.compare.bench scene_stages ../shared/data/scenes [--points 300000]

Times are processor times where the tables say so, which depend little on other work of the machine.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from typing import Annotated, Any

import numpy as np
import typer

from spherefunc_bullet.classification import decide
from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.console import print_table, progress, say
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.sources import read_geometry
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.scenes.impairment.folder import evenly
from spherefunc_bullet.scenes.recognition.recognition import recognise
from spherefunc_bullet.scenes.scans.scan import Scan, load_scan
from spherefunc_bullet.settling.cached_runs import CloudObject
from spherefunc_bullet.settling.drops import DropsByRadius, RunLimit
from spherefunc_bullet.settling.resting_places import resting_places
from spherefunc_bullet.settling.settling import settle
from spherefunc_bullet.simulator import Simulator, make_simulator
from spherefunc_bullet.simulator.mechanics import CarrySettings, PoseSettings, StandSettings

from ..machine import usable_backends
from ..rooms.real_scans import scan_files
from .harness import Data, Repeats, of_household, timed

OBJECTS = {"mug": "mug_01", "chair": "shell_chair_01", "sofa": "sofa_02"}
HANDLED = ("mug_01", "shell_chair_01", "dining_table_02")  # objects for poses, standing and carrying
IMPORT = "import spherefunc_bullet as sf; sf.load_cloud, sf.make_simulator, sf.load_model"
STEPS = ("reading", "sampling", "simulation", "features", "scores")  # of one label
SMALL = 1 / 26  # of a mug's largest extent: the radius at which 300 spheres half fill it
WANTED = {"poses, 100 drops": "2", "keeping 300 small spheres": "3"}  # seconds at most
LABELLED = 40  # objects, at most
TURNS = 3  # runs on each scan, of which the fastest counts


def label_steps(path: Path, model: FunctionClassifier) -> list[float]:
    """Return the milliseconds of processor time that each of `STEPS` takes, from a file to scores."""
    marks = [process_time()]

    def done(made: Any) -> Any:
        marks.append(process_time())
        return made

    done(read_geometry(path))
    cloud = done(load_cloud(path))  # reads again, which is subtracted
    settled = done(settle(cloud, model.simulator, model.chosen_radii(), model.seed, model.run_limit))
    done(model.score_profiles(done(model.profiles([settled]))))
    reading, loading, *others = (1000 * np.diff(marks)).tolist()
    return [reading, max(loading - reading, 0.0), *others]


def processor_seconds(command: Sequence[str], cache: Path) -> float:
    """Return the processor time of a command with its children, with a separate cache folder."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = os.environ | {"SPHEREFUNC_CACHE": str(cache)}
    subprocess.run(command, env=environment, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def print_answers(repeats: Repeats = 5):
    """Print the processor time of an import and of `classify` in a new process, and of each step of one answer."""
    paths = {title: of_household(name) for title, name in OBJECTS.items()}
    with TemporaryDirectory() as folder:
        classify = [sys.executable, "-m", "spherefunc_bullet", "classify", str(paths["mug"]), "--json"]
        calls = {"python alone": [sys.executable, "-c", ""], "import": [sys.executable, "-c", IMPORT]}
        calls |= {"first classify of a mug": classify, "second classify of it": classify}
        rows = [[name, f"{processor_seconds(command, Path(folder)):.2f}"] for name, command in calls.items()]
    print_table("\nA process of its own, seconds of the processor", ["call", "s"], rows)
    model, rows = load_model(shipped_model("fast")), []
    # The first round compiles and loads what is to be timed.
    rounds = [[label_steps(path, model) for path in paths.values()] for _ in range(1 + repeats)][1:]
    for (title, path), steps in zip(paths.items(), zip(*rounds, strict=True), strict=True):
        medians = np.median(steps, axis=0)
        rows.append([f"{title} ({path.stem})", *(f"{value:.1f}" for value in medians), f"{sum(medians):.1f}"])
    print_table("\nA label by fast in a process that is up, ms of the processor", ["object", *STEPS, "all"], rows)


@dataclass(frozen=True, kw_only=True, eq=False)
class TimedObject(CloudObject):
    """A cloud with the seconds of each run of drops on it."""

    seconds: list[float] = field(default_factory=list)

    def drops(self, run_limit: RunLimit) -> DropsByRadius:
        """Return the drops of runs with a limit, and note the time."""
        start = perf_counter()
        drops = super().drops(run_limit)
        self.seconds.append(perf_counter() - start)
        return drops


def seconds_of(cloud: Cloud, model: CloudClassifier) -> tuple[float, float]:
    """Return the seconds of drops, and those of quantities and scores, on a loaded cloud."""
    item = TimedObject(raw_cloud=cloud, drop_config=model.drop_config())
    start = perf_counter()
    decide(item, model)
    drop_seconds = sum(item.seconds)
    return drop_seconds, perf_counter() - start - drop_seconds


def time_labels(data: Data):
    """Print the milliseconds of an answer in a running process, the median and the mean over objects."""
    chosen, rows = [item.path for item in evenly(open_dataset(data).objects, LABELLED)], []
    for backend in ("fast", "bullet"):
        model = load_model(shipped_model(backend))
        seconds_of(load_cloud(chosen[0]), model)  # compiles and loads what is to be timed
        taken = np.array([seconds_of(load_cloud(path), model) for path in progress(chosen, len(chosen), backend)])
        totals, medians = taken.sum(axis=1), np.median(taken, axis=0)
        times = [np.median(totals), totals.mean(), totals.max(), *medians]
        rows.append([backend, str(len(chosen)), *(f"{1000 * time:.1f}" for time in times)])
    head = ["backend", "objects", "median ms", "mean", "longest", "median of drops", "of quantities and scores"]
    print_table(f"a label of the models that ship, objects of {data}, loading and sampling excluded", head, rows)


def questions(simulator: Simulator, cloud: Cloud) -> dict[str, Callable[[], object]]:
    """Return the questions about an object, by their names in the table."""
    places = resting_places(cloud)
    benchmarks: dict[str, Callable[[], object]] = {
        "poses, 100 drops": lambda: simulator.poses(cloud, PoseSettings(), 0),
        "standing, 100 places": lambda: simulator.stands(cloud, StandSettings(load=20.0), places, 0),
    }
    if hasattr(simulator, "carry"):
        benchmarks["keeping"] = lambda: simulator.carry(cloud, CarrySettings(), 0)
        if cloud.size.max() < 0.2:
            small = CarrySettings(radius=float(cloud.size.max()) * SMALL)
            benchmarks["keeping 300 small spheres"] = lambda: simulator.carry(cloud, small, 0)
    return benchmarks


def time_mechanics(repeats: Repeats = 3):
    """Print the shortest processor and wall times of poses, standing and carrying, without loading."""
    rows = []
    for backend in usable_backends(("fast", "bullet")):
        simulator = make_simulator(backend)
        for name in HANDLED:
            for words, question in questions(simulator, load_cloud(of_household(name))).items():
                question()  # compiles and loads what is to be timed
                both, _ = timed(question, repeats, lambda: np.array([process_time(), perf_counter()]))
                rows.append([name, backend, words, *(f"{least:.2f}" for least in np.min(both, axis=0))])
                rows[-1].append(WANTED.get(words, ""))
    head = ["object", "backend", "question", "processor s", "by the clock", "wanted"]
    print_table("Mechanics of one object", head, rows)


def some_points(scan: Scan, count: int) -> Scan:
    """Return a scan with a maximum number of its points."""
    if count >= len(scan):
        return scan
    chosen = np.sort(np.random.default_rng(0).permutation(len(scan))[:count])
    colors = None if scan.colors is None else scan.colors[chosen]
    return replace(scan, points=scan.points[chosen], colors=colors)


def time_scenes(
    data: Annotated[Path, typer.Argument(help="Folder of scans.")],
    points: Annotated[int, typer.Option(help="Number of points of a scan; smaller scans are left out.")] = 300_000,
):
    """Print the seconds of recognition, stage by stage: wall times of the fastest run on each scan."""
    model, table = load_model(shipped_model("fast", scans=True)), []
    scans = [load_scan(path, report=say) for path in scan_files(data, "")]
    scans = [some_points(scan, points) for scan in scans if len(scan) >= points]
    if not scans:
        raise InputError(f"{data}: expected a scan of {points:,} points or more, found none")
    for scan in progress(scans, len(scans), "recognising"):
        turns = [recognise(scan, model) for _ in range(TURNS + 1)][1:]  # after one to warm up
        room = min(turns, key=lambda room: sum(room.stages.values()))
        counts = [len(room.proposals), sum(one.screened for one in room.proposals)]
        table.append([scan.name, *counts, *room.stages.values(), sum(room.stages.values())])
    table.append(["mean", *np.mean([row[1:] for row in table], axis=0)])
    cells = [[row[0], *(f"{value:.0f}" for value in row[1:3]), *(f"{value:.3f}" for value in row[3:])] for row in table]
    head = ["scan", "proposals", "screened", *room.stages, "all"]
    print_table(f"Seconds of scans of {points:,} points", head, cells)
