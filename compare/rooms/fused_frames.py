"""How well objects of virtual rooms are found in maps fused from more and more depth images, ids and removals too.

    python -m spherefunc_bullet.compare.rooms.fused_frames ../shared/data/models --rooms 8 [--json]

Rooms are furnished from a folder of meshes; a virtual Kinect with its noise sees them from known poses. F-measures are
of functions, from image to label, over the objects that the images of each column show enough of (as `spherefunc
rooms` counts them), beside those of the same images' points without fusion. Then one object that was found as what it
is, and carries nothing, is taken out of each room, and as many images as were fused before are taken again.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.console import Failures, print_json, print_table, progress, run, show
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.function_model import FunctionModel
from spherefunc_bullet.learning.model_file import inference_model, shipped_model
from spherefunc_bullet.scenes.fusion.scene_fusion import FusedObject, SceneFusion
from spherefunc_bullet.scenes.recognition.recognition import Room, recognise
from spherefunc_bullet.scenes.scans.depth_image import Intrinsics
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.virtual_rooms.furnishing import VirtualRoom
from spherefunc_bullet.scenes.virtual_rooms.kinect import KINECT, DepthImage, Kinect, Surfaces, photograph
from spherefunc_bullet.scenes.virtual_rooms.lived_in import LivedIn, furnish_lived_in
from spherefunc_bullet.scenes.virtual_rooms.scans import VirtualScan, viewpoints

from .matching import Counts, function_counts, match_parts, rounded

COUNTS = (1, 3, 6, 12)  # depth images
FUSED, RAW = "fused", "not fused"
SPARE = 8  # poses, in place of those from which a camera sees too little
LEAST_SEEN = 0.5  # of a coarse image's pixels
REMOVED_AFTER = 6  # images, and as many of the room without the object


@dataclass
class Tally:
    """What was counted over all rooms."""

    functions: dict[tuple[int, str], dict[str, Counts]] = field(default_factory=dict)  # by images and way
    kept: int = 0  # true objects found in two updates in a row, that have one id in both
    again: int = 0  # that were found in two updates in a row
    removed: int = 0  # objects taken out
    noticed: int = 0  # of those, said to be gone
    others: int = 0  # objects that stayed, known when one was taken out
    lost: int = 0  # of those, said to be gone

    def count(self, images: int, way: str, given: dict[str, Counts]):
        """Add one room's counts."""
        before = self.functions.setdefault((images, way), {})
        for name, counts in given.items():
            before[name] = before.get(name, Counts()) + counts


def camera_of(kinect: Kinect) -> Intrinsics:
    """Return a virtual Kinect's camera; its rays go through the middles of pixels."""
    focal, cx, cy = kinect.focal_length, (kinect.width - 1) / 2, (kinect.height - 1) / 2
    return Intrinsics(width=kinect.width, height=kinect.height, fx=focal, fy=focal, cx=cx, cy=cy)


def sees(surfaces: Surfaces, pose: np.ndarray) -> bool:
    """Return whether a camera in a pose has depth in enough of its image; before a sofa's back it has none."""
    coarse = Kinect(width=64, height=48).noisy(0.0)
    return np.isfinite(photograph(surfaces, pose, coarse, np.random.default_rng(0)).depth).mean() >= LEAST_SEEN


def owners(surfaces: Surfaces, points: np.ndarray) -> np.ndarray:
    """Return the label of the surface nearest to each point (N, 3), (N,) int32."""
    nearest = surfaces.raycaster.compute_closest_points(points.astype(np.float32))
    return surfaces.labels[nearest["geometry_ids"].numpy()]


def seen_in(room: VirtualRoom, images: list[DepthImage]) -> VirtualScan:
    """Return what images show, as points with their owners."""
    points, labels = (np.concatenate(parts) for parts in zip(*(image.points() for image in images), strict=True))
    return VirtualScan(room, points, labels)


def counted(truth: np.ndarray, found: Room, room: VirtualRoom, asked: list[int], names: list[str]) -> dict[str, Counts]:
    """Return the counts of each function in a recognised room."""
    labels = {number: room.objects[number].item.functions for number in asked}
    given = {item.id: item.members for item in found.objects}
    matches = match_parts(truth, found.labels, asked)
    return {name: function_counts(matches, given, labels, name) for name in names}


def measure(room: VirtualRoom, model: FunctionModel, noise: float, seed: int, tally: Tally):
    """Fuse a room's images, and count after some of them, and after an object was taken out."""
    number = int(room.name.rpartition("_")[2])
    kinect, surfaces = KINECT.noisy(noise), Surfaces(room.meshes())
    poses = viewpoints(room, surfaces, max(COUNTS) + SPARE, kinect, np.random.default_rng([seed, number]))
    poses = [pose for pose in poses if sees(surfaces, pose)][: max(COUNTS)]
    # In such an order that the first few are from all sides.
    poses = [poses[k] for k in sorted(range(len(poses)), key=lambda k: (k % 4, k))]
    rng, fusion, images, before = np.random.default_rng([seed, number, 1]), SceneFusion(model), [], {}
    for pose in poses:
        images.append(photograph(surfaces, pose, kinect, rng))
        fusion.add(images[-1].depth, camera_of(kinect), pose)
        if len(images) in COUNTS:
            before = counted_after(room, surfaces, fusion, images, tally, before)
    taken_out(SceneFusion(model), room, surfaces, poses, kinect, rng, tally)


def counted_after(
    room: VirtualRoom,
    surfaces: Surfaces,
    fusion: SceneFusion,
    images: list[DepthImage],
    tally: Tally,
    before: dict[int, int],
) -> dict[int, int]:
    """Count one update, and the same images' points without fusion; return the id of each true object found."""
    scan, objects = seen_in(room, images), fusion.objects()
    asked, model = scan.seen().tolist(), fusion.model
    truth = owners(surfaces, fusion.scan.points)
    tally.count(len(images), FUSED, counted(truth, fusion.room, room, asked, model.functions_))
    raw = recognise(Scan(name=room.name, points=scan.points), model)
    tally.count(len(images), RAW, counted(scan.labels, raw, room, asked, model.functions_))
    ids = ids_of(truth, fusion.room, objects, asked)
    tally.again += len(before.keys() & ids.keys())
    tally.kept += sum(before[true] == ids[true] for true in before.keys() & ids.keys())
    return ids


def ids_of(truth: np.ndarray, found: Room, objects: list[FusedObject], asked: list[int]) -> dict[int, int]:
    """Return the id of each true object that is found."""
    matches = match_parts(truth, found.labels, asked)
    return {true: objects[label].id for label, true in matches.items() if true is not None}


def taken_out(
    fusion: SceneFusion,
    room: VirtualRoom,
    surfaces: Surfaces,
    poses: list[np.ndarray],
    kinect: Kinect,
    rng: np.random.Generator,
    tally: Tally,
):
    """Take out of a room an object that was found and carries nothing, and count what is said to be gone."""
    camera = camera_of(kinect)
    for pose in poses[:REMOVED_AFTER]:
        fusion.add(photograph(surfaces, pose, kinect, rng).depth, camera, pose)
    objects = fusion.objects()
    ids = ids_of(owners(surfaces, fusion.scan.points), fusion.room, objects, list(range(len(room.objects))))
    carriers = {placed.support for placed in room.objects}
    free = sorted(true for true in ids if true not in carriers)
    if not free:
        return
    true = free[int(rng.integers(len(free)))]
    rest = Surfaces((label, mesh) for label, mesh in room.meshes() if label != true)
    for pose in poses[:REMOVED_AFTER]:
        fusion.add(photograph(rest, pose, kinect, rng).depth, camera, pose)
    gone = {known.id for known in fusion.tracker.missing(fusion.views[REMOVED_AFTER:])}
    tally.removed += 1
    tally.noticed += ids[true] in gone
    tally.others += len(ids) - 1
    tally.lost += sum(number in gone for other, number in ids.items() if other != true)


def report(tally: Tally, names: list[str], about: dict[str, object], json: bool):
    """Print what was counted."""
    rows = [
        {"images": images, "way": way, **{name: rounded(table[name].f_measure) for name in names}}
        for (images, way), table in sorted(tally.functions.items())
    ]
    ids = {name: getattr(tally, name) for name in ("kept", "again", "removed", "noticed", "others", "lost")}
    if json:
        print_json(about | {"f_measure": rows, "ids": ids})
        return
    cells = [[str(row["images"]), row["way"], *(f"{row[name] or 0:.2f}" for name in names)] for row in rows]
    print_table(f"{about['rooms']} rooms: F of functions, from depth images to labels", ["images", "", *names], cells)
    show(f"ids: {tally.kept} of {tally.again} objects found in two updates in a row have the same")
    show(
        f"taken out: {tally.noticed} of {tally.removed} said to be gone, and {tally.lost} of {tally.others} that stayed"
    )


def main(
    data: Annotated[str, typer.Argument(metavar="DATA", help="Meshes: a folder with manifest.csv, or a catalogue.")],
    rooms: Annotated[int, typer.Option(min=1, help="How many rooms.")] = 8,
    noise: Annotated[float, typer.Option(help="Noise of the images, in times a Kinect's.")] = 1.0,
    seed: Annotated[int, typer.Option(help="Of rooms, poses and noise.")] = 0,
    model: Annotated[Path | None, typer.Option(help="A model file; without one, the one for scans that ships.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON on stdout.")] = False,
):
    """Measure objects of virtual rooms in maps of 1, 3, 6 and 12 depth images."""
    classifier = inference_model(model or shipped_model("fast", scans=True), None)
    tally, failures, names = Tally(), Failures(), list(classifier.functions_)
    furnished = furnish_lived_in(open_dataset(data), rooms, seed=seed, failed=failures.add, lived_in=LivedIn())
    for room in progress(furnished, rooms, "fusing rooms"):
        measure(room, classifier, noise, seed, tally)
    report(tally, names, {"data": data, "rooms": rooms, "noise": noise, "seed": seed}, json)
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
