"""The surface between the points of a cloud, as alpha shapes define it.

Three points form a face if a ball of radius ``alpha`` can touch them without containing any other point (an exposed
face of the alpha shape; Edelsbrunner and Mücke, "Three-dimensional alpha shapes", 1994). On a plane these are the
Delaunay triangles, so planes are exact at any tilt; inside a thin wall, where no ball fits, there are none. Wider gaps
are spanned if a ball of radius ``gap`` can touch the three points and the smallest ball through them contains no other
point (a Gabriel face), which closes holes and leaves corners open.
"""

from __future__ import annotations

import math

import numpy as np

from ...processes.compilation import njit

MAX_NEIGHBORS = 256  # largest number of neighbours of a point, the nearest within twice the gap
ROOM = 4 * MAX_NEIGHBORS  # for neighbours before the nearest of them are kept
RINGS = 64  # of equal area around a point, for sorting its neighbours
SLACK = 0.995  # of the radius of the ball, so that four points on one circle form four faces, not none


def faces_between(points: np.ndarray, alpha: float, gap: float) -> np.ndarray:
    """Return the faces (M, 3) int32 between points.

    Parameters
    ----------
    points : (N, 3) float64
        Sorted, so that the order of a cloud's points has no influence.
    alpha : float, unit of the points
        Radius of the ball that defines the alpha shape.
    gap : float, at least alpha
        Radius of the largest empty ball on the surface that does not count as a hole.
    """
    order, starts, keys, dims, low = point_cells(points, 2 * gap)
    placed = points[order]
    capacity = 4 * len(points) + 64
    while True:
        faces = np.empty((capacity, 3), np.int32)
        count = span_faces(placed, keys, starts, dims, low, alpha, gap, faces)
        if count <= capacity:
            return order[faces[:count]].astype(np.int32)
        capacity = count


def point_cells(points: np.ndarray, side: float):
    """Sort points into cubic cells, keeping their order within a cell.

    Returns
    -------
    order : (N,) intp
        Indices of the points, cell by cell.
    starts : (C + 1,) int64
        Start of each occupied cell in ``order``.
    keys : (C,) int64
        Numbers of the occupied cells, ascending; neighbours along z have consecutive numbers.
    dims : (3,) int64
        Size of the grid, with an empty margin of one cell.
    low : (3,) float64
        Lower corner of the grid.
    """
    low = points.min(axis=0) - side
    cells = np.floor((points - low) / side).astype(np.int64)
    dims = cells.max(axis=0) + 2
    key = (cells[:, 0] * dims[1] + cells[:, 1]) * dims[2] + cells[:, 2]
    order = np.argsort(key, kind="stable")
    keys, starts = np.unique(key[order], return_index=True)
    return order, np.append(starts, len(points)), keys, dims, low


@njit(cache=True, error_model="numpy")
def span_faces(points, keys, starts, dims, low, alpha, gap, faces):
    """Write the faces between sorted points into ``faces`` and return their number, even if it exceeds the room."""
    found, distances, near, squared = np.empty(ROOM, np.int64), np.empty(ROOM), np.empty(ROOM, np.int64), np.empty(ROOM)
    rings, offset, seen = np.empty(RINGS + 1, np.int64), np.empty((MAX_NEIGHBORS, 3)), np.empty(MAX_NEIGHBORS, np.int64)
    count = 0
    for i in range(len(points)):
        gathered = gather(points, i, keys, starts, dims, low, 2 * gap, found, distances, rings, near, squared)
        for k in range(gathered):
            for axis in range(3):
                offset[k, axis] = points[near[k], axis] - points[i, axis]
        candidates = in_sight(offset, squared, gathered, gap, seen)
        for m in range(candidates):
            a = seen[m]
            if near[a] < i:
                continue
            for n in range(m):
                b = seen[n]
                if near[b] > i and is_face(offset, squared, gathered, a, b, alpha, gap):
                    if count < len(faces):
                        faces[count, 0], faces[count, 1], faces[count, 2] = i, near[a], near[b]
                    count += 1
    return count


@njit(cache=True, error_model="numpy")
def gather(points, i, keys, starts, dims, low, reach, found, distances, rings, near, squared):
    """Write the neighbours of a point within reach into ``near``, nearest first, and return their number."""
    x, y, z = points[i, 0], points[i, 1], points[i, 2]
    ix, iy, iz = int((x - low[0]) / reach), int((y - low[1]) / reach), int((z - low[2]) / reach)
    count = 0
    for jx in range(ix - 1, ix + 2):
        for jy in range(iy - 1, iy + 2):
            first = (jx * dims[1] + jy) * dims[2] + iz - 1
            c = np.searchsorted(keys, first)
            while c < len(keys) and keys[c] <= first + 2:
                for j in range(starts[c], starts[c + 1]):
                    dx, dy, dz = points[j, 0] - x, points[j, 1] - y, points[j, 2] - z
                    d = dx * dx + dy * dy + dz * dz
                    if d > reach * reach or d == 0.0:
                        continue
                    if count == ROOM:
                        count = sort_by_distance(found, distances, count, reach, rings, near, squared)
                        found[:count], distances[:count] = near[:count], squared[:count]
                    found[count], distances[count] = j, d
                    count += 1
                c += 1
    return sort_by_distance(found, distances, count, reach, rings, near, squared)


@njit(cache=True, error_model="numpy")
def sort_by_distance(found, distances, count, reach, rings, near, squared):
    """Write the nearest of the found points into ``near`` and ``squared``, nearest first; return their number.

    Points at the same distance keep their order. Each is put into its ring, and sorted there by insertion.
    """
    per_ring = RINGS / (reach * reach)
    rings[:] = 0
    for k in range(count):
        rings[min(int(distances[k] * per_ring), RINGS - 1) + 1] += 1
    for ring in range(RINGS):
        rings[ring + 1] += rings[ring]
    for k in range(count):
        d = distances[k]
        ring = min(int(d * per_ring), RINGS - 1)
        place = rings[ring]
        rings[ring] += 1
        near[place], squared[place] = found[k], d
    for k in range(1, count):
        j, d, place = near[k], squared[k], k
        while place > 0 and squared[place - 1] > d:
            near[place], squared[place] = near[place - 1], squared[place - 1]
            place -= 1
        near[place], squared[place] = j, d
    return min(count, MAX_NEIGHBORS)


@njit(cache=True, error_model="numpy")
def in_sight(offset, squared, gathered, gap, seen):
    """Write the neighbours that can share a face with the origin, and return their number.

    Neighbours hidden behind another one cannot: that one lies in the lens common to all balls, of radii up to the gap,
    through the two points, and sees them under an angle close to 180 degrees.
    """
    count = 0
    for a in range(gathered):
        ratio = squared[a] / (4 * (1.02 * gap) ** 2)  # for a lens that is slightly too thin
        cosine = 1 - ratio
        hidden = False
        for k in range(a):
            wx, wy, wz = offset[a, 0] - offset[k, 0], offset[a, 1] - offset[k, 1], offset[a, 2] - offset[k, 2]
            dot = offset[k, 0] * wx + offset[k, 1] * wy + offset[k, 2] * wz
            if dot > 0 and dot * dot > cosine * squared[k] * (wx * wx + wy * wy + wz * wz):
                hidden = True
                break
        if not hidden:
            seen[count] = a
            count += 1
    return count


@njit(cache=True, error_model="numpy")
def is_face(offset, squared, gathered, a, b, alpha, gap):
    """Return whether the origin and two neighbours form a face."""
    ux, uy, uz = offset[a, 0], offset[a, 1], offset[a, 2]
    vx, vy, vz = offset[b, 0], offset[b, 1], offset[b, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    nn = nx * nx + ny * ny + nz * nz
    uu, vv = squared[a], squared[b]
    if nn <= 1e-6 * uu * vv:
        return False
    # Centre of the smallest ball through the three points, relative to the origin.
    f, g = 0.5 * vv / nn, 0.5 * uu / nn
    cx = f * (ny * uz - nz * uy) + g * (vy * nz - vz * ny)
    cy = f * (nz * ux - nx * uz) + g * (vz * nx - vx * nz)
    cz = f * (nx * uy - ny * ux) + g * (vx * ny - vy * nx)
    rr = cx * cx + cy * cy + cz * cz
    if rr > gap * gap:
        return False
    ball = alpha
    if rr > alpha * alpha:
        if not is_empty(offset, squared, gathered, a, b, cx, cy, cz, rr):
            return False
        ball = gap
    h = math.sqrt((ball * ball - rr) / nn)
    hx, hy, hz = h * nx, h * ny, h * nz
    return is_empty(offset, squared, gathered, a, b, cx + hx, cy + hy, cz + hz, ball * ball) or is_empty(
        offset, squared, gathered, a, b, cx - hx, cy - hy, cz - hz, ball * ball
    )


@njit(cache=True, error_model="numpy")
def is_empty(offset, squared, gathered, a, b, cx, cy, cz, rr):
    """Return whether a ball through the origin and neighbours a and b contains no other neighbour."""
    limit = SLACK * SLACK * rr
    for k in range(gathered):
        if squared[k] > 4 * rr:
            return True
        if k == a or k == b:
            continue
        dx, dy, dz = offset[k, 0] - cx, offset[k, 1] - cy, offset[k, 2] - cz
        if dx * dx + dy * dy + dz * dz < limit:
            return False
    return True
