"""The simulators' speed on one core.

    python -m spherefunc_bullet.compare.bench [--quick] [--json] [--backends fast,bullet] [--file PATH --radius 5mm]

Loading and compilation are not counted. Every object runs in a process of its own, so that peak memory is its own.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

from spherefunc_bullet.console import print_json, print_table, progress, show
from spherefunc_bullet.datasets.catalogue import built_catalogue
from spherefunc_bullet.formats.units import format_length, parse_length

from ..machine import machine, usable_backends
from .answers import print_answers
from .peer import peer_mug
from .timing import Case, Growth, StageTiming, Timing, time_growth, time_simulation, time_stages

Made = TypeVar("Made")
OBJECTS = {  # of the catalogue: title, name, radius
    "fast": [
        ("mug", "mug_01", "5mm"),
        ("chair", "shell_chair_01", "5mm"),
        ("sofa", "sofa_02", "5mm"),
        ("table", "dining_table_02", "1cm"),
    ],
    "bullet": [("mug", "mug_01", "5mm"), ("chair", "shell_chair_01", "2cm"), ("sofa", "sofa_02", "5cm")],
}
PLAIN_TABLE = "table of 1.2 x 0.8 m"
STAGE_RADIUS = {"fast": parse_length("1cm"), "bullet": parse_length("2cm")}
PEER_RADIUS = parse_length("5mm")
TABLE_RADIUS = parse_length("1cm")


def cases(backend: str, table: Path, quick: bool) -> list[Case]:
    """Return the objects of a backend's bench; a quick one does without the sofa, which takes longest."""
    folder = built_catalogue("household").parent
    chosen = [
        Case(title=f"{title} ({name})", path=folder / f"{name}.ply", radius=parse_length(radius))
        for title, name, radius in OBJECTS.get(backend, OBJECTS["fast"])
        if not (quick and title == "sofa")
    ]
    chosen.append(Case(title=PLAIN_TABLE, path=table, radius=TABLE_RADIUS))
    mug = peer_mug()
    return chosen if mug is None else [Case(title="mug (PyBullet's)", path=mug, radius=PEER_RADIUS), *chosen]


def write_plain_table(folder: Path) -> Path:
    """Write a table of 1.2 x 0.8 m on four legs, and return its path."""
    from spherefunc_bullet.scenes.household.parts.solids import box, join, shift

    legs = [shift(box(0.05, 0.05, 0.72), x, y) for x in (-0.56, 0.56) for y in (-0.36, 0.36)]
    path = folder / "plain_table.ply"
    join(shift(box(1.2, 0.8, 0.03), z=0.72), *legs).export(path)
    return path


def apart(function: Callable[..., Made], *arguments: object) -> Made:
    """Return what a function returns in a fresh process."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def use_one_core():
    """Keep this process and those it starts to one core."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ[name] = "1"
    if hasattr(os, "sched_setaffinity"):  # Linux; elsewhere the variables have to do
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def print_timings(timings: Iterable[Timing], backend: str):
    """Print the simulations' table."""
    head = ["object", "radius", "points", "settled", "drops", "best s", "median s", "drops/s", "settled/s", "peak MiB"]
    rows = [
        [
            timing.title,
            format_length(timing.radius),
            *(f"{count:,}" for count in (timing.points, timing.settled, timing.drops)),
            *(f"{seconds:.3f}" for seconds in (timing.best, timing.median)),
            *(f"{count / timing.best:,.0f}" for count in (timing.drops, timing.settled)),
            "" if timing.peak_bytes is None else f"{timing.peak_bytes / 2**20:,.0f}",
        ]
        for timing in timings
    ]
    print_table(f"Simulation by {backend}, one core, compilation and loading excluded", head, rows)


def print_stages(stages: Iterable[StageTiming], backend: str):
    """Print what an object costs before and after its simulation."""
    rows = [
        [
            stage.title,
            f"{stage.points:,}",
            *(f"{1000 * seconds:.1f}" for seconds in (stage.sampling, stage.simulation, stage.histogram)),
            f"{(stage.sampling + stage.histogram) / stage.simulation:.2f}" if stage.simulation else "",
        ]
        for stage in stages
    ]
    head = ["object", "points", "sampling ms", "simulation ms", "histogram ms", "(sampling + histogram) / simulation"]
    radius = format_length(STAGE_RADIUS.get(backend, STAGE_RADIUS["fast"]))
    print_table(f"\nStages of one object, {backend}, spheres of {radius}, best of the runs", head, rows)


def print_growth(growth: Growth, backend: str):
    """Print how much dearer a drop gets as spheres settle."""
    show(
        f"\n{backend}, {growth.title}, {growth.settled:,} settled: {1e3 * growth.first:.3f} ms a drop during the first "
        f"500 settled, {1e3 * growth.last:.3f} ms during the last 500: {growth.last / growth.first:.2f} times"
    )


@dataclass(frozen=True, kw_only=True)
class BackendBench:
    """What was measured of one backend."""

    simulation: list[Timing]
    stages: list[StageTiming]
    growth: Growth | None


def measure(chosen: list[Case], backend: str, repeats: int) -> BackendBench:
    """Measure one backend, each object in a process of its own."""
    radius = STAGE_RADIUS.get(backend, STAGE_RADIUS["fast"])
    timed = progress(chosen, len(chosen), f"timing {backend}")
    simulation = [apart(time_simulation, case, backend, repeats) for case in timed]
    staged = progress(chosen, len(chosen), "timing the stages")
    stages = [apart(time_stages, replace(case, radius=radius), backend, repeats) for case in staged]
    growth = [apart(time_growth, case, backend, repeats) for case in chosen if case.title == PLAIN_TABLE]
    return BackendBench(simulation=simulation, stages=stages, growth=growth[0] if growth else None)


def main():
    """Measure and print."""
    parser = argparse.ArgumentParser("python -m spherefunc_bullet.compare.bench", description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one run of each, without the sofa")
    parser.add_argument("--backends", default="fast,bullet", help="which simulators are measured")
    parser.add_argument("--file", type=Path, help="measure this file instead")
    parser.add_argument("--radius", default="5mm", help="of the spheres on --file")
    parser.add_argument("--json", action="store_true", help="print JSON on stdout instead of tables")
    options = parser.parse_args()
    use_one_core()
    repeats = 1 if options.quick else 3
    measured: dict[str, BackendBench] = {}
    with TemporaryDirectory() as folder:
        table = write_plain_table(Path(folder))
        for backend in usable_backends(options.backends.split(",")):
            chosen = cases(backend, table, options.quick)
            if options.file is not None:
                chosen = [Case(title=options.file.name, path=options.file, radius=parse_length(options.radius))]
            measured[backend] = measure(chosen, backend, repeats)
    if options.json:
        backends = {name: asdict(of_backend) for name, of_backend in measured.items()}
        print_json({"machine": machine(), "repeats": repeats, "backends": backends})
        return
    for name, of_backend in measured.items():
        print_timings(of_backend.simulation, name)
        print_stages(of_backend.stages, name)
        if of_backend.growth is not None:
            print_growth(of_backend.growth, name)
    if options.file is None:
        print_answers()
    show("\n" + "\n".join(f"{name}: {value}" for name, value in machine().items()))
