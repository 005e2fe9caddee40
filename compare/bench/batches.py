"""What a batch adds to the work itself, what a second process gains, and what it would cost on larger data.

    python -m spherefunc_bullet.compare.bench batch_overhead DATA [--processor-time]
    python -m spherefunc_bullet.compare.bench cost_model --run DIR

Overhead: the same objects three ways, several times, in turn: in a plain loop that reads, samples, simulates and keeps
nothing; as a batch of one worker process; and of two. That wants an idle machine. On a busy one ``--processor-time``
compares the loop with a worker's and the caller's work in one process, by processor time: with hashing, packing,
syncing and the ledger, without the messages between processes. Costs are read from a finished run's ledger.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

from spherefunc_bullet.batch.batch import Batch, Outcomes, run_batch
from spherefunc_bullet.batch.folder import RunFolder
from spherefunc_bullet.batch.ledger import Ledger
from spherefunc_bullet.batch.task import Task, settled_rows
from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.console import print_table, show
from spherefunc_bullet.datasets.dataset import Dataset, open_dataset, parse_shard, shard_of
from spherefunc_bullet.formats.units import format_duration, format_length, format_memory, parse_lengths
from spherefunc_bullet.settling.records import Dropping
from spherefunc_bullet.settling.settling import drop_settings, warm_up

from .harness import print_machine

COLLECTIONS = {"ShapeNet": 51_300, "Objaverse": 800_000, "ten million": 10_000_000}
CORES = (1, 64, 4096)


def plain_loop(dataset: Dataset, dropping: Dropping) -> tuple[float, float]:
    """Return the seconds of the loop, compilation excluded, and those of the simulations in it."""
    simulator = dropping.simulator
    warm_up(simulator)
    load_cloud(dataset.objects[0].path)
    started, simulated = time.perf_counter(), 0.0
    for item in dataset.objects:
        cloud = load_cloud(item.path)
        settings = [drop_settings(simulator, radius) for radius in dropping.radii]
        simulated += sum(simulator.drop(cloud, run, 0).seconds for run in settings)
    return time.perf_counter() - started, simulated


def batch_seconds(dataset: Dataset, dropping: Dropping, jobs: int) -> tuple[float, float]:
    """Return the seconds of a batch: all of it, and from its first object's end to its last's.

    The latter is without the start of the processes, some seconds however long the run, and scaled to all objects.
    """
    with tempfile.TemporaryDirectory() as scratch:
        batch = Batch(dataset=dataset, dropping=dropping, folder=RunFolder(Path(scratch)))
        started, ends = time.perf_counter(), []
        for _ in run_batch(batch, jobs=jobs):
            ends.append(time.perf_counter())
    return ends[-1] - started, (ends[-1] - ends[jobs - 1]) * len(ends) / max(len(ends) - jobs, 1)


def processor_seconds(dataset: Dataset, dropping: Dropping) -> tuple[float, float]:
    """Return the processor seconds of the plain loop, and of a batch's work on the same objects in this process."""
    started = time.process_time()
    plain_loop(dataset, dropping)
    middle = time.process_time()
    with tempfile.TemporaryDirectory() as scratch:
        batch = Batch(dataset=dataset, dropping=dropping, folder=RunFolder(Path(scratch)))
        list(run_batch(batch, work=lambda tasks: in_this_process(tasks, batch.folder)))
    return middle - started, time.process_time() - middle


def in_this_process(tasks: Sequence[Task], folder: RunFolder) -> Outcomes:
    """Do tasks as a worker does, without one."""
    for index, task in enumerate(tasks):
        yield index, settled_rows(task, folder)


def print_processor_time(title: str, dataset: Dataset, dropping: Dropping, rounds: int):
    """Print processor seconds, best of the rounds, and what a batch adds."""
    plain_loop(shard_of(dataset, (1, len(dataset))), dropping)  # compiles and loads
    measured = [processor_seconds(dataset, dropping) for _ in range(rounds)]
    loop, batch = map(min, zip(*measured, strict=True))
    seconds = f"plain loop {loop:.2f} s, batch {batch:.2f} s of processor time"
    show(f"{title}: {seconds}; a batch adds {batch / loop - 1:.1%}")


def measure_overhead(
    data: Annotated[str, typer.Argument(metavar="DATA")] = "household",
    backend: str = "fast",
    radii: str = "2cm",
    shard: Annotated[str | None, typer.Option(help="Only these objects, such as 1/4.")] = None,
    rounds: Annotated[int, typer.Option(min=1, help="Of which the best counts.")] = 3,
    processor_time: Annotated[bool, typer.Option("--processor-time", help="In one process, by its time.")] = False,
):
    """Print seconds, best of the rounds, and the two ratios that were aimed for."""
    dataset = shard_of(open_dataset(data), parse_shard(shard))
    dropping = Dropping(simulator=backend, radii=parse_lengths(radii))
    title = f"{dataset.name}, {len(dataset)} objects, {backend}, {radii}, best of {rounds}"
    if processor_time:
        return print_processor_time(title, dataset, dropping, rounds)
    ways = [plain_loop, partial(batch_seconds, jobs=1), partial(batch_seconds, jobs=2)]
    loops, one, two = zip(*[[way(dataset, dropping) for way in ways] for _ in range(rounds)], strict=True)
    loop, simulated = min(loops)
    (whole, steady), (whole_two, steady_two) = (map(min, zip(*pairs, strict=True)) for pairs in (one, two))
    rows = [["plain loop", f"{loop:.2f}", f"{simulated:.2f}"], ["batch, 1 process", f"{whole:.2f}", f"{steady:.2f}"]]
    rows += [["batch, 2 processes", f"{whole_two:.2f}", f"{steady_two:.2f}"]]
    print_table(title, ["", "seconds", "of them simulation, or without the start"], rows)
    show(f"a batch adds {steady / loop - 1:.1%} to the loop, two processes are {steady / steady_two:.2f} times one")
    print_machine()


class Cost(NamedTuple):
    """What one radius of one backend cost in a run, an object on average."""

    backend: str
    radius: float  # metres
    objects: int
    seconds: float  # of simulation
    bytes: float  # of the file of the centres
    drops: float


def costs(ledger: Ledger) -> list[Cost]:
    """Return the mean costs by backend and radius, of the runs that were done."""
    sql = """SELECT backend, radius, count(*), avg(seconds), avg(bytes), avg(drops)
        FROM runs JOIN ways USING (way) WHERE outcome = 'done' GROUP BY backend, radius ORDER BY backend, radius"""
    return [Cost(*row) for row in ledger.query(sql)]


def bytes_per_row(ledger: Ledger) -> float:
    """Return what a row takes in the ledger, its index included."""
    ((rows,),) = ledger.query("SELECT count(*) FROM runs")
    ((pages, size),) = ledger.query("SELECT page_count, page_size FROM pragma_page_count, pragma_page_size")
    return pages * size / max(rows, 1)


def cost_rows(measured: Iterable[Cost]) -> list[list[str]]:
    """Return the table of measured costs."""
    return [
        [cost.backend, format_length(cost.radius), str(cost.objects), f"{cost.seconds:.3f}", f"{cost.drops:,.0f}"]
        + [format_memory(cost.bytes)]
        for cost in measured
    ]


def extrapolated(measured: list[Cost], overhead: float, row_bytes: float) -> list[list[str]]:
    """Return the table of larger collections, by backend, all radii of the run together.

    Parameters
    ----------
    overhead : float
        Seconds an object takes beside its simulations: reading, sampling, hashing.
    """
    rows = []
    for backend in dict.fromkeys(cost.backend for cost in measured):
        own = [cost for cost in measured if cost.backend == backend]
        seconds, size = sum(cost.seconds for cost in own) + overhead, sum(cost.bytes for cost in own)
        for name, count in COLLECTIONS.items():
            times = [format_duration(count * seconds / cores) for cores in CORES]
            files, ledger = format_memory(count * size), format_memory(count * len(own) * row_bytes)
            rows.append([f"{backend}, {name}", f"{count:,}", *times, files, f"{count * len(own):,}", ledger])
    return rows


def print_cost_model(
    run: Annotated[list[Path], typer.Option(metavar="DIR", help="A finished run; may be repeated.")],
    overhead: Annotated[float, typer.Option(help="Seconds an object takes beside its simulations.")] = 0.0,
):
    """Print the cost model of one run or several."""
    measured, sizes = [], []
    for folder in run:
        with RunFolder(folder).ledger() as ledger:
            measured += costs(ledger)
            sizes.append(bytes_per_row(ledger))
    columns = ["backend", "radius", "objects", "s/object", "drops", "file"]
    print_table("Measured, the mean of an object", columns, cost_rows(measured))
    cores = [f"{count:,} core{'s' * (count > 1)}" for count in CORES]
    columns = ["collection", "objects", *cores, "centres", "files", "ledger"]
    larger = extrapolated(measured, overhead, max(sizes))
    print_table(f"\nExtrapolated, {max(sizes):.0f} bytes a ledger row", columns, larger)
