"""Contacts of a sphere, and the directions in which they let it move.

A contact is the unit normal from the touched surface to the sphere. For the cloud it is the normal of the plane
estimated through the points in contact (paper, §III-A); for a settled sphere, the direction between the centres.
"""

from __future__ import annotations

import math

from .kernels import inline_jit

MAX_CONTACTS = 12
# Points with a spread across of less than a quarter of that along form an edge, a rim or a wire, not a plane to rest
# on. The value is the product of the two variances over their squared sum.
RIDGE = 0.06


@inline_jit
def nearest_point(around, near, x, y, z, reach):
    """Return the index of the point (3, N) nearest to (x, y, z), -1 if none is within ``reach``, and its distance."""
    nearest, best = -1, reach * reach
    for i in range(near):
        dx, dy, dz = around[0, i] - x, around[1, i] - y, around[2, i] - z
        d2 = dx * dx + dy * dy + dz * dz
        if d2 < best:
            nearest, best = i, d2
    return nearest, math.sqrt(best)


@inline_jit
def plane_normal(around, near, x, y, z, reach):
    """Return the normal of the least-squares plane through the points within ``reach`` of (x, y, z).

    It is (0, 0, 0) if the points form a ridge instead of a plane. The axis with the largest minor is solved for, which
    is exact for coplanar points and needs no eigenvalues.
    """
    count = 0
    mx = my = mz = xx = yy = zz = xy = xz = yz = 0.0
    for i in range(near):
        px, py, pz = around[0, i] - x, around[1, i] - y, around[2, i] - z
        if px * px + py * py + pz * pz < reach * reach:
            count += 1
            mx += px
            my += py
            mz += pz
            xx += px * px
            yy += py * py
            zz += pz * pz
            xy += px * py
            xz += px * pz
            yz += py * pz
    if count < 3:
        return 0.0, 0.0, 0.0
    xx -= mx * mx / count
    yy -= my * my / count
    zz -= mz * mz / count
    xy -= mx * my / count
    xz -= mx * mz / count
    yz -= my * mz / count
    minor_x, minor_y, minor_z = yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy
    largest = max(minor_x, minor_y, minor_z)
    spread = xx + yy + zz
    if largest <= RIDGE * spread * spread:
        return 0.0, 0.0, 0.0
    if largest == minor_z:
        nx, ny, nz = xy * yz - xz * yy, xy * xz - yz * xx, minor_z
    elif largest == minor_y:
        nx, ny, nz = xz * yz - xy * zz, minor_y, xy * xz - yz * xx
    else:
        nx, ny, nz = minor_x, xz * yz - xy * zz, xy * yz - xz * yy
    norm = math.sqrt(nx * nx + ny * ny + nz * nz)
    return nx / norm, ny / norm, nz / norm


@inline_jit
def cloud_contact(nearby, x, y, z, radius, shape):
    """Write the cloud's contact into ``nearby.normals[0]``; return whether there is one and whether it is a plane.

    If the nearest point is farther aside than the spacing of the cloud explains, the sphere hangs over an edge, and its
    contact is this edge, not the plane next to it.
    """
    around, near, normals = nearby.points, nearby.counts[0], nearby.normals
    nearest, distance = nearest_point(around, near, x, y, z, radius + shape.bump)
    if nearest < 0:
        return False, False
    ax, ay, az = around[0, nearest], around[1, nearest], around[2, nearest]
    px, py, pz = x - ax, y - ay, z - az
    nx, ny, nz = plane_normal(around, near, ax, ay, az, shape.patch)
    along = px * nx + py * ny + pz * nz
    if along < 0:
        nx, ny, nz, along = -nx, -ny, -nz, -along
    aside = distance * distance - along * along
    is_plane = along > 0 and aside < shape.gap * shape.gap
    if is_plane:
        normals[0, 0], normals[0, 1], normals[0, 2] = nx, ny, nz
    else:
        normals[0, 0], normals[0, 1], normals[0, 2] = px / distance, py / distance, pz / distance
    return True, is_plane


@inline_jit
def sphere_contacts(nearby, x, y, z, radius, tolerance, count):
    """Append the contacts with settled spheres to ``nearby.normals``; return the new count."""
    neighbours, normals = nearby.spheres, nearby.normals
    reach = 2 * radius + tolerance
    for i in range(nearby.counts[1]):
        dx, dy, dz = x - neighbours[0, i], y - neighbours[1, i], z - neighbours[2, i]
        d2 = dx * dx + dy * dy + dz * dz
        if d2 < reach * reach and count < MAX_CONTACTS:
            d = math.sqrt(d2)
            normals[count, 0], normals[count, 1], normals[count, 2] = dx / d, dy / d, dz / d
            count += 1
    return count


@inline_jit
def is_allowed(normals, count, vx, vy, vz):
    """Return whether a motion does not lead into any of the contacts."""
    for k in range(count):
        if vx * normals[k, 0] + vy * normals[k, 1] + vz * normals[k, 2] < -1e-9:
            return False
    return True


@inline_jit
def steepest_descent(normals, count):
    """Project the direction of gravity (0, 0, -1) onto the motions that the contacts allow.

    Returns the projection, whose length is the sine of the slope, or 0 if the sphere is blocked. Of the feasible
    projections onto the plane of one contact or the line of two, the longest is nearest to gravity.
    """
    if is_allowed(normals, count, 0.0, 0.0, -1.0):
        return 0.0, 0.0, -1.0
    bx = by = bz = 0.0
    longest = 0.0
    for i in range(count):
        if normals[i, 2] <= 0:
            continue
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        vx, vy, vz = nz * nx, nz * ny, nz * nz - 1
        length = -vz
        if length > longest and is_allowed(normals, count, vx, vy, vz):
            bx, by, bz, longest = vx, vy, vz, length
    for i in range(count):
        for j in range(i):
            ax = normals[i, 1] * normals[j, 2] - normals[i, 2] * normals[j, 1]
            ay = normals[i, 2] * normals[j, 0] - normals[i, 0] * normals[j, 2]
            az = normals[i, 0] * normals[j, 1] - normals[i, 1] * normals[j, 0]
            a2 = ax * ax + ay * ay + az * az
            if a2 < 1e-12:
                continue
            vx, vy, vz = -az * ax / a2, -az * ay / a2, -az * az / a2
            length = -vz
            if length > longest and is_allowed(normals, count, vx, vy, vz):
                bx, by, bz, longest = vx, vy, vz, length
    return bx, by, bz
