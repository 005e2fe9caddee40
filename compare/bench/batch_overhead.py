"""What a batch adds to the work itself, and what a second process gains.

``python -m spherefunc_bullet.compare.bench.batch_overhead DATA`` does the same objects three ways, several times, in
turn: in a plain loop that reads, samples, simulates and keeps nothing; as a batch of one worker process; and of two.
That wants an idle machine. On a busy one ``--processor-time`` compares the loop with a worker's and the caller's work
in one process, by processor time: with hashing, packing, syncing and the ledger, without the messages between
processes.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from spherefunc_bullet.batch.batch import Batch, Outcomes, run_batch
from spherefunc_bullet.batch.folder import RunFolder
from spherefunc_bullet.batch.task import Task, settled_rows
from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.console import print_table, show
from spherefunc_bullet.datasets.dataset import Dataset, open_dataset, parse_shard, shard_of
from spherefunc_bullet.formats.units import parse_lengths
from spherefunc_bullet.settling.records import Dropping
from spherefunc_bullet.settling.settling import drop_settings, warm_up

from ..machine import machine


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


def main():
    """Print seconds, best of the rounds, and the two ratios that were aimed for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", nargs="?", default="household")
    parser.add_argument("--backend", default="fast")
    parser.add_argument("--radii", default="2cm")
    parser.add_argument("--shard", help="only these objects, such as 1/4")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--processor-time", action="store_true")
    given = parser.parse_args()
    dataset = shard_of(open_dataset(given.data), parse_shard(given.shard))
    dropping = Dropping(simulator=given.backend, radii=parse_lengths(given.radii))
    title = f"{dataset.name}, {len(dataset)} objects, {given.backend}, {given.radii}, best of {given.rounds}"
    if given.processor_time:
        print_processor_time(title, dataset, dropping, given.rounds)
        return
    ways = [plain_loop, partial(batch_seconds, jobs=1), partial(batch_seconds, jobs=2)]
    loops, one, two = zip(*[[way(dataset, dropping) for way in ways] for _ in range(given.rounds)], strict=True)
    loop, simulated = min(loops)
    (whole, steady), (whole_two, steady_two) = (map(min, zip(*pairs, strict=True)) for pairs in (one, two))
    rows = [["plain loop", f"{loop:.2f}", f"{simulated:.2f}"], ["batch, 1 process", f"{whole:.2f}", f"{steady:.2f}"]]
    rows += [["batch, 2 processes", f"{whole_two:.2f}", f"{steady_two:.2f}"]]
    print_table(title, ["", "seconds", "of them simulation, or without the start"], rows)
    show(f"a batch adds {steady / loop - 1:.1%} to the loop, two processes are {steady / steady_two:.2f} times one")
    show("\n".join(f"{name}: {value}" for name, value in machine().items()))


if __name__ == "__main__":
    main()
