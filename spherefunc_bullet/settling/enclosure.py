"""Which spheres at rest are walled in: pushed along the ground, whichever way, they meet the object.

A pile of spheres stays behind a slit in a wall that nothing else would stay behind, so the pile alone does not tell.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ..compilation import prepare

DIRECTIONS = 64
NARROWER = 0.8  # radii: a gap is one where so much of the sphere gets through


def walled_in(points: np.ndarray, centers: np.ndarray, radius: float) -> np.ndarray:
    """Return whether spheres at rest (S, 3) meet an object's points (N, 3) in every level direction, (S,) bool.

    Parameters
    ----------
    points, centers : metres
    radius : float
        Of the spheres, metres.
    """
    prepare(by_layer)
    prepare(met_everywhere)
    reach = NARROWER * radius
    order, starts = by_layer(points, points[:, 2].min(), reach)
    return met_everywhere(points, order, starts, points[:, 2].min(), np.asarray(centers, np.float64), reach)


@njit(cache=True, error_model="numpy")
def by_layer(points, bottom, height):
    """Return the points' indices layer by layer from the bottom (N,), and where each layer begins."""
    layers = np.empty(len(points), np.int64)
    for i in range(len(points)):
        layers[i] = int((points[i, 2] - bottom) / height)
    starts = np.zeros(layers.max() + 2, np.int64)
    for layer in layers:
        starts[layer + 1] += 1
    starts = np.cumsum(starts)
    order, free = np.empty(len(points), np.int64), starts.copy()
    for i in range(len(points)):
        order[free[layers[i]]] = i
        free[layers[i]] += 1
    return order, starts


@njit(cache=True, error_model="numpy")
def adds_nothing(met, dx, dy, sine, step):
    """Return whether all directions are met that a point (dx, dy) aside, seen under twice arcsin(sine), can meet.

    By bounds that cost less than the angles, since most points stand behind others: an arctangent to 0.005, and
    arcsin(s) <= s + (pi / 2 - 1) s**3.
    """
    x, y = abs(dx), abs(dy)
    ratio = min(x, y) / max(x, y)
    angle = ratio * (1.0584 - 0.273 * ratio)  # within 0.004
    if y > x:
        angle = 0.5 * math.pi - angle
    if dx < 0:
        angle = math.pi - angle
    if dy < 0:
        angle = -angle
    spread = sine + (0.5 * math.pi - 1) * sine * sine * sine + 0.005
    for turn in range(int(math.ceil((angle - spread) / step)), int(math.floor((angle + spread) / step)) + 1):
        if not met[turn % DIRECTIONS]:
            return False
    return True


@njit(cache=True, error_model="numpy")
def met_everywhere(points, order, starts, bottom, centers, reach):
    """Return whether cylinders as thick as ``reach`` around a centre meet points in each of `DIRECTIONS`, (S,) bool."""
    step = 2 * math.pi / DIRECTIONS
    met_all = np.zeros(len(centers), np.bool_)
    for k in range(len(centers)):
        x, y, z = centers[k]
        layer = int((z - bottom) / reach)
        first = min(max(layer - 1, 0), len(starts) - 1)
        last = min(max(layer + 2, 0), len(starts) - 1)
        met, count = np.zeros(DIRECTIONS, np.bool_), 0
        for i in order[starts[first] : starts[last]]:
            dx, dy, dz = points[i, 0] - x, points[i, 1] - y, points[i, 2] - z
            across = reach * reach - dz * dz
            distance = math.sqrt(dx * dx + dy * dy)
            if across <= 0 or distance * distance <= across:
                continue
            sine = math.sqrt(across) / distance
            if adds_nothing(met, dx, dy, sine, step):
                continue
            spread = math.asin(sine)
            angle = math.atan2(dy, dx)
            for turn in range(int(math.ceil((angle - spread) / step)), int(math.floor((angle + spread) / step)) + 1):
                if not met[turn % DIRECTIONS]:
                    met[turn % DIRECTIONS] = True
                    count += 1
            if count == DIRECTIONS:
                met_all[k] = True
                break
    return met_all
