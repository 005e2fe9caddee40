"""What poses, standing and carrying take: seconds of one object of the catalogue, without loading.

    python -m spherefunc_bullet.compare.bench.mechanics [--repeats 3]
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter, process_time
from typing import Annotated

import typer

from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.console import print_table, run
from spherefunc_bullet.datasets.catalogue import built_catalogue
from spherefunc_bullet.settling.places import resting_places
from spherefunc_bullet.simulator import Simulator, make_simulator
from spherefunc_bullet.simulator.mechanics import CarrySettings, PoseSettings, StandSettings

from ..machine import usable_backends

OBJECTS = ("mug_01", "shell_chair_01", "dining_table_02")
SMALL = 1 / 26  # of a mug's largest extent, the radius of which 300 spheres are half of what it holds


WANTED = {"poses, 100 drops": "2", "keeping 300 small spheres": "3"}  # seconds at most


def seconds(question: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Return the least processor time and the least time by the clock of some runs, after one that is not counted."""
    question()
    taken = []
    for _ in range(repeats):
        started, clock = process_time(), perf_counter()
        question()
        taken.append((process_time() - started, perf_counter() - clock))
    processor, clocked = zip(*taken, strict=True)
    return min(processor), min(clocked)


def questions(simulator: Simulator, cloud: Cloud) -> dict[str, Callable[[], object]]:
    """Return what one asks of an object, by what the table calls it."""
    places = resting_places(cloud)
    asked: dict[str, Callable[[], object]] = {
        "poses, 100 drops": lambda: simulator.poses(cloud, PoseSettings(), 0),
        "standing, 100 places": lambda: simulator.stands(cloud, StandSettings(load=20.0), places, 0),
    }
    if hasattr(simulator, "carry"):
        asked["keeping"] = lambda: simulator.carry(cloud, CarrySettings(), 0)
        if cloud.size.max() < 0.2:
            small = CarrySettings(radius=float(cloud.size.max()) * SMALL)
            asked["keeping 300 small spheres"] = lambda: simulator.carry(cloud, small, 0)
    return asked


def main(repeats: Annotated[int, typer.Option(min=1, help="Runs, of which the best counts.")] = 3):
    """Print a line for each object and question."""
    folder, rows = built_catalogue("household").parent, []
    for backend in usable_backends(("fast", "bullet")):
        simulator = make_simulator(backend)
        for name in OBJECTS:
            for words, question in questions(simulator, load_cloud(folder / f"{name}.ply")).items():
                processor, clocked = seconds(question, repeats)
                rows.append([name, backend, words, f"{processor:.2f}", f"{clocked:.2f}", WANTED.get(words, "")])
    head = ["object", "backend", "question", "processor s", "by the clock", "wanted"]
    print_table("Mechanics of one object", head, rows)


if __name__ == "__main__":
    run(lambda: typer.run(main))
