"""What a room's pictures are coloured by (paper, Fig. 6: cyan to sit on, magenta for tables)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..recognition.recognition import Room
from ..scans.scan import Scan

FUNCTION_COLOURS = {"sittable": (0, 190, 215), "table": (225, 0, 190), "cup": (245, 150, 0)}
_FURTHER = ((0, 158, 115), (120, 94, 240), (213, 94, 0), (120, 120, 0))  # of functions that others name
_GREY = np.array([[90, 96, 110], [225, 226, 230]])  # of points without colour, from the lowest to the highest
_FADED = 0.45  # how far towards white goes what is of no object


def function_colour(name: str, names: Iterable[str]) -> tuple[int, int, int]:
    """Return the colour of a function, out of all that there are."""
    others = [other for other in sorted(names) if other not in FUNCTION_COLOURS]
    return FUNCTION_COLOURS.get(name) or _FURTHER[others.index(name) % len(_FURTHER)]


def point_colours(scan: Scan, room: Room, level_points: np.ndarray) -> np.ndarray:
    """Return a colour (N, 3) uint8 for each point: the scan's own, or grey by height; paler where it is no object."""
    if scan.colors is not None:
        colours = scan.colors.astype(np.float64)
    else:
        low, high = np.percentile(level_points[:, 2], [1, 99])
        share = np.clip((level_points[:, 2:] - low) / max(high - low, 1e-6), 0, 1)
        colours = _GREY[0] + share * (_GREY[1] - _GREY[0])
    faded = (room.labels < 0)[:, None]
    return np.where(faded, colours + _FADED * (255 - colours), colours).astype(np.uint8)
