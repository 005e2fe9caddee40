"""A sphere falls straight down until it touches points or settled spheres (paper, §III-A)."""

from __future__ import annotations

import math

from numba import njit

from .grid import EMPTY, cell_index, may_touch_points

# A contact this close to the sphere's equator does not stop a fall: the sphere slides past a wall that it
# grazes. It may then overlap what it grazes by at most (1 - GRAZE) of the distance at which they touch.
GRAZE_POINT = 0.99
GRAZE_SPHERE = 0.995
TIGHT = 0.982  # nearer than this share of the contact distance is an overlap


@njit(cache=True)
def fall_on_points(points, x, y, z, radius, best):
    """Return the height of the first contact with the cloud below (x, y, z), and whether that place is clear.

    ``best`` is a contact height known already; a lower one is not looked for.
    """
    graze = (GRAZE_POINT * radius) ** 2
    tight = (TIGHT * radius) ** 2
    first_x = cell_index(x - radius - points.left, points.cell, points.nx)
    last_x = cell_index(x + radius - points.left, points.cell, points.nx)
    first_y = cell_index(y - radius - points.front, points.cell, points.ny)
    last_y = cell_index(y + radius - points.front, points.cell, points.ny)
    level = cell_index(points.top - z - radius, points.cell, points.nz)
    for ix in range(first_x, last_x + 1):
        for iy in range(first_y, last_y + 1):
            column = (ix * points.ny + iy) * points.nz
            for i in range(points.start[column + level], points.start[column + points.nz]):
                pz = points.z[i]
                if pz + radius <= best:
                    break
                dx = points.x[i] - x
                dy = points.y[i] - y
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


@njit(cache=True)
def fall_on_spheres(spheres, x, y, z, radius, best):
    """Return the height of the first contact with settled spheres below (x, y, z), and whether it is clear."""
    reach = 2 * radius
    graze = (GRAZE_SPHERE * reach) ** 2
    tight = (TIGHT * reach) ** 2
    first_x = cell_index(x - reach - spheres.left, spheres.cell, spheres.nx)
    last_x = cell_index(x + reach - spheres.left, spheres.cell, spheres.nx)
    first_y = cell_index(y - reach - spheres.front, spheres.cell, spheres.ny)
    last_y = cell_index(y + reach - spheres.front, spheres.cell, spheres.ny)
    level = cell_index(z + reach - spheres.bottom, spheres.cell, spheres.nz)
    for ix in range(first_x, last_x + 1):
        for iy in range(first_y, last_y + 1):
            column = ix * spheres.ny + iy
            for iz in range(min(level, spheres.highest[column]), -1, -1):
                if spheres.bottom + (iz + 1) * spheres.cell + reach <= best:
                    break
                i = spheres.first[column * spheres.nz + iz]
                while i != EMPTY:
                    dx = spheres.centers[i, 0] - x
                    dy = spheres.centers[i, 1] - y
                    sz = spheres.centers[i, 2]
                    i = spheres.following[i]
                    d2 = dx * dx + dy * dy
                    if d2 >= graze:
                        continue
                    contact = sz + math.sqrt(reach * reach - d2)
                    if contact <= z:
                        best = max(best, contact)
                    elif d2 + (z - sz) ** 2 < tight:
                        return best, False
                    elif sz < z:
                        best = max(best, z)
    return best, True


@njit(cache=True)
def fall_on_neighbours(neighbours, near, x, y, z, radius, best):
    """Do as `fall_on_spheres` with the first ``near`` neighbouring spheres alone."""
    reach = 2 * radius
    graze = (GRAZE_SPHERE * reach) ** 2
    tight = (TIGHT * reach) ** 2
    for i in range(near):
        dx, dy = neighbours[i, 0] - x, neighbours[i, 1] - y
        d2 = dx * dx + dy * dy
        if d2 >= graze:
            continue
        sz = neighbours[i, 2]
        contact = sz + math.sqrt(reach * reach - d2)
        if contact <= z:
            best = max(best, contact)
        elif d2 + (z - sz) ** 2 < tight:
            return best, False
        elif sz < z:
            best = max(best, z)
    return best, True


@njit(cache=True)
def fall(points, spheres, x, y, z, radius):
    """Return the height at which a sphere falling from (x, y, z) first touches, and whether it starts clear.

    The ground at z = 0 ends every fall, so the height is at least the radius.
    """
    best, clear = fall_on_spheres(spheres, x, y, z, radius, radius)
    if not clear:
        return best, False
    return fall_on_points(points, x, y, z, radius, best)


@njit(cache=True)
def short_fall(points, spheres, neighbours, near, x, y, z, radius, depth):
    """Do as `fall`, looking first at the neighbours, which are all the spheres that ``depth`` can reach."""
    best, clear = fall_on_neighbours(neighbours, near, x, y, z, radius, radius)
    if not clear:
        return best, False
    if z - best > depth:
        return fall(points, spheres, x, y, z, radius)
    if not may_touch_points(spheres, x, y, z):
        return best, True
    return fall_on_points(points, x, y, z, radius, best)


@njit(cache=True)
def stands_on_floor(points, x, y, radius):
    """Tell whether the object has a floor at ground level under a sphere that came down to z = 0.

    Single-sheet models have one; a sphere beside a leg is farther from the leg's foot than this.
    """
    reach = 0.8 * radius
    first_x = cell_index(x - reach - points.left, points.cell, points.nx)
    last_x = cell_index(x + reach - points.left, points.cell, points.nx)
    first_y = cell_index(y - reach - points.front, points.cell, points.ny)
    last_y = cell_index(y + reach - points.front, points.cell, points.ny)
    for ix in range(first_x, last_x + 1):
        for iy in range(first_y, last_y + 1):
            column = (ix * points.ny + iy) * points.nz
            for i in range(points.start[column + points.nz] - 1, points.start[column] - 1, -1):
                if points.z[i] > 0.1 * radius:
                    break
                if (points.x[i] - x) ** 2 + (points.y[i] - y) ** 2 < reach * reach:
                    return True
    return False
