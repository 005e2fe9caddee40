"""``spherefunc scene --frames``: the objects of a room from depth images over time; they keep their ids."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from spherefunc_bullet.console import Failures, print_json, print_table, progress, say, show
from spherefunc_bullet.errors import InputError, one_line
from spherefunc_bullet.formats.files import prepare_folder, require_place

EVERY = 10  # images between two updates of the objects

if TYPE_CHECKING:
    import numpy as np

    from spherefunc_bullet.places.place import Place

    from ..fusion.frames import Frames
    from ..fusion.scene_fusion import FusedObject, SceneFusion
    from ..recognition.room import InferredObject, Room
    from ..report.room_places import PlacesByObject
    from ..scans.scan import Scan


def require_outputs(out: Path, source: Path, stem: str, others: Iterable[Path | None]):
    """Raise InputError, before anything is read, if a room's files cannot be written or would change what is read."""
    from ..report.files import room_files

    prepare_folder(out)
    if any(place.is_dir() and out.samefile(place) for place in (source, source / "depth")):
        raise InputError(f"--out {out}: expected another folder than the one of the images, a picture would join them")
    for path in room_files(out, stem):
        require_place(path, [source, *filter(None, others)])


def scene_of_frames(
    fusion: SceneFusion,
    source: Frames,
    folder: Path,
    *,
    every: int,
    out: Path | None,
    json: bool,
    remarks: Callable[[Scan, Room], None],
    use: Callable[[Scan, Room], dict[int | None, list[Place]] | None],
):
    """Fuse the images of a folder, write and print the objects, and exit with code 2 if an image was left out."""
    failures = Failures()
    objects = fuse(fusion, source, every, failures)
    remarks(fusion.scan, fusion.room)
    used = use(fusion.scan, fusion.room)
    about = fused_json(fusion, source, objects, used) | {"file": str(folder)}
    if out is not None:
        write_files(fusion.scan, fusion.room, out, folder.resolve().name, about, used)
    if json:
        print_json(about)
    else:
        print_fused(fusion, objects)
        print_used("fused", {fusion.ids.get(owner): found for owner, found in (used or {}).items()})
    failures.exit()


def write_files(scan: Scan, room: Room, out: Path, stem: str, about: dict[str, object], used: PlacesByObject | None):
    """Write the files of a room with its JSON and its places, and print their paths."""
    from ..report.files import write_room

    for path in write_room(scan, room, out, stem, about, used):
        say(f"wrote {path}")


def fuse(fusion: SceneFusion, source: Frames, every: int, failures: Failures) -> list[FusedObject]:
    """Add the images of a folder one by one, recognise after every so many, and return the objects at the end.

    An image that cannot be used is reported and left out; so are all images from that on at which odometry is lost.
    """
    from ..fusion.tracking import OdometryLost

    for count, frame in enumerate(progress(source.frames, len(source.frames), "fusing"), start=1):
        try:
            depth = frame.depth()
            pose = frame.T_world_camera() if source.posed else None
            fusion.add(depth, source.camera_of(depth), pose, one_line(frame.path.name))
        except OdometryLost as error:
            failures.add(error)
            break
        except InputError as error:
            failures.add(error)
        if every and count % every == 0 and count < len(source.frames) and fusion.views:
            with suppress(InputError):  # too little is seen so far
                fusion.objects()
    if not fusion.views:
        raise InputError(f"{len(source.frames)} images: expected at least one that can be used, found none")
    return fusion.objects(whole=True)


def fused_json(
    fusion: SceneFusion, source: Frames, objects: list[FusedObject], used: dict[int | None, list[Place]] | None
) -> dict[str, object]:
    """Return a fused room for JSON: what `room_json` returns, and ids, images, poses, and objects that are gone."""
    from ..report.files import inferred_json, room_json

    whole = room_json(fusion.scan, fusion.room, used)
    inferred = inferred_at_ids(fusion)
    whole["inferred"] = [inferred_json(item, fusion.room) for item in inferred]
    reasons = {old.reason: new.reason for old, new in zip(fusion.room.inferred, inferred, strict=True)}
    for place in whole.get("places", ()):
        note = place.get("note", "")
        if known := [reason for reason in reasons if note.endswith(reason)]:
            place["note"] = note.removesuffix(known[0]) + reasons[known[0]]
    for row, item in zip(whole["objects"], objects, strict=True):
        moved = None if item.moved is None else item.moved.round(4).tolist()
        row |= {"id": item.id, "label": item.label, "seen": item.seen, "moved": moved}  # label: in the labelled PLY
    return whole | {
        "frames": {"fused": fusion.count, "left_out": len(source.frames) - fusion.count},
        "poses": "given" if source.posed else "odometry",
        "agreement": None if fusion.map.agreement is None else round(fusion.map.agreement, 4),
        "gone": [
            {"id": one.id, "functions": sorted(one.functions), "center": one.center.round(4).tolist(), "seen": one.seen}
            for one in fusion.gone
        ],
        "stages": {name: round(seconds, 4) for name, seconds in (fusion.stages | fusion.room.stages).items()},
    }


def inferred_at_ids(fusion: SceneFusion) -> list[InferredObject]:
    """Return what is inferred at tables that have the ids of the fused objects, in place of their labels."""
    return [item.at(fusion.ids[item.table]) for item in fusion.room.inferred]


def print_fused(fusion: SceneFusion, objects: list[FusedObject]):
    """Print the objects with a function, and those that are gone."""
    from ..report.files import object_cells

    rows = []
    for item in objects:
        if item.functions:
            functions = ", ".join(sorted(item.functions))
            cells = object_cells(fusion.room, fusion.room.objects[item.label], functions, item.unsure)
            moved = "" if item.moved is None else position_text(item.moved)
            rows.append([str(item.id), *cells, position_text(item.box.center), str(item.seen), moved])
    title = f"{fusion.count} depth image{'s' * (fusion.count != 1)}"
    show(f"{print_objects(title, fusion.room, rows, 'id', 'images', 'moved, m')}; {len(fusion.gone)} gone")
    print_inferred(inferred_at_ids(fusion))
    stages = ", ".join(f"{name} {seconds:.2f}" for name, seconds in fusion.stages.items())
    show(f"seconds of the last image and the last update: {stages}")
    for one in fusion.gone:
        say(f"gone: object {one.id}, {', '.join(sorted(one.functions)) or 'of no function'}")


def print_inferred(items: Iterable[InferredObject]):
    """Print a line for each object that was not seen, but inferred."""
    for item in items:
        show(f"inferred, not counted: {item.function}, since {item.reason}")


def print_objects(title: str, room: Room, rows: list[list[str]], first: str, *last: str) -> str:
    """Print the rows of the objects with a function; return in words how many have one, and how many do not."""
    columns = [first, "for", *room.function_names, "size, cm", "centre, m", *last]
    says = "what objects are for, the score of each function, and in brackets the threshold that it has to exceed"
    print_table(f"{title}: {says}", columns, rows)
    return f"{len(rows)} object{'s' * (len(rows) != 1)} with a function, {len(room.objects) - len(rows)} without"


def position_text(position: np.ndarray) -> str:
    """Return coordinates (3,), metres, as text."""
    return " ".join(f"{round(float(coordinate), 2) + 0.0:.2f}" for coordinate in position)  # no -0.00


def print_used(name: str, used: dict[int | None, list[Place]]):
    """Print the places of each object, by its number, as lines."""
    from spherefunc_bullet.places.words import HEAD, place_columns

    rows = [
        ["" if owner is None else str(owner), *place_columns(place.as_json())]
        for owner, found in used.items()
        for place in found
    ]
    print_table(f"{name}: where it can be used", ["object", *HEAD], rows)
