"""Shared parts of the benches: objects, a compiled simulator, times of repeated runs, a fresh process, one core."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, TypeVar

import typer

from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.console import show
from spherefunc_bullet.datasets.catalogue import built_catalogue
from spherefunc_bullet.formats.units import parse_length
from spherefunc_bullet.settling.settling import warm_up
from spherefunc_bullet.simulator import Simulator, make_simulator

from ..machine import machine

Made = TypeVar("Made")
Data = Annotated[str, typer.Argument(metavar="DATA", help="A folder with manifest.csv, or a catalogue's name.")]
Backends = Annotated[str, typer.Option(help="Simulators to measure, or whose models to use.")]
Repeats = Annotated[int, typer.Option(min=1, help="Number of runs of each.")]


@dataclass(frozen=True, kw_only=True)
class Case:
    """One object to be measured."""

    title: str
    path: Path
    radius: float  # metres


def of_household(name: str) -> Path:
    """Return the file of an object of the catalogue."""
    return built_catalogue("household").parent / f"{name}.ply"


def case_of(title: str, name: str, radius: str) -> Case:
    """Return an object of the catalogue to be measured."""
    return Case(title=f"{title} ({name})", path=of_household(name), radius=parse_length(radius))


def peer_mug(title: str) -> Case | None:
    """Return the mug that comes with PyBullet, or None without PyBullet."""
    try:
        import pybullet_data
    except ImportError:
        return None
    path = Path(pybullet_data.getDataPath()) / "objects" / "mug.obj"
    return Case(title=title, path=path, radius=parse_length("5mm"))


def plain_table(folder: Path) -> Case:
    """Write a table of 1.2 x 0.8 m on four legs into a folder."""
    from spherefunc_bullet.scenes.household.parts.solids import box, join, shift

    legs = [shift(box(0.05, 0.05, 0.72), x, y) for x in (-0.56, 0.56) for y in (-0.36, 0.36)]
    path = folder / "plain_table.ply"
    join(shift(box(1.2, 0.8, 0.03), z=0.72), *legs).export(path)
    return Case(title="table of 1.2 x 0.8 m", path=path, radius=parse_length("1cm"))


def warm(case: Case, backend: str) -> tuple[Simulator, Cloud]:
    """Return a simulator, with its kernels compiled, and an object's cloud."""
    simulator, cloud = make_simulator(backend), load_cloud(case.path)
    warm_up(simulator)
    return simulator, cloud


def timed(
    make: Callable[[], Made], repeats: int, clock: Callable[[], float] = time.perf_counter
) -> tuple[list[float], Made]:
    """Return the seconds of every run by a clock, and the result of the last one."""
    seconds = []
    for _ in range(repeats):
        started = clock()
        made = make()
        seconds.append(clock() - started)
    return seconds, made


def apart(function: Callable[..., Made], *arguments: object) -> Made:
    """Return the result of a function that is called in a fresh process."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def use_one_core():
    """Restrict this process and those that it starts to one core."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ[name] = "1"
    if hasattr(os, "sched_setaffinity"):  # on Linux; elsewhere there are only the variables
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def print_machine():
    """Print the machine and the versions."""
    show("\n" + "\n".join(f"{name}: {value}" for name, value in machine().items()))
