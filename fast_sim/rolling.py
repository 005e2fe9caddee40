"""Rolling: a sphere in contact rolls downhill until it is blocked, on a flat surface, or off the object (§III-A)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .contact import cloud_contact, nearest_point, sphere_contacts, steepest_descent
from .falling import TIGHT_POINT, fall_nearby, stands_on_floor
from .kernels import inline_jit
from .nearby import STRIDE, fill_neighbourhood, is_in_strip, still_valid, touches_points

SETTLED, ROLLED_OFF, REJECTED, TIMED_OUT = 0, 1, 2, 3  # as spherefunc_bullet.simulator.Outcome
ASTRAY = 4  # has left its strip, see `strips`
MAX_STEPS = 20_000  # of one sphere, whatever happens
ASIDE = 2.1  # radii: smallest distance of other spheres from one that does not lean on any
GRAZING = 1e-6  # a smaller share of the motion towards a point counts as tangential, along a contact


class RollShape(NamedTuple):
    """Lengths that depend on the radius and on the cloud's spacing, in metres."""

    gap: float  # largest distance between the contact and the nearest point of a flat surface
    patch: float  # distance from the contact within which points define the plane
    bump: float  # depth to which a sphere sinks between points, so the height that it must be able to climb
    flat: float  # sine of the slope that counts as flat
    stalled: int  # steps without a new lowest height after which a sphere is blocked


@inline_jit
def free_path(around, near, x, y, z, vx, vy, vz, touch, length):
    """Return how far a sphere can move along the unit vector v before it is within ``touch`` of a point around."""
    for i in range(near):
        px, py, pz = x - around[0, i], y - around[1, i], z - around[2, i]
        approach = px * vx + py * vy + pz * vz
        inside = approach * approach - (px * px + py * py + pz * pz) + touch * touch
        if (approach < -GRAZING * touch) & (inside > 0):  # one branch, which is rarely taken
            length = min(length, -approach - math.sqrt(inside))
    return length


@inline_jit
def step(points, spheres, nearby, x, y, z, radius, shape):
    """Move a sphere in contact at (x, y, z) one stride downhill; return its new position and whether it moved.

    It moves along the steepest descent that its contacts allow until something is in the way, is lifted over the
    roughness of a sampled surface, and falls onto what is below.
    """
    normals = nearby.normals
    touching, on_plane = cloud_contact(nearby, x, y, z, radius, shape)
    count = sphere_contacts(nearby, x, y, z, radius, 0.02 * radius, 1 if touching else 0)
    vx, vy, vz = steepest_descent(normals, count)
    slope = math.sqrt(vx * vx + vy * vy + vz * vz)
    if slope < (shape.flat if on_plane else 1e-3):
        return x, y, z, False
    vx, vy, vz = vx / slope, vy / slope, vz / slope
    length = free_path(nearby.spheres, nearby.counts[1], x, y, z, vx, vy, vz, 2 * radius, STRIDE * radius)
    length = free_path(nearby.points, nearby.counts[0], x, y, z, vx, vy, vz, radius - shape.bump, length)
    if length < 0.01 * radius:
        return x, y, z, False
    nx, ny, nz = x + length * vx, y + length * vy, z + length * vz
    if touching:
        nx += shape.bump * normals[0, 0]
        ny += shape.bump * normals[0, 1]
        nz += shape.bump * normals[0, 2]
    height, clear = fall_nearby(points, spheres, nearby, nx, ny, nz, radius)
    if not clear:
        return x, y, z, False
    return nx, ny, height, True


@inline_jit
def rest(points, nearby, x, y, z, radius, low, high):
    """Return the outcome of a sphere that stops at (x, y, z), and whether it touches the object.

    Resting on spheres alone counts only within the object's bounding box (paper, §III-A).
    """
    if still_valid(nearby, x, y, z, radius):
        on_object = nearest_point(nearby.points, nearby.counts[0], x, y, z, 1.01 * radius)[0] >= 0
    else:
        on_object = touches_points(points, x, y, z, 1.01 * radius)
    if on_object:
        return SETTLED, True
    inside = low[0] <= x <= high[0] and low[1] <= y <= high[1] and low[2] <= z <= high[2]
    return (SETTLED if inside else REJECTED), False


@inline_jit
def height_on_plane(nearby, x, y, z, radius, shape):
    """Return the height at which a sphere at rest touches the flat surface below it.

    In contact with points, it has sunk between them. Next to other spheres, on which it may lean, it stays there.
    """
    around, normal = nearby.points, nearby.normals[0]
    if not cloud_contact(nearby, x, y, z, radius, shape)[1] or normal[2] < math.sqrt(1 - shape.flat * shape.flat):
        return z
    i = nearest_point(around, nearby.counts[0], x, y, z, radius + shape.bump)[0]
    along = (x - around[0, i]) * normal[0] + (y - around[1, i]) * normal[1] + (z - around[2, i]) * normal[2]
    height = z + (radius - along) / normal[2]
    if height <= z or nearest_point(around, nearby.counts[0], x, y, height, TIGHT_POINT * radius)[0] >= 0:
        return z
    aside = nearest_point(nearby.spheres, nearby.counts[1], x, y, height, ASIDE * radius)[0]
    return z if aside >= 0 else height


@inline_jit
def roll(points, spheres, nearby, x, y, z, radius, shape, low, high):
    """Roll a sphere from its first contact at (x, y, z) until it rests or has left the object.

    Returns x, y, z, the outcome, and whether it rests on the object itself.
    """
    lowest, stalled = z, 0
    nearby.place[0] = np.inf  # the neighbourhood is not known yet
    for _ in range(MAX_STEPS):
        if z <= radius:
            if stands_on_floor(points, x, y, radius):
                return x, y, z, SETTLED, True
            return x, y, z, ROLLED_OFF, False
        if not still_valid(nearby, x, y, z, radius):
            if not is_in_strip(nearby, x, y):
                return x, y, z, ASTRAY, False
            fill_neighbourhood(points, spheres, nearby, x, y, z, radius)
        x, y, z, moved = step(points, spheres, nearby, x, y, z, radius, shape)
        stalled = stalled + 1 if z > lowest - 0.002 * radius else 0
        lowest = min(lowest, z)
        if not moved or stalled >= shape.stalled:
            outcome, on_object = rest(points, nearby, x, y, z, radius, low, high)
            if on_object and still_valid(nearby, x, y, z, radius):
                z = height_on_plane(nearby, x, y, z, radius, shape)
            return x, y, z, outcome, on_object
    return x, y, z, TIMED_OUT, False
