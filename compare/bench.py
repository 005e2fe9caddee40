"""The simulator's speed on one core, beside a naive PyBullet script.

    python -m compare.bench [--quick] [--json] [--file PATH --radius 5mm]

Loading and compilation are not counted. Every object runs in a process of its own, so that peak memory is its own.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path

from spherefunc_bullet.catalogue import built_catalogue
from spherefunc_bullet.command_line import fail
from spherefunc_bullet.console import print_json, print_table, progress, say
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.lengths import format_length, parse_length

from .machine import machine
from .peer import peer_mug
from .timing import PeerTiming, StageTiming, Timing, time_peer, time_simulation, time_stages

OBJECTS = {  # of the catalogue: title, name, radius
    "mug": ("mug_01", "5mm"),
    "chair": ("shell_chair_01", "5mm"),
    "sofa": ("sofa_02", "5mm"),
    "table": ("dining_table_02", "1cm"),
}
STAGE_RADIUS = parse_length("1cm")
PEER_RADIUS = parse_length("5mm")
PEER_SECONDS = 30.0


@dataclass(frozen=True, kw_only=True)
class Case:
    """One object to be measured."""

    title: str
    path: Path
    radius: float  # metres


def cases(quick: bool) -> list[Case]:
    """Return the objects of the bench; a quick one does without the sofa, which takes longest."""
    folder = built_catalogue("household").parent
    chosen = [
        Case(title=f"{title} ({name})", path=folder / f"{name}.ply", radius=parse_length(radius))
        for title, (name, radius) in OBJECTS.items()
        if not (quick and title == "sofa")
    ]
    mug = peer_mug()
    return chosen if mug is None else [Case(title="mug (PyBullet's)", path=mug, radius=PEER_RADIUS), *chosen]


def apart(function, *arguments):
    """Return what a function returns in a fresh process."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def use_one_core():
    """Keep this process and those it starts to one core."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ[name] = "1"
    if hasattr(os, "sched_setaffinity"):  # Linux; elsewhere the variables have to do
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def measure(chosen: list[Case], backend: str, repeats: int) -> list[Timing]:
    """Return the simulation's timing of every case."""
    doing = progress(chosen, len(chosen), f"timing {backend}")
    return [apart(time_simulation, each.title, each.path, each.radius, backend, repeats) for each in doing]


def measure_stages(chosen: list[Case], backend: str, repeats: int) -> list[StageTiming]:
    """Return the timing of sampling, simulation and histogram, each file once."""
    doing = progress(chosen, len(chosen), "timing the stages")
    return [apart(time_stages, each.title, each.path, STAGE_RADIUS, backend, repeats) for each in doing]


def measure_peer() -> PeerTiming | None:
    """Return the naive script's timing on PyBullet's mug, or None where PyBullet is not installed."""
    mug = peer_mug()
    if mug is None:
        say("The naive PyBullet script is left out: PyBullet is not installed (pip install spherefunc-bullet[bullet]).")
        return None
    say(f"Running the naive PyBullet script for up to {PEER_SECONDS:g} s …")
    return apart(time_peer, mug, PEER_RADIUS, PEER_SECONDS)


def print_timings(timings: Iterable[Timing], backend: str):
    """Print the simulations' table."""
    head = ["object", "radius", "points", "settled", "drops", "best s", "median s", "drops/s", "settled/s", "peak MiB"]
    rows = [
        [
            each.title,
            format_length(each.radius),
            *(f"{count:,}" for count in (each.points, each.settled, each.drops)),
            *(f"{seconds:.3f}" for seconds in (each.best, each.median)),
            *(f"{rate:,.0f}" for rate in (each.drops / each.best, each.settled / each.best)),
            f"{each.peak_bytes / 2**20:,.0f}",
        ]
        for each in timings
    ]
    print_table(f"Simulation by {backend}, one core, compilation and loading excluded", head, rows)


def print_stages(stages: Iterable[StageTiming]):
    """Print what an object costs before and after its simulation."""
    rows = [
        [
            each.title,
            f"{each.points:,}",
            *(f"{1000 * seconds:.1f}" for seconds in (each.sampling, each.simulation, each.histogram)),
            f"{(each.sampling + each.histogram) / each.simulation:.2f}" if each.simulation else "",
        ]
        for each in stages
    ]
    head = ["object", "points", "sampling ms", "simulation ms", "histogram ms", "(sampling + histogram) / simulation"]
    print_table(f"\nStages of one object, spheres of {format_length(STAGE_RADIUS)}, best of the runs", head, rows)


def print_peer(peer: PeerTiming, ours: Timing, backend: str):
    """Print the naive script beside the same mesh in the backend."""
    end = "to the miss limit" if peer.finished else "stopped by the clock"
    naive, fast = peer.drops / peer.seconds, ours.drops / ours.best
    rows = [
        ["naive PyBullet script", f"{peer.drops:,}", f"{peer.settled:,}", f"{peer.seconds:.1f}", f"{naive:,.1f}", end],
        [backend, f"{ours.drops:,}", f"{ours.settled:,}", f"{ours.best:.4f}", f"{fast:,.0f}", "to the miss limit"],
    ]
    head = [f"the same mug, r = {format_length(PEER_RADIUS)}", "drops", "settled", "seconds", "drops/s", "ended"]
    print_table("\nThe peer", head, rows)
    print(f"{backend} drops {fast / naive:,.0f} times as many spheres a second.")


def arguments() -> argparse.Namespace:
    """Return the command's options."""
    parser = argparse.ArgumentParser(prog="python -m compare.bench", description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one run of each, without the sofa and the peer")
    parser.add_argument("--backend", default="fast", help="which simulator is measured")
    parser.add_argument("--file", type=Path, help="measure this file instead")
    parser.add_argument("--radius", default="5mm", help="of the spheres on --file")
    parser.add_argument("--json", action="store_true", help="print JSON on stdout instead of tables")
    return parser.parse_args()


def main():
    """Measure and print."""
    options = arguments()
    use_one_core()
    repeats = 1 if options.quick else 3
    radius = parse_length(options.radius)
    chosen = cases(options.quick)
    if options.file is not None:
        chosen = [Case(title=options.file.name, path=options.file, radius=radius)]
    timings = measure(chosen, options.backend, repeats)
    stages = measure_stages(chosen, options.backend, repeats)
    peer = None if options.quick or options.file is not None else measure_peer()
    if options.json:
        found = {"machine": machine(), "backend": options.backend, "repeats": repeats}
        found |= {"simulation": [asdict(each) for each in timings], "stages": [asdict(each) for each in stages]}
        print_json(found | {"peer": None if peer is None else asdict(peer)})
        return
    print_timings(timings, options.backend)
    print_stages(stages)
    if peer is not None:
        print_peer(peer, timings[0], options.backend)
    print("\n" + "\n".join(f"{name}: {value}" for name, value in machine().items()))


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(fail(error))
