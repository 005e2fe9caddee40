"""What lies around a rolling sphere, copied once and used for several steps.

A step looks four times at its surroundings. Copied side by side they are read from the nearest cache, and one
search of the grids serves until the sphere has rolled away from where it was made.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from .grid import EMPTY, cell_index, may_touch_points

# Radii: the longest step, the fall after it that the surroundings decide, and the way that they serve for.
STRIDE, DEPTH, SLACK = 1.0, 0.05, 0.2
SPHERE_REACH = 2 + STRIDE + DEPTH + SLACK
POINT_REACH = 1 + STRIDE + DEPTH + SLACK
MAX_LOOKS = 64  # of one sphere that are remembered
MAX_SPHERES = 128  # that fit within SPHERE_REACH of a place: at the densest 0.74 * (SPHERE_REACH + 1)**3 = 87


class Nearby(NamedTuple):
    """Points and settled spheres near a place."""

    points: np.ndarray  # (N, 3) metres, the first counts[0] rows
    spheres: np.ndarray  # (MAX_SPHERES, 3) metres, the first counts[1] rows
    counts: np.ndarray  # (3,) int64: points, spheres, and looks since the sphere began to roll
    place: np.ndarray  # (3,) metres
    normals: np.ndarray  # (C, 3) scratch for contacts
    looks: np.ndarray  # (MAX_LOOKS, 4) metres, the first places looked around, and 1 where a long fall began there


def nowhere(point_count: int, max_contacts: int) -> Nearby:
    """Return room for the surroundings of any place of a cloud with so many points."""
    rooms = np.empty((point_count, 3)), np.empty((MAX_SPHERES, 3)), np.zeros(3, np.int64)
    return Nearby(*rooms, np.full(3, np.inf), np.empty((max_contacts + 1, 3)), np.empty((MAX_LOOKS, 4)))


@njit(cache=True, error_model="numpy")
def look_around(points, spheres, nearby, x, y, z, radius):
    """Fill the surroundings of (x, y, z)."""
    nearby.place[0], nearby.place[1], nearby.place[2] = x, y, z
    if nearby.counts[2] < MAX_LOOKS:
        look = nearby.looks[nearby.counts[2]]
        look[0], look[1], look[2], look[3] = x, y, z, 0.0
    nearby.counts[2] += 1
    nearby.counts[0] = 0
    if may_touch_points(spheres, x, y, z):
        nearby.counts[0] = copy_points(points, x, y, z, POINT_REACH * radius, nearby.points)
    nearby.counts[1] = copy_spheres(spheres, x, y, z, SPHERE_REACH * radius, nearby.spheres)


@njit(cache=True, error_model="numpy")
def still_serves(nearby, x, y, z, radius):
    """Tell whether a sphere at (x, y, z) is near enough to where its surroundings were searched."""
    dx, dy, dz = x - nearby.place[0], y - nearby.place[1], z - nearby.place[2]
    return dx * dx + dy * dy + dz * dz < (SLACK * radius) ** 2


@njit(cache=True, error_model="numpy")
def copy_points(points, x, y, z, reach, copied):
    """Copy the points within ``reach`` of (x, y, z) to ``copied``; return how many."""
    count = 0
    first_y = cell_index(y - reach - points.front, points.per_metre, points.ny)
    last_y = cell_index(y + reach - points.front, points.per_metre, points.ny)
    top = cell_index(points.top - z - reach, points.per_metre, points.nz)
    bottom = cell_index(points.top - z + reach, points.per_metre, points.nz)
    for ix in range(
        cell_index(x - reach - points.left, points.per_metre, points.nx),
        cell_index(x + reach - points.left, points.per_metre, points.nx) + 1,
    ):
        for iy in range(first_y, last_y + 1):
            column = (ix * points.ny + iy) * points.nz
            for i in range(points.start[column + top], points.start[column + bottom + 1]):
                px, py, pz = points.xyz[i, 0], points.xyz[i, 1], points.xyz[i, 2]
                if (px - x) ** 2 + (py - y) ** 2 + (pz - z) ** 2 < reach * reach:
                    copied[count, 0], copied[count, 1], copied[count, 2] = px, py, pz
                    count += 1
    return count


@njit(cache=True, error_model="numpy")
def copy_spheres(spheres, x, y, z, reach, copied):
    """Copy the centres of the settled spheres within ``reach`` of (x, y, z) to ``copied``; return how many."""
    count = 0
    first_y = cell_index(y - reach - spheres.front, spheres.per_metre, spheres.ny)
    last_y = cell_index(y + reach - spheres.front, spheres.per_metre, spheres.ny)
    for ix in range(
        cell_index(x - reach - spheres.left, spheres.per_metre, spheres.nx),
        cell_index(x + reach - spheres.left, spheres.per_metre, spheres.nx) + 1,
    ):
        for iy in range(first_y, last_y + 1):
            block = spheres.last[ix * spheres.ny + iy]
            while block != EMPTY and spheres.blocks[block, 0, 0] > z - reach:
                for k in range(1, int(spheres.blocks[block, 0, 1]) + 1):
                    cx, cy, cz = spheres.blocks[block, k, 0], spheres.blocks[block, k, 1], spheres.blocks[block, k, 2]
                    if (cx - x) ** 2 + (cy - y) ** 2 + (cz - z) ** 2 < reach * reach:
                        copied[count, 0], copied[count, 1], copied[count, 2] = cx, cy, cz
                        count += 1
                block = np.uint32(spheres.blocks[block, 0, 2])
    return count
