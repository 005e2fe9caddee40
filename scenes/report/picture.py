"""A picture of a room: its points, and a box in the function's colour around each object that has one (Fig. 6).

Cyan is to sit on, magenta are tables, as in the paper.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..recognition.recognition import Room
from ..scans.scan import Scan
from ..segmentation.segmentation import WALL
from .room_places import BEAD, DrawnPlaces, PlacesByObject, drawn_places

if TYPE_CHECKING:
    from PIL import Image

FUNCTION_COLOURS = {"sittable": (0, 190, 215), "table": (225, 0, 190), "cup": (245, 150, 0)}
_FURTHER = ((0, 158, 115), (120, 94, 240), (213, 94, 0), (120, 120, 0))  # of other functions
_SHADES = np.array([[90, 96, 110], [225, 226, 230]])  # of points without colour, from the lowest to the highest
_FADED = 0.3  # towards white, for points of no object
_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
_FIELD = 2 * np.tan(np.radians(20.0))  # of view, vertical
_MAX_POINTS = 400_000  # more add nothing to a picture of that size
_PAPER = 252
_SEEN = 0.7  # opacity of places: what a person sits on is seen through the person
_GREY = (120, 120, 120)
_FILLED = 0.92  # of a picture's width or height, by its contents
_LARGEST = 10  # pixels, side of a point
_NEIGHBOURS = 4  # of a point on a surface, those that are next to it
_ELEVATION_DEG = 32.0


def function_colour(name: str, names: Iterable[str]) -> tuple[int, int, int]:
    """Return the colour of a function, given the names of all."""
    others = [other for other in sorted(names) if other not in FUNCTION_COLOURS]
    return FUNCTION_COLOURS.get(name) or _FURTHER[others.index(name) % len(_FURTHER)]


def point_colours(scan: Scan, room: Room, level_points: np.ndarray) -> np.ndarray:
    """Return a colour (N, 3) uint8 for each point: the scan's own, or grey by height; paler for points of no object."""
    if scan.colors is not None:
        colours = scan.colors.astype(np.float64)
    else:
        low, high = np.percentile(level_points[:, 2], [1, 99])
        share = np.clip((level_points[:, 2:] - low) / max(high - low, 1e-6), 0, 1)
        colours = _SHADES[0] + share * (_SHADES[1] - _SHADES[0])
    faded = (room.labels < 0)[:, None]
    return np.where(faded, colours + _FADED * (255 - colours), colours).astype(np.uint8)


@dataclass(frozen=True, kw_only=True, eq=False)
class BoxMark:
    """A box to draw, with a text above it, or below if it is thin."""

    corners: np.ndarray  # (8, 3) metres, level frame, as `Box.corners` has them
    colour: tuple[int, int, int]
    text: str
    thin: bool = False  # for objects that are inferred and not found


@dataclass(frozen=True, kw_only=True)
class Camera:
    """The camera of a picture."""

    eye: np.ndarray  # (3,) metres, level frame
    axes: np.ndarray  # (3, 3) rows: right, down, forward
    size: tuple[int, int]  # pixels
    zoom: float = 1.0
    middle: tuple[float, float] = (0.0, 0.0)  # pixels from the optical axis to the middle of the picture

    @property
    def focal(self) -> float:
        """Focal length, pixels."""
        return self.zoom * self.size[1] / _FIELD

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return pixels and distances (N, 3) of points (N, 3): to the right, down, and forward in metres."""
        seen = (points - self.eye) @ self.axes.T
        depth = np.maximum(seen[:, 2], 1e-3)
        offset = np.array(self.size) / 2 - self.middle
        return np.column_stack([seen[:, :2] / depth[:, None] * self.focal + offset, depth])

    def filled_by(self, points: np.ndarray) -> Camera:
        """Return the same camera with its picture cut out around points (N, 3)."""
        places = self.project(points)[:, :2]
        low, high = places.min(axis=0), places.max(axis=0)
        zoom = float((_FILLED * np.array(self.size) / np.maximum(high - low, 1)).min())
        middle = zoom * ((low + high - self.size) / 2 + self.middle)
        return replace(self, zoom=zoom * self.zoom, middle=(float(middle[0]), float(middle[1])))


def look_at(low: np.ndarray, high: np.ndarray, azimuth_deg: float, size: tuple[int, int]) -> Camera:
    """Return a camera that sees the whole box (low, high) from above."""
    azimuth, elevation = np.radians([azimuth_deg, _ELEVATION_DEG])
    toward = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    axes = np.stack([right, np.cross(-toward, right), -toward])
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, -1).T - (low + high) / 2
    across = np.abs(corners @ axes[0]) / (size[0] / size[1])
    distance = (np.maximum(across, np.abs(corners @ axes[1])) * 2 / _FIELD + corners @ toward).max()
    return Camera(eye=(low + high) / 2 + 1.02 * distance * toward, axes=axes, size=size)


def room_picture(
    scan: Scan, room: Room, *, size: tuple[int, int] = (1000, 750), used: PlacesByObject | None = None
) -> Image.Image:
    """Draw a scan, its places and the boxes of its objects with a function, from where most of the objects is seen.

    Parameters
    ----------
    scan : Scan
    room : Room
        With the scan's objects.
    size : (int, int)
        Pixels.
    used : mapping, optional
        The places of each object by its id.
    """
    from PIL import Image

    points = room.levelling.to_level(scan.points)
    step = max(1, len(points) // _MAX_POINTS)
    colours = point_colours(scan, room, points)[::step]
    points, labels = points[::step], room.labels[::step]
    is_wall = (labels == WALL) & (labels >= 0).any()  # of a scan without objects, all is shown
    shown = points[~is_wall]
    marks = [*inferred_marks(room), *marks_of(room)]
    whole = [mark.corners for mark in marks]
    uses = drawn_places(room, used or {}, radius := BEAD * float(np.ptp(span(shown, whole), axis=0).max()))
    whole += [use.beads for use in uses]
    low, high = span(shown, whole)
    inside = ((points >= low - 0.3) & (points <= high + 0.3)).all(axis=1)
    points, colours, labels, is_wall = points[inside], colours[inside], labels[inside], is_wall[inside]
    fine = (2 * size[0], 2 * size[1])
    camera = look_at(low, high, best_azimuth(points, labels, low, high), fine)
    camera = camera.filled_by(np.vstack([points[~is_wall], *whole]))
    open_room = ~in_front(camera, points, is_wall)
    points, colours = points[open_room], colours[open_room]
    widths = np.full(len(points), spacing_of(points))
    plain = Image.fromarray(splatted(camera, points, colours, widths))
    for use in uses:
        points, count = np.vstack([points, use.beads]), len(use.beads)
        colours = np.vstack([colours, np.tile(np.uint8(use.colour), (count, 1))])
        widths = np.append(widths, np.full(count, 2 * radius))
    image = Image.blend(plain, Image.fromarray(splatted(camera, points, colours, widths)), _SEEN) if uses else plain
    draw_marks(image, camera, marks)
    draw_key(image, uses)
    return image.resize(size, Image.Resampling.LANCZOS)


def span(points: np.ndarray, whole: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the two corners (3,) of a picture's contents: all but stray points, and whole boxes and places (K, 3).

    A table's box reaches down to the floor, even if the scan does not show its legs.
    """
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    corners = np.concatenate([np.array([low, high]), *whole])
    return corners.min(axis=0), corners.max(axis=0)


def best_azimuth(points: np.ndarray, labels: np.ndarray, low: np.ndarray, high: np.ndarray) -> float:
    """Return the direction, in degrees, from which most points of objects are seen."""
    chosen = slice(None, None, max(1, len(points) // 60_000))
    points, labels, is_wall = points[chosen], labels[chosen], (labels == WALL)[chosen]
    sizes = np.zeros(len(points))
    marks, seen = np.repeat((labels >= 0)[:, None], 3, axis=1).astype(np.uint8), []
    for azimuth in range(0, 360, 45):
        camera = look_at(low, high, azimuth, (160, 120))
        open_room = ~in_front(camera, points, is_wall)
        seen.append(splatted(camera, points[open_room], marks[open_room], sizes[open_room], paper=0)[..., 0].sum())
    return 45.0 * int(np.argmax(seen))


def in_front(camera: Camera, points: np.ndarray, is_wall: np.ndarray) -> np.ndarray:
    """Return which points (N, 3), of walls and ceiling as ``is_wall`` says, are on the camera's side, (N,) bool."""
    middle, forward = np.median(points[:, :2], axis=0), camera.axes[2, :2]
    return is_wall & ((points[:, :2] - middle) @ forward < 0)


def splatted(
    camera: Camera, points: np.ndarray, colours: np.ndarray, widths: np.ndarray, paper: int = _PAPER
) -> np.ndarray:
    """Return an image (H, W, 3) uint8 of points as squares of widths (N,), metres, the nearest in front."""
    width, height = camera.size
    image, nearest = np.full((height * width, 3), paper, np.uint8), np.full(height * width, np.inf)
    at = camera.project(points)
    order = np.argsort(-at[:, 2], kind="stable")  # for equal pixels numpy keeps the last value: the nearest point's
    colours, depth = colours[order], at[order, 2]
    sides = np.clip(np.ceil(widths[order] * camera.focal / depth), 1, _LARGEST).astype(np.int64)
    x, y = (np.floor(at[order, :2].T) - sides // 2).astype(np.int64)
    for step in np.ndindex(*2 * (sides.max(initial=1),)):
        inside = (x + step[0] >= 0) & (x + step[0] < width) & (y + step[1] >= 0) & (y + step[1] < height)
        drawn = np.flatnonzero(inside & (sides > max(step)))
        pixels = (y[drawn] + step[1]) * width + x[drawn] + step[0]
        visible = depth[drawn] <= nearest[pixels]
        pixels, drawn = pixels[visible], drawn[visible]
        image[pixels], nearest[pixels] = colours[drawn], depth[drawn]
    return image.reshape(height, width, 3)


def spacing_of(points: np.ndarray) -> float:
    """Return the usual distance between neighbours among points (N, 3), metres."""
    from scipy.spatial import cKDTree

    if len(points) < _NEIGHBOURS + 1:
        return 0.0
    some = points[:: max(1, len(points) // 2000)]
    return float(np.median(cKDTree(points).query(some, k=_NEIGHBOURS + 1)[0][:, -1]))


def marks_of(room: Room) -> list[BoxMark]:
    """Return the boxes of the objects that have a function, each with name and score, and "?" if it is unsure."""
    return [
        BoxMark(
            corners=item.box.corners,
            colour=function_colour(name, item.functions),
            text=f"{name} {item.functions[name].score:.2f}" + " ?" * bool(room.doubts(item)),
        )
        for item in room.objects
        if (name := item.main_function) is not None
    ]


def inferred_marks(room: Room) -> list[BoxMark]:
    """Return the boxes of inferred objects, thin and grey."""
    return [
        BoxMark(corners=item.box.corners, colour=_GREY, text=f"{item.function}: inferred", thin=True)
        for item in room.inferred
    ]


def draw_marks(image: Image.Image, camera: Camera, marks: Sequence[BoxMark]):
    """Draw boxes in their order, and over all of them the texts, which do not overlap."""
    from PIL import ImageDraw, ImageFont

    draw, font = ImageDraw.Draw(image), ImageFont.load_default(size=image.size[1] // 42)
    wide = max(3, image.size[1] // 270)
    corners = [camera.project(mark.corners)[:, :2] for mark in marks]
    for mark, at in zip(marks, corners, strict=True):
        for a, b in _EDGES:
            draw.line([tuple(at[a]), tuple(at[b])], fill=mark.colour, width=wide // 2 if mark.thin else wide)
    taken: list[tuple[float, float, float, float]] = []
    for mark, at in zip(marks, corners, strict=True):
        anchor, away = ("mt", 1) if mark.thin else ("mb", -1)
        x, y = at[np.argmax(away * at[:, 1])]
        place = frame_of(draw.textbbox((x, y), mark.text, font=font, anchor=anchor))
        while any(overlap(place, other) for other in taken):
            y += away * (place[3] - place[1])
            place = frame_of(draw.textbbox((x, y), mark.text, font=font, anchor=anchor))
        taken.append(place)
        draw.rectangle(place, fill=(255, 255, 255))
        draw.text((x, y), mark.text, fill=mark.colour, font=font, anchor=anchor)


def draw_key(image: Image.Image, uses: Sequence[DrawnPlaces]):
    """Draw what the colours of places mean, in the lower left corner."""
    from PIL import ImageDraw, ImageFont

    draw, side = ImageDraw.Draw(image), image.size[1] // 42
    font, top = ImageFont.load_default(side), image.size[1] - (1.5 * len(uses) + 0.5) * side
    for number, use in enumerate(uses):
        y = top + 1.5 * number * side
        draw.rectangle(frame_of(draw.textbbox((2 * side, y), use.words, font=font)), fill=(255, 255, 255))
        draw.rectangle((0.5 * side, y, 1.5 * side, y + side), fill=use.colour)
        draw.text((2 * side, y), use.words, fill=use.colour, font=font)


def frame_of(box: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    """Return the frame around a text's box: left, top, right and bottom in pixels."""
    return box[0] - 4, box[1] - 3, box[2] + 4, box[3] + 3


def overlap(one: tuple[float, float, float, float], other: tuple[float, float, float, float]) -> bool:
    """Return whether two frames have pixels in common.

    Examples
    --------
    >>> overlap((0, 0, 2, 2), (1, 1, 3, 3)), overlap((0, 0, 2, 2), (2, 0, 4, 2))
    (True, False)
    """
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
