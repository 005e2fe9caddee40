"""Falling: a sphere falls straight down until it touches points or settled spheres (paper, §III-A)."""

from __future__ import annotations

import math

import numpy as np

from .grid import BLOCK, cell_index, columns_around, falls_past_points
from .kernels import inline_jit
from .nearby import DEPTH, covers_fall

# A contact this close to the equator of the sphere does not stop a fall: the sphere slides past a wall that it grazes.
# It may then overlap with the wall by at most (1 - GRAZE) of the contact distance.
GRAZE_POINT = 0.99
GRAZE_SPHERE = 0.995
# A distance of less than these shares of the contact distance is an overlap: slightly less than 2 % of the radius.
TIGHT_POINT = 0.982
TIGHT_SPHERE = 0.991


@inline_jit
def fall_on_points(points, x, y, z, radius, best):
    """Return the height of the first contact with the cloud below (x, y, z), and whether (x, y, z) is clear.

    ``best`` is the height of a known contact; lower contacts are not searched.
    """
    graze = (GRAZE_POINT * radius) ** 2
    tight = (TIGHT_POINT * radius) ** 2
    first_x, last_x, first_y, last_y = columns_around(points, x, y, radius)
    level = cell_index(points.top - z - radius, points.per_metre, points.nz)
    for ix in range(first_x, last_x + 1):
        for iy in range(first_y, last_y + 1):
            column = (ix * points.ny + iy) * points.nz
            for i in range(points.start[column + level], points.start[column + points.nz]):
                pz = points.xyz[i, 2]
                if pz + points.cell + radius <= best:
                    break  # a column is sorted by cell, so within one cell a later point can be higher
                dx = points.xyz[i, 0] - x
                dy = points.xyz[i, 1] - y
                d2 = dx * dx + dy * dy
                if d2 >= graze:
                    continue
                contact = pz + math.sqrt(radius * radius - d2)
                if contact <= z:
                    best = max(best, contact)
                elif d2 + (z - pz) ** 2 < tight:
                    return best, False
                elif pz < z:
                    best = max(best, z)
    return best, True


@inline_jit
def fall_on_spheres(spheres, x, y, z, radius, best):
    """Return the height of the first contact with settled spheres below (x, y, z), and whether it is clear."""
    reach = 2 * radius
    graze = (GRAZE_SPHERE * reach) ** 2
    tight = (TIGHT_SPHERE * reach) ** 2
    first_x, last_x, first_y, last_y = columns_around(spheres, x, y, reach)
    for ix in range(first_x, last_x + 1):
        for column in range(ix * spheres.ny + first_y, ix * spheres.ny + last_y + 1):
            highest, block = spheres.blocks[column, 0, 3], np.uint64(column)
            while highest + reach > best:
                for k in range(BLOCK):
                    dx = spheres.blocks[block, 1, k] - x
                    dy = spheres.blocks[block, 2, k] - y
                    sz = spheres.blocks[block, 3, k]
                    d2 = dx * dx + dy * dy
                    if d2 >= graze or sz + reach <= best:
                        continue
                    contact = sz + math.sqrt(reach * reach - d2)
                    if contact <= z:
                        best = max(best, contact)
                    elif d2 + (z - sz) ** 2 < tight:
                        return best, False
                    elif sz < z:
                        best = max(best, z)
                highest, block = spheres.blocks[block, 0, 0], np.uint64(spheres.blocks[block, 0, 2])
    return best, True


@inline_jit
def fall_on_nearby(around, count, x, y, z, touch, graze, tight, best):
    """Return the same as `fall_on_points` for the first ``count`` points around (3, N) and a contact distance."""
    aside = (graze * touch) ** 2
    tight = (tight * touch) ** 2
    for i in range(count):
        dx, dy = around[0, i] - x, around[1, i] - y
        d2 = dx * dx + dy * dy
        if d2 >= aside:
            continue
        pz = around[2, i]
        contact = pz + math.sqrt(touch * touch - d2)
        if contact <= z:
            best = max(best, contact)
        elif d2 + (z - pz) ** 2 < tight:
            return best, False
        elif pz < z:
            best = max(best, z)
    return best, True


@inline_jit
def fall(points, spheres, x, y, z, radius):
    """Return the height at which a sphere falling from (x, y, z) first touches, and whether it starts clear.

    The ground at z = 0 ends every fall, so the height is at least the radius.
    """
    return fall_to(points, spheres, x, y, z, radius, radius)


@inline_jit
def fall_to(points, spheres, x, y, z, radius, best):
    """Return the same as `fall` for a sphere with a known contact at the height ``best`` <= z."""
    best, clear = fall_on_spheres(spheres, x, y, z, radius, best)
    if not clear or falls_past_points(spheres, x, y, z, best):
        return best, clear
    return fall_on_points(points, x, y, z, radius, best)


@inline_jit
def fall_nearby(points, spheres, nearby, x, y, z, radius):
    """Return the same as `fall`, using only the neighbourhood unless the fall leads out of it."""
    around, near = nearby.spheres, nearby.counts[1]
    best, clear = fall_on_nearby(around, near, x, y, z, 2 * radius, GRAZE_SPHERE, TIGHT_SPHERE, radius)
    if clear:
        around, near = nearby.points, nearby.counts[0]
        best, clear = fall_on_nearby(around, near, x, y, z, radius, GRAZE_POINT, TIGHT_POINT, best)
    if clear and z - best > DEPTH * radius and not covers_fall(nearby, x, y, z, best, radius):
        return fall_to(points, spheres, x, y, z, radius, best)
    return best, clear


@inline_jit
def stands_on_floor(points, x, y, radius):
    """Return whether the object has a floor at ground level under a sphere that fell to z = 0.

    Models made of single sheets have one; a sphere next to a leg is farther from the foot of the leg.
    """
    reach = 0.8 * radius
    first_x, last_x, first_y, last_y = columns_around(points, x, y, reach)
    for ix in range(first_x, last_x + 1):
        for iy in range(first_y, last_y + 1):
            column = (ix * points.ny + iy) * points.nz
            for i in range(points.start[column + points.nz] - 1, points.start[column] - 1, -1):
                if points.xyz[i, 2] > 0.1 * radius + points.cell:
                    break
                aside = (points.xyz[i, 0] - x) ** 2 + (points.xyz[i, 1] - y) ** 2
                if points.xyz[i, 2] <= 0.1 * radius and aside < reach * reach:
                    return True
    return False
