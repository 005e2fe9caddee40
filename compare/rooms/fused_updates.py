"""Updates of a fused room after every depth image of a round, beside looks at all of the map: objects and seconds.

``python -m spherefunc_bullet.compare.rooms.fused_updates ../shared/data/models`` furnishes rooms, in which a virtual
Kinect goes round in steps of ten degrees with known poses. After every image one map is updated; after each quarter of
the round the whole of a second one is looked at. F-measures are as in `fused_frames`.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Mapping
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, run, show
from spherefunc_bullet.scenes.fusion.scene_fusion import SceneFusion
from spherefunc_bullet.scenes.virtual_rooms.kinect import KINECT
from spherefunc_bullet.scenes.virtual_rooms.scans import pose_at

from . import fused_frames
from .fused_frames import FunctionCounts, FusedRoom
from .matching import counts_by_function
from .trials import summed

STEPS = 36  # of a round
QUARTERS = ("1/4", "1/2", "3/4", "1")
UPDATED, WHOLE = "updated", "all looked at"


def timed_objects(fusion: SceneFusion, whole: bool, seconds: list[float]):
    """Recognise the objects of a map, and add the seconds that it took."""
    start = time.perf_counter()
    fusion.objects(whole=whole)
    seconds.append(time.perf_counter() - start)


def count_round(fused: FusedRoom, functions: FunctionCounts, seconds: Mapping[str, list[float]]):
    """Add the counts of functions after each quarter of a round, and the seconds of each way."""
    updated, whole, images = SceneFusion(fused.model), SceneFusion(fused.model), []
    poses = [pose_at(fused.room, angle) for angle in np.linspace(0, 2 * np.pi, STEPS, endpoint=False)]
    poses = [pose for pose in poses if fused_frames.sees(fused.surfaces, pose)]
    ends = {round(len(poses) * (k + 1) / len(QUARTERS)): quarter for k, quarter in enumerate(QUARTERS)}
    for pose in poses:
        images.append(fused.photographed(fused.surfaces, pose))
        for fusion in (updated, whole):
            fusion.add(images[-1].depth, KINECT.camera, pose)
        timed_objects(updated, False, seconds[UPDATED])
        if len(images) in ends:
            timed_objects(whole, True, seconds[WHOLE])
            labels = fused_frames.seen_in(fused.room, images).functions()
            for way, fusion in ((UPDATED, updated), (WHOLE, whole)):
                truth = fused_frames.owners(fused.surfaces, fusion.scan.points)
                counts = counts_by_function(fusion.room, truth, labels, fused.model.functions_)
                functions[ends[len(images)], way] = summed(functions[ends[len(images)], way], counts)


def main(
    data: Annotated[str, typer.Argument(metavar="DATA", help="Meshes: a folder with manifest.csv, or a catalogue.")],
    rooms: Annotated[int, typer.Option(min=1, help="Number of rooms.")] = 4,
    seed: options.Seed = 0,
):
    """Measure updates of fused virtual rooms after every depth image."""
    functions, seconds, failures = defaultdict(dict), {UPDATED: [], WHOLE: []}, Failures()
    for fused in fused_frames.fused_rooms(data, rooms, 1.0, 0.0, seed, failures):
        count_round(fused, functions, seconds)
    fused_frames.print_quality(fused_frames.quality_rows(functions, "round", QUARTERS, (UPDATED, WHOLE)), rooms)
    for way, each in seconds.items():
        middle, most = np.quantile(each, [0.5, 0.9])
        words = f"{way}: {middle:.2f} s in the median, {np.mean(each):.2f} in the mean"
        show(f"{words}, 0.9 of {len(each)} below {most:.2f}")
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
