"""``spherefunc rooms``: how well rooms are segmented and labelled, measured on virtual ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from spherefunc_bullet.commands.options import Backend, Jobs, Json, Method, Radii, Seed, drop_config
from spherefunc_bullet.console import Failures, print_json, print_table
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import BY_FILE, parse_length, parse_numbers
from spherefunc_bullet.scenes.commands.dataset import Fused, LivedInText, Points
from spherefunc_bullet.scenes.commands.scene import Completion, Proposals

if TYPE_CHECKING:
    from ..rooms.matching import Row
    from ..rooms.trials import Condition

SCAN = ("scan", "noise")  # columns of every table
QUALITIES = (("f_measure", "precision", "recall"), ("f_measure_cut_out", "f_measure_whole"))


def rooms(
    data: Annotated[str, typer.Argument(metavar="DATA", help="Meshes: a folder with manifest.csv, or a catalogue.")],
    model: Annotated[
        Path | None,
        typer.Option(help="A model file. Without one, each half of DATA is classified by a model of the other."),
    ] = None,
    count: Annotated[int, typer.Option("--rooms", min=1, help="How many rooms.")] = 12,
    views: Annotated[str, typer.Option(help="Scans of each room: fused views, or whole surfaces.")] = "whole,1,2,3,5",
    noise: Annotated[str, typer.Option(help="Noise of the views as multiples of a Kinect's, such as 0,1,2.")] = "1",
    lived_in: LivedInText = None,
    fused: Fused = None,
    points: Points = None,
    tolerance: Annotated[str, typer.Option(help="Largest distance between neighbours of one cluster.")] = "2cm",
    completion: Completion = None,
    proposals: Proposals = None,
    cut_out: Annotated[bool, typer.Option("--cut-out", help="Also classify objects cut out by ground truth.")] = False,
    backend: Backend = "fast",
    radii: Radii = None,
    method: Method = "cubes",
    seed: Seed = 0,
    report: Annotated[Path | None, typer.Option(help="Folder for rooms.json, the plot and its numbers.")] = None,
    jobs: Jobs = -1,
    json: Json = False,
):
    """Scan virtual rooms, segment and classify the scans, and compare with the ground truth."""
    from spherefunc_bullet.datasets.dataset import open_dataset
    from spherefunc_bullet.formats.files import prepare_folder
    from spherefunc_bullet.scenes.recognition.completion import steps_of
    from spherefunc_bullet.scenes.recognition.proposals import kinds_of
    from spherefunc_bullet.scenes.segmentation.segmentation import Segmentation
    from spherefunc_bullet.scenes.virtual_rooms.lived_in import parse_lived_in
    from spherefunc_bullet.scenes.virtual_rooms.scans import Resolution
    from spherefunc_bullet.simulator import make_simulator

    from ..rooms.folds import TrainingOptions, two_folds, whole_fold
    from ..rooms.trials import RoomTrial, run_trial

    failures, dataset, steps = Failures(), open_dataset(data), steps_of(completion)
    prepare_folder(report)
    trial = RoomTrial(
        rooms=count,
        conditions=conditions(views, noise),
        seed=seed,
        settings=Segmentation(cluster_tolerance=parse_length(tolerance)),
        completion=steps,
        cut_out=cut_out,
        proposals=kinds_of(proposals),
        lived_in=parse_lived_in(lived_in),
        resolution=Resolution(leaf=parse_length(fused) if fused else None, points=points),
    )
    how = drop_config(backend, None, radii, seed, BY_FILE, "m", method)
    training = TrainingOptions(drop_config=how, completion=steps, method=method)
    folds = [whole_fold(dataset, model)] if model else two_folds(dataset, training, failures.add, jobs)
    counts = run_trial(folds, trial, failures.add, jobs)
    about = {
        "data": dataset.name,
        "model": str(model) if model else "the other half",
        "backend": make_simulator(folds[0].model.simulator).name,
        "tolerance": trial.settings.cluster_tolerance,
        "completion": list(trial.completion),
        "proposals": list(trial.proposals),
        "lived_in": asdict(trial.lived_in),
        "resolution": asdict(trial.resolution),
        "seed": seed,
    }
    show(about, [total.row(condition) for condition, total in counts.items()], report, json)
    failures.exit()


def show(about: Row, measured: Sequence[Row], report: Path | None, json: bool):
    """Print the results, and write the report."""
    if report is not None:
        from ..rooms.benchmark import write_report

        write_report(report, about, measured)
    if json:
        print_json(about | {"conditions": measured})
        return
    parts, labels, times, stages = [], [], [], list(measured[0]["seconds"])
    for row in measured:
        scan, found = [row["views"], f"{row['noise']:g}"], row["segmentation"]
        counts = [row["rooms"], f"{row['points'] // row['rooms']:,}", row["objects"], row["hidden"], found["hits"]]
        parts.append([*scan, *counts, figure(found["recall"]), figure(found["precision"])])
        for function, quality in row["functions"].items():
            sure = f"{quality['true_sure_claims']}/{quality['sure_claims']}"
            of_scan, of_others = ([figure(quality[name]) for name in names] for names in QUALITIES)
            labels.append([*scan, function, *of_scan, sure, *of_others])
        seconds = [*(row["seconds"][name] for name in stages), sum(row["seconds"].values())]
        times.append([*scan, *(f"{value:.2f}" for value in seconds)])
    print_table(title_of(about), [*SCAN, "rooms", "points", "objects", "hidden", "found", "recall", "precision"], parts)
    head = [*SCAN, "function", "F", "precision", "recall", "sure ones true", "F, cut out by truth", "F, whole models"]
    print_table("\nFunctions", head, labels)
    print_table("\nSeconds a room", [*SCAN, *stages, "all"], times)


def title_of(about: Row) -> str:
    """Return in a sentence what was measured, and how."""
    kinds = ", ".join(f"{name} in {share:.0%}" for name, share in about["lived_in"].items() if share)
    rooms = f"Rooms of {about['data']}, {about['backend']}, learnt from {about['model']}"
    how = f"completion {'+'.join(about['completion']) or 'none'}, tolerance {100 * about['tolerance']:g} cm"
    return f"{rooms}; {how}{f'; {kinds} of the rooms' if kinds else ''}. Objects at IoU 0.5"


def figure(value: float | None) -> str:
    """Return a figure for a table; a dash if there is none."""
    return "–" if value is None else f"{value:.3f}"


def conditions(views: str, noise: str) -> tuple[Condition, ...]:
    """Return every number of views with every noise; whole surfaces once, without noise.

    Raises
    ------
    InputError
        If a list is not valid.
    """
    from spherefunc_bullet.scenes.virtual_rooms.scans import parse_views

    from ..rooms.trials import Condition

    expected = "numbers from 0, such as 0,1,2"
    numbers, levels = [parse_views(view) for view in views.split(",")], parse_numbers("--noise", noise, expected)
    if not all(0.0 <= level < math.inf for level in levels):
        raise InputError(f"--noise {noise!r}: expected {expected}")
    pairs = [(number, level) for number in numbers for level in ([0.0] if number is None else levels)]
    return tuple(Condition(views=number, noise=level) for number, level in pairs)
