"""What recognition of a scan costs, stage by stage.

    python -m spherefunc_bullet.compare.bench.scene_stages ../shared/data/scenes [--points 300000] [--only NAME]

The fastest of three turns of each scan counts, in seconds by the clock: measure on a quiet machine.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.console import print_table, progress, run, say
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.scenes.recognition.recognition import Room, recognise
from spherefunc_bullet.scenes.scans.scan import load_scan

from ..rooms.real_scans import scan_files
from ..rooms.scan_trials import some_points

TURNS = 3


def fastest(turns: list[Room]) -> dict[str, float]:
    """Return the stages of the turn that took least, seconds."""
    return min((room.stages for room in turns), key=lambda stages: sum(stages.values()))


def main(
    data: Annotated[Path, typer.Argument(help="Folder of scans.")],
    points: Annotated[int, typer.Option(help="Take at most so many points, and leave out what has fewer.")] = 300_000,
    only: Annotated[str, typer.Option(help="Scans whose names hold this, or one of these.")] = "",
):
    """Measure and print."""
    model, rows = load_model(shipped_model("fast", scans=True)), {}
    scans = [load_scan(path, report=say) for path in scan_files(data, only)]
    scans = [some_points(scan, points) for scan in scans if len(scan) >= points]
    if not scans:
        raise InputError(f"{data}: expected a scan of {points:,} points or more, found none")
    for scan in progress(scans, len(scans), "recognising"):
        turns = [recognise(scan, model) for _ in range(TURNS + 1)][1:]  # after one to warm up
        rows[scan.name] = fastest(turns)
    stages = list(next(iter(rows.values())))
    table = [[name, *(own[stage] for stage in stages), sum(own.values())] for name, own in rows.items()]
    table.append(["mean", *np.mean([row[1:] for row in table], axis=0)])
    cells = [[row[0], *(f"{value:.3f}" for value in row[1:])] for row in table]
    print_table(f"Seconds of scans of {points:,} points", ["scan", *stages, "all"], cells)


if __name__ == "__main__":
    run(lambda: typer.run(main))
