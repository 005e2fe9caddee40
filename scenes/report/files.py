"""A recognised room as files: JSON, a labelled PLY, a picture, and a page."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from spherefunc_bullet.formats.ply import ply_bytes
from spherefunc_bullet.formats.writing import write_bytes, write_text, writing
from spherefunc_bullet.places.place import Place

from ..recognition.room import Inferred, Room, SceneObject
from ..scans.scan import Scan
from .colours import function_colour, point_colours

Used = Mapping[int | None, Sequence[Place]]  # the places of each object, under None those of none
_PLAIN = np.array([200, 200, 200], np.uint8)  # of an object without a function, in the labelled PLY


def room_json(scan: Scan, room: Room, places: Used | None = None) -> dict[str, object]:
    """Return what was found, for JSON; all of it in metres and in the scan's own frame, or the one named."""
    levelling, counts = room.levelling, np.bincount(room.labels[room.labels >= 0])
    return {
        "file": scan.name,
        "points": len(scan),
        "dropped": scan.dropped,
        **({} if scan.level_frame is None else {"frame": scan.level_frame}),
        "floor": {
            "normal": levelling.up.round(6).tolist(),
            "height": round(levelling.height, 4),
            "seen": levelling.floor_seen,
            "from": levelling.source,
        },
        "up": levelling.up.round(6).tolist(),
        "T_level_scan": levelling.T_level_scan.round(6).tolist(),
        "objects": [
            object_json(item, room, int(counts[item.id])) | places_json(item.id, places) for item in room.objects
        ],
        **places_json(None, places),
        "inferred": [inferred_json(item, room) for item in room.inferred],
        "stages": {name: round(seconds, 4) for name, seconds in room.stages.items()},
        "seconds": round(sum(room.stages.values()), 3),
    }


def places_json(owner: int | None, places: Used | None) -> dict[str, object]:
    """Return for JSON the places of one object, or those of none; nothing where none were asked for."""
    return {} if places is None else {"places": [place.as_json() for place in places.get(owner, [])]}


def inferred_json(item: Inferred, room: Room) -> dict[str, object]:
    """Return for JSON what was not seen, but has its place."""
    corners = room.levelling.to_scan(item.box.corners)
    return {
        "function": item.function,
        "table": item.table,
        "size": item.box.size.round(4).tolist(),
        "corners": corners.round(4).tolist(),
        "reason": item.reason,
    }


def object_json(item: SceneObject, room: Room, points: int) -> dict[str, object]:
    """Return one object for JSON."""
    box = room.box_in_scan(item.box)
    axes = item.box.axes @ room.levelling.T_level_scan[:3, :3]
    doubts = room.doubts(item)
    return {
        "id": item.id,
        "points": points,
        "box": {
            "center": box.center.round(4).tolist(),
            "size": box.size.round(4).tolist(),
            "yaw": round(box.yaw, 4),
            "axes": axes.round(6).tolist(),
            "corners": room.levelling.to_scan(item.box.corners).round(4).tolist(),
        },
        "support": round(item.support, 4),
        "fragment": item.fragment,
        "proposed_by": item.proposed_by,
        **({} if item.made_from is None else {"from": item.made_from, "height": item.height}),
        "functions": {
            name: asdict(membership) | {"bar": room.bar(item, name)} for name, membership in item.functions.items()
        },
        "unsure": bool(doubts),
        "reasons": [*room.reasons(item), *doubts],
    }


def labelled_ply(scan: Scan, room: Room) -> bytes:
    """Return the scan as a binary PLY in its own frame, with colour, label, and the function's own colour beside.

    ``label`` is an object's id, -1 the floor, -2 a wall or the ceiling, -3 what is left over; ``function`` is the
    place of the object's best function in the header's comment, from 1, and 0 for none.
    """
    names, best = room.function_names, [item.main_function for item in room.objects]
    function = np.array([0 if name is None else names.index(name) + 1 for name in best] + [0], np.uint8)
    tints = np.array([_PLAIN if name is None else function_colour(name, names) for name in best] + [_PLAIN], np.uint8)
    object_of = np.where(room.labels >= 0, room.labels, len(best))
    own = point_colours(scan, room, room.levelling.to_level(scan.points))
    red, green, blue = np.where((function[object_of] > 0)[:, None], tints[object_of], own).astype(np.uint8).T
    labels = {"label": room.labels.astype(np.int32), "function": function[object_of]}
    return ply_bytes(scan.points, f"functions {' '.join(names)}", red=red, green=green, blue=blue, **labels)


def write_room(scan: Scan, room: Room, folder: Path, stem: str) -> list[Path]:
    """Write ``STEM.json``, ``STEM_labelled.ply``, ``STEM.png`` and ``STEM.html`` to a folder, and return them.

    Raises
    ------
    InputError
        If they cannot be written.
    """
    from .page import room_page
    from .picture import room_picture

    paths = [folder / f"{stem}{end}" for end in (".json", "_labelled.ply", ".png", ".html")]
    write_text(paths[0], json.dumps(room_json(scan, room), indent=2) + "\n")
    write_bytes(paths[1], labelled_ply(scan, room))
    with writing(paths[2]):
        room_picture(scan, room).save(paths[2])
    write_text(paths[3], room_page(scan, room))
    return paths
