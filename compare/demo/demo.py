"""The whole way on the built-in catalogue: simulate, evaluate, compare simulators, classify objects never seen.

    python -m spherefunc_bullet.compare.demo --out demo
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.clouds.cloud import load_cloud, placed
from spherefunc_bullet.commands.classify import classified, print_functions
from spherefunc_bullet.commands.train import train_on
from spherefunc_bullet.console import Failures, progress, say
from spherefunc_bullet.datasets.catalogue import make_catalogue, write_catalogue
from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject, open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.reading import read_geometry
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.method import find_method
from spherefunc_bullet.quantities import format_length, parse_lengths
from spherefunc_bullet.settling.settling import settle
from spherefunc_bullet.simulator import make_simulator

from ..comparison.advice import recommendation
from ..comparison.comparison import compare_entries
from ..comparison.entries import evenly, hold, settled_experiment
from ..comparison.experiment import BACKENDS, Experiment, contestants
from ..comparison.files import write_report
from ..evaluation.confusion import Confusion, count_confusion
from ..evaluation.evaluation import Options, all_features, labels_of, protocols
from ..evaluation.protocol import leave_one_out, pooled_scores
from ..evaluation.sizes import TRAIN_SIZES, wanted_sizes
from ..evaluation.tables import report
from ..machine import machine, usable_backends
from ..pages.pictures import View, render
from .gallery import write_gallery, write_png
from .page import ClassifiedObject, Summary, page

DATA = "household"
UNSEEN_SEED = 7  # of the catalogue from which the classified objects come; training uses 0
UNSEEN = (
    "mug_02",
    "wine_glass_01",
    "dining_table_03",
    "coffee_table_02",
    "dining_chair_04",
    "sofa_02",
    "filing_cabinet_01",
    "vase_01",
)
SIZE = (320, 280)  # of an object's picture, pixels
CUT_BELOW = 0.5  # metres: smaller objects are cut open, because what they hold is inside
SPHERES_ACROSS = 30  # of a picture: about so many radii to an object's largest extent
OBJECTS = 40  # evenly spread over the catalogue, so in its proportions
AGAIN = 8  # of them dropped on with a second seed
RADII = (0.03, 0.05)  # metres: the quick ones


@dataclass(frozen=True, kw_only=True)
class Demo:
    """What is run."""

    out: Path
    backend: str = "fast"
    radii: tuple[float, ...] = parse_lengths("1cm,2cm,3cm,5cm")  # metres
    method: str = "default"
    trials: int = 10
    seed: int = 0
    jobs: int = -1


class Stopwatch:
    """The seconds that each step took, in order."""

    def __init__(self):
        self.seconds: dict[str, float] = {}

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Say what is done, and time it."""
        say(f"{name} …")
        started = time.perf_counter()
        yield
        self.seconds[name] = time.perf_counter() - started


def run_demo(demo: Demo) -> Path:
    """Do everything and return the page's path.

    Raises
    ------
    InputError
        If there is no such backend or method, or the folder cannot be written.
    """
    watch, simulator = Stopwatch(), make_simulator(demo.backend)
    with watch.step(f"dropping spheres on the catalogue {DATA}"):
        simulated = simulate_all(open_dataset(DATA), simulator, demo)
    with watch.step("evaluating, beside baselines that need no spheres"):
        results, confusion = evaluated(simulated, demo)
    with watch.step("learning all, and classifying objects that were not learnt"):
        model = train_on(simulated, simulator, demo.radii, method=demo.method, seed=demo.seed)
        unseen = write_unseen(demo.out / "objects", simulated)
        rows = [classified(each.path, model, True, "z", "m") for each in unseen]
    about = {"data": DATA, "objects": len(simulated.objects), "backend": demo.backend, "method": demo.method}
    with watch.step("comparing simulators on some of the objects"):
        comparison = compare_some(DATA, demo.out / "comparison", demo.jobs)
    print_results(about, results, rows, model)
    print(f"\n{comparison['answer']}\n{recommendation(comparison)}")
    with watch.step("drawing"):
        objects = list(drawn_objects(unseen, rows, model, demo))
        gallery = write_gallery(demo.out / "pictures", demo.backend, demo.seed)
    write_text(demo.out / "evaluation.json", json.dumps(about | {"results": results}, indent=2))
    summary = Summary(
        data=DATA,
        objects=len(simulated.objects),
        results=results,
        confusion=confusion,
        classified=objects,
        figure=opened(gallery[-1]),
        comparison=comparison,
        configuration=configuration(demo, simulator, simulated),
        seconds=watch.seconds,
    )
    return write_text(demo.out / "report.html", page(summary))


def simulate_all(dataset: Dataset, simulator, demo: Demo) -> Simulated:
    """Return the data set with its settled spheres."""
    failures = Failures()
    return simulate_dataset(
        dataset, simulator, demo.radii, seed=demo.seed, jobs=demo.jobs, failed=failures.add
    )


def evaluated(simulated: Simulated, demo: Demo) -> tuple[list[dict], Confusion]:
    """Return the protocols' results, and who was taken for what when left out."""
    method, labels = find_method(demo.method), labels_of(simulated)
    features, methods = all_features(simulated, demo.radii, method)
    count = len(simulated.objects)
    options = Options(wanted_sizes(TRAIN_SIZES, count), demo.trials, demo.seed, leave_one_out=False, groups=False)
    scores, _ = pooled_scores(features["spheres"], labels, leave_one_out(count, demo.seed), method)
    return protocols(features, labels, options, methods), count_confusion(labels, scores)


def write_unseen(folder: Path, learnt: Simulated) -> list[DatasetObject]:
    """Write the objects to be classified and return them; refuse one that was learnt.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    made = {item.name: item for item in make_catalogue(DATA, seed=UNSEEN_SEED)}
    write_catalogue([made[name] for name in UNSEEN], folder, f"{DATA}, seed {UNSEEN_SEED}")
    unseen = open_dataset(folder).objects
    known = {each.path.read_bytes() for each in learnt.objects}
    for each in unseen:
        if each.path.read_bytes() in known:
            raise RuntimeError(f"{each.path.name} is one of the training objects")
    return list(unseen)


def print_results(about: dict, results: list[dict], rows: list[dict], model: FunctionClassifier):
    """Print the evaluation and what the objects are for."""
    report(about, results, False)
    print()
    print_functions(rows, model.functions_, False)


def drawn_objects(
    unseen: Sequence[DatasetObject], rows: list[dict], model: FunctionClassifier, demo: Demo
) -> Iterator[ClassifiedObject]:
    """Yield each classified object with its picture, which is also written beside the page."""
    pairs = zip(unseen, rows, strict=True)
    for each, row in progress(pairs, len(rows), "drawing objects"):
        picture, radius, settled = draw_object(each.path, model, demo)
        write_png(picture, demo.out / "pictures" / f"{each.path.stem}.png")
        scores = {name: function["score"] for name, function in row["functions"].items()}
        decided = row["neighbors"][max(scores, key=scores.get)]
        yield ClassifiedObject(
            name=each.path.stem.replace("_", " "),
            functions=each.functions,
            also=each.also,
            scores=scores,
            predicted=frozenset(name for name, function in row["functions"].items() if function["member"]),
            nearest=max(decided, key=lambda neighbor: neighbor["weight"])["name"],
            picture=picture,
            radius=radius,
            settled=settled,
        )


def draw_object(path: Path, model: FunctionClassifier, demo: Demo):
    """Return a picture of an object with its settled spheres, their radius in metres and their number."""
    cloud = load_cloud(path)
    radius = min(demo.radii, key=lambda each: abs(each * SPHERES_ACROSS - cloud.size.max()))
    centers = settle(cloud, model.simulator, [radius], demo.seed)[radius]
    geometry = read_geometry(path)
    view = View(size=SIZE, cut=bool(cloud.size.max() < CUT_BELOW))
    return render(placed(geometry.vertices), geometry.faces, centers, radius, view), radius, len(centers)


def configuration(demo: Demo, simulator, simulated: Simulated) -> dict[str, str]:
    """Return what decides the results, for people."""
    drops = sum(sum(record.drops.values()) for record in simulated.records)
    return {
        "backend": f"{simulator.name}, version {simulator.version}",
        "its options": ", ".join(f"{name} = {value}" for name, value in simulator.options().items()) or "none",
        "method": find_method(demo.method).name,
        "radii of the spheres": ", ".join(map(format_length, demo.radii)),
        "objects learnt": f"{len(simulated.objects)}, catalogue {simulated.name}, seed 0",
        "objects classified": f"{len(UNSEEN)}, catalogue {DATA}, seed {UNSEEN_SEED}",
        "spheres dropped": f"{drops:,}",
        "trials": f"{demo.trials}, seed {demo.seed}",
    } | machine()


def opened(path: Path):
    """Return an image file as an RGB image."""
    from PIL import Image

    return Image.open(path).convert("RGB")


def write_text(path: Path, text: str) -> Path:
    """Write a text file and return its path."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: expected a file that can be written; {error.strerror}") from error
    return path


def main():
    """Run the demo and say where the page is."""
    parser = argparse.ArgumentParser(
        prog="python -m spherefunc_bullet.compare.demo", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--out", type=Path, default=Path("demo"), help="folder for everything that is written")
    parser.add_argument("--backend", default="fast", help="which simulator drops the spheres")
    parser.add_argument("--jobs", type=int, default=-1, help="processes that work at once; -1: one per core")
    options = parser.parse_args()
    path = run_demo(Demo(out=options.out, backend=options.backend, jobs=options.jobs))
    print(f"\nThe report is in {path}, that on the simulators in {path.parent / 'comparison' / 'report.html'}.")


def compare_some(data: str, out: Path, jobs: int) -> dict:
    """Write objects of a catalogue and the report of a comparison on them, and return the report.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    folder = out / "objects"
    write_catalogue(evenly(make_catalogue(data), OBJECTS), folder, f"{OBJECTS} of {data}")
    experiment = Experiment(
        data=str(folder), backends=usable_backends(BACKENDS), radii={"all": RADII}, repeated=AGAIN
    )
    contest = hold(open_dataset(folder), contestants(experiment), experiment, jobs, Failures())
    experiment = settled_experiment(experiment, contest)
    found = compare_entries(contest, experiment)
    write_report(out, found, contest, experiment)
    return found
