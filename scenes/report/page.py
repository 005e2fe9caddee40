"""A room as a page for a browser: points and boxes interactive, and a table of the objects."""

from __future__ import annotations

import json
from html import escape

import numpy as np

from spherefunc_bullet.viewer.data import packed, quantised, rounded
from spherefunc_bullet.viewer.page import page_html, table_html, viewer_file

from ..recognition.recognition import Room, SceneObject
from ..scans.scan import Scan
from .colours import function_colour, point_colours
from .picture import best_azimuth

MAX_POINTS = 250_000  # that a page carries, 9 bytes each
SCRIPTS = ("shaders.js", "camera.js", "drawing.js", "controls.js")


def room_page(scan: Scan, room: Room) -> str:
    """Return the page, complete in itself."""
    style = "\n".join([viewer_file("viewer.css"), viewer_file("room.css", __package__), viewer_file("dark.css")])
    script = "\n".join([*(viewer_file(name) for name in SCRIPTS), viewer_file("room.js", __package__)])
    data = json.dumps(room_data(scan, room), separators=(",", ":")).replace("<", "\\u003c")
    parts = [
        f"<h1>{escape(scan.name)}</h1>",
        lead_html(scan, room),
        f'<div class="room-display"><script type="application/json">{data}</script></div>',
        f'<div class="display display-details">{objects_table(room)}</div>',
        *(f"<p>Inferred, and not counted: {one.function}, since {escape(one.reason)}.</p>" for one in room.inferred),
    ]
    return page_html(scan.name, parts, style=style, script=script, kind="display-page")


def lead_html(scan: Scan, room: Room) -> str:
    """Return what stands above the picture."""
    functional = sum(item.main_function is not None for item in room.objects)
    return (
        f"<p class='lead'>{len(scan):,} points, {len(room.objects)} objects, {functional} of them with a function; "
        f"levelled by: {escape(room.levelling.source)}. Drag to turn, right-drag to move, wheel to zoom (click first), "
        "double-click to reset. In brackets is the bar that a score has to pass: the object then has the function.</p>"
    )


def room_data(scan: Scan, room: Room) -> dict[str, object]:
    """Return what the viewer draws, for JSON."""
    points = room.levelling.to_level(scan.points)
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    shown = np.flatnonzero(((points > low - 0.5) & (points < high + 0.5)).all(axis=1))
    shown = shown[:: -(-len(shown) // MAX_POINTS)]
    names = room.function_names
    area = np.prod(np.sort(high - low)[1:])
    boxes = [
        {"function": name, "score": item.functions[name].score, "corners": rounded(item.box.corners)}
        for item in room.objects
        if (name := item.main_function) is not None
    ]
    return {
        "name": scan.name,
        "points": quantised(points[shown]),
        "colours": packed(point_colours(scan, room, points)[shown].ravel(), np.uint8),
        "radius": float(np.clip(2.0 * np.sqrt(area / len(shown)), 0.002, 0.02)),
        "low": rounded(low),
        "high": rounded(high),
        "azimuth": float(np.radians(best_azimuth(points[shown], room.labels[shown], low, high))),
        "functions": {name: [channel / 255 for channel in function_colour(name, names)] for name in names},
        "boxes": boxes,
    }


def score_text(room: Room, item: SceneObject, function: str) -> str:
    """Return the score of one function of an object, and the bar that it had to pass."""
    return f"{item.functions[function].score:.2f} ({room.bar(item, function):.2f})"


def objects_table(room: Room) -> str:
    """Return the objects as a table, those with a function first."""
    head = ["object", "for", *room.function_names, "size, cm", "points"]
    rows = [
        [str(item.id), item.main_function or "none"]
        + [score_text(room, item, name) for name in item.functions]
        + [" × ".join(f"{100 * side:.0f}" for side in item.box.size), f"{len(item.points):,}"]
        for item in sorted(room.objects, key=lambda item: (item.main_function is None, item.id))
    ]
    return table_html(head, rows, texts=2)
