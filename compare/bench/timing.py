"""Timings of one object: what it costs to sample, to simulate and to count, and how much memory at most."""

from __future__ import annotations

import os
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, load_cloud, placed
from spherefunc_bullet.formats.reading import read_geometry
from spherefunc_bullet.learning.histogram import CubeHistogram
from spherefunc_bullet.simulator import DropSettings, Simulator, make_simulator


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
    peak_bytes: int  # of the whole process, interpreter and libraries included


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


@dataclass(frozen=True, kw_only=True)
class PeerTiming:
    """The naive script on one object."""

    drops: int
    settled: int
    seconds: float
    finished: bool


def time_simulation(title: str, path: Path, radius: float, backend: str, repeats: int) -> Timing:
    """Return one object's timing; loading and compilation are not in it."""
    simulator, cloud = make_simulator(backend), load_cloud(path)
    warm_up(simulator)
    settings = DropSettings(radius=radius)
    seconds, result = timed(lambda: simulator.drop(cloud, settings, 0), repeats)
    return Timing(
        title=title,
        radius=radius,
        points=len(cloud),
        settled=result.settled,
        drops=result.drops,
        best=min(seconds),
        median=statistics.median(seconds),
        peak_bytes=peak_bytes(),
    )


def time_growth(title: str, path: Path, radius: float, backend: str, repeats: int, span: int = 500) -> Growth:
    """Return what a drop costs during the first and the last so many settled spheres.

    From runs that stop early, which are the beginnings of the whole one; the one that stops at the first sphere holds
    what comes before any drop.
    """
    simulator, cloud = make_simulator(backend), load_cloud(path)
    warm_up(simulator)
    whole = simulator.drop(cloud, DropSettings(radius=radius), 0)
    span = min(span, whole.settled // 2)
    stops = [1, span, whole.settled - span, whole.settled]
    runs = [
        min(
            (simulator.drop(cloud, DropSettings(radius=radius, max_spheres=stop), 0) for _ in range(repeats)),
            key=lambda run: run.seconds,
        )
        for stop in stops
    ]
    first, last = (
        (after.seconds - before.seconds) / (after.drops - before.drops)
        for before, after in ((runs[0], runs[1]), (runs[2], runs[3]))
    )
    return Growth(title=title, settled=whole.settled, first=first, last=last)


def time_stages(title: str, path: Path, radius: float, backend: str, repeats: int) -> StageTiming:
    """Return what sampling, simulation and histogram of one object cost; a cloud is not sampled."""
    simulator, geometry = make_simulator(backend), read_geometry(path)
    warm_up(simulator)
    sampling, cloud = [0.0], load_cloud(path)
    if len(geometry.faces):
        sampling, cloud = timed(lambda: cloud_from_mesh(geometry.vertices, geometry.faces), repeats)
    simulation, result = timed(lambda: simulator.drop(cloud, DropSettings(radius=radius), 0), repeats)
    histogram, _ = timed(lambda: CubeHistogram(radius).fit_transform([result.centers]), repeats)
    stages = {"sampling": min(sampling), "simulation": min(simulation), "histogram": min(histogram)}
    return StageTiming(title=title, points=len(cloud), **stages)


def time_peer(path: Path, radius: float, seconds: float) -> PeerTiming:
    """Return the naive script's timing on a mesh, moved to where the simulator has it.

    For a process of its own: stdout is closed to PyBullet, which prints on it and would spoil JSON.
    """
    from .peer import run_naively

    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    geometry = read_geometry(path)
    run = run_naively(placed(geometry.vertices), geometry.faces, radius, seconds=seconds)
    return PeerTiming(drops=run.drops, settled=run.settled, seconds=run.seconds, finished=run.finished)


def warm_up(simulator: Simulator):
    """Compile everything: sampling, simulation and histogram of a small box."""
    import trimesh

    box = trimesh.creation.box((0.1, 0.1, 0.1))
    cloud: Cloud = cloud_from_mesh(box.vertices, box.faces, "box")
    result = simulator.drop(cloud, DropSettings(radius=0.01), 0)
    CubeHistogram(0.01).fit_transform([result.centers])


def timed(run: Callable, repeats: int) -> tuple[list[float], object]:
    """Return the seconds of every run, and what the last returned."""
    seconds, found = [], None
    for _ in range(repeats):
        started = time.perf_counter()
        found = run()
        seconds.append(time.perf_counter() - started)
    return seconds, found


def peak_bytes() -> int:
    """Return the most memory that this process has had."""
    import resource

    unit = 1 if sys.platform == "darwin" else 1024  # macOS counts bytes, Linux kibibytes
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
