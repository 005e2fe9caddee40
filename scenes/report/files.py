"""A recognised room as files: JSON, a labelled PLY, a picture, and a page."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from dataclasses import asdict
from html import escape
from pathlib import Path

import numpy as np

from spherefunc_bullet.formats.files import write_bytes, write_text
from spherefunc_bullet.formats.ply import ply_bytes
from spherefunc_bullet.viewer.data import packed, quantised, rounded
from spherefunc_bullet.viewer.page import page_html, table_html, viewer_file

from ..recognition.proposals import CLUSTERS, POOLS
from ..recognition.room import InferredObject, Room, SceneObject
from ..scans.scan import Scan
from ..segmentation.segmentation import WALL
from .picture import best_azimuth, function_colour, point_colours
from .room_places import BEAD, PlacesByObject, drawn_places, places_html

MAX_POINTS = 250_000  # that a page carries, 9 bytes each
PROPOSED = {CLUSTERS: "separate clusters of points", POOLS: "parts on which pools of spheres rest"}
WHY_LOW = (
    "The thresholds were chosen in rooms whose objects the model had not learnt. That of seats is low because most "
    "clusters with an unsure score for it were seats."
)
SCRIPTS = ("shaders.js", "camera.js", "drawing.js", "controls.js")


def room_page(scan: Scan, room: Room, used: PlacesByObject | None = None) -> str:
    """Return the interactive page of a room and its places, as one HTML text without other files."""
    style = "\n".join([viewer_file("viewer.css"), viewer_file("room.css", __package__), viewer_file("dark.css")])
    script = "\n".join([*(viewer_file(name) for name in SCRIPTS), viewer_file("room.js", __package__)])
    data = json.dumps(room_data(scan, room, used or {}), separators=(",", ":")).replace("<", "\\u003c")
    parts = [
        f"<h1>{escape(scan.name)}</h1>",
        lead_html(scan, room),
        f'<div class="room-display"><script type="application/json">{data}</script></div>',
        objects_html(room),
        places_html(used or {}),
        *(f"<p>Inferred, and not counted: {item.function}, since {escape(item.reason)}.</p>" for item in room.inferred),
    ]
    return page_html(scan.name, parts, style=style, script=script, kind="display-page")


def lead_html(scan: Scan, room: Room) -> str:
    """Return the paragraph above the picture."""
    functional = sum(item.main_function is not None for item in room.objects)
    return (
        f"<p class='lead'>{len(scan):,} points, {len(room.objects)} objects, {functional} of them with a function; "
        f"levelled by: {escape(room.levelling.source)}. Drag to turn, right-drag to move, wheel to zoom (click first), "
        "double-click to reset.</p>"
    )


def room_data(scan: Scan, room: Room, used: PlacesByObject) -> dict[str, object]:
    """Return the data of the viewer, for JSON."""
    points = room.levelling.to_level(scan.points)
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    shown = np.flatnonzero(((points > low - 0.5) & (points < high + 0.5)).all(axis=1))
    shown = shown[:: -(-len(shown) // MAX_POINTS)]
    is_wall = (room.labels[shown] == WALL) & (room.labels[shown] >= 0).any()  # of a scan without objects, all is shown
    shown = shown[np.argsort(is_wall, kind="stable")]
    names = room.function_names
    bead = BEAD * float((high - low).max())
    area = np.prod(np.sort(high - low)[1:])
    boxes = [
        {
            "function": name,
            "score": item.functions[name].score,
            "unsure": bool(room.doubts(item)),
            "corners": rounded(item.box.corners),
        }
        for item in room.objects
        if (name := item.main_function) is not None
    ]
    return {
        "name": scan.name,
        "points": quantised(points[shown]),
        "colours": packed(point_colours(scan, room, points)[shown].ravel(), np.uint8),
        "walls": int(is_wall.sum()),  # number of points of walls and ceiling, the last ones
        "middle": rounded(np.median(points[shown], axis=0)),
        "radius": float(np.clip(2.0 * np.sqrt(area / len(shown)), 0.002, 0.02)),
        "low": rounded(low),
        "high": rounded(high),
        "azimuth": float(np.radians(best_azimuth(points[shown], room.labels[shown], low, high))),
        "functions": {name: [channel / 255 for channel in function_colour(name, names)] for name in names},
        "boxes": boxes,
        "bead": bead,
        "uses": [
            {"name": use.words, "tint": [channel / 255 for channel in use.colour], "middles": quantised(use.beads)}
            for use in drawn_places(room, used, bead)
        ],
    }


def score_text(room: Room, item: SceneObject, function: str) -> str:
    """Return the score of one function of an object, and the threshold that it had to exceed."""
    return f"{item.functions[function].score:.2f} ({room.threshold(item, function):.2f})"


def object_cells(room: Room, item: SceneObject, functions: str, unsure: bool) -> list[str]:
    """Return the cells of an object in a table: what it is for, the score of each function, and its size."""
    scores = [score_text(room, item, name) for name in room.function_names]
    return [functions + ", unsure" * unsure, *scores, " × ".join(f"{100 * side:.0f}" for side in item.box.size)]


def objects_html(room: Room) -> str:
    """Return the tables of the objects with a function and, folded, of those without."""
    having = [item for item in room.objects if item.main_function is not None]
    others = [item for item in room.objects if item.main_function is None]
    parts = [f"<p>{escape(thresholds_text(room))}</p>"] if room.objects else []
    parts += [objects_table(room, having)] if having else []
    if others:
        count = f"{len(others)} {'others' if having else 'objects'} without a function"
        parts.append(f"<details><summary>{count}</summary>{objects_table(room, others)}</details>")
    return f'<div class="display display-details">{"".join(parts)}</div>'


def thresholds_text(room: Room) -> str:
    """Return a sentence with the threshold of each function, and why they differ."""
    proposed = {item.proposed_by: item for item in room.objects}
    texts = {
        by: ", ".join(f"{name} {room.threshold(proposed[by], name):.2f}" for name in room.function_names)
        for by in sorted(proposed)
    }
    if len(set(texts.values())) == 1:
        [values] = set(texts.values())
    else:
        values = "; ".join(f"{text} of {PROPOSED.get(by, by)}" for by, text in texts.items())
    text = f"A score counts as yes if it is above the threshold of its function, in brackets: {values}."
    sentences = [text, *([] if room.thresholds is None else [WHY_LOW])]
    for low, high in sorted(set(room.unsure_ranges.values())):
        names = " or ".join(name for name, between in room.unsure_ranges.items() if between == (low, high))
        sentences.append(f"An answer whose score for {names} is between {low:.2f} and {high:.2f} is unsure (?).")
    return " ".join(sentences)


def objects_table(room: Room, objects: Sequence[SceneObject]) -> str:
    """Return a table of some objects, in the order of their ids."""
    head = ["object", "for", *room.function_names, "size, cm", "points"]
    rows = [
        [
            str(item.id),
            *object_cells(room, item, item.main_function or "none", bool(room.doubts(item))),
            f"{len(item.points):,}",
        ]
        for item in sorted(objects, key=lambda item: item.id)
    ]
    return table_html(head, rows, texts=2)


_PLAIN = np.array([200, 200, 200], np.uint8)  # of an object without a function, in the labelled PLY
_DIGITS = 12  # after the point of directions and turns: with 6, points at UTM coordinates would be metres off


def room_json(scan: Scan, room: Room, places: PlacesByObject | None = None) -> dict[str, object]:
    """Return a room for JSON, in metres and in the scan's own frame, or the frame that is named."""
    levelling, counts = room.levelling, np.bincount(room.labels[room.labels >= 0])
    return {
        "file": scan.name,
        "points": len(scan),
        "dropped": scan.dropped,
        **({} if scan.level_frame is None else {"frame": scan.level_frame}),
        "floor": {
            "normal": levelling.up.round(_DIGITS).tolist(),
            "height": round(levelling.height, 4),
            "seen": levelling.floor_seen,
            "from": levelling.source,
        },
        "up": levelling.up.round(_DIGITS).tolist(),
        "T_level_scan": levelling.T_level_scan.round(_DIGITS).tolist(),
        "objects": [
            object_json(item, room, int(counts[item.id])) | places_json(item.id, places) for item in room.objects
        ],
        **places_json(None, places),
        "inferred": [inferred_json(item, room) for item in room.inferred],
        "stages": {name: round(seconds, 4) for name, seconds in room.stages.items()},
        "seconds": round(sum(room.stages.values()), 3),
    }


def places_json(owner: int | None, places: PlacesByObject | None) -> dict[str, object]:
    """Return for JSON the places of one object, or of no object; without places no field."""
    return {} if places is None else {"places": [place.as_json() for place in places.get(owner, [])]}


def inferred_json(item: InferredObject, room: Room) -> dict[str, object]:
    """Return an inferred object for JSON."""
    return {
        "function": item.function,
        "table": item.table,
        "size": item.box.size.round(4).tolist(),
        "corners": room.levelling.to_scan(item.box.corners).round(4).tolist(),
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
        "functions": {name: asdict(one) | {"bar": room.threshold(item, name)} for name, one in item.functions.items()},
        "unsure": bool(doubts),
        "reasons": [*room.reasons(item), *doubts],
    }


def labelled_ply(scan: Scan, room: Room) -> bytes:
    """Return the scan as a binary PLY in its own frame, with labels, coloured by function.

    ``label`` is an object's id, -1 the floor, -2 a wall or the ceiling, -3 points that are left over; ``function`` is
    the place of the object's best function in the header's comment, from 1, and 0 for none.
    """
    names, best = room.function_names, [item.main_function for item in room.objects]
    function = np.array([0 if name is None else names.index(name) + 1 for name in best] + [0], np.uint8)
    tints = np.array([_PLAIN if name is None else function_colour(name, names) for name in best] + [_PLAIN], np.uint8)
    object_of = np.where(room.labels >= 0, room.labels, len(best))
    colours = point_colours(scan, room, room.levelling.to_level(scan.points))
    red, green, blue = np.where((function[object_of] > 0)[:, None], tints[object_of], colours).astype(np.uint8).T
    labels = {"label": room.labels.astype(np.int32), "function": function[object_of]}
    return ply_bytes(scan.points, f"functions {' '.join(names)}", red=red, green=green, blue=blue, **labels)


def room_files(folder: Path, stem: str) -> list[Path]:
    """Return the paths of a room's JSON, labelled PLY, picture and page."""
    return [folder / f"{stem}{end}" for end in (".json", "_labelled.ply", ".png", ".html")]


def write_room(
    scan: Scan, room: Room, folder: Path, stem: str, about: dict[str, object], used: PlacesByObject | None
) -> list[Path]:
    """Write the files of a room, `room_files`, to a folder, and return their paths; ``about`` is its JSON.

    Raises
    ------
    InputError
        If they cannot be written.
    """
    from .picture import room_picture

    paths = room_files(folder, stem)
    write_text(paths[0], json.dumps(about, indent=2) + "\n")
    write_bytes(paths[1], labelled_ply(scan, room))
    room_picture(scan, room, used=used).save(picture := io.BytesIO(), "png")
    write_bytes(paths[2], picture.getvalue())
    write_text(paths[3], room_page(scan, room, used))
    return paths
