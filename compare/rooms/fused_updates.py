"""Updates of a fused room after every depth image of a round, beside looks at all of the map: objects and seconds.

``python -m spherefunc_bullet.compare.rooms.fused_updates ../shared/data/models`` furnishes rooms, in which a virtual
Kinect goes round in steps of ten degrees with known poses. After every image one map is updated; after each quarter of
the round the whole of a second one is looked at. F-measures are as in `fused_frames`.
"""

from __future__ import annotations

import time
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, progress, run, show
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.learning.model_file import inference_model, shipped_model
from spherefunc_bullet.scenes.fusion.scene_fusion import SceneFusion
from spherefunc_bullet.scenes.virtual_rooms.furnishing import VirtualRoom
from spherefunc_bullet.scenes.virtual_rooms.kinect import KINECT
from spherefunc_bullet.scenes.virtual_rooms.lived_in import LivedIn, furnish_lived_in
from spherefunc_bullet.scenes.virtual_rooms.scans import pose_at

from .fused_frames import FunctionCounts, FusedRoom, owners, seen_in, sees
from .matching import MatchCounts, counts_by_function, rounded

STEPS = 36  # of a round
QUARTERS = ("1/4", "1/2", "3/4", "1")
UPDATED, WHOLE = "updated", "all looked at"


@dataclass
class Seconds:
    """What updates took, and looks at all of the map."""

    updated: list[float] = field(default_factory=list)
    whole: list[float] = field(default_factory=list)


def timed_objects(fusion: SceneFusion, whole: bool, seconds: list[float]):
    """Recognise the objects of a map, and add the seconds that it took."""
    start = time.perf_counter()
    fusion.objects(whole=whole)
    seconds.append(time.perf_counter() - start)


def count_round(fused: FusedRoom, room: VirtualRoom, functions: FunctionCounts, seconds: Seconds):
    """Add the counts of functions after each quarter of a round, and the seconds."""
    updated, whole, images = SceneFusion(fused.model), SceneFusion(fused.model), []
    poses = [pose_at(room, angle) for angle in np.linspace(0, 2 * np.pi, STEPS, endpoint=False)]
    poses = [pose for pose in poses if sees(fused.surfaces, pose)]
    ends = {round(len(poses) * (k + 1) / len(QUARTERS)): quarter for k, quarter in enumerate(QUARTERS)}
    for pose in poses:
        images.append(fused.photographed(fused.surfaces, pose))
        for fusion in (updated, whole):
            fusion.add(images[-1].depth, KINECT.camera, pose)
        timed_objects(updated, False, seconds.updated)
        if len(images) in ends:
            timed_objects(whole, True, seconds.whole)
            labels = seen_in(room, images).functions()
            for way, fusion in ((UPDATED, updated), (WHOLE, whole)):
                truth = owners(fused.surfaces, fusion.scan.points)
                for name, counts in counts_by_function(fusion.room, truth, labels, fused.model.functions_).items():
                    functions[ends[len(images)], way, name] += counts


def report(functions: FunctionCounts, seconds: Seconds, names: tuple[str, ...], about: dict[str, object], json: bool):
    """Print what was counted."""
    rows = [
        {"round": part, "way": way} | {name: rounded(functions[part, way, name].f_measure) for name in names}
        for part in QUARTERS
        for way in (UPDATED, WHOLE)
    ]
    if json:
        print_json(about | {"f_measure": rows, "seconds": {"updated": seconds.updated, "whole": seconds.whole}})
        return
    cells = [[row["round"], row["way"], *(f"{row[name] or 0:.2f}" for name in names)] for row in rows]
    print_table(f"{about['rooms']} rooms: F of functions, from depth images to labels", ["round", "", *names], cells)
    for way, each in ((UPDATED, seconds.updated), (WHOLE, seconds.whole)):
        middle, most = np.quantile(each, [0.5, 0.9])
        show(
            f"{way}: {middle:.2f} s in the median, {np.mean(each):.2f} in the mean, 0.9 of {len(each)} below {most:.2f}"
        )


def main(
    data: Annotated[str, typer.Argument(metavar="DATA", help="Meshes: a folder with manifest.csv, or a catalogue.")],
    rooms: Annotated[int, typer.Option(min=1, help="Number of rooms.")] = 4,
    seed: options.Seed = 0,
    model: Annotated[Path | None, typer.Option(help="A model file; by default the one for scans that ships.")] = None,
    json: options.Json = False,
):
    """Measure updates of fused virtual rooms after every depth image."""
    classifier = inference_model(model or shipped_model("fast", scans=True), None)
    functions: FunctionCounts = defaultdict(MatchCounts)
    seconds, failures = Seconds(), Failures()
    furnished = furnish_lived_in(open_dataset(data), rooms, seed=seed, failed=failures.add, lived_in=LivedIn())
    for room in progress(furnished, rooms, "going round"):
        count_round(FusedRoom(room, classifier, 1.0, 0.0, seed), room, functions, seconds)
    report(functions, seconds, classifier.functions_, {"data": data, "rooms": rooms, "seed": seed}, json)
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
