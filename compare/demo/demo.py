"""All steps on the built-in catalogue: simulate, evaluate, compare simulators, classify objects that were not learnt.

``spherefunc demo --out demo`` runs it, and so does ``make demo``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from PIL import Image

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.commands.classify import Row, classified_file, print_functions
from spherefunc_bullet.commands.train import train_on
from spherefunc_bullet.console import Failures, progress, say, show
from spherefunc_bullet.datasets.catalogue import make_catalogue, write_catalogue
from spherefunc_bullet.datasets.dataset import DatasetObject, open_dataset
from spherefunc_bullet.formats.files import prepare_folder, write_text
from spherefunc_bullet.formats.units import Stopwatch, format_length, parse_lengths
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.learning.method import METHODS, PROFILE
from spherefunc_bullet.learning.model_file import model_for_views
from spherefunc_bullet.settling.cached_runs import DropConfig, LoadOptions
from spherefunc_bullet.settling.settling import settle
from spherefunc_bullet.simulator import Simulator
from spherefunc_bullet.viewer.mechanics_pictures import write_picture
from spherefunc_bullet.viewer.pictures import SPHERES_ACROSS, CameraView, fitting_radius, object_picture

from ..comparison.comparison import compare_entries
from ..comparison.entries import repeatable, simulate_candidates
from ..comparison.experiment import BACKENDS, Experiment, candidates
from ..comparison.page import write_report
from ..comparison.recommendation import recommendation_sentence, recommendations
from ..comparison.significance import Report
from ..evaluation.evaluation import Confusion, count_confusion
from ..evaluation.impaired import impaired_copies, impaired_shares
from ..evaluation.protocol import Protocol, labels_of, wanted_sizes
from ..evaluation.readings import spheres_profiled
from ..evaluation.tables import Result, evaluate_features, print_results, results_of
from ..figures.impaired_picture import draw_impaired
from ..machine import machine, options_text, usable_backends
from .gallery import write_gallery
from .laid_table import write_laid_table
from .page import ClassifiedObject, Summary, page

DATA = "household"
UNSEEN_SEED = 7  # of the catalogue from which the classified objects come; training uses 0
MEMBERS = ("mug_02", "wine_glass_01", "dining_table_03", "coffee_table_02", "dining_chair_04", "sofa_02")
UNSEEN = (*MEMBERS, "filing_cabinet_01", "vase_01")  # the last two have no function
METHOD = METHODS[PROFILE]
DRAWN = parse_lengths("1cm,2cm,3cm,5cm")  # radii of the spheres in pictures, metres
SIZE = (320, 280)  # of an object's picture, pixels
COPIED = 3  # objects of each function with impaired copies
TRIALS = 2
AGAIN = 20  # objects simulated with a second seed
COMPARED_TRIALS = 6  # with 3, differences of 0.1 would not show
LEARNT = "20,half"  # training sizes of the table


@contextmanager
def step(watch: Stopwatch, name: str) -> Iterator[None]:
    """Print the name of a step, and time it."""
    say(f"{name} …")
    yield
    watch.lap(name)


def run_demo(out: Path, backend: str, jobs: int) -> Path:
    """Run all steps, write the report and return its path.

    Raises
    ------
    InputError
        If there is no such backend, or the folder cannot be written.
    """
    prepare_folder(out)
    watch, drop_config = Stopwatch(), DropConfig(simulator=backend, radii=METHOD.radii, run_limit=METHOD.run_limit)
    with step(watch, f"dropping spheres on the catalogue {DATA}"):
        simulated = simulate_dataset(open_dataset(DATA), drop_config, jobs=jobs, failed=Failures().add)
    with step(watch, "evaluating, beside baselines that need no spheres"):
        results, confusion = evaluated(simulated)
    with step(watch, "asking whether copies that look right still work"):
        how = {"copied": COPIED, "jobs": jobs, "failed": Failures().add}
        [copies] = impaired_copies([simulated], open_dataset(DATA), [drop_config], **how)
        shares = impaired_shares(copies, drop_config, METHOD)
    with step(watch, "learning all, and classifying objects that were not learnt"):
        model = train_on(simulated, drop_config, METHOD.name)
        unseen = write_unseen(out / "objects", simulated)
        models = [(model, partial(model_for_views, model, given=True))]
        rows = [classified_file(item.path, models, LoadOptions(up="z")) for item in unseen]
    with step(watch, "comparing simulators on the same objects"):
        comparison = compare_all(out / "comparison", jobs)
    about = dict(data=DATA, objects=len(simulated.objects), backend=backend, method=METHOD.name)
    print_results(about, results, False, shares)
    show()
    print_functions(rows, model.functions_, False)
    show(f"\n{comparison['answer']}\n{recommendation_sentence(recommendations(comparison))}")
    with step(watch, "drawing"):
        cards = list(drawn_objects(unseen, rows, model, out / "pictures"))
        impaired = draw_impaired(shares, out / "pictures" / "impaired.png")
        laid = write_laid_table(out / "pictures")
        gallery = write_gallery(out / "pictures", backend)
    write_text(out / "evaluation.json", json.dumps(about | {"results": results, "impaired": shares}, indent=2))
    summary = Summary(
        data=DATA,
        objects=len(simulated.objects),
        results=results,
        confusion=confusion,
        classified=cards,
        figure=Image.open(gallery[-1]).convert("RGB"),
        impaired=Image.open(impaired).convert("RGB"),
        laid=Image.open(laid).convert("RGB"),
        comparison=comparison,
        configuration=configuration(drop_config.simulator, simulated),
        seconds=watch.seconds,
    )
    return write_text(out / "report.html", page(summary))


def evaluated(simulated: Simulated) -> tuple[list[Result], Confusion]:
    """Return the results on random halves, and the confusion matrix with every object left out."""
    halves = Protocol(train_sizes=tuple(wanted_sizes(LEARNT, len(simulated.objects))), trials=TRIALS)
    results = results_of(evaluate_features(simulated, METHOD.radii, METHOD, halves))
    labels = labels_of(simulated)
    alone = Protocol(leave_one_out=True).splits(labels)
    evaluation = spheres_profiled(simulated, labels, METHOD.radii).evaluation(alone)
    return results, count_confusion(labels, *evaluation.left_out.values())


def write_unseen(folder: Path, learnt: Simulated) -> list[DatasetObject]:
    """Write the objects to be classified and return them, after a check that none was learnt.

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
    unseen: Sequence[DatasetObject], rows: Sequence[Row], model: CloudClassifier, folder: Path
) -> Iterator[ClassifiedObject]:
    """Yield each classified object with its picture, which is also written in a folder."""
    pairs = zip(unseen, rows, strict=True)
    for item, row in progress(pairs, len(rows), "drawing objects"):
        cloud = load_cloud(item.path)
        radius = fitting_radius(DRAWN, cloud.size, SPHERES_ACROSS)
        centers = settle(cloud, model.simulator, [radius], 0)[radius].rests
        picture = object_picture(cloud, centers, radius, CameraView(size=SIZE))
        write_picture(picture, folder / f"{item.path.stem}.png")
        functions = row["functions"].items()
        yield ClassifiedObject(
            name=item.path.stem.replace("_", " "),
            functions=item.functions,
            also=item.also,
            scores={name: function["score"] for name, function in functions},
            predicted=frozenset(name for name, function in functions if function["member"]),
            nearest=row["nearest"][0]["name"],
            reason=row["reasons"][0],
            picture=picture,
            radius=radius,
            settled=len(centers),
        )


def configuration(simulator: Simulator, simulated: Simulated) -> dict[str, str]:
    """Return the settings that decide the results, in words."""
    drops = sum(sum(record.drops.values()) for record in simulated.records)
    return {
        "backend": f"{simulator.name}, version {simulator.version}",
        "its options": options_text(simulator.options()),
        "method": METHOD.name,
        "radii of the spheres": ", ".join(map(format_length, METHOD.radii)),
        "objects learnt": f"{len(simulated.objects)}, catalogue {simulated.name}, seed 0",
        "objects classified": f"{len(UNSEEN)}, catalogue {DATA}, seed {UNSEEN_SEED}",
        "spheres dropped": f"{drops:,}",
        "trials": f"{TRIALS}, seed 0",
    } | machine()


def compare_all(out: Path, jobs: int) -> Report:
    """Write the report of a comparison on the whole catalogue, and return it.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    backends = usable_backends(BACKENDS)
    experiment = Experiment(data=DATA, backends=backends, trials=COMPARED_TRIALS, repeated=AGAIN)
    comparison = simulate_candidates(open_dataset(DATA), candidates(experiment), experiment, jobs, Failures())
    experiment = repeatable(experiment, comparison)
    report = compare_entries(comparison, experiment)
    write_report(out, report, comparison, experiment)
    return report
