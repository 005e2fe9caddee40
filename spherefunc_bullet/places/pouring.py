"""Places to pour: above the openings of objects that hold water."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from ..clouds.cloud import MAX_GAP, Cloud
from ..clouds.water import SPILLED_AT, Water, first_spill, wall_of, waters_of
from .place import FUNCTION, Place
from .regions import HeightMap, rings_of, surface_of

LEAST_ML = 5.0
LEAST_DEPTH = 0.01  # metres
LEAST_STEEP = 0.12  # depth over the width of the opening: the hollow of a seat is flatter
ABOVE = 0.03  # metres above the brim from which one pours
MAX_EXTENT = 1.2  # metres: larger objects are not vessels
HIGHER = 0.2  # of the depth, and at least `LEAST_DEPTH`: walls that are so much higher than the brim have a hole
UNEVEN = 2  # cells: walls that are less higher than the brim belong to it
SIDES, TESTED = 24, 4000  # headings that are tried to spill, and cells of water
HOLE = "the walls are higher all around: water above this brim runs out through a hole"


def pour_places(cloud: Cloud) -> list[Place]:
    """Return a place for each body of water that an object holds under an opening, the largest first."""
    if cloud.size.max() > MAX_EXTENT:
        return []
    return [place for water in waters_of(cloud) if (place := pour_place(cloud, water)) is not None]


def pour_place(cloud: Cloud, water: Water) -> Place | None:
    """Return the place to pour into a body of water, or None if it is too small or too shallow."""
    if len(water.opening) < 4:
        return None
    low, high = water.opening.min(axis=0) - 2, water.opening.max(axis=0) + 3
    open_cells = np.zeros(high - low, bool)
    open_cells[tuple((water.opening - low).T)] = True
    room = water.cell * (ndimage.distance_transform_edt(open_cells) - 0.5)
    surface = HeightMap(water.origin[:2] + low * water.cell, water.cell, np.zeros(open_cells.shape), 0.0)
    middle = surface.middles(np.array(np.unravel_index(room.argmax(), room.shape)))
    depth = water.brim_height - (water.origin[2] + water.cells[:, 2].min() * water.cell)
    area = len(water.opening) * water.cell**2
    capacity = water.volume * 1e6
    least = max(LEAST_DEPTH, LEAST_STEEP * np.sqrt(area), wall_of(cloud))  # walls as thick leave pits between points
    if capacity < LEAST_ML or depth < least:
        return None
    tilt, heading = spill(cloud, water)
    return Place(
        kind="pour",
        function=FUNCTION["pour"],
        position=np.array([*middle, water.brim_height + ABOVE]),
        region=rings_of(surface, open_cells, np.array([0.0, 0.0, water.brim_height])),
        area=float(area),
        height=water.brim_height,
        score=float(np.clip(2 * depth / np.sqrt(area), 0, 1)),
        radius=float(room.max()),
        capacity_ml=float(capacity),
        filled_ml=float(SPILLED_AT * capacity),
        levels=water.levels(),
        spill_tilt_deg=tilt,
        spill_heading_deg=heading,
        depth=float(depth),
        inside=tuple(
            water.origin + cell * water.cell for cell in (water.cells.min(axis=0), water.cells.max(axis=0) + 1)
        ),
        note=HOLE if walled(cloud, middle, water.brim_height + max(LEAST_DEPTH, HIGHER * depth)) else "",
    )


def spill(cloud: Cloud, water: Water) -> tuple[float, float]:
    """Return the smallest tilt at which a vessel filled to nine tenths spills, and its heading, degrees.

    At a tilt it keeps what is below the horizontal plane through the lowest point of its rim, of which some sides may
    be higher than the brim.
    """
    middles, rim = water.middles(), rim_of(cloud, water)
    some, headings = middles[:: max(1, len(middles) // TESTED)], np.arange(SIDES) * 2 * np.pi / SIDES
    tilts = np.array([first_spill(some, rim, heading, water.cell / 2) for heading in headings])
    return float(np.degrees(tilts.min())), float(np.degrees(headings[tilts.argmin()]))


def rim_of(cloud: Cloud, water: Water) -> np.ndarray:
    """Return the edge of the opening of a vessel (K, 3), metres, each cell as high as the wall beside it.

    Where walls are higher all around, water leaves through a hole, and no side is known: all are as high as the brim.
    """
    reach = 1 + int(np.ceil(wall_of(cloud) / water.cell))  # in a cloud, water keeps off its walls
    low = water.opening.min(axis=0) - reach - 1
    shape = tuple(water.opening.max(axis=0) + reach + 2 - low)
    walls = np.full(shape, water.brim_height)
    columns = np.floor((cloud.points[:, :2] - water.origin[:2]) / water.cell).astype(int) - low
    near = ((columns >= 0) & (columns < shape)).all(axis=1)
    np.maximum.at(walls, tuple(columns[near].T), cloud.points[near, 2])
    walls[walls < water.brim_height + UNEVEN * water.cell] = water.brim_height
    is_open = np.zeros(shape, bool)
    is_open[tuple((water.opening - low).T)] = True
    edge = np.argwhere(is_open & ~ndimage.binary_erosion(is_open))
    heights = ndimage.maximum_filter(walls, 2 * reach + 1)[tuple(edge.T)]
    heights = heights if heights.min() <= water.brim_height else np.full(len(edge), water.brim_height)
    return np.column_stack([water.origin[:2] + (edge + low + 0.5) * water.cell, heights])


def walled(cloud: Cloud, place: np.ndarray, height: float) -> bool:
    """Return whether a place (2,), seen from above, is enclosed by walls of at least a height.

    False without a mesh: between points that are far apart, water finds a way even where there is no hole.
    """
    if cloud.mesh is None:
        return False
    surface = surface_of(cloud, MAX_GAP)
    low, _ = ndimage.label(surface.heights < height)
    start = tuple(np.floor((place - surface.origin) / surface.cell).astype(int))
    return bool(low[start] != low[0, 0])
