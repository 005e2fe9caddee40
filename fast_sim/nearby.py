"""The neighbourhood of a rolling sphere, copied once and used for several steps.

A step reads its surroundings four times. A compact copy is read from the fastest cache, and one search of the grids is
enough until the sphere has rolled away from where it was made.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .grid import cell_index, columns_around, may_touch_points
from .kernels import entry_jit, inline_jit
from .lanes import lowest_bit, near_of_eight, near_of_four

# Radii: the longest step, the fall after it that the neighbourhood covers, and the distance for which it is reused.
STRIDE, DEPTH, SLACK = 1.0, 0.05, 0.2
SPHERE_REACH = 2 + STRIDE + DEPTH + SLACK
POINT_REACH = 1 + STRIDE + DEPTH + SLACK
KNOWN = 0.9999 * (STRIDE + DEPTH + SLACK)  # within this distance, the neighbourhood contains all that a sphere touches
MAX_SPHERES = 128  # within SPHERE_REACH of a place; the densest packing has 0.74 * (SPHERE_REACH + 1)**3 = 87

# Unsigned, because signed indices need a test for negative values.
NONE, ONE, FOUR, EIGHT, FULL = (np.uint64(number) for number in (0, 1, 4, 8, 64))


class Neighbourhood(NamedTuple):
    """Points and settled spheres near a place."""

    points: np.ndarray  # (3, N + 1) metres, all x, all y and all z of the first counts[0]
    spheres: np.ndarray  # (3, MAX_SPHERES) metres, of the first counts[1]
    counts: np.ndarray  # (2,) int64: points, spheres
    place: np.ndarray  # (3,) metres
    normals: np.ndarray  # (C, 3) scratch for contacts
    strip: np.ndarray  # (4,) metres: left, right, front and back bounds of the strip; infinite for most runs
    pending: np.ndarray  # (16,) uint64 scratch: indices of the points or blocks whose bits are passed to copy functions


@inline_jit
def is_in_strip(nearby, x, y):
    """Return whether (x, y) is inside the strip."""
    strip = nearby.strip
    return (strip[0] <= x) & (x <= strip[1]) & (strip[2] <= y) & (y <= strip[3])


@inline_jit
def fill_neighbourhood(points, spheres, nearby, x, y, z, radius):
    """Fill the neighbourhood of (x, y, z)."""
    nearby.place[0], nearby.place[1], nearby.place[2] = x, y, z
    nearby.counts[0] = 0
    if may_touch_points(spheres, x, y, z):
        nearby.counts[0] = copy_points(points, x, y, z, POINT_REACH * radius, nearby.pending, nearby.points)
    nearby.counts[1] = copy_spheres(spheres, x, y, z, SPHERE_REACH * radius, nearby.pending, nearby.spheres)


@inline_jit
def still_valid(nearby, x, y, z, radius):
    """Return whether the neighbourhood is still valid for a sphere at (x, y, z)."""
    dx, dy, dz = x - nearby.place[0], y - nearby.place[1], z - nearby.place[2]
    slack = SLACK * radius
    return dx * dx + dy * dy + dz * dz < slack * slack


@inline_jit
def covers_fall(nearby, x, y, high, low, radius):
    """Return whether the neighbourhood contains everything that a sphere falling from ``high`` to ``low`` can touch."""
    dx, dy, above, below = x - nearby.place[0], y - nearby.place[1], high - nearby.place[2], low - nearby.place[2]
    known = KNOWN * radius
    return dx * dx + dy * dy + max(above * above, below * below) < known * known


@inline_jit
def copy_points(points, x, y, z, reach, pending, copied):
    """Copy the points within ``reach`` of (x, y, z) to ``copied``; return their number.

    The results of all lanes are collected in the bits of one number before any point is copied: the processor cannot
    predict which points are near, and mispredictions would cost more than everything else.
    """
    first_x, last_x, first_y, last_y = columns_around(points, x, y, reach)
    top = cell_index(points.top - z - reach, points.per_metre, points.nz)
    bottom = cell_index(points.top - z + reach, points.per_metre, points.nz)
    stride, bits, near, count = np.uint64(len(points.xyz)), NONE, NONE, NONE
    for ix in range(first_x, last_x + 1):
        for iy in range(first_y, last_y + 1):
            column = (ix * points.ny + iy) * points.nz
            i, end = np.uint64(points.start[column + top]), np.uint64(points.start[column + bottom + 1])
            while i < end:
                lanes = near_of_eight(points.xyz, i, stride, x, y, z, reach * reach)
                if end - i < EIGHT:
                    lanes &= (ONE << (end - i)) - ONE  # the other lanes belong to other cells
                near |= lanes << bits
                pending[bits // EIGHT] = i
                i += EIGHT
                bits += EIGHT
                if bits == FULL:
                    count = copy_near_points(points.xyz, near, pending, copied, count)
                    bits = near = NONE
    return copy_near_points(points.xyz, near, pending, copied, count)


@inline_jit
def copy_near_points(xyz, near, pending, copied, count):
    """Append the points whose bits are set to the first ``count`` of ``copied``; return the new count."""
    while near:
        bit = lowest_bit(near)
        near &= near - ONE
        i = pending[bit // EIGHT] + bit % EIGHT
        copied[0, count], copied[1, count], copied[2, count] = xyz[i, 0], xyz[i, 1], xyz[i, 2]
        count += ONE
    return count


@inline_jit
def copy_spheres(spheres, x, y, z, reach, pending, copied):
    """Copy the settled centres within ``reach`` of (x, y, z) to ``copied``; return their number; see `copy_points`."""
    first_x, last_x, first_y, last_y = columns_around(spheres, x, y, reach)
    low, bits, near, count = z - reach, NONE, NONE, NONE
    for ix in range(first_x, last_x + 1):
        for column in range(ix * spheres.ny + first_y, ix * spheres.ny + last_y + 1):
            highest, block = spheres.blocks[column, 0, 3], np.uint64(column)
            while highest > low:
                first = FOUR * (FOUR * block + ONE)  # after the head of the block
                near |= near_of_four(spheres.blocks, first, FOUR, x, y, z, reach * reach) << bits
                pending[bits // FOUR] = block
                bits += FOUR
                if bits == FULL:
                    count = copy_near_spheres(spheres.blocks, near, pending, copied, count)
                    bits = near = NONE
                highest, block = spheres.blocks[block, 0, 0], np.uint64(spheres.blocks[block, 0, 2])
    return copy_near_spheres(spheres.blocks, near, pending, copied, count)


@inline_jit
def copy_near_spheres(blocks, near, pending, copied, count):
    """Append settled centres like `copy_near_points`."""
    while near:
        bit = lowest_bit(near)
        near &= near - ONE
        block, k = blocks[pending[bit // FOUR]], bit % FOUR
        copied[0, count], copied[1, count], copied[2, count] = block[1, k], block[2, k], block[3, k]
        count += ONE
    return count


@entry_jit
def touches_points(points, x, y, z, reach):
    """Return whether a point is within ``reach`` of (x, y, z)."""
    first_x, last_x, first_y, last_y = columns_around(points, x, y, reach)
    top = cell_index(points.top - z - reach, points.per_metre, points.nz)
    bottom = cell_index(points.top - z + reach, points.per_metre, points.nz)
    for ix in range(first_x, last_x + 1):
        for iy in range(first_y, last_y + 1):
            column = (ix * points.ny + iy) * points.nz
            for i in range(points.start[column + top], points.start[column + bottom + 1]):
                dx, dy, dz = points.xyz[i, 0] - x, points.xyz[i, 1] - y, points.xyz[i, 2] - z
                if dx * dx + dy * dy + dz * dz < reach * reach:
                    return True
    return False
