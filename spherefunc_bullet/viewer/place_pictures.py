"""Pictures of places: regions drawn on the object, a person drawn sitting, a stream drawn pouring."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..clouds.cloud import corners_of
from ..formats.writing import write_bytes

if TYPE_CHECKING:
    from mpl_toolkits.mplot3d import Axes3D

    from ..places.place import Place

MOST_POINTS = 6000
DRAWN = 0.25  # the least score of a place that is drawn
COLOURS = {"sit": "tab:red", "put": "tab:green", "pour": "tab:blue"}
# Joints of a sitter 1.75 m tall, ahead and up from the seat, metres: head, neck, hip, knee, foot, toes.
JOINTS = np.array([[-0.02, 0.86], [0.0, 0.60], [0.0, 0.08], [0.42, 0.10], [0.44, -0.36], [0.60, -0.38]])


def places_picture(shown: Sequence[tuple[str, np.ndarray, Sequence[Place]]]) -> bytes:
    """Return a PNG with a panel for each object: its name, its points (N, 3) with z up, and its places.

    Places and points are in one frame, metres.
    """
    from io import BytesIO

    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    columns = min(3, len(shown))
    rows = -(-len(shown) // columns)
    figure = Figure(figsize=(5 * columns, 5 * rows), dpi=100)
    for number, (name, points, places) in enumerate(shown):
        axes = figure.add_subplot(rows, columns, number + 1, projection="3d", computed_zorder=False)
        draw_object(axes, name, points, places)
        for place in (one for one in places if one.score >= DRAWN):
            draw_place(axes, place)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1 - 0.08 / rows, wspace=0)
    image = BytesIO()
    FigureCanvasAgg(figure).print_png(image)
    return image.getvalue()


def draw_object(axes: Axes3D, name: str, points: np.ndarray, places: Sequence[Place]):
    """Draw an object's points, in a frame that has room for whoever sits on it."""
    some = points[:: max(1, len(points) // MOST_POINTS)]
    axes.scatter(*some.T, s=1.5, c="0.6", linewidths=0, depthshade=False)
    low, high = corners_of(points)
    tall = max([high[2], *(place.position[2] + 0.9 for place in places if place.kind == "sit")])
    side = max(float((high - low).max()), float(tall - low[2])) / 2
    middle = (low + high) / 2
    axes.set(xlim=(middle[0] - side, middle[0] + side), ylim=(middle[1] - side, middle[1] + side))
    axes.set_zlim(low[2], low[2] + 2 * side)
    axes.set_box_aspect((1, 1, 1))
    axes.set_axis_off()
    axes.view_init(elev=25, azim=-55)
    axes.set_title(name)


def draw_place(axes: Axes3D, place: Place):
    """Draw one place's region, and how it is used."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    colour = COLOURS[place.kind]
    if place.region:
        axes.add_collection3d(Poly3DCollection([place.region[0]], facecolor=colour, alpha=0.25, zorder=2))
    for ring in place.region:
        axes.plot(*np.vstack([ring, ring[:1]]).T, c=colour, lw=1.5, zorder=3)
    if place.kind == "sit":
        draw_person(axes, place)
    elif place.kind == "pour":
        top = place.position + [0, 0, 3 * (place.depth or 0.05) / 2]
        axes.plot(*np.array([top, [*place.position[:2], place.height]]).T, c=colour, lw=4, zorder=4)
    for pose in place.poses[:20]:
        axes.scatter(*pose[:3, 3], c=colour, s=12, marker="x", zorder=4)


def draw_person(axes: Axes3D, place: Place):
    """Draw a person who sits there as sticks."""
    angle = np.radians(0.0 if place.heading_deg is None else place.heading_deg)
    ahead = np.array([np.cos(angle), np.sin(angle), 0.0])
    joints = place.position + JOINTS[:, :1] * ahead + JOINTS[:, 1:] * [0, 0, 1]
    axes.plot(*joints[1:].T, c="black", lw=4, solid_capstyle="round", zorder=5)
    axes.scatter(*joints[0], c="black", s=160, zorder=5)


def write_places_picture(shown: Sequence[tuple[str, np.ndarray, Sequence[Place]]], path: Path):
    """Write the picture of objects and their places."""
    write_bytes(path, places_picture(shown))
