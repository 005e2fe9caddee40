"""Directions seen from above: in which of them something is near a level, in compiled loops over a scene's voxels."""

from __future__ import annotations

import numpy as np

from spherefunc_bullet.processes.compilation import njit

from ..settings import POOL

# What is noted for each direction around a level, in the order of the rows of `look_around_level`.
GOES_ON, BESIDE, WALLED_NEAR, WALLED_FAR, LOWER_NEAR, GROUND_NEAR, SEEN_NEAR = range(7)


def tangents() -> np.ndarray:
    """Return the tangents (D / 4 - 1,) of the angles between the directions of a right angle."""
    return np.tan(np.arange(1, POOL.directions // 4) * (2 * np.pi / POOL.directions))


@njit(cache=True, error_model="numpy")
def direction_of(x, y, tangents):
    """Return the direction of (x, y) from the origin, counterclockwise; the first one begins at the x axis."""
    quarter = len(tangents) + 1
    if x > 0.0 and y >= 0.0:
        first, along, across = 0, x, y
    elif y > 0.0:
        first, along, across = quarter, y, -x
    elif x < 0.0:
        first, along, across = 2 * quarter, -x, -y
    elif y < 0.0:
        first, along, across = 3 * quarter, -y, x
    else:
        return 0
    for tangent in tangents:
        if across < along * tangent:
            return first
        first += 1
    return first


@njit(cache=True, error_model="numpy")
def sort_by_direction(places, middle, tangents, way, far):
    """Write the direction (N,) and the distance (N,) of places (N, 2 or more) from a middle (2,)."""
    for i in range(len(places)):
        x, y = places[i, 0] - middle[0], places[i, 1] - middle[1]
        way[i], far[i] = direction_of(x, y, tangents), np.sqrt(x * x + y * y)


def polar(places: np.ndarray, middle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the direction (N,) int and the distance (N,) of places (N, 2 or more) from a middle (2,)."""
    way, far = np.empty(len(places), np.int64), np.empty(len(places))
    sort_by_direction(places, middle, tangents(), way, far)
    return way, far


@njit(cache=True, error_model="numpy")
def look_around_level(
    means, keys, own, y_range, middle, edge, height, support, limits, tangents, noted, over, near, around
):
    """Note in which directions other voxels of a scene are around a level.

    Parameters
    ----------
    means : (K, 3) float64, metres
        Of the scene's voxels that are within reach along x.
    keys : (K,) int64
        Their keys, ascending.
    own : (C,) int64
        The keys of the level's own voxels, ascending, which are left out.
    y_range : (2,) float64, metres
        Between which voxels are within reach along y.
    middle : (2,) float64, metres
    edge : (D,) float64
        Metres from the middle to the edge of the level, in each direction.
    height, support : float
        Of the level and of what it stands on, metres.
    limits : tuple of 5 floats, metres
        What is next to the level and what is around it, in distance from the edge; what rises above the level; how far
        heights that are equal may differ, roughly and closely.
    noted : (7, D) bool
        Receives True for each direction in which there is something, in rows as named above.
    over : (K,) int64
        Receives the voxels that are inside the edge.
    near, around : (K,) float64, metres
        Receive the heights over the level of those next to it, and of those around it.

    Returns
    -------
    int, int, int
        How many there are of each.
    """
    near_level, far_level, rises, slab, cell = limits
    inside, count_near, count_around, place = 0, 0, 0, 0
    reach = edge.max() + far_level
    for i in range(len(means)):
        if not y_range[0] < means[i, 1] < y_range[1]:
            continue
        while place < len(own) and own[place] < keys[i]:
            place += 1
        if place < len(own) and own[place] == keys[i]:
            continue
        x, y, z = means[i, 0] - middle[0], means[i, 1] - middle[1], means[i, 2]
        distance = np.sqrt(x * x + y * y)
        if distance >= reach:
            continue
        way = direction_of(x, y, tangents)
        beyond, above = distance - edge[way], z - height
        if beyond < 0:
            over[inside] = i
            inside += 1
        if not -cell < beyond < far_level:
            continue
        noted[WALLED_FAR, way] |= above > rises
        noted[WALLED_NEAR, way] |= above > rises and beyond < near_level
        noted[GOES_ON, way] |= beyond < 2 * slab and abs(above) < 2 * cell
        if beyond <= 0:
            continue
        around[count_around] = above
        count_around += 1
        if beyond >= near_level:
            continue
        near[count_near] = above
        count_near += 1
        noted[SEEN_NEAR, way] = True
        noted[BESIDE, way] |= z > support + slab
        noted[LOWER_NEAR, way] |= z > support + slab and above < -2 * cell
        noted[GROUND_NEAR, way] |= abs(z) < slab
    return inside, count_near, count_around
