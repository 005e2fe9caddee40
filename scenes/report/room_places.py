"""The places of a room for its picture and its page: as small spheres in the colour of their use, and as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from spherefunc_bullet.places.place import Place, Similarity
from spherefunc_bullet.places.words import HEAD, place_columns
from spherefunc_bullet.viewer.page import table_html
from spherefunc_bullet.viewer.place_pictures import COLOURS, WORDS, beads_of

from ..recognition.room import Room

BEAD = 0.003  # of the room's largest extent: radius of the spheres that show places
LEAST_HOLE = 0.1  # metres, extent of a hole in a region that is drawn
# By an object's id, None for what lies on no object; in the scan's frame.
PlacesByObject = Mapping[int | None, Sequence[Place]]


@dataclass(frozen=True, kw_only=True, eq=False)
class DrawnPlaces:
    """All places of one kind, to sit, to put something or to pour, as they are drawn."""

    words: str
    colour: tuple[int, int, int]
    beads: np.ndarray  # (N, 3) metres, level frame, middles of the spheres that show the places


def drawn_places(room: Room, used: PlacesByObject, radius: float) -> list[DrawnPlaces]:
    """Return the places of a room, kind by kind, drawn with spheres of a radius, metres."""
    up, shift = room.levelling.T_level_scan[:3, :3].T, room.levelling.T_level_scan[:3, 3]
    to_scan = Similarity(up, 1.0, -up @ shift)
    places = [outlined(place.moved_back(to_scan)) for found in used.values() for place in found]
    above = np.array([0.0, 0.0, radius])  # or the points of the surface would hide half of each sphere
    return [
        DrawnPlaces(words=WORDS[kind], colour=rgb(colour), beads=beads_of(of_kind, radius) + above)
        for kind, colour in COLOURS.items()
        if (of_kind := [place for place in places if place.kind == kind])
    ]


def outlined(place: Place) -> Place:
    """Return a place without the small holes of its region: a rough surface has many, and none means much."""
    first, *holes = place.region
    return replace(place, region=(first, *(ring for ring in holes if np.ptp(ring, axis=0).max() >= LEAST_HOLE)))


def rgb(colour: str) -> tuple[int, int, int]:
    """Return the channels of a colour such as ``#d62728``, 0 to 255."""
    red, green, blue = bytes.fromhex(colour[1:])
    return red, green, blue


def places_html(used: PlacesByObject) -> str:
    """Return a table of the places of a room, as on the console; nothing without places."""
    rows = [
        ["" if owner is None else str(owner), *place_columns(place.as_json()), place.note.partition(":")[0]]
        for owner, found in used.items()
        for place in found
    ]
    if not rows:
        return ""
    table = table_html(["on object", *HEAD, "note"], rows, texts=2, label="Places")
    title = "Where the room can be used; lengths in m, positions in the scan's frame"
    return f'<div class="display display-details"><h2>{title}</h2>{table}</div>'
