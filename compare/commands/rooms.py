"""``spherefunc rooms``: how well rooms are taken apart and labelled, measured on virtual ones."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from spherefunc_bullet.commands.options import DEFAULT_RADII, Backend, Jobs, Json, Method, Radii, Seed
from spherefunc_bullet.console import Failures, print_json, print_table, progress
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.quantities import parse_length, parse_lengths


def rooms(
    data: Annotated[str, typer.Argument(metavar="DATA", help="Meshes: a folder with manifest.csv, or a catalogue.")],
    model: Annotated[
        Path | None, typer.Option(help="A model file. Without one, each half of DATA is told by what the other taught.")
    ] = None,
    count: Annotated[int, typer.Option("--rooms", min=1, help="How many rooms.")] = 12,
    views: Annotated[str, typer.Option(help="Scans of each room: fused views, or whole surfaces.")] = "whole,1,2,3,5",
    noise: Annotated[str, typer.Option(help="Noise of the views, in times a Kinect's, such as 0,1,2.")] = "1",
    examples: Annotated[
        str, typer.Option(help="Learn whole models, partial views of them, both, or both-large: views of large ones.")
    ] = "both-large",
    tolerance: Annotated[str, typer.Option(help="Largest distance between neighbours of one cluster.")] = "2cm",
    large_tolerance: Annotated[str, typer.Option(help="Likewise, where a part is as large as furniture.")] = "5cm",
    completion: Annotated[
        str | None, typer.Option(help="What is done to objects: some of smooth,bottom,sides,mirror; or none.")
    ] = None,
    cut_out: Annotated[
        bool, typer.Option("--cut-out", help="Also tell functions of objects that the truth cuts out.")
    ] = False,
    backend: Backend = "fast",
    radii: Radii = DEFAULT_RADII,
    method: Method = "default",
    seed: Seed = 0,
    report: Annotated[Path | None, typer.Option(help="Folder for rooms.json, the plot and its numbers.")] = None,
    jobs: Jobs = -1,
    json: Json = False,
):
    """Furnish virtual rooms, scan them, take the scans apart, and compare with the truth."""
    from spherefunc_bullet.datasets.dataset import open_dataset
    from spherefunc_bullet.formats.writing import prepare_folder
    from spherefunc_bullet.scenes.recognition.completion import steps_of
    from spherefunc_bullet.scenes.segmentation.segmentation import Segmentation
    from spherefunc_bullet.simulator import make_simulator

    from ..rooms.lessons import Lesson, folds, told_by
    from ..rooms.trials import RoomTrial, run_trial

    failures, dataset, steps = Failures(), open_dataset(data), steps_of(completion)
    prepare_folder(report)
    trial = RoomTrial(
        rooms=count,
        conditions=conditions(views, noise),
        seed=seed,
        settings=Segmentation(
            cluster_tolerance=parse_length(tolerance), large_tolerance=parse_length(large_tolerance)
        ),
        completion=steps,
        cut_out=cut_out,
    )
    lesson = Lesson(
        simulator=make_simulator(backend),
        radii=tuple(parse_lengths(radii)),
        examples=one_of_examples(examples),
        completion=steps,
        method=method,
        seed=seed,
    )
    if model is None:
        parts = folds(dataset, lesson, failures.add, jobs)
    else:
        parts = [told_by(model, dataset, jobs)]
    found = run_trial(parts, trial, failures.add, lambda each: progress(each, count, "scanning rooms"), jobs)
    backend = make_simulator(parts[0].model.simulator).name
    about = {"data": dataset.name, "model": str(model) if model else f"the other half, {examples}", "backend": backend}
    used = trial.settings
    about |= {"tolerance": used.cluster_tolerance, "large_tolerance": used.large_tolerance}
    about |= {"completion": list(steps), "seed": seed}
    measured = [{"views": str(key), "noise": key.noise} | tally.row() for key, tally in found.items()]
    show(about, measured, report, json)
    failures.exit()


def show(about: dict, measured: list[dict], report: Path | None, json: bool):
    """Print what was measured, and write the report."""
    if report is not None:
        from ..rooms.curves import room_curves, write_report

        write_report(report, about, measured, room_curves(about, measured))
    if json:
        print_json(about | {"conditions": measured})
        return
    print_segmentation(about, measured)
    print_labels(measured)
    print_seconds(measured)


def print_segmentation(about: dict, measured: list[dict]):
    """Print how many objects were found."""
    steps = "+".join(about["completion"]) or "none"
    print_table(
        f"Rooms of {about['data']}, {about['backend']}, learnt from {about['model']}; completion {steps}, tolerance "
        f"{100 * about['tolerance']:g} cm. Objects at IoU 0.5",
        ["scan", "noise", "rooms", "points", "objects", "hidden", "found", "recall", "precision"],
        [
            [
                each["views"],
                f"{each['noise']:g}",
                str(each["rooms"]),
                f"{each['points'] // each['rooms']:,}",
                str(each["objects"]),
                str(each["hidden"]),
                str(each["segmentation"]["hits"]),
                figure(each["segmentation"]["recall"]),
                figure(each["segmentation"]["precision"]),
            ]
            for each in measured
        ],
    )


def print_labels(measured: list[dict]):
    """Print how well functions are told: from the scan, from objects cut out by the truth, and from whole models."""
    names = ("f_measure", "precision", "recall", "f_measure_cut_out", "f_measure_whole")
    print_table(
        "\nFunctions",
        ["scan", "noise", "function", "F", "precision", "recall", "F, cut out by truth", "F, whole models"],
        [
            [each["views"], f"{each['noise']:g}", name, *(figure(row[key]) for key in names)]
            for each in measured
            for name, row in each["functions"].items()
        ],
    )


def print_seconds(measured: list[dict]):
    """Print what each stage of recognition took, mean over rooms."""
    stages = list(measured[0]["seconds"])
    rows = [
        [each["views"], f"{each['noise']:g}", *(f"{each['seconds'][name]:.2f}" for name in stages)]
        + [f"{sum(each['seconds'].values()):.2f}"]
        for each in measured
    ]
    print_table("\nSeconds a room", ["scan", "noise", *stages, "all"], rows)


def figure(value: float | None) -> str:
    """Return a figure for a table; a dash where there is none."""
    return "–" if value is None else f"{value:.3f}"


def conditions(views: str, noise: str) -> tuple:
    """Return every number of views with every noise; whole surfaces once, without noise.

    Raises
    ------
    InputError
        If they are no such lists.
    """
    from spherefunc_bullet.scenes.virtual_rooms.scans import parse_views

    from ..rooms.trials import Condition

    numbers = [parse_views(each) for each in views.split(",")]
    try:
        levels = [float(each) for each in noise.split(",")]
    except ValueError:
        levels = [-1.0]
    if min(levels) < 0:
        raise InputError(f"--noise {noise}: expected numbers from 0, such as 0,1,2")
    return tuple(
        Condition(views=number, noise=level)
        for number in numbers
        for level in (levels if number is not None else [0.0])
    )


def one_of_examples(examples: str) -> str:
    """Return what to learn from, or raise InputError if it is none of the choices."""
    from ..rooms.lessons import EXAMPLES

    if examples not in EXAMPLES:
        raise InputError(f"--examples {examples}: expected one of {', '.join(EXAMPLES)}")
    return examples
