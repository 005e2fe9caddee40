"""Timings of one object: what it costs to sample, to simulate and to count, and how much memory at most."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, load_cloud
from spherefunc_bullet.formats.reading import read_geometry
from spherefunc_bullet.learning.histogram import CubeHistogram
from spherefunc_bullet.processes.memory import peak_bytes
from spherefunc_bullet.settling.settling import warm_up
from spherefunc_bullet.simulator import DropSettings, Simulator, make_simulator

SPAN = 500  # settled spheres, at the beginning and at the end
Made = TypeVar("Made")


@dataclass(frozen=True, kw_only=True)
class Case:
    """One object to be measured."""

    title: str
    path: Path
    radius: float  # metres


@dataclass(frozen=True, kw_only=True)
class Timing:
    """Simulation of one object."""

    title: str
    radius: float  # metres
    points: int
    settled: int
    drops: int
    best: float  # seconds
    median: float  # seconds
    peak_bytes: int | None  # of the whole process, interpreter and libraries included


@dataclass(frozen=True, kw_only=True)
class StageTiming:
    """The stages of one object, best of the runs, seconds."""

    title: str
    points: int
    sampling: float
    simulation: float
    histogram: float


@dataclass(frozen=True, kw_only=True)
class Growth:
    """What a drop costs on an empty object and on a full one, seconds."""

    title: str
    settled: int
    first: float  # a drop, until the first spheres have settled
    last: float  # a drop, while the last ones settle


def time_simulation(case: Case, backend: str, repeats: int) -> Timing:
    """Return one object's timing; loading and compilation are not in it."""
    simulator, cloud = warm(case, backend)
    seconds, result = timed(lambda: simulator.drop(cloud, DropSettings(radius=case.radius), 0), repeats)
    return Timing(
        title=case.title,
        radius=case.radius,
        points=len(cloud),
        settled=result.settled,
        drops=result.drops,
        best=min(seconds),
        median=statistics.median(seconds),
        peak_bytes=peak_bytes(),
    )


def time_growth(case: Case, backend: str, repeats: int) -> Growth:
    """Return what a drop costs during the first and the last so many settled spheres.

    From runs that stop early, which are the beginnings of the whole one; the one that stops at the first sphere holds
    what comes before any drop.
    """
    simulator, cloud = warm(case, backend)
    settled = simulator.drop(cloud, DropSettings(radius=case.radius), 0).settled
    span = min(SPAN, settled // 2)
    runs = []
    for stop in (1, span, settled - span, settled):
        settings = DropSettings(radius=case.radius, max_spheres=stop)
        runs.append(min((simulator.drop(cloud, settings, 0) for _ in range(repeats)), key=lambda run: run.seconds))
    first, last = (
        (after.seconds - before.seconds) / (after.drops - before.drops) for before, after in (runs[:2], runs[2:])
    )
    return Growth(title=case.title, settled=settled, first=first, last=last)


def time_stages(case: Case, backend: str, repeats: int) -> StageTiming:
    """Return what sampling, simulation and histogram of one object cost; a cloud is not sampled."""
    geometry, (simulator, cloud), sampling = read_geometry(case.path), warm(case, backend), [0.0]
    if len(geometry.faces):
        sampling, cloud = timed(lambda: cloud_from_mesh(geometry.vertices, geometry.faces), repeats)
    simulation, result = timed(lambda: simulator.drop(cloud, DropSettings(radius=case.radius), 0), repeats)
    histogram, _ = timed(lambda: CubeHistogram(case.radius).fit_transform([result.centers]), repeats)
    stages = {"sampling": min(sampling), "simulation": min(simulation), "histogram": min(histogram)}
    return StageTiming(title=case.title, points=len(cloud), **stages)


def warm(case: Case, backend: str) -> tuple[Simulator, Cloud]:
    """Return a simulator and an object's cloud, all that has to be compiled for them compiled."""
    simulator, cloud = make_simulator(backend), load_cloud(case.path)
    warm_up(simulator)
    return simulator, cloud


def timed(make: Callable[[], Made], repeats: int) -> tuple[list[float], Made]:
    """Return the seconds of every run, and what the last returned."""
    seconds = []
    for _ in range(repeats):
        started = time.perf_counter()
        made = make()
        seconds.append(time.perf_counter() - started)
    return seconds, made
