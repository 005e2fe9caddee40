"""The simulators' speed on one core.

    python -m spherefunc_bullet.compare.bench [--backends fast,bullet]

Loading and compilation are not counted. Every object runs in a separate process, so that peak memory is its own.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from spherefunc_bullet.clouds.cloud import cloud_from_mesh
from spherefunc_bullet.console import print_table, progress
from spherefunc_bullet.formats.sources import read_geometry
from spherefunc_bullet.formats.units import format_length, parse_length
from spherefunc_bullet.learning.histogram import CubeHistogram
from spherefunc_bullet.settling.settling import peak_bytes
from spherefunc_bullet.simulator import DropSettings

from ..machine import usable_backends
from .answers import print_answers
from .harness import Backends, Case, apart, case_of, peer_mug, plain_table, print_machine, timed, use_one_core, warm

OBJECTS = {  # of the catalogue: title, name, radius
    "fast": [
        ("mug", "mug_01", "5mm"),
        ("chair", "shell_chair_01", "5mm"),
        ("sofa", "sofa_02", "5mm"),
        ("table", "dining_table_02", "1cm"),
    ],
    "bullet": [("mug", "mug_01", "5mm"), ("chair", "shell_chair_01", "2cm"), ("sofa", "sofa_02", "5cm")],
}
REPEATS = 3
STAGE_RADIUS = {"fast": parse_length("1cm"), "bullet": parse_length("2cm")}
Measured = dict[str, Any]  # the measurements of one object by name; times in seconds


def cases(backend: str, table: Case) -> list[Case]:
    """Return the objects of a backend's bench."""
    chosen_objects = OBJECTS.get(backend, OBJECTS["fast"])
    chosen = [peer_mug("mug (PyBullet's)"), *(case_of(*case) for case in chosen_objects), table]
    return [case for case in chosen if case is not None]


def time_simulation(case: Case, backend: str) -> Measured:
    """Return the times of one object's simulation, without loading and compilation, and the process's peak memory."""
    simulator, cloud = warm(case, backend)
    seconds, result = timed(lambda: simulator.drop(cloud, DropSettings(radius=case.radius), 0), REPEATS)
    about = {"title": case.title, "radius": case.radius, "points": len(cloud), "settled": result.settled}
    times = {"best": min(seconds), "median": statistics.median(seconds)}
    return about | {"drops": result.drops} | times | {"peak_bytes": peak_bytes()}


def time_stages(case: Case, backend: str) -> Measured:
    """Return the best times of sampling, simulation and histogram of one object."""
    geometry, (simulator, _) = read_geometry(case.path), warm(case, backend)
    sampling, cloud = timed(lambda: cloud_from_mesh(geometry.vertices, geometry.faces), REPEATS)
    simulation, result = timed(lambda: simulator.drop(cloud, DropSettings(radius=case.radius), 0), REPEATS)
    histogram, _ = timed(lambda: CubeHistogram(case.radius).fit_transform([result.centers]), REPEATS)
    stages = {"sampling": min(sampling), "simulation": min(simulation), "histogram": min(histogram)}
    return {"title": case.title, "points": len(cloud)} | stages


def print_timings(timings: Iterable[Measured], backend: str):
    """Print the simulations' table."""
    head = ["object", "radius", "points", "settled", "drops", "best s", "median s", "drops/s", "settled/s", "peak MiB"]
    rows = []
    for case in timings:
        counts = [f"{case[name]:,}" for name in ("points", "settled", "drops")]
        times = [f"{case[name]:.3f}" for name in ("best", "median")]
        rates = [f"{case[name] / case['best']:,.0f}" for name in ("drops", "settled")]
        peak = "" if case["peak_bytes"] is None else f"{case['peak_bytes'] / 2**20:,.0f}"
        rows.append([case["title"], format_length(case["radius"]), *counts, *times, *rates, peak])
    print_table(f"Simulation by {backend}, one core, compilation and loading excluded", head, rows)


def print_stages(stages: Iterable[Measured], backend: str):
    """Print the times of an object's stages before and after its simulation."""
    rows = []
    for case in stages:
        sampling, simulation, histogram = times = [case[name] for name in ("sampling", "simulation", "histogram")]
        ratio = f"{(sampling + histogram) / simulation:.2f}" if simulation else ""
        rows.append([case["title"], f"{case['points']:,}", *(f"{1000 * seconds:.1f}" for seconds in times), ratio])
    head = ["object", "points", "sampling ms", "simulation ms", "histogram ms", "(sampling + histogram) / simulation"]
    radius = format_length(STAGE_RADIUS.get(backend, STAGE_RADIUS["fast"]))
    print_table(f"\nStages of one object, {backend}, spheres of {radius}, best of the runs", head, rows)


def measure(chosen: list[Case], backend: str) -> dict[str, Any]:
    """Return the measurements of one backend, each object in a separate process."""
    each = progress(chosen, len(chosen), f"timing {backend}")
    simulation = [apart(time_simulation, case, backend) for case in each]
    radius = STAGE_RADIUS.get(backend, STAGE_RADIUS["fast"])
    staged = progress([replace(case, radius=radius) for case in chosen], len(chosen), "timing the stages")
    return {"simulation": simulation, "stages": [apart(time_stages, case, backend) for case in staged]}


def print_speed(backends: Backends = "fast,bullet"):
    """Print the simulators' speed on one core; with the name of another bench, that one (see its --help)."""
    use_one_core()
    with TemporaryDirectory() as folder:
        table = plain_table(Path(folder))
        measured = {name: measure(cases(name, table), name) for name in usable_backends(backends.split(","))}
    for name, of_backend in measured.items():
        print_timings(of_backend["simulation"], name)
        print_stages(of_backend["stages"], name)
    print_answers()
    print_machine()
