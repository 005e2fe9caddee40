"""Enclosure: which spheres at rest are walled in, so that they hit the object if pushed in any horizontal direction.

A pile of spheres does not show that: it stays even behind a wall with a slit, through which anything else would escape.
"""

from __future__ import annotations

import math

import numpy as np

from ..processes.compilation import lean_njit

DIRECTIONS = 64
NONE, ONE, EVERY = np.uint64(0), np.uint64(1), np.uint64(2**64 - 1)  # directions as bits
NARROWER = 0.8  # radii: size of the sphere that must fit through a gap


def walled_in(points: np.ndarray, centers: np.ndarray, radius: float) -> np.ndarray:
    """Return whether spheres at rest (S, 3) meet an object's points (N, 3) in every horizontal direction, (S,) bool.

    Parameters
    ----------
    points, centers : metres
    radius : float
        Of the spheres, metres.
    """
    reach, z = NARROWER * radius, points[:, 2]
    bottom, layers = z.min(), int((z.max() - z.min()) / reach) + 1
    rooms = np.empty(len(points), np.int32), np.zeros(layers, np.bool_), np.zeros((2, layers + 1), np.int64)
    met = np.zeros(len(centers), np.bool_)
    met_everywhere(points, np.asarray(centers, np.float64), reach, bottom, *rooms, np.empty((len(points), 3)), met)
    return met


@lean_njit(error_model="numpy", forceinline=True)
def sort_by_layer(points, centers, bottom, height, layers, used, starts, placed):
    """Write the points in the layer of a centre or next to it, layer by layer, and where each layer starts.

    The arguments are those of `met_everywhere`.
    """
    count = len(used)
    for k in range(len(centers)):
        first, last = around(centers[k, 2], bottom, height, count)
        for layer in range(first, last):
            used[layer] = True
    for i in range(len(points)):
        layers[i] = int((points[i, 2] - bottom) / height)
        starts[0, layers[i] + 1] += used[layers[i]]
    for layer in range(count):
        starts[0, layer + 1] += starts[0, layer]
        starts[1, layer] = starts[0, layer]
    for i in range(len(points)):
        layer = layers[i]
        if used[layer]:
            row = starts[1, layer]
            placed[row, 0], placed[row, 1], placed[row, 2] = points[i, 0], points[i, 1], points[i, 2]
            starts[1, layer] = row + 1


@lean_njit(error_model="numpy", forceinline=True)
def around(z, bottom, height, count):
    """Return the range of layers around a height, as first and end, out of ``count`` layers."""
    layer = int((z - bottom) / height)
    return min(max(layer - 1, 0), count), min(max(layer + 2, 0), count)


@lean_njit(error_model="numpy", forceinline=True)
def directions(first, last):
    """Return the directions from one to another, modulo whole turns, as the bits of a number."""
    count = last - first + 1
    if count >= DIRECTIONS:
        return EVERY
    if count <= 0:
        return NONE
    bits, turn = (ONE << np.uint64(count)) - ONE, np.uint64(first & (DIRECTIONS - 1))
    return bits if turn == NONE else (bits << turn) | (bits >> (np.uint64(DIRECTIONS) - turn))


@lean_njit(error_model="numpy", forceinline=True)
def can_meet(dx, dy, squared_sine):
    """Return a superset of the directions in which a point at an offset (dx, dy), within the arcsine, is met.

    It is computed from bounds, which cost less than the angles, since most points are behind others: an arctangent
    accurate to 0.005, and arcsin(s) <= s + (pi / 2 - 1) s**3.
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
    sine = math.sqrt(squared_sine)
    spread = sine * (1 + (0.5 * math.pi - 1) * squared_sine) + 0.005
    per_radian = DIRECTIONS / (2 * math.pi)
    return directions(
        np.int64(math.ceil((angle - spread) * per_radian)), np.int64(math.floor((angle + spread) * per_radian))
    )


@lean_njit(cache=True, error_model="numpy")
def met_everywhere(points, centers, reach, bottom, layers, used, starts, placed, met_all):
    """Find whether cylinders of radius ``reach`` from each centre meet points in each of the `DIRECTIONS`.

    Parameters
    ----------
    points, centers : (N, 3) and (S, 3) float64, metres
    reach, bottom : float, metres
        Height of a layer, and start of the lowest one.
    layers : (N,) int32
        Scratch: the layer of each point.
    used : (L,) bool
        All False; receives whether each layer is used.
    starts : (2, L + 1) int64
        All 0; receives the start and the end of each layer.
    placed : (N, 3) float64
        Scratch: the used points, layer by layer.
    met_all : (S,) bool
        All False; receives the results.
    """
    step = 2 * math.pi / DIRECTIONS
    sort_by_layer(points, centers, bottom, reach, layers, used, starts, placed)
    for k in range(len(centers)):
        x, y, z = centers[k, 0], centers[k, 1], centers[k, 2]
        first, last = around(z, bottom, reach, len(used))
        met = NONE
        for i in range(starts[0, first], starts[0, last]):
            dx, dy, dz = placed[i, 0] - x, placed[i, 1] - y, placed[i, 2] - z
            across = reach * reach - dz * dz
            if across <= 0:
                continue
            if can_meet(dx, dy, across / (dx * dx + dy * dy)) & ~met == NONE:
                continue
            distance = math.sqrt(dx * dx + dy * dy)
            if distance * distance <= across:
                continue
            spread, angle = math.asin(math.sqrt(across) / distance), math.atan2(dy, dx)
            met |= directions(
                np.int64(math.ceil((angle - spread) / step)), np.int64(math.floor((angle + spread) / step))
            )
            if met == EVERY:
                met_all[k] = True
                break
