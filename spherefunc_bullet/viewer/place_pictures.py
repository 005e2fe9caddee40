"""Pictures and pages of places: their regions on the object, a person who sits there, a stream that is poured.

The person is made of rods with round ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..clouds.cloud import Cloud, corners_of
from ..formats.files import write_text
from ..places.place import SHOWN, Place, Similarity
from ..places.words import HEAD, lengths_in, place_columns

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d import Axes3D

    from .data import Panel

Rod = tuple[Sequence[float] | np.ndarray, Sequence[float] | np.ndarray, float]  # ends, radius
TALL = 1.75  # metres, height of the person whose dimensions follow
SHANK = 0.46  # metres from the knee to the ankle
FOOT = 0.045  # metres: radius of a foot and of a shank
KNEE = np.array([0.42, 0.10, 0.07])
# Ahead, to the left, and up from the seat, metres; the left one of limbs that come in pairs.
SINGLE: tuple[Rod, ...] = (
    ((0.0, 0.0, 0.12), (0.0, 0.0, 0.48), 0.10),  # trunk
    ((0.0, -0.15, 0.55), (0.0, 0.15, 0.55), 0.055),  # shoulders
    ((0.0, 0.0, 0.57), (0.01, 0.0, 0.70), 0.045),  # neck
    ((0.02, 0.0, 0.76), (0.02, 0.0, 0.80), 0.09),  # head
)
PAIRED: tuple[Rod, ...] = (
    ((0.0, 0.06, 0.10), (0.0, 0.08, 0.48), 0.08),  # side of the trunk
    ((0.0, 0.08, 0.07), tuple(KNEE), 0.07),  # thigh
    ((0.0, 0.20, 0.54), (-0.02, 0.23, 0.26), 0.042),  # upper arm
    ((-0.02, 0.23, 0.26), (0.27, 0.13, 0.17), 0.036),  # forearm, with the hand on the thigh
)


@dataclass(frozen=True, eq=False)
class Limb:
    """A rod with round ends, metres."""

    start: np.ndarray  # (3,)
    end: np.ndarray  # (3,)
    radius: float

    def surface(self, step: float) -> np.ndarray:
        """Return a grid of points (rows, columns, 3) on the surface, about a step apart; each row is a closed ring."""
        length = np.linalg.norm(self.end - self.start)
        axis = (self.end - self.start) / length
        aside = np.cross(axis, [1.0, 0.0, 0.0] if abs(axis[0]) < 0.9 else [0.0, 1.0, 0.0])
        aside /= np.linalg.norm(aside)
        bow = np.linspace(0, np.pi / 2, 1 + max(2, round(self.radius * np.pi / 2 / step)))
        straight = np.linspace(0, length, 1 + max(1, round(length / step)))[1:-1]
        along = np.concatenate([-self.radius * np.cos(bow), straight, length + self.radius * np.sin(bow)])
        wide = self.radius * np.concatenate([np.sin(bow), np.ones(len(straight)), np.cos(bow)])
        turn = np.linspace(0, 2 * np.pi, 1 + max(8, round(2 * np.pi * self.radius / step)))
        around = np.cos(turn)[:, None] * aside + np.sin(turn)[:, None] * np.cross(axis, aside)
        return self.start + along[:, None, None] * axis + wide[:, None, None] * around

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Return whether points (N, 3) are inside."""
        way = self.end - self.start
        share = np.clip((points - self.start) @ way / (way @ way), 0, 1)
        return np.linalg.norm(points - self.start - share[:, None] * way, axis=1) < 0.98 * self.radius


def seated_person(place: Place, person: float = TALL) -> list[Limb]:
    """Return the limbs of a person, of a height in metres, who sits at a place.

    Both feet are on the ground if the seat is low enough.
    """
    scale = person / TALL
    angle = np.radians(0.0 if place.heading_deg is None else place.heading_deg)
    ahead, left = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([-np.sin(angle), np.cos(angle), 0.0])
    axes = scale * np.stack([ahead, left, [0.0, 0.0, 1.0]])
    limbs = [*SINGLE]
    for start, end, radius in (*PAIRED, *shank_and_foot(place.height / scale)):
        limbs += [(np.multiply(start, (1, side, 1)), np.multiply(end, (1, side, 1)), radius) for side in (1, -1)]
    return [Limb(place.position + start @ axes, place.position + end @ axes, scale * r) for start, end, r in limbs]


def shank_and_foot(height: float) -> list[Rod]:
    """Return the left shank and foot for the height of a seat, metres; on a low seat they are further ahead."""
    down = float(np.clip(height + KNEE[2] - FOOT, 0.1, SHANK))
    ankle = KNEE + [np.sqrt(SHANK**2 - down**2), 0.0, -down]
    return [(KNEE, ankle, FOOT), (ankle, ankle + [0.17, 0.0, 0.0], FOOT)]


def person_faces(limbs: list[Limb]) -> np.ndarray:
    """Return the surface of a person as quadrangles (N, 4, 3)."""
    grids = [limb.surface(0.04) for limb in limbs]
    corners = [np.stack([g[:-1, :-1], g[:-1, 1:], g[1:, 1:], g[1:, :-1]], axis=2).reshape(-1, 4, 3) for g in grids]
    return np.concatenate(corners)


def person_points(limbs: list[Limb], step: float) -> np.ndarray:
    """Return points (N, 3) on the surface of a person, about a step apart."""
    points = []
    for limb in limbs:
        surface = limb.surface(step)[:, :-1].reshape(-1, 3)
        inside = np.any([other.holds(surface) for other in limbs if other is not limb], axis=0)
        points.append(surface[~inside])
    return np.concatenate(points)


MOST_POINTS = 6000
DRAWN = 0.25  # least score of a place that is drawn
BEAD = 0.01  # of the object's largest extent: radius of the spheres that lines are made of
COLOURS = {"sit": "#d62728", "put": "#2ca02c", "pour": "#1f77b4"}  # red, green, blue
BODY = "0.45"  # the grey of a person
FAILED = "0.35"  # the grey of a place that did not hold when it was used
WORDS = {"sit": "a place to sit", "put": "a place to put something", "pour": "a place to pour"}
WORDS[FAILED] = "did not hold when it was used"
EXPLAINED = (
    "Pale: the object. Drawn with small spheres, coloured by height: the outline of each place, a person "
    "{person:g} m tall who sits there, a stream that is poured; single spheres are poses in which the object can be "
    "put down. Drag to turn, scroll to zoom. In tables are {lengths}; positions are those of the file."
)


def places_picture(shown: Sequence[tuple[str, np.ndarray, Sequence[Place]]], person: float = TALL) -> bytes:
    """Return a PNG with a panel for each object: name, points (N, 3) and places, in one frame, z up, metres."""
    from matplotlib.figure import Figure

    from .still import png_of_figure

    columns = min(3, len(shown))
    rows = -(-len(shown) // columns)
    figure = Figure(figsize=(5 * columns, 5 * rows), dpi=100)
    for number, (name, points, places) in enumerate(shown):
        axes = figure.add_subplot(rows, columns, number + 1, projection="3d", computed_zorder=False)
        drawn = [one for one in places if one.score >= DRAWN]
        count = sum(place.score >= SHOWN for place in places)
        title = f"{name}, {len(drawn)} of {count} places" if len(drawn) < count else name
        draw_object(axes, title, points, places, person)
        for place in sorted(drawn, key=did_not_hold, reverse=True):
            draw_place(axes, place, person)
    figure.subplots_adjust(left=0, right=1, bottom=0.08 / rows, top=1 - 0.08 / rows, wspace=0)
    add_legend(figure, [place for _, _, places in shown for place in places if place.score >= DRAWN], person)
    return png_of_figure(figure)


def add_legend(figure: Figure, places: Sequence[Place], person: float):
    """Add a legend below the panels with the colours that occur in them."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    used = {(FAILED if did_not_hold(place) else place.kind) for place in places}
    shown = {kind: words for kind, words in WORDS.items() if kind in used}
    keys = [Patch(facecolor=COLOURS.get(kind, FAILED), alpha=0.6, label=words) for kind, words in shown.items()]
    if "sit" in used:
        keys.append(Patch(facecolor=BODY, label=f"a person {person:g} m tall who sits there"))
    if any(place.poses for place in places):
        cross = {"color": COLOURS["put"], "marker": "x", "markersize": 4, "linestyle": ""}
        keys.append(Line2D([], [], label="where the object can stand", **cross))
    if keys:
        abreast = min(len(keys), 2 * len(figure.axes[:3]))  # two below each panel
        figure.legend(handles=keys, loc="lower center", ncols=abreast, frameon=False, columnspacing=1, fontsize=9)


def did_not_hold(place: Place) -> bool:
    """Return whether a place has a proof that failed."""
    return place.proven is not None and not place.proven.holds


def draw_object(axes: Axes3D, name: str, points: np.ndarray, places: Sequence[Place], person: float):
    """Draw the points of an object, with room for persons who sit on it."""
    some = points[:: max(1, len(points) // MOST_POINTS)]
    axes.scatter(*some.T, s=1.5, c="0.6", linewidths=0, depthshade=False)
    low, high = corners_of(points)
    tall = max([high[2], *(place.position[2] + 0.54 * person for place in places if place.kind == "sit")])
    side = max(float((high - low).max()), float(tall - low[2])) / 2
    middle = (low + high) / 2
    axes.set(xlim=(middle[0] - side, middle[0] + side), ylim=(middle[1] - side, middle[1] + side))
    axes.set_zlim(low[2], low[2] + 2 * side)
    axes.set_box_aspect((1, 1, 1))
    axes.set_axis_off()
    axes.view_init(elev=25, azim=-55)
    axes.set_title(name)


def draw_place(axes: Axes3D, place: Place, person: float):
    """Draw the region of a place, and how it is used."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    failed = did_not_hold(place)
    colour = FAILED if failed else COLOURS[place.kind]
    if place.region and not failed:
        axes.add_collection3d(Poly3DCollection([place.region[0]], facecolor=colour, alpha=0.25, zorder=2))
    for ring in place.region:
        axes.plot(*np.vstack([ring, ring[:1]]).T, c=colour, lw=1.0 if failed else 1.5, zorder=2 if failed else 3)
    if place.kind == "sit":
        faces = person_faces(seated_person(place, person))
        look = {"facecolors": FAILED, "alpha": 0.12} if failed else {"facecolors": BODY, "shade": True}
        axes.add_collection3d(Poly3DCollection(faces, **look, zorder=5))
    elif place.kind == "pour":
        axes.plot(*stream_of(place).T, c=colour, lw=4, zorder=4)
    axes.scatter(*put_down(place).T, c=colour, s=12, marker="x", depthshade=False, zorder=4)


def heading_unknown(place: Place) -> bool:
    """Return whether too little was seen of a seat to say which way one faces there; on a stool it is any."""
    return place.inferred and place.heading_deg is None


def put_down(place: Place) -> np.ndarray:
    """Return the middle of the base of the object that is put down, in each pose of a place, (K, 3).

    Poses are of the object's frame, whose origin may be far from it; in the first, the base is at the position.
    """
    if not place.poses:
        return np.empty((0, 3))
    base = place.poses[0][:3, :3].T @ (place.position - place.poses[0][:3, 3])
    return np.array([pose[:3, :3] @ base + pose[:3, 3] for pose in place.poses])


def stream_of(place: Place) -> np.ndarray:
    """Return the ends (2, 3) of the stream that is poured at a place."""
    return np.array([place.position + [0, 0, 3 * (place.depth or 0.05) / 2], [*place.position[:2], place.height]])


def write_places_page(
    shown: Sequence[tuple[Cloud, Similarity, Sequence[Place]]], path: Path, person: float = TALL, unit: str = "m"
):
    """Write an interactive page of objects: clouds, transformations to the input's frame, and places in that.

    Outlines, persons and streams are made of small spheres, each kind of place in a panel of its own. Places of
    functions that an object does not have are left out.
    """
    from .page import display_page
    from .still import pictured

    parts = [f"<p>{EXPLAINED.format(person=person, lengths=lengths_in(unit))}</p>"]
    for cloud, to_input, places in shown:
        drawn = [place for place in places if place.score >= SHOWN]
        by_kind = {kind: [place for place in drawn if place.kind == kind] for kind in COLOURS}
        some = [panel_of(cloud, to_input, *kind, person, unit) for kind in by_kind.items() if kind[1]]
        parts.append(f"<h1>{escape(cloud.name)}</h1>")
        parts.append(pictured(cloud, some, some) if some else "<p>No place.</p>")
        if count := len(places) - len(drawn):
            what = f"{count} {'place' if count == 1 else 'places'}"
            parts.append(f"<p>Not shown: {what} of functions that the object does not have.</p>")
    write_text(path, display_page("Places", parts))


def panel_of(cloud: Cloud, to_input: Similarity, kind: str, places: Sequence[Place], person: float, unit: str) -> Panel:
    """Return the panel for the places of one kind."""
    from ..learning.reasons.cubes import Cubes
    from .data import Layer, Panel
    from .page import table_html

    radius = float(np.clip(BEAD * cloud.size.max(), 0.0005, 0.02))
    rows = []
    for one in places:
        clearance = "open" if one.clearance is None else f"{one.clearance:.2g}"
        rows.append([*place_columns(one.as_json(), unit)[1:], clearance, str(one.proven or "")])
    columns = len(rows[0]) - (not any(row[-1] for row in rows))  # without proofs no column of them
    table = table_html([*HEAD[1:], "free above", "proof"][:columns], [row[:columns] for row in rows], texts=0)
    none = Cubes(side=1.0, corners=np.empty((0, 3)), counts=np.empty(0))
    beads = beads_of([place.moved_back(to_input) for place in places], radius, person)
    layer = Layer(radius=radius, centers=beads, cubes=none, note="", details=table)
    return Panel(title=f"places to {kind}: {len(places)}", layers=[layer])


def beads_of(places: Sequence[Place], radius: float, person: float = TALL) -> np.ndarray:
    """Return the middles (N, 3) of spheres of a radius that show places: outlines, persons, streams and poses."""
    lines = [beads_on(line, radius) for place in places for line in lines_of(place)]
    seats = [place for place in places if place.kind == "sit" and not heading_unknown(place)]
    sitters = [person_points(seated_person(place, person), 1.3 * radius) for place in seats]
    return np.vstack([*lines, *sitters, *(put_down(place) for place in places), np.empty((0, 3))])


def lines_of(place: Place) -> list[np.ndarray]:
    """Return the lines (K, 3) that show a place."""
    rings = [np.vstack([ring, ring[:1]]) for ring in place.region]
    return [*rings, stream_of(place)] if place.kind == "pour" else rings


def beads_on(line: np.ndarray, radius: float) -> np.ndarray:
    """Return points along a line (K, 3), so close that spheres around them touch."""
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    along = np.append(0.0, np.cumsum(steps))
    at = np.linspace(0.0, along[-1], 2 + int(along[-1] / (1.5 * radius)))
    return np.column_stack([np.interp(at, along, line[:, axis]) for axis in range(3)])
