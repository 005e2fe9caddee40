"""Real scans with known objects: how many of the functional ones are found, and how much of what is found is true.

``python -m spherefunc_bullet.compare.rooms.real_scans DATA`` prints it, for every scan of a folder, with the cause of
each miss and of each false claim, and beside it what baselines say of the same proposals (`--learnt`).
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from spherefunc_bullet.console import Failures, print_json, run, say, show
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.function_model import FunctionModel
from spherefunc_bullet.scenes.recognition.completion import steps_of
from spherefunc_bullet.scenes.recognition.proposals import kinds_of
from spherefunc_bullet.scenes.recognition.recognition import compile_kernels
from spherefunc_bullet.scenes.segmentation.segmentation import Segmentation

from .baselines import Baseline, baselines, learnt_objects
from .exam import exam_rows, print_exam
from .matching import score_of
from .scan_report import SPHERES, Pictures, print_causes, print_functions, print_scans
from .scan_trials import Measured, Trial, measure


def scan_files(data: Path, only: str) -> list[Path]:
    """Return the scans of a folder whose names hold one of some words.

    Raises
    ------
    InputError
        If there is none.
    """
    paths = sorted(file for file in data.glob("*.ply") if any(part in file.name for part in only.split(",")))
    if not paths:
        raise InputError(f"{data}: expected scans NAME.ply{f' with {only} in their names' if only else ''}, found none")
    return paths


def print_measured(measured: Measured):
    """Print all of it."""
    print_scans(measured.rows)
    print_functions(measured.readings, measured.inferred)
    print_causes(measured.misses, measured.false_claims)
    print_exam(exam_rows(measured.examined))
    score = score_of(measured.readings.get(SPHERES, ())).row()
    show(f"all: {score['found']} of {score['seen']} found, {score['found']} of {score['claims']} claims true")


def learnt_baselines(
    sources: str | None, model: FunctionModel, failed: Callable[[InputError], None]
) -> dict[str, Baseline]:
    """Return the baselines after learning some data sets, none without such; say where the model knows others."""
    if sources is None:
        return {}
    learnt = learnt_objects(sources.split(","), failed)
    if len(learnt.names) != len(model.names_):
        say(f"--learnt: {len(learnt.names)} objects, not the {len(model.names_)} that the model keeps")
    return baselines(learnt, model)


def main(
    data: Annotated[Path, typer.Argument(help="Folder of scans, with NAME_boxes.csv or NAME_instances.csv.")],
    model: Annotated[Path | None, typer.Option(help="A model file; without one, the model that ships.")] = None,
    backend: Annotated[str, typer.Option(help="Whose shipped model to use.")] = "fast",
    complete: Annotated[str | None, typer.Option(help="Some of smooth,top,bottom,sides,mirror; or none.")] = None,
    cluster_tolerance: Annotated[float, typer.Option(help="Metres.")] = Segmentation.cluster_tolerance,
    proposals: Annotated[str | None, typer.Option(help="What may be objects: clusters,pools, or one.")] = None,
    alone: Annotated[
        bool, typer.Option("--alone", help="Tell objects by spheres, not by what surrounds them.")
    ] = False,
    only: Annotated[str, typer.Option(help="Scans whose names hold this, or one of these.")] = "",
    points: Annotated[int | None, typer.Option(help="Take at most so many points, of scans known by boxes.")] = None,
    learnt: Annotated[str | None, typer.Option(help="Data sets that the model has learnt: adds baselines.")] = None,
    pictures: Annotated[Path | None, typer.Option(help="Folder for pictures, where the licence allows them.")] = None,
    review: Annotated[Path | None, typer.Option(help="Folder for pictures of all, with the truth, to look at.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
):
    """Measure recognition on real scans."""
    from spherefunc_bullet.learning.model_file import load_model, shipped_model
    from spherefunc_bullet.settling.settling import warm_up
    from spherefunc_bullet.simulator import make_simulator

    paths = scan_files(data, only)
    failures, measured, shown = Failures(), Measured(), Pictures(published=pictures, review=review)
    classifier = load_model(model or shipped_model(backend, scans=True))
    if alone:
        classifier.in_scenes_ = None
    trial = Trial(
        model=classifier,
        settings=Segmentation(cluster_tolerance=cluster_tolerance),
        completion=steps_of(complete),
        proposals=kinds_of(proposals),
        baselines=learnt_baselines(learnt, classifier, failures.add),
    )
    shown.prepare()
    warm_up(make_simulator(classifier.simulator))
    compile_kernels()
    for path in paths:
        try:
            measure(path, points, trial, shown, measured)
        except InputError as error:
            failures.add(error)
    print_json(measured.json()) if as_json else print_measured(measured)
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
