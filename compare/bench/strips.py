"""What it buys to fill a large object strip by strip: seconds as drawn, in strips, and on two cores; and the piles.

    python -m spherefunc_bullet.compare.bench.strips [--seeds 12]

The three take turns, and the best of three turns counts. How many spheres settle is of so many seeds each way.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.console import print_table, progress, run
from spherefunc_bullet.datasets.catalogue import built_catalogue
from spherefunc_bullet.formats.units import format_length, parse_length
from spherefunc_bullet.simulator import DropResult, DropSettings, make_simulator

OBJECTS = [("shell_chair_01", "5mm", 12), ("dining_table_02", "1cm", 12), ("sofa_02", "5mm", 3)]  # and seeds
TURNS = 3


def dropped(cloud: Cloud, radius: float, seed: int, **options: object) -> DropResult:
    """Return a run by `fast` to the end."""
    return make_simulator("fast", **options).drop(cloud, DropSettings(radius=radius), seed)


def seconds(cloud: Cloud, radius: float, ways: Sequence[dict]) -> tuple[list[float], bool]:
    """Return the least seconds of each way to drop, and whether the last two gave the same bits."""
    runs = [[dropped(cloud, radius, 0, **way) for way in ways] for _ in range(TURNS + 1)][1:]  # after one to warm up
    one, other = runs[0][-2:]
    same = np.array_equal(one.centers, other.centers) and np.array_equal(one.outcomes, other.outcomes)
    return [min(run.seconds for run in turns) for turns in zip(*runs, strict=True)], same


def spread(counts: Sequence[int]) -> str:
    """Return the mean and the standard deviation of some counts, as people write them."""
    return f"{np.mean(counts):,.0f} ± {np.std(counts, ddof=1):,.0f}"


def main(
    seeds: Annotated[int | None, typer.Option(min=2, help="Piles of an object; by default 12, of the sofa 3.")] = None,
):
    """Measure and print."""
    ways = [{"as_drawn": True}, {"cores": 1}, {"cores": min(2, os.cpu_count() or 1)}]
    rows = []
    for name, length, few in progress(OBJECTS, len(OBJECTS), "filling"):
        cloud, radius = load_cloud(built_catalogue("household").parent / f"{name}.ply"), parse_length(length)
        (drawn, one, two), same = seconds(cloud, radius, ways)
        piles = [[dropped(cloud, radius, seed, **way).settled for seed in range(seeds or few)] for way in ways[:2]]
        rows.append(
            [
                name,
                format_length(radius),
                *(f"{value:.3f}" for value in (drawn, one, two)),
                f"{one / two:.2f}",
                "same" if same else "OTHER",
                *map(spread, piles),
            ]
        )
    times = ["as drawn s", "in strips s", "on 2 cores s", "times", "bits"]
    head = ["object", "radius", *times, "settled, as drawn", "in strips"]
    print_table("A large object by fast, best of three turns, compilation and loading excluded", head, rows)


if __name__ == "__main__":
    run(lambda: typer.run(main))
