"""What a drop costs against the spheres that have settled, in a crate, by both simulators: numbers and a picture.

    python -m spherefunc_bullet.compare.bench.growth [--picture growth.svg]

From runs that stop early, which are the beginnings of longer ones. Processor time, so that other work on the machine
counts little.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.console import print_table, progress, run
from spherefunc_bullet.formats.units import parse_length
from spherefunc_bullet.settling.settling import warm_up
from spherefunc_bullet.simulator import DropSettings, make_simulator

from ..machine import usable_backends

STOPS = {  # settled spheres, and their radius: a crate holds 160,000 of 5 mm, and 20,000 of 1 cm
    "fast": ("5mm", (1_000, 3_000, 10_000, 30_000, 100_000)),
    "bullet": ("1cm", (100, 300, 1_000, 3_000, 10_000)),
}


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """The drops of a run between two numbers of settled spheres."""

    first: int
    last: int
    cost: float  # seconds of the processor a drop


def write_crate(folder: Path) -> Path:
    """Write a crate of 60 x 60 x 40 cm with walls of 1 cm, open above, and return its path."""
    from spherefunc_bullet.scenes.household.parts.solids import box, join, shift

    sides = [shift(box(0.6, 0.01, 0.4), y=y) for y in (-0.295, 0.295)]
    ends = [shift(box(0.01, 0.58, 0.4), x=x) for x in (-0.295, 0.295)]
    path = folder / "crate.ply"
    join(box(0.58, 0.58, 0.01), *sides, *ends).export(path)
    return path


def stretches(cloud: Cloud, backend: str, radius: float, stops: Sequence[int]) -> list[Stretch]:
    """Return what drops cost between each two of the numbers of settled spheres."""
    simulator, ends = make_simulator(backend), []
    warm_up(simulator)
    # Whatever is kept of a cloud, and the code that long runs alone need.
    simulator.drop(cloud, DropSettings(radius=radius, max_spheres=5 * stops[0]), 0)
    for stop in progress(stops, len(stops), backend):
        started = process_time()
        result = simulator.drop(cloud, DropSettings(radius=radius, max_spheres=stop), 0)
        ends.append((process_time() - started, result.drops))
    between = zip(stops, stops[1:], ends, ends[1:], strict=False)
    return [Stretch(first=a, last=b, cost=(t - s) / (n - m)) for a, b, (s, m), (t, n) in between]


def draw(measured: dict[str, list[Stretch]], path: Path):
    """Draw each simulator's cost of a drop against the spheres that have settled."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.2, 3.2), layout="constrained")
    axes = figure.add_subplot()
    for (backend, parts), style in zip(measured.items(), ("o-", "s--"), strict=False):
        middles = [np.sqrt(part.first * part.last) for part in parts]
        label = f"{backend}, spheres of {STOPS[backend][0]}"
        axes.loglog(middles, [1e6 * part.cost for part in parts], style, markersize=4, linewidth=1.2, label=label)
    axes.set(xlabel="spheres that have settled in the crate", ylabel="microseconds a drop", ylim=(1, 1e4))
    axes.grid(linewidth=0.3, color="#dddddd")
    axes.legend(frameon=False)
    figure.savefig(path)


def main(picture: Annotated[Path | None, typer.Option(help="Draw them into this file, SVG or PNG.")] = None):
    """Print what a drop costs as a crate fills, and draw it."""
    measured = {}
    with TemporaryDirectory() as folder:
        cloud = load_cloud(write_crate(Path(folder)))
    for backend in usable_backends(STOPS):
        radius, stops = STOPS[backend]
        measured[backend] = stretches(cloud, backend, parse_length(radius), stops)
    rows = [
        [backend, STOPS[backend][0], f"{part.first:,} to {part.last:,}", f"{1e6 * part.cost:,.1f}"]
        for backend, parts in measured.items()
        for part in parts
    ]
    print_table("What a drop costs in a crate", ["backend", "radius", "settled", "us a drop"], rows)
    if picture is not None:
        draw(measured, picture)


if __name__ == "__main__":
    run(lambda: typer.run(main))
