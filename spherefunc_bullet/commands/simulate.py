"""``spherefunc simulate``: drop spheres on objects."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..console import Failures, print_json, print_table, progress, say, shown_names, with_path
from ..errors import InputError
from ..formats.files import prepare_folder, unused_name, write_bytes
from ..formats.units import format_length, parse_lengths
from . import options

if TYPE_CHECKING:
    from ..clouds.cloud import Cloud
    from ..simulator import DropResult, DropSettings, Simulator

Summary = dict[str, Any]  # JSON entry of one run
Run = tuple[Summary, "DropResult"]
COUNTS = ("drops", "settled", "rolled_off", "rejected", "timed_out")


def simulate(
    files: options.Files,
    radius: Annotated[str, typer.Option(help="Sphere radius, such as 1cm, 5mm or 0.01; several with commas.")] = "1cm",
    backend: options.Backend = "fast",
    shape: options.Shape = None,
    seed: options.Seed = 0,
    out: Annotated[
        Path | None,
        typer.Option(help="Write one .npz with the settled centres per object and radius into this folder."),
    ] = None,
    cores: Annotated[int | None, typer.Option(min=1, help="Number of cores for one large object.")] = None,
    max_spheres: options.MaxSpheres = 5_000_000,
    miss_limit: options.MissLimit = None,
    up: options.Up = options.BY_FILE,
    units: options.Units = "m",
    package_path: options.PackagePath = None,
    json: options.Json = False,
):
    """Drop spheres on each object and count how many settle."""
    from ..processes.tasks import run_tasks
    from ..simulator import MISS_LIMIT, DropSettings, isolated, make_simulator

    simulator = make_simulator(backend, **options.simulator_options(shape=shape, cores=cores))
    limits = {"miss_limit": MISS_LIMIT if miss_limit is None else miss_limit, "max_spheres": max_spheres}
    runs = [DropSettings(radius=length, **limits) for length in parse_lengths(radius)]
    prepare_folder(out)
    failures, rows, written = Failures(), [], []
    tasks = [(file, simulator, runs, seed, up, units) for file in files]
    outcomes = run_tasks(drop_on_file, tasks, files, isolate=isolated(simulator))
    for index, outcome in progress(outcomes, len(files), "dropping"):
        done, error = ([], outcome) if isinstance(outcome, InputError) else outcome
        rows += [row for row, _ in done]
        try:
            save_results(done, out, files[index], written)
        except InputError as unsaved:
            error = unsaved
        if error is not None:
            failures.add(with_path(error, files[index]))
    print_json(rows) if json else print_summaries(rows)
    failures.exit()


def drop_on_file(
    file: Path, simulator: Simulator, runs: Sequence[DropSettings], seed: int, up: str, units: str
) -> tuple[list[Run], InputError | None]:
    """Return the summary and the result of each run on a file up to the first error, and that error."""
    from ..clouds.cloud import load_cloud
    from ..settling.settling import warm_up, warn_of_gaps
    from ..simulator import drop_on

    done = []
    try:
        cloud = load_cloud(file, up=up, units=units, report=say)
        warm_up(simulator)  # so that the seconds do not include compilation
        warn_of_gaps(cloud, min(settings.radius for settings in runs), say)
        for settings in runs:
            result = drop_on(cloud, simulator, settings, seed)
            done.append((summary(file, cloud, result), result))
    except InputError as error:
        return done, error
    return done, None


def save_results(done: list[Run], folder: Path | None, file: Path, written: list[Path]):
    """Write the settled centres of the runs on a file, with their provenance; nothing without a folder."""
    import json

    import numpy as np

    from ..formats.npz import packed

    for row, result in done if folder is not None else []:
        radius = format_length(row["radius"]).replace(" ", "")
        path = unused_name(folder, f"{file.stem}_{row['backend']}_r{radius}", ".npz", written)
        written.append(path)
        about = {"bounding_box": np.array(row["bounding_box"]), "provenance": np.array(json.dumps(result.provenance))}
        write_bytes(path, packed({"centers": result.centers, "on_object": result.on_object} | about))


def summary(file: Path, cloud: Cloud, result: DropResult) -> Summary:
    """Return the JSON entry of one run."""
    provenance = result.provenance
    return {
        "file": str(file),
        "backend": provenance["backend"],
        "radius": provenance["settings"]["radius"],
        "seed": provenance["seed"],
        "points": len(cloud.points),
        **{name: getattr(result, name) for name in COUNTS},
        "stop": result.stop.name.lower(),
        "seconds": round(result.seconds, 4),
        "bounding_box": cloud.bounds.tolist(),
        "provenance": provenance,
    }


def print_summaries(rows: list[Summary]):
    """Print runs as a table."""
    names, shown = ("points", *COUNTS, "seconds"), shown_names(row["file"] for row in rows)
    table = []
    for row in rows:
        table.append([shown[row["file"]], format_length(row["radius"]), *(str(row[name]) for name in names)])
    if table:
        print_table(f"Spheres dropped by {rows[0]['backend']}", ["file", "radius", *names], table)
