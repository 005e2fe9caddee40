"""``spherefunc batch``: a long headless run that can be resumed, and ``spherefunc batch merge``."""

from __future__ import annotations

import time
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer.core import TyperGroup

from ..console import INTERRUPTED, Failures, as_options, print_json, print_table, progress, say, show, with_path
from ..errors import InputError
from . import options

if TYPE_CHECKING:
    from ..batch.batch import Batch


class RunOrMerge(TyperGroup):
    """A group whose default command is ``run``: all arguments that do not begin with ``merge`` are those of a run."""

    def parse_args(self, ctx: typer.Context, args: list[str]) -> list[str]:
        return super().parse_args(ctx, args if args[:1] == ["merge"] else ["run", *args])


HELP = "Simulate a data set; can be resumed, and survives crashes. `batch merge` joins runs."
app = typer.Typer(cls=RunOrMerge, help=HELP)
Run = Annotated[Path, typer.Option("--run", metavar="DIR", help="Folder for the run's ledger and settled spheres.")]


@app.command("run", hidden=True)
def run(
    context: typer.Context,
    folder: Run,
    data: Annotated[
        str | None, typer.Argument(metavar="[DATA]", help="A folder with manifest.csv, or a catalogue's name.")
    ] = None,
    backend: options.Backend = "fast",
    shape: options.Shape = None,
    method: options.Method = options.DEFAULT_METHOD,
    radii: options.Radii = None,
    seed: options.Seed = 0,
    miss_limit: options.MissLimit = None,
    up: options.Up = options.BY_FILE,
    units: options.Units = "m",
    package_path: options.PackagePath = None,
    jobs: options.Jobs = -1,
    time_limit: Annotated[
        str | None, typer.Option(help="Time limit per object, all radii together: 90s, 30min, 2h. Two attempts.")
    ] = None,
    memory_limit: Annotated[str | None, typer.Option(help="Memory limit per worker process: 800MiB, 4GiB.")] = None,
    shard: Annotated[str | None, typer.Option(help="Part i of n of the objects, such as 3/8.")] = None,
    scheduler: Annotated[str | None, typer.Option(help="Address of a Dask scheduler: tcp://host:8786.")] = None,
    shared_path: Annotated[
        bool, typer.Option("--shared-path", help="The workers can read DATA at the same path; else files are sent.")
    ] = False,
    retry_failed: Annotated[bool, typer.Option("--retry-failed", help="Try objects again that failed before.")] = False,
    status: Annotated[
        bool, typer.Option("--status", help="Print the progress of the run, also while it runs.")
    ] = False,
    json: options.Json = False,
):
    """Simulate every object of DATA at every radius and save the results in DIR; call again to continue.

    An object that crashes its process, or takes too long or too much memory, is tried twice and then recorded as
    failed; the others continue. Shards and runs of other machines are joined by: spherefunc batch merge SHARD... --run
    DIR.
    """
    if status:
        given = {name for name in context.params if context.get_parameter_source(name).name == "COMMANDLINE"}
        for unused in sorted(given - {"folder", "status", "json"}):
            option = "DATA" if unused == "data" else f"--{unused.replace('_', '-')}"
            raise InputError(f"{option}: expected without --status")
        show_status(folder, json)
        return
    if data is None:
        raise InputError("batch: expected DATA, a data set to simulate, or --status; got neither")
    here, far = {"--jobs": None if jobs == -1 else jobs}, {"--shared-path": shared_path or None}
    options.require_beside("--scheduler", scheduler is not None, here, far)
    from ..batch.batch import Batch, ObjectLimits
    from ..batch.folder import RunFolder
    from ..datasets.dataset import open_dataset, parse_shard, require_no_label, shard_of
    from ..formats.units import parse_duration, parse_memory

    limits = ObjectLimits(seconds=parse_duration(time_limit), memory=parse_memory(memory_limit))
    how = options.drop_config(backend, shape, radii, seed, up, units, method, miss_limit)
    part = parse_shard(shard)
    dataset = open_dataset(data)
    require_no_label(f"--run {folder}", folder / "settled", Path(data))
    batch = Batch(dataset=shard_of(dataset, part), drop_config=how, folder=RunFolder(folder))
    context = nullcontext()
    if scheduler is not None:
        from ..batch.cluster import on_scheduler

        context = on_scheduler(scheduler, batch.folder, limits, shared_path=shared_path)
    with context as work:
        run_and_report(batch, json, jobs=jobs, limits=limits, retry_failed=retry_failed, work=work)


def run_and_report(batch: Batch, json: bool, **how):
    """Run a batch and report the result; Ctrl-C ends it at once and keeps all finished objects."""
    from ..batch.batch import run_batch

    started, failures, interrupted = time.perf_counter(), Failures(), False
    counts = {"done": 0, "failed": 0, "skipped": 0}
    try:
        doing = f"dropping spheres on {batch.dataset.name}"
        for finished in progress(run_batch(batch, **how), len(batch.objects), doing):
            counts["failed" if finished.errors else "skipped" if finished.skipped else "done"] += 1
            for error in finished.errors:
                failures.add(with_path(InputError(error), finished.name))
    except KeyboardInterrupt:
        interrupted = True
        say("spherefunc: stopped; finished objects are kept, and the same command continues")
    summary = counts | {"seconds": round(time.perf_counter() - started, 3)}
    print_json(summary) if json else say(", ".join(f"{name} {value}" for name, value in summary.items()))
    if interrupted:
        raise typer.Exit(INTERRUPTED)
    failures.exit()


def show_status(folder: Path, json: bool):
    """Print the progress of a run."""
    from ..batch.folder import RunFolder, status
    from ..formats.units import format_duration, format_memory

    with RunFolder(folder).ledger() as ledger:
        about = status(ledger)
    for failure in about["failures"]:
        failure["error"] = as_options(failure["error"])
    if json:
        print_json(about)
        return
    if about["waiting"] and about["running"] is False:
        left = "none: nothing runs, it ended or was killed; run the same command to go on"
    else:
        left = "unknown" if about["seconds_left"] is None else format_duration(about["seconds_left"])
    rate = "unknown" if about["rate"] is None else f"{about['rate']:.3g} runs/s"
    show(f"{about['done']} of {about['objects']} objects done, {about['failed']} failed, {about['waiting']} waiting")
    totals = f"{format_duration(about['seconds'])} of simulation, {format_memory(about['bytes'])} of centres kept"
    show(f"rate {rate}, time left {left}; {totals}")
    if about["failures"]:
        print_table("Failures", ["object", "outcome", "why"], [list(failure.values()) for failure in about["failures"]])


@app.command()
def merge(
    shards: Annotated[list[Path], typer.Argument(metavar="SHARD...", help="Run directories.")],
    folder: Run,
    json: options.Json = False,
):
    """Merge the ledgers and results of several runs into one."""
    from ..batch.folder import RunFolder, merge_runs

    failures = Failures()
    merged = merge_runs([RunFolder(shard) for shard in shards], RunFolder(folder), failed=failures.add)
    print_json(merged) if json else say(", ".join(f"{name} {value}" for name, value in merged.items()))
    failures.exit()
