"""A sphere in contact rolls downhill until it is blocked, is on a flat surface, or leaves the object (§III-A)."""

from __future__ import annotations

import math
from typing import NamedTuple

from numba import njit

from .contact import cloud_contact, sphere_contacts, steepest_descent, touches_cloud
from .falling import short_fall, stands_on_floor
from .grid import cell_index, gather, may_touch_points

SETTLED, ROLLED_OFF, REJECTED, TIMED_OUT = 0, 1, 2, 3  # as spherefunc_bullet.simulator.Outcome
MAX_STEPS = 20_000  # of one sphere, whatever happens
STALLED_STEPS = 4  # steps without a new lowest height after which a sphere is blocked
STRIDE, DEPTH = 0.7, 0.4  # radii: the longest step, and the fall after it that neighbours decide
GRAZING = 1e-6  # an approach slower than this share of the way is a tangent one, along a contact


class RollShape(NamedTuple):
    """Lengths that depend on the radius and on the cloud's spacing, in metres."""

    gap: float  # farthest that a flat surface's nearest point lies aside of the contact
    patch: float  # reach around the contact whose points make the plane
    bump: float  # how far a sphere sinks between points, so how high it must be able to climb
    flat: float  # sine of the slope that counts as flat


@njit(cache=True)
def free_path_points(points, x, y, z, vx, vy, vz, radius, length):
    """Return how far a sphere can move along the unit vector v before it hits the cloud, at most ``length``."""
    margin = radius + length
    touch = radius * radius
    top = cell_index(points.top - z - margin, points.cell, points.nz)
    bottom = cell_index(points.top - z + margin, points.cell, points.nz)
    for ix in range(
        cell_index(x - margin - points.left, points.cell, points.nx),
        cell_index(x + margin - points.left, points.cell, points.nx) + 1,
    ):
        for iy in range(
            cell_index(y - margin - points.front, points.cell, points.ny),
            cell_index(y + margin - points.front, points.cell, points.ny) + 1,
        ):
            column = (ix * points.ny + iy) * points.nz
            for i in range(points.start[column + top], points.start[column + bottom + 1]):
                px, py, pz = x - points.x[i], y - points.y[i], z - points.z[i]
                approach = px * vx + py * vy + pz * vz
                if approach < -GRAZING * radius:
                    inside = approach * approach - (px * px + py * py + pz * pz) + touch
                    if inside > 0:
                        length = min(length, -approach - math.sqrt(inside))
    return length


@njit(cache=True)
def free_path_spheres(neighbours, near, x, y, z, vx, vy, vz, radius, length):
    """Return how far a sphere can move along the unit vector v before it hits a settled one."""
    touch = 4 * radius * radius
    for i in range(near):
        px, py, pz = x - neighbours[i, 0], y - neighbours[i, 1], z - neighbours[i, 2]
        approach = px * vx + py * vy + pz * vz
        if approach < -GRAZING * radius:
            inside = approach * approach - (px * px + py * py + pz * pz) + touch
            if inside > 0:
                length = min(length, -approach - math.sqrt(inside))
    return length


@njit(cache=True)
def step(points, spheres, x, y, z, radius, shape, scratch):
    """Move a sphere in contact at (x, y, z) one stride downhill; return its new place and whether it moved.

    It moves along the steepest descent that its contacts leave free, as far as nothing is in the way, is
    lifted over the roughness of a sampled surface, and falls again to what is below.
    """
    normals, neighbours = scratch
    stride, depth = STRIDE * radius, DEPTH * radius
    near = gather(spheres, x, y, z, 2 * radius + stride + depth, neighbours)
    count = 0
    touching = on_plane = False
    near_cloud = may_touch_points(spheres, x, y, z)
    if near_cloud:
        touching, on_plane = cloud_contact(points, x, y, z, radius, shape, normals)
        count = 1 if touching else 0
    count = sphere_contacts(neighbours, near, x, y, z, radius, 0.02 * radius, normals, count)
    vx, vy, vz = steepest_descent(normals, count)
    slope = math.sqrt(vx * vx + vy * vy + vz * vz)
    if slope < (shape.flat if on_plane else 1e-3):
        return x, y, z, False
    vx, vy, vz = vx / slope, vy / slope, vz / slope
    length = free_path_spheres(neighbours, near, x, y, z, vx, vy, vz, radius, stride)
    if near_cloud:
        length = free_path_points(points, x, y, z, vx, vy, vz, radius - shape.bump, length)
    if length < 0.01 * radius:
        return x, y, z, False
    nx, ny, nz = x + length * vx, y + length * vy, z + length * vz
    if touching:
        nx += shape.bump * normals[0, 0]
        ny += shape.bump * normals[0, 1]
        nz += shape.bump * normals[0, 2]
    height, clear = short_fall(points, spheres, neighbours, near, nx, ny, nz, radius, depth - shape.bump)
    if not clear:
        return x, y, z, False
    return nx, ny, height, True


@njit(cache=True)
def rest(points, spheres, x, y, z, radius, low, high):
    """Return the outcome of coming to rest at (x, y, z), and whether it is on the object.

    Resting on spheres alone counts only within the object's bounding box (paper, §III-A).
    """
    if touches_cloud(points, spheres, x, y, z, radius):
        return SETTLED, True
    inside = low[0] <= x <= high[0] and low[1] <= y <= high[1] and low[2] <= z <= high[2]
    return (SETTLED if inside else REJECTED), False


@njit(cache=True)
def roll(points, spheres, x, y, z, radius, shape, low, high, scratch):
    """Roll a sphere that has just touched at (x, y, z) until it rests or is gone.

    Returns x, y, z, the outcome, and whether it rests on the object itself.
    """
    lowest, stalled = z, 0
    for _ in range(MAX_STEPS):
        if z <= radius:
            if stands_on_floor(points, x, y, radius):
                return x, y, z, SETTLED, True
            return x, y, z, ROLLED_OFF, False
        x, y, z, moved = step(points, spheres, x, y, z, radius, shape, scratch)
        if not moved:
            outcome, on_object = rest(points, spheres, x, y, z, radius, low, high)
            return x, y, z, outcome, on_object
        if z < lowest - 0.002 * radius:
            lowest, stalled = z, 0
        else:
            stalled += 1
            if stalled >= STALLED_STEPS:
                outcome, on_object = rest(points, spheres, x, y, z, radius, low, high)
                return x, y, z, outcome, on_object
    return x, y, z, TIMED_OUT, False
