"""``spherefunc compare``: simulators on the same objects, splits and seeds, accuracy against cost."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spherefunc_bullet.commands.options import Jobs, Json, MissLimit, RunDir
from spherefunc_bullet.console import INTERRUPTED, Failures, print_json, print_table, say, show
from spherefunc_bullet.errors import InputError

if TYPE_CHECKING:
    from ..comparison.experiment import Experiment
    from ..comparison.significance import Report


def compare(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder, a catalogue's name, or an experiment.toml.")],
    backends: Annotated[
        str | None,
        typer.Option(
            "--backends",
            "--backend",
            help="Simulators, such as fast,bullet:mesh,bullet:voxel. Default: fast,bullet, if installed.",
        ),
    ] = None,
    shapes: Annotated[str | None, typer.Option(help="Collision shapes, such as voxel,compound.")] = None,
    radii: Annotated[
        list[str] | None,
        typer.Option(
            help="Sphere radii: 2cm,3cm for all, or fast=1cm,2cm for one; may be repeated. Default: of the method."
        ),
    ] = None,
    trials: Annotated[int | None, typer.Option(min=1, help="Number of random equal splits. Default: 10.")] = None,
    methods: Annotated[
        str | None,
        typer.Option("--methods", "--method", help="profile; or cubes, paper or both; tables show the first."),
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Random seed of drops and splits. Default: 0.")] = None,
    repeated: Annotated[
        int | None, typer.Option(min=1, help="Objects simulated with a second seed. Default: all if fast, else 40.")
    ] = None,
    copied: Annotated[
        int | None, typer.Option(min=0, help="Number of objects of each function with impaired copies. Default: 4.")
    ] = None,
    tasks: Annotated[
        str | None, typer.Option(help="Tasks: labels, and also poses, standing, keeping, places. Default: labels.")
    ] = None,
    task_objects: Annotated[
        int | None, typer.Option(min=1, help="Maximum number of objects for each task other than labels. Default: 100.")
    ] = None,
    report: Annotated[
        Path | None, typer.Option(help="Folder for report.html, .json and .md, the charts and experiment.toml.")
    ] = None,
    miss_limit: MissLimit = None,
    up: Annotated[str | None, typer.Option(help="Axis of the files that points up. Default: z.")] = None,
    units: Annotated[str | None, typer.Option(help="Unit of the files' coordinates. Default: m.")] = None,
    jobs: Jobs = -1,
    run: RunDir = None,
    json: Json = False,
):
    """Compare simulators on the same objects: accuracy of classification, cost, and agreement."""
    from spherefunc_bullet.datasets.dataset import open_dataset
    from spherefunc_bullet.formats.files import prepare_folder

    from ..comparison.comparison import compare_entries, shares_of_copies, tasks_of
    from ..comparison.entries import repeatable, require_splittable, simulate_candidates
    from ..comparison.experiment import candidates, read_experiment
    from ..comparison.page import IMPAIRED, write_report
    from ..figures.impaired_picture import draw_impaired

    given = dict(backends=backends, shapes=shapes, radii=radii, trials=trials, methods=methods, seed=seed)
    given |= dict(repeated=repeated, copied=copied, miss_limit=miss_limit, up=up, units=units)
    given |= dict(tasks=tasks, task_objects=task_objects)
    given = {name: value for name, value in given.items() if value not in (None, [])}
    if data.endswith(".toml"):
        if given:  # which would make it another experiment
            options = " or --".join(given)
            raise InputError(f"{data}: expected no --{options} beside an experiment; write it into the file")
        experiment = read_experiment(Path(data))
    else:
        experiment = experiment_of(data, given)
    compared, dataset = candidates(experiment), open_dataset(experiment.data)
    require_splittable(dataset.name, dataset.objects)
    prepare_folder(report)
    failures = Failures()
    try:
        comparison = simulate_candidates(dataset, compared, experiment, jobs, failures, run)
        experiment = repeatable(experiment, comparison)
        shares = shares_of_copies(comparison, experiment, dataset, jobs=jobs) if experiment.copied else None
        figures = compare_entries(comparison, experiment, shares, tasks_of(experiment, compared, dataset))
    except KeyboardInterrupt:
        where = "the cache" if run is None else str(run)
        say(f"spherefunc: stopped; finished runs are kept in {where}, and the same command continues from there")
        raise typer.Exit(INTERRUPTED) from None
    if report is not None:
        if shares:
            draw_impaired(shares, report / IMPAIRED)
        write_report(report, figures, comparison, experiment)
    if json:
        print_json({name: value for name, value in figures.items() if name != "per_object"})
    else:
        print_report(figures)
    failures.exit()


def experiment_of(data: str, given: Mapping[str, Any]) -> Experiment:
    """Return the experiment that options describe.

    Named backends have to be installed; default ones that are not installed are left out, with a message.
    """
    from spherefunc_bullet.learning.method import PROFILE

    from ..comparison.experiment import BACKENDS, COPIED, Experiment, parse_radii, read_methods
    from ..machine import usable_backends

    values = {name: value for name, value in given.items() if name not in ("tasks", "seed", "radii")}
    values |= {name: names(name, given[name]) for name in ("backends", "shapes", "methods") if name in given}
    read_methods(list(values.get("methods", [PROFILE])))
    if "tasks" in given:
        values["tasks"] = parse_tasks(given["tasks"])
    if PROFILE in values.get("methods", [PROFILE]):  # full runs on copies would take hours
        values.setdefault("copied", COPIED)
    if "seed" in given:
        values["seeds"] = (given["seed"], given["seed"] + 1)
    if "radii" in given:
        values["radii"] = parse_radii(given["radii"])
    if "backends" not in values:
        values["backends"] = usable_backends(BACKENDS)
    return Experiment(data=data, **values)


def parse_tasks(text: str) -> tuple[str, ...]:
    """Return the tasks of a comma-separated list, labels among them."""
    from ..comparison.experiment import read_options_of

    try:
        return read_options_of(list(names("tasks", text)))
    except InputError as error:
        raise InputError(f"--tasks {text}: {error}") from error


def names(option: str, text: str) -> tuple[str, ...]:
    """Return the different names of a comma-separated list."""
    given = tuple(dict.fromkeys(part.strip() for part in text.split(",") if part.strip()))
    if not given:
        raise InputError(f"--{option} {text!r}: expected at least one name")
    return given


def print_report(report: Report):
    """Print the tables and the answer."""
    from ..comparison.tables import tables

    for table in tables(report):
        print_table(f"{table.title}\n", table.columns, table.rows)
        show()
    show("\n".join(f"{name}: {value}" for name, value in report["machine"].items()))
    show(f"\n{report['answer']}")
