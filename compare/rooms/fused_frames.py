"""Objects of virtual rooms in maps fused from depth images, beside the same images' points put together by true poses.

``python -m spherefunc_bullet.compare.rooms.fused_frames ../shared/data/models`` furnishes rooms, which a virtual Kinect
sees from known poses; with ``--pose-error`` fusion gets poses that are off, and aligns them with the map or leaves them
as given. F-measures are of functions, from images to labels, over the objects that the images show well enough (as
`spherefunc rooms` counts them). Then an object that was found and carries nothing is taken out of each room, and as
many images as before are taken again.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import Annotated

import numpy as np
import typer
from scipy.spatial.transform import Rotation

from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, progress, run, show
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.learning.model_file import inference_model, shipped_model
from spherefunc_bullet.scenes.fusion.alignment import TURN
from spherefunc_bullet.scenes.fusion.point_map import FusionSettings
from spherefunc_bullet.scenes.fusion.scene_fusion import FusedObject, SceneFusion
from spherefunc_bullet.scenes.recognition.recognition import Room, recognise
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.virtual_rooms.furnishing import VirtualRoom
from spherefunc_bullet.scenes.virtual_rooms.kinect import KINECT, DepthImage, Kinect, Surfaces, photograph
from spherefunc_bullet.scenes.virtual_rooms.lived_in import LivedIn, furnish_lived_in
from spherefunc_bullet.scenes.virtual_rooms.scans import VirtualScan, viewpoints

from .matching import MatchCounts, Row, counts_by_function, match_parts, rounded
from .trials import summed

COUNTS = (1, 3, 6, 12)  # depth images
FUSED, AS_GIVEN, TOGETHER = "fused", "poses as given", "put together"
WAYS = FUSED, AS_GIVEN, TOGETHER
SPARE = 8  # poses, in place of those from which a camera sees too little
LEAST_SEEN = 0.5  # of a coarse image's pixels
REMOVED_AFTER = 6  # images, and as many of the room without the object

FunctionCounts = defaultdict[tuple[int | str, str], dict[str, MatchCounts]]  # by images or part of a round, and way


class FusedRoom:
    """One room with its camera poses; what is counted adds up over rooms."""

    def __init__(self, room: VirtualRoom, model: CloudClassifier, noise: float, pose_error: float, seed: int):
        number = int(room.name.rpartition("_")[2])
        self.room, self.model, self.kinect, self.pose_error = room, model, KINECT.noisy(noise), pose_error
        self.surfaces, self.rng = Surfaces(room.meshes()), np.random.default_rng([seed, number, 1])
        tried = viewpoints(room, self.surfaces, max(COUNTS) + SPARE, self.kinect, np.random.default_rng([seed, number]))
        poses = [pose for pose in tried if sees(self.surfaces, pose)][: max(COUNTS)]
        # In such an order that the first few are from all sides.
        self.poses = [pose for start in range(4) for pose in poses[start::4]]

    def reported(self, pose: np.ndarray) -> np.ndarray:
        """Return a pose (4, 4) as a robot would report it: off by the error in metres, and a degree for each 4 cm."""
        if not self.pose_error:
            return pose
        error = np.eye(4)
        error[:3, :3] = Rotation.from_rotvec(np.radians(TURN * self.pose_error) * self.rng.normal(size=3)).as_matrix()
        error[:3, 3] = self.pose_error * self.rng.normal(size=3)
        return pose @ error

    def photographed(self, surfaces: Surfaces, pose: np.ndarray) -> DepthImage:
        """Return an image of surfaces from a pose."""
        return photograph(surfaces, pose, self.kinect, self.rng)

    def count(self, functions: FunctionCounts, ids: Counter):
        """Add the counts of functions and ids after some numbers of images."""
        fusion, as_given = SceneFusion(self.model), SceneFusion(self.model, fusion=FusionSettings(pose_error=0))
        images, before = [], {}
        for pose in self.poses:
            images.append(self.photographed(self.surfaces, pose))
            given = self.reported(pose)
            for each in (fusion, as_given):
                each.add(images[-1].depth, KINECT.camera, given)
            if len(images) in COUNTS:
                scan, objects = seen_in(self.room, images), fusion.objects()
                as_given.objects()
                labels = scan.functions()
                together = recognise(Scan(name=self.room.name, points=scan.points), self.model)
                truth, other = (owners(self.surfaces, each.scan.points) for each in (fusion, as_given))
                rooms = (fusion.room, truth), (as_given.room, other), (together, scan.labels)
                for way, (found, owner) in zip(WAYS, rooms, strict=True):
                    counts = counts_by_function(found, owner, labels, self.model.functions_)
                    functions[len(images), way] = summed(functions[len(images), way], counts)
                now = ids_of(truth, fusion.room, objects, labels)
                again = before.keys() & now.keys()
                ids["again"] += len(again)
                ids["kept"] += sum(before[true] == now[true] for true in again)
                before = now
        self.agreement = [each.map.agreement for each in (fusion, as_given)]

    def count_removal(self, ids: Counter):
        """Take out an object that was found and carries nothing, and add what is said to be gone."""
        fusion = SceneFusion(self.model)
        for pose in self.poses[:REMOVED_AFTER]:
            fusion.add(self.photographed(self.surfaces, pose).depth, KINECT.camera, self.reported(pose))
        objects = fusion.objects()
        truth = owners(self.surfaces, fusion.scan.points)
        found = ids_of(truth, fusion.room, objects, range(len(self.room.objects)))
        carriers = {placed.support for placed in self.room.objects}
        free = sorted(true for true in found if true not in carriers)
        if not free:
            return
        removed = free[int(self.rng.integers(len(free)))]
        rest = Surfaces((label, mesh) for label, mesh in self.room.meshes() if label != removed)
        for pose in self.poses[:REMOVED_AFTER]:
            fusion.add(self.photographed(rest, pose).depth, KINECT.camera, self.reported(pose))
        gone = {known.id for known in fusion.tracker.missing(list(fusion.views)[REMOVED_AFTER:])}
        ids["removed"] += 1
        ids["noticed"] += found.pop(removed) in gone
        ids["stayed"] += len(found)
        ids["lost"] += sum(number in gone for number in found.values())


def sees(surfaces: Surfaces, pose: np.ndarray) -> bool:
    """Return whether a camera in a pose has depth in enough of its image; right before a wardrobe it has none."""
    coarse = Kinect(width=64, height=48)
    return np.isfinite(photograph(surfaces, pose, coarse, np.random.default_rng(0)).depth).mean() >= LEAST_SEEN


def owners(surfaces: Surfaces, points: np.ndarray) -> np.ndarray:
    """Return the label of the surface nearest to each point (N, 3), (N,) int32."""
    nearest = surfaces.raycaster.compute_closest_points(points.astype(np.float32))
    return surfaces.labels[nearest["geometry_ids"].numpy()]


def seen_in(room: VirtualRoom, images: list[DepthImage]) -> VirtualScan:
    """Return what images show, as points with their owners."""
    points, labels = (np.concatenate(parts) for parts in zip(*(image.points() for image in images), strict=True))
    return VirtualScan(room, points, labels)


def ids_of(truth: np.ndarray, found: Room, objects: list[FusedObject], seen: Iterable[int]) -> dict[int, int]:
    """Return the id of each true object that is found."""
    matches = match_parts(truth, found.labels, seen)
    return {true: objects[label].id for label, true in matches.items() if true is not None}


def quality_rows(functions: FunctionCounts, what: str, parts: Sequence[int | str], ways: Sequence[str]) -> list[Row]:
    """Return the F-measures of functions, a row for each number of images or part of a round and each way."""
    return [
        {what: part, "way": way} | {name: rounded(one.f_measure) for name, one in functions[part, way].items()}
        for part, way in product(parts, ways)
    ]


def print_quality(rows: Sequence[Row], rooms: int):
    """Print the F-measures of functions."""
    what, _, *names = rows[0]
    cells = [[str(row[what]), row["way"], *(f"{row.get(name) or 0:.2f}" for name in names)] for row in rows]
    print_table(f"{rooms} rooms: F of functions, from depth images to labels", [what, "", *names], cells)


def report(functions: FunctionCounts, ids: Counter, about: dict[str, object], json: bool):
    """Print what was counted."""
    rows = quality_rows(functions, "images", COUNTS, WAYS)
    if json:
        print_json(about | {"f_measure": rows, "ids": dict(ids)})
        return
    print_quality(rows, about["rooms"])
    aligned, as_given = about["agreement"]
    show(f"agreement of the images of a room: {aligned:.3f} in the median, {as_given:.3f} by poses as given")
    show(f"{ids['kept']} of {ids['again']} objects that were found in two updates in a row kept their id")
    gone = f"{ids['noticed']} of {ids['removed']} that were taken out"
    show(f"gone: {gone}, {ids['lost']} of {ids['stayed']} that stayed")


def fused_rooms(
    data: str, rooms: int, noise: float, pose_error: float, seed: int, failures: Failures
) -> Iterator[FusedRoom]:
    """Yield furnished rooms whose images are to be fused; the model for scans that ships recognises them."""
    classifier = inference_model(shipped_model("fast", scans=True), None)
    furnished = furnish_lived_in(open_dataset(data), rooms, seed=seed, failed=failures.add, lived_in=LivedIn())
    for room in progress(furnished, rooms, "fusing rooms"):
        yield FusedRoom(room, classifier, noise, pose_error, seed)


def main(
    data: Annotated[str, typer.Argument(metavar="DATA", help="Meshes: a folder with manifest.csv, or a catalogue.")],
    rooms: Annotated[int, typer.Option(min=1, help="Number of rooms.")] = 8,
    noise: Annotated[float, typer.Option(help="Noise of the images, as a multiple of a Kinect's.")] = 1.0,
    pose_error: Annotated[float, typer.Option(min=0, help="Deviation of the poses along each axis, metres.")] = 0.0,
    seed: options.Seed = 0,
    json: options.Json = False,
):
    """Measure objects of virtual rooms in maps of 1, 3, 6 and 12 depth images."""
    functions, ids, failures, agreements = defaultdict(dict), Counter(), Failures(), []
    for fused in fused_rooms(data, rooms, noise, pose_error, seed, failures):
        fused.count(functions, ids)
        fused.count_removal(ids)
        agreements.append(fused.agreement)
    about = {"data": data, "rooms": rooms, "noise": noise, "pose_error": pose_error, "seed": seed}
    about["agreement"] = np.median(agreements, axis=0).tolist()
    report(functions, ids, about, json)
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
