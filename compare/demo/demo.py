"""The whole way on the built-in catalogue: simulate, evaluate, compare simulators, classify objects never seen.

    python -m spherefunc_bullet.compare.demo --out demo
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.commands.answer_tables import Row, print_functions
from spherefunc_bullet.commands.classify import classified
from spherefunc_bullet.commands.train import train_on
from spherefunc_bullet.console import Failures, progress, say
from spherefunc_bullet.datasets.catalogue import make_catalogue, write_catalogue
from spherefunc_bullet.datasets.dataset import DatasetObject, open_dataset
from spherefunc_bullet.formats.units import Stopwatch, format_length, parse_lengths
from spherefunc_bullet.formats.writing import write_text
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.learning.method import PROFILE, PROFILE_RADII, find_method
from spherefunc_bullet.settling.records import Dropping
from spherefunc_bullet.settling.settling import settle
from spherefunc_bullet.simulator import Simulator
from spherefunc_bullet.viewer.pictures import SPHERES_ACROSS, View, fitting_radius, object_picture

from ..comparison.comparison import compare_entries
from ..comparison.entries import evenly, repeatable, simulate_candidates
from ..comparison.experiment import BACKENDS, Experiment, candidates
from ..comparison.files import write_report
from ..comparison.recommendation import recommendation_sentence, recommendations
from ..comparison.report import Report
from ..evaluation.confusion import Confusion, count_confusion
from ..evaluation.impaired import Shares, impaired_shares
from ..evaluation.profiled import spheres_profiled
from ..evaluation.protocol import Protocol, labels_of
from ..evaluation.results import Result, evaluate_features, results_of
from ..evaluation.sizes import wanted_sizes
from ..evaluation.tables import About, print_results
from ..figures.impaired_picture import draw_impaired
from ..machine import machine, options_text, usable_backends
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
OBJECTS = 60  # evenly spread over the catalogue, so in its proportions
AGAIN = 8  # of them dropped on with a second seed
COMPARED_TRIALS = 3
LEARNT = "20,half"  # training objects of the table; `spherefunc evaluate` has them all


@dataclass(frozen=True, kw_only=True)
class Demo:
    """What is run."""

    out: Path
    backend: str = "fast"
    radii: tuple[float, ...] = PROFILE_RADII  # metres
    drawn: tuple[float, ...] = parse_lengths("1cm,2cm,3cm,5cm")  # radii of the spheres in pictures, metres
    method: str = PROFILE
    copied: int = 3  # objects of each function, copies of which are made
    trials: int = 2
    seed: int = 0
    jobs: int = -1


@contextmanager
def step(watch: Stopwatch, name: str) -> Iterator[None]:
    """Say what is done, and time it."""
    say(f"{name} …")
    yield
    watch.lap(name)


def run_demo(demo: Demo) -> Path:
    """Do everything and return the page's path.

    Raises
    ------
    InputError
        If there is no such backend or method, or the folder cannot be written.
    """
    watch, length = Stopwatch(), find_method(demo.method).length
    dropping = Dropping(simulator=demo.backend, radii=demo.radii, seed=demo.seed, length=length)
    with step(watch, f"dropping spheres on the catalogue {DATA}"):
        simulated = simulate_dataset(open_dataset(DATA), dropping, jobs=demo.jobs, failed=Failures().add)
    with step(watch, "evaluating, beside baselines that need no spheres"):
        results, confusion = evaluated(simulated, demo)
    with step(watch, "asking whether copies that look right still work"):
        shares = still_working(simulated, dropping, demo)
    with step(watch, "learning all, and classifying objects that were not learnt"):
        model = train_on(simulated, dropping, demo.method)
        unseen = write_unseen(demo.out / "objects", simulated)
        rows = [classified(item.path, model, True, "z", "m") for item in unseen]
    with step(watch, "comparing simulators on some of the objects"):
        comparison = compare_some(demo.out / "comparison", demo.jobs)
    about = About(data=DATA, objects=len(simulated.objects), backend=demo.backend, method=demo.method)
    print_results(about, results, False, shares)
    print()
    print_functions(rows, model.functions_, False)
    print(f"\n{comparison['answer']}\n{recommendation_sentence(recommendations(comparison))}")
    with step(watch, "drawing"):
        cards = list(drawn_objects(unseen, rows, model, demo))
        impaired = draw_impaired(shares, demo.out / "pictures" / "impaired.png")
        gallery = write_gallery(demo.out / "pictures", demo.backend, demo.seed)
    write_text(demo.out / "evaluation.json", json.dumps(about | {"results": results, "impaired": shares}, indent=2))
    summary = Summary(
        data=DATA,
        objects=len(simulated.objects),
        results=results,
        confusion=confusion,
        classified=cards,
        figure=Image.open(gallery[-1]).convert("RGB"),
        impaired=Image.open(impaired).convert("RGB"),
        comparison=comparison,
        configuration=configuration(demo, dropping.simulator, simulated),
        seconds=watch.seconds,
    )
    return write_text(demo.out / "report.html", page(summary))


def evaluated(simulated: Simulated, demo: Demo) -> tuple[list[Result], Confusion]:
    """Return the results on random halves, and who was taken for what when left out."""
    method, sizes = find_method(demo.method), wanted_sizes(LEARNT, len(simulated.objects))
    halves = Protocol(train_sizes=tuple(sizes), trials=demo.trials, seed=demo.seed)
    results = results_of(evaluate_features(simulated, demo.radii, method, halves))
    labels = labels_of(simulated)
    alone = Protocol(leave_one_out=True, seed=demo.seed).splits(labels)
    evaluation = spheres_profiled(simulated, labels, demo.radii).evaluation(alone)
    return results, count_confusion(labels, *evaluation.left_out.values())


def still_working(simulated: Simulated, dropping: Dropping, demo: Demo) -> Shares:
    """Return the share of impaired copies that are still called by their function, of some of the objects."""
    how = {"copied": demo.copied, "jobs": demo.jobs, "failed": Failures().add}
    return impaired_shares(simulated, open_dataset(DATA), dropping, demo.radii, find_method(demo.method), **how)


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
    known = {item.path.read_bytes() for item in learnt.objects}
    for item in unseen:
        if item.path.read_bytes() in known:
            raise RuntimeError(f"{item.path.name} is one of the training objects")
    return list(unseen)


def drawn_objects(
    unseen: Sequence[DatasetObject], rows: Sequence[Row], model: CloudClassifier, demo: Demo
) -> Iterator[ClassifiedObject]:
    """Yield each classified object with its picture, which is also written beside the page."""
    pairs = zip(unseen, rows, strict=True)
    for item, row in progress(pairs, len(rows), "drawing objects"):
        cloud = load_cloud(item.path)
        radius = fitting_radius(demo.drawn, cloud.size, SPHERES_ACROSS)
        centers = settle(cloud, model.simulator, [radius], demo.seed)[radius]
        picture = object_picture(cloud, centers, radius, View(size=SIZE))
        write_png(picture, demo.out / "pictures" / f"{item.path.stem}.png")
        scores = {name: function["score"] for name, function in row["functions"].items()}
        yield ClassifiedObject(
            name=item.path.stem.replace("_", " "),
            functions=item.functions,
            also=item.also,
            scores=scores,
            predicted=frozenset(name for name, function in row["functions"].items() if function["member"]),
            nearest=row["nearest"][0]["name"],
            reason=row["reasons"][0],
            picture=picture,
            radius=radius,
            settled=len(centers),
        )


def configuration(demo: Demo, simulator: Simulator, simulated: Simulated) -> dict[str, str]:
    """Return what decides the results, for people."""
    drops = sum(sum(record.drops.values()) for record in simulated.records)
    return {
        "backend": f"{simulator.name}, version {simulator.version}",
        "its options": options_text(simulator.options()),
        "method": find_method(demo.method).name,
        "radii of the spheres": ", ".join(map(format_length, demo.radii)),
        "objects learnt": f"{len(simulated.objects)}, catalogue {simulated.name}, seed 0",
        "objects classified": f"{len(UNSEEN)}, catalogue {DATA}, seed {UNSEEN_SEED}",
        "spheres dropped": f"{drops:,}",
        "trials": f"{demo.trials}, seed {demo.seed}",
    } | machine()


def compare_some(out: Path, jobs: int) -> Report:
    """Write objects of the catalogue and the report of a comparison on them, and return the report.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    folder = out / "objects"
    write_catalogue(evenly(make_catalogue(DATA), OBJECTS), folder, f"{OBJECTS} of {DATA}")
    backends = usable_backends(BACKENDS)
    experiment = Experiment(data=str(folder), backends=backends, trials=COMPARED_TRIALS, repeated=AGAIN)
    comparison = simulate_candidates(open_dataset(folder), candidates(experiment), experiment, jobs, Failures())
    experiment = repeatable(experiment, comparison)
    report = compare_entries(comparison, experiment)
    write_report(out, report, comparison, experiment)
    return report


def main():
    """Run the demo and say where the page is."""
    parser = argparse.ArgumentParser("python -m spherefunc_bullet.compare.demo", description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("demo"), help="folder for everything that is written")
    parser.add_argument("--backend", default="fast", help="which simulator drops the spheres")
    parser.add_argument("--jobs", type=int, default=-1, help="processes that work at once; -1: one per core")
    options = parser.parse_args()
    path = run_demo(Demo(out=options.out, backend=options.backend, jobs=options.jobs))
    print(f"\nThe report is in {path}, that on the simulators in {path.parent / 'comparison' / 'report.html'}.")
