"""The simulators' speed on one core.

    python -m spherefunc_bullet.compare.bench [--backends fast,bullet]

Loading and compilation are not counted. Every object runs in a separate process, so that peak memory is its own.
"""

from __future__ import annotations

import statistics
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

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


def cases(backend: str, table: Case) -> list[Case]:
    """Return the objects of a backend's bench."""
    chosen_objects = OBJECTS.get(backend, OBJECTS["fast"])
    chosen = [peer_mug("mug (PyBullet's)"), *(case_of(*case) for case in chosen_objects), table]
    return [case for case in chosen if case is not None]


def simulation_row(case: Case, backend: str) -> list[str]:
    """Return the times of one object's simulation, without loading and compilation, and the process's peak memory."""
    simulator, cloud = warm(case, backend)
    seconds, result = timed(lambda: simulator.drop(cloud, DropSettings(radius=case.radius), 0), REPEATS)
    best, peak = min(seconds), peak_bytes()
    counts = [f"{count:,}" for count in (len(cloud), result.settled, result.drops)]
    rates = [f"{count / best:,.0f}" for count in (result.drops, result.settled)]
    times = [f"{best:.3f}", f"{statistics.median(seconds):.3f}"]
    memory = "" if peak is None else f"{peak / 2**20:,.0f}"
    return [case.title, format_length(case.radius), *counts, *times, *rates, memory]


def stages_row(case: Case, backend: str) -> list[str]:
    """Return the best times of sampling, simulation and histogram of one object."""
    geometry, (simulator, _) = read_geometry(case.path), warm(case, backend)
    sampling, cloud = timed(lambda: cloud_from_mesh(geometry.vertices, geometry.faces), REPEATS)
    simulation, result = timed(lambda: simulator.drop(cloud, DropSettings(radius=case.radius), 0), REPEATS)
    histogram, _ = timed(lambda: CubeHistogram(case.radius).fit_transform([result.centers]), REPEATS)
    before, during, after = times = [min(seconds) for seconds in (sampling, simulation, histogram)]
    ratio = f"{(before + after) / during:.2f}" if during else ""
    return [case.title, f"{len(cloud):,}", *(f"{1000 * seconds:.1f}" for seconds in times), ratio]


def print_backend(chosen: list[Case], backend: str):
    """Print the tables of one backend, each object measured in a separate process."""
    each = progress(chosen, len(chosen), f"timing {backend}")
    rows = [apart(simulation_row, case, backend) for case in each]
    head = ["object", "radius", "points", "settled", "drops", "best s", "median s", "drops/s", "settled/s", "peak MiB"]
    print_table(f"Simulation by {backend}, one core, compilation and loading excluded", head, rows)
    radius = STAGE_RADIUS.get(backend, STAGE_RADIUS["fast"])
    staged = progress([replace(case, radius=radius) for case in chosen], len(chosen), "timing the stages")
    rows = [apart(stages_row, case, backend) for case in staged]
    head = ["object", "points", "sampling ms", "simulation ms", "histogram ms", "(sampling + histogram) / simulation"]
    print_table(f"\nStages of one object, {backend}, spheres of {format_length(radius)}, best of the runs", head, rows)


def print_speed(backends: Backends = "fast,bullet"):
    """Print the simulators' speed on one core; with the name of another bench, that one (see its --help)."""
    use_one_core()
    with TemporaryDirectory() as folder:
        table = plain_table(Path(folder))
        for name in usable_backends(backends.split(",")):
            print_backend(cases(name, table), name)
    print_answers()
    print_machine()
