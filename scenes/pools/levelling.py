"""A pool's flat surface as it is in the world: level, even, and whole below what stood on it and hid it."""

from __future__ import annotations

import numpy as np

from .cutting import MARGIN, Footprint, footprint_of
from .surfaces import CELL, Pool
from .tops import SLAB, fitted_height

_FLAT = 0.010  # metres: median distance from its plane; a cushion's is more
_SCATTER = 0.022  # metres from the plane up to which points are the sensor's scatter


def levelled(points: np.ndarray, pool: Pool) -> np.ndarray:
    """Return an object's points (N, 3) with its flat surface even and without gaps; as they are where it is not flat.

    Of a sensor's scatter of a centimetre, and of a top that is a degree off, spheres make hollows and slopes.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    pool : Pool
        Whose surface the object has.
    """
    ground = footprint_of(pool)
    near = ground.grown(MARGIN).holds(points) & (np.abs(points[:, 2] - pool.height) < SLAB)
    if not near.any():
        return points
    plane = fitted_height(points[near], pool.height)
    rise = points[:, 2] - points[:, :2] @ plane[:2] - plane[2]
    if np.median(np.abs(rise[near])) > _FLAT:
        return points
    own = near & (np.abs(rise) < _SCATTER)
    even = points.copy()
    even[own, 2] = pool.height
    return np.vstack([even, bare_places(ground, points[own], pool.height)])


def bare_places(ground: Footprint, points: np.ndarray, height: float) -> np.ndarray:
    """Return places (M, 3) a centimetre apart at a height, where a footprint has none of the points (N, 3)."""
    bare = ground.mask.copy()
    place = np.floor(points[:, :2] / CELL).astype(np.int64) - ground.corner
    known = ((place >= 0) & (place < bare.shape)).all(axis=1)
    bare[tuple(place[known].T)] = False
    corners = (np.argwhere(bare) + ground.corner) * CELL
    offsets = np.array([[x, y] for x in (0.25, 0.75) for y in (0.25, 0.75)]) * CELL
    places = (corners[:, None] + offsets).reshape(-1, 2)
    return np.column_stack([places, np.full(len(places), height)])
