"""``spherefunc scene --frames``: a room from depth images over time, whose objects keep their ids."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from spherefunc_bullet.console import Failures, print_json, print_table, progress, say, show
from spherefunc_bullet.errors import InputError, one_line

EVERY = 10  # images between two updates of the objects

if TYPE_CHECKING:
    from ..fusion.frames import Frames
    from ..fusion.scene_fusion import FusedObject, SceneFusion
    from ..recognition.room import Room
    from ..scans.scan import Scan


def require_frames_alone(frames: Path | None, others: dict[str, object], only: dict[str, object]):
    """Raise InputError for options of single scans with --frames, and those of --frames without it."""
    wrong, beside = (others, "without --frames") if frames is not None else (only, "with --frames DIR")
    name = next((name for name, value in wrong.items() if value is not None), None)
    if name is not None:
        raise InputError(f"{name}: expected {beside}")


def scene_of_frames(
    fusion: SceneFusion,
    source: Frames,
    folder: Path,
    *,
    every: int,
    out: Path | None,
    json: bool,
    remarks: Callable[[Scan, Room], None],
):
    """Fuse the images of a folder, write and print what was found, and leave with code 2 if any was left out."""
    from ..report.files import room_json

    failures = Failures()
    objects = fuse(fusion, source, every, failures)
    scan, room = fusion.scan, fusion.room
    remarks(scan, room)
    if out is not None:
        write_files(scan, room, out, folder.resolve().name)
    if json:
        whole = room_json(scan, room) | {"file": str(folder)} | fused_json(fusion, source)
        print_json(whole | {"objects": [tracked_json(*pair) for pair in zip(whole["objects"], objects, strict=True)]})
    else:
        print_fused(fusion, objects)
    failures.exit()


def write_files(scan: Scan, room: Room, out: Path, stem: str):
    """Write the files of a room, and say which."""
    from ..report.files import write_room

    for path in write_room(scan, room, out, stem):
        say(f"wrote {path}")


def fuse(fusion: SceneFusion, source: Frames, every: int, failures: Failures) -> list[FusedObject]:
    """Add the images of a folder one by one, recognise after this many, and return the objects at the end.

    An image that cannot be used is said and left out, and the rest goes on; not so where odometry is lost.
    """
    from ..fusion.tracking import OdometryLost

    for count, frame in enumerate(progress(source.frames, len(source.frames), "fusing"), start=1):
        try:
            depth = frame.depth()
            pose = frame.T_world_camera() if source.posed else None
            fusion.add(depth, source.camera_of(depth), pose, one_line(frame.path.name))
        except OdometryLost:
            raise
        except InputError as error:
            failures.add(error)
        if every and count % every == 0 and count < len(source.frames) and fusion.views:
            fusion.objects()
    if not fusion.views:
        raise InputError(f"{len(source.frames)} images: expected at least one that can be used, found none")
    return fusion.objects()


def fused_json(fusion: SceneFusion, source: Frames) -> dict[str, object]:
    """Return for JSON what `room_json` does not know: ids, images and motions of the objects."""
    return {
        "frames": {"fused": len(fusion.views), "left_out": len(source.frames) - len(fusion.views)},
        "poses": "given" if source.posed else "odometry",
        "gone": [
            {
                "id": item.id,
                "functions": sorted(item.functions),
                "center": item.center.round(4).tolist(),
                "seen": item.seen,
            }
            for item in fusion.gone
        ],
        "stages": {name: round(seconds, 4) for name, seconds in (fusion.stages | fusion.room.stages).items()},
    }


def tracked_json(row: dict[str, object], item: FusedObject) -> dict[str, object]:
    """Return an object's row with the id that it keeps; ``label`` is its number in the labelled PLY."""
    moved = None if item.moved is None else item.moved.round(4).tolist()
    return row | {"id": item.id, "label": item.label, "seen": item.seen, "moved": moved}


def print_fused(fusion: SceneFusion, objects: list[FusedObject]):
    """Print the objects with a function, and what moved or is gone."""
    names = fusion.room.function_names
    rows = [
        [str(item.id), ", ".join(sorted(item.functions)), *(f"{item.scores[name]:.2f}" for name in names)]
        + [" × ".join(f"{100 * side:.0f}" for side in item.box.size)]
        + [" ".join(f"{place:.2f}" for place in item.box.center), str(item.seen), motion_text(item)]
        for item in objects
        if item.functions
    ]
    columns = ["id", "for", *names, "size, cm", "centre, m", "images", "moved, m"]
    print_table(f"{len(fusion.views)} depth images: what objects are for, and the score of each", columns, rows)
    show(f"{len(rows)} objects with a function, {len(objects) - len(rows)} without; {len(fusion.gone)} gone")
    stages = ", ".join(f"{name} {seconds:.2f}" for name, seconds in fusion.stages.items())
    show(f"seconds of the last image and the last update: {stages}")
    for one in fusion.gone:
        say(f"gone: object {one.id}, {', '.join(sorted(one.functions)) or 'of no function'}")


def motion_text(item: FusedObject) -> str:
    """Return an object's last motion as a text, empty for none."""
    return "" if item.moved is None else " ".join(f"{shift:.2f}" for shift in item.moved)
