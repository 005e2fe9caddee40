"""Levels below other levels: shelves, lower boards of tables. In a column of points, each is below a gap."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..clouds.cloud import Cloud
from ..processes.compilation import njit
from .place import Place
from .putting import DISC, footprint_of, put_place
from .regions import HeightMap, Region, level_regions

GAP = 0.12  # metres, least free height above a shelf
OVER = 0.03  # metres that stay free above an object on the shelf
HAND = 0.06  # metres to either side of the way on which a hand reaches in
REACHED = 0.25  # metres above the shelf, greatest height of this way
WAYS = 8  # number of directions that are tried
MOST = 6  # number of shelves above each other
UNEVEN = 0.005  # metres, root mean square distance of a shelf from its plane: the foot of a round table is a cone
MOST_CELLS = 4_000_000
EXACT = 1e-4  # metres: heights are not known better


def shelf_places(cloud: Cloud, surface: HeightMap, put: Cloud | None, lowest: float) -> list[Place]:
    """Return places to put on levels below others that can be reached from a side, which is their heading.

    Parameters
    ----------
    cloud : Cloud
    surface : HeightMap
        The cloud from above.
    put : Cloud, optional
        An object, as it stands, for which poses are searched.
    lowest : float, metres
        Lower cells are the ground.
    """
    footprint = None if put is None else footprint_of(put)
    least = DISC if footprint is None else 0.01
    needed = GAP if footprint is None else footprint.height + OVER
    if cloud.size[2] <= needed:
        return []
    layers, found = layers_of(cloud, surface), []
    shelves, gaps = np.full((MOST, *surface.heights.shape), -np.inf), np.zeros((MOST, *surface.heights.shape))
    find_shelves(layers.highest, layers.lowest, needed - EXACT, lowest, shelves, gaps)
    for heights, free in zip(shelves, gaps, strict=True):
        if np.isfinite(heights).sum() * surface.cell**2 < np.pi * least**2:
            break  # the following ones are even smaller
        shelf = replace(surface, heights=heights)
        around = replace(surface, heights=np.where(np.isfinite(heights), heights, surface.heights))
        for region in level_regions(shelf, least, lowest):
            if unevenness(shelf, region) > UNEVEN + shelf.rough:
                continue
            place, clearance = put_place(around, region, footprint), float(free[region.cells].min())
            way = None if place is None else way_in(layers, shelf, place.position, clearance)
            if way is not None:
                found.append(replace(place, clearance=clearance, heading_deg=way))
    return found


def unevenness(surface: HeightMap, region: Region) -> float:
    """Return the root mean square distance of the cells of a region from its plane, metres."""
    off = surface.heights[region.cells] - region.height_at(surface.middles(np.argwhere(region.cells)))
    return float(np.sqrt(np.mean(off**2)))


@dataclass(frozen=True, eq=False)
class Layers:
    """The cells of a surface, divided into layers by height."""

    highest: np.ndarray  # (X, Y, Z) height of the highest point in each, metres; -inf if there is none
    lowest: np.ndarray  # (X, Y, Z) of the lowest point; inf if there is none
    bottom: float  # metres
    side: float  # height of a layer, metres


def layers_of(cloud: Cloud, surface: HeightMap) -> Layers:
    """Return the layers of a cloud's points."""
    most = MOST_CELLS // surface.heights.size
    side = max(surface.cell, float(cloud.size[2]) / max(8, most))
    bottom = float(cloud.bounds[0, 2])
    highest = np.full((*surface.heights.shape, int(cloud.size[2] / side) + 1), -np.inf, np.float32)
    lowest = np.full_like(highest, np.inf)
    fill_layers(cloud.points, surface.origin, surface.cell, bottom, side, highest, lowest)
    return Layers(highest, lowest, bottom, side)


def way_in(layers: Layers, shelf: HeightMap, position: np.ndarray, clearance: float) -> float | None:
    """Return the side, in degrees, from which a position (3,) is reached on the shortest way; None if there is none."""
    above = position[2] + 3 * shelf.rough + 0.01
    first = int(np.ceil((above - layers.bottom) / layers.side))
    last = int((position[2] + min(clearance, REACHED) - layers.bottom) / layers.side)
    walls = np.argwhere(np.isfinite(layers.highest[:, :, first:last]).any(axis=2))
    level = np.argwhere(np.abs(shelf.heights - position[2]) < 0.02)
    near, far = (shelf.middles(cells) - position[:2] for cells in (walls, level))
    open_ways = []
    for angle in np.arange(WAYS) * 2 * np.pi / WAYS:
        ahead, aside = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        if not ((near @ ahead > 0) & (np.abs(near @ aside) <= HAND)).any():
            ends = far[np.abs(far @ aside) <= HAND] @ ahead
            open_ways.append((float(ends.max(initial=0.0)), float(np.degrees(angle))))
    return min(open_ways)[1] if open_ways else None


@njit(cache=True, error_model="numpy")
def fill_layers(points, origin, cell, bottom, side, highest, lowest):
    """Write the heights of the highest and of the lowest point of each cell (X, Y, Z)."""
    for n in range(len(points)):
        i, j = int((points[n, 0] - origin[0]) / cell), int((points[n, 1] - origin[1]) / cell)
        k = min(int((points[n, 2] - bottom) / side), highest.shape[2] - 1)
        highest[i, j, k] = max(highest[i, j, k], points[n, 2])
        lowest[i, j, k] = min(lowest[i, j, k], points[n, 2])


@njit(cache=True, error_model="numpy")
def find_shelves(highest, lowest, needed, ground, shelves, gaps):
    """Write the levels below gaps of each column, from the highest down, and the heights of the gaps, (MOST, X, Y)."""
    for i in range(highest.shape[0]):
        for j in range(highest.shape[1]):
            above, count = np.inf, 0
            for k in range(highest.shape[2] - 1, -1, -1):
                if highest[i, j, k] == -np.inf:
                    continue
                gap = above - highest[i, j, k]
                if above < np.inf and gap >= needed and highest[i, j, k] > ground and count < len(shelves):
                    shelves[count, i, j], gaps[count, i, j] = highest[i, j, k], gap
                    count += 1
                above = lowest[i, j, k]
