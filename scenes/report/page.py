"""A room as a page for a browser: points and boxes to turn about, and a table of the objects."""

from __future__ import annotations

import json
from html import escape

import numpy as np

from spherefunc_bullet.viewer.data import packed, quantised, rounded
from spherefunc_bullet.viewer.page import viewer_file

from ..recognition.recognition import Room, main_function
from ..scans.scan import Scan
from .colours import function_colour, point_colours
from .picture import best_azimuth

MAX_POINTS = 250_000  # that a page carries, 9 bytes each
SCRIPTS = ("shaders.js", "camera.js", "drawing.js", "controls.js")


def room_page(scan: Scan, room: Room) -> str:
    """Return the page, complete in itself."""
    styles = "\n".join([viewer_file("viewer.css"), viewer_file("room.css", __package__), viewer_file("dark.css")])
    script = "\n".join([*(viewer_file(name) for name in SCRIPTS), viewer_file("room.js", __package__)])
    data = json.dumps(room_data(scan, room), separators=(",", ":")).replace("<", "\\u003c")
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n<link rel="icon" href="data:,">\n'
        f"<title>{escape(scan.name)}</title>\n<style>\n{styles}</style>\n</head>\n"
        f'<body class="scene-page">\n<h1>{escape(scan.name)}</h1>\n{lead_html(scan, room)}\n'
        f'<div class="room-scene"><script type="application/json">{data}</script></div>\n{table_html(room)}\n'
        f"<script>\n(() => {{\n{script}\n}})();\n</script>\n</body>\n</html>\n"
    )


def lead_html(scan: Scan, room: Room) -> str:
    """Return what stands above the picture."""
    found = sum(main_function(item) is not None for item in room.objects)
    return (
        f"<p class='lead'>{len(scan):,} points, {len(room.objects)} objects, {found} of them with a function; "
        f"levelled by: {escape(room.levelling.source)}. Drag to turn, right-drag to move, wheel to zoom (click first), "
        "double-click to reset.</p>"
    )


def room_data(scan: Scan, room: Room) -> dict:
    """Return what the viewer draws, for JSON."""
    points = room.levelling.to_level(scan.points)
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    shown = np.flatnonzero(((points > low - 0.5) & (points < high + 0.5)).all(axis=1))
    shown = shown[:: -(-len(shown) // MAX_POINTS)]
    names = list(room.objects[0].functions) if room.objects else []
    area = np.prod(np.sort(high - low)[1:])
    boxes = [
        {"function": name, "score": item.functions[name]["score"], "corners": rounded(item.box.corners)}
        for item in room.objects
        if (name := main_function(item)) is not None
    ]
    return {
        "name": scan.name,
        "points": quantised(points[shown]),
        "colours": packed(point_colours(scan, room, points)[shown].ravel(), np.uint8),
        "radius": float(np.clip(2.0 * np.sqrt(area / len(shown)), 0.002, 0.02)),
        "low": rounded(low),
        "high": rounded(high),
        "azimuth": float(np.radians(best_azimuth(points[shown], room.labels[shown], low, high))),
        "functions": {name: [each / 255 for each in function_colour(name, names)] for name in names},
        "boxes": boxes,
    }


def table_html(room: Room) -> str:
    """Return the objects as a table, those with a function first."""
    names = list(room.objects[0].functions) if room.objects else []
    order = sorted(room.objects, key=lambda item: (main_function(item) is None, item.id))
    head = "".join(f"<th class='number'>{escape(each)}</th>" for each in names)
    rows = [
        f"<tr><td>{item.id}</td><td>{escape(main_function(item) or 'none')}</td>"
        + "".join(f"<td class='number'>{item.functions[name]['score']:.2f}</td>" for name in names)
        + f"<td class='number'>{' × '.join(f'{100 * each:.0f}' for each in item.box.size)}</td>"
        f"<td class='number'>{len(item.points):,}</td></tr>"
        for item in order
    ]
    return (
        "<div class='scene scene-details'><table><tr><th>object</th><th>for</th>"
        f"{head}<th class='number'>size, cm</th><th class='number'>points</th></tr>\n"
        + "\n".join(rows)
        + "</table></div>"
    )
