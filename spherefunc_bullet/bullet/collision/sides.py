"""Flat sides of a surface of triangles.

Sides grow one after the other, beginning at the flattest faces, over faces that share a vertex and lie near one plane,
which is refitted as the side grows.
"""

from __future__ import annotations

import numpy as np

from ...processes.compilation import njit

FREE = -1
STEP = 0.25  # of the tolerance: faces whose bending differs by less are seeds in their own order
ROUNDS = 4  # of fitting a plane to the faces that grew on the previous one
TINY = 1e-12  # twice the area below which a face is degenerate, in units of the vertices


def grow_sides(vertices: np.ndarray, faces: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the number (M,) of the side that each face belongs to, those with most faces first.

    Parameters
    ----------
    vertices : (N, 3) float64
    faces : (M, 3) integers
    tolerance : float, unit of the vertices
        Largest distance of a side's vertices from its plane.
    """
    starts, incident = faces_of_vertices(faces, len(vertices))
    normals = unit_normals(vertices, faces)
    bends = bending(vertices, faces, normals, starts, incident)
    bends[np.isnan(normals[:, 0])] = np.inf
    seeds = np.argsort(np.minimum(bends / (STEP * tolerance), 1e6).astype(np.int64), kind="stable")
    labels = extend_side(vertices, faces, normals, starts, incident, seeds, tolerance)
    sizes = np.bincount(labels)
    rank = np.empty(len(sizes), np.int64)
    rank[np.argsort(-sizes, kind="stable")] = np.arange(len(sizes))
    return rank[labels]


def faces_of_vertices(faces: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the start (N + 1,) of the faces of each vertex in a list (3 M,), and that list."""
    corners = faces.ravel()
    starts = np.zeros(count + 1, np.int64)
    np.cumsum(np.bincount(corners, minlength=count), out=starts[1:])
    return starts, (np.argsort(corners, kind="stable") // 3).astype(np.int32)


def unit_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the normals (M, 3); NaN for degenerate faces, to whose plane nothing is near."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    lengths[lengths < TINY] = np.nan
    return normals / lengths[:, None]


@njit(cache=True, error_model="numpy")
def bending(vertices, faces, normals, starts, incident):
    """Return the largest distance (M,) of the corners of the surrounding faces from the plane of each face."""
    bends = np.zeros(len(faces))
    for f in range(len(faces)):
        a = faces[f, 0]
        for k in range(3):
            v = faces[f, k]
            for i in range(starts[v], starts[v + 1]):
                for m in range(3):
                    w = faces[incident[i], m]
                    d = 0.0
                    for x in range(3):
                        d += normals[f, x] * (vertices[w, x] - vertices[a, x])
                    bends[f] = max(bends[f], abs(d))
    return bends


@njit(cache=True, error_model="numpy")
def extend_side(vertices, faces, normals, starts, incident, seeds, tolerance):
    """Return the number of the side of every face (M,), in the order of the seeds."""
    labels = np.full(len(faces), FREE, np.int32)
    stamps = np.zeros(len(faces), np.int32)
    seen = np.zeros(len(vertices), np.int32)
    members, corners = np.empty(len(faces), np.int32), np.empty(len(vertices), np.int32)
    stamp, sides = 0, 0
    for seed in seeds:
        if labels[seed] >= 0:
            continue
        plane, best, grown = plane_of_face(vertices, faces, normals, seed), np.empty(4), 0
        for _ in range(ROUNDS):
            stamp += 1
            count, reached = grow(
                vertices, faces, starts, incident, labels, seed, plane, tolerance, stamp, stamps, seen, members, corners
            )
            if count <= grown:
                break
            best, grown = plane, count
            plane = fit_plane(vertices, corners[:reached])
        labels[seed] = sides
        if grown > 1:
            labels[seed] = FREE
            stamp += 1
            grow(
                vertices, faces, starts, incident, labels, seed, best, tolerance, stamp, stamps, seen, members, corners
            )
            labels[members[:grown]] = sides
        sides += 1
    return labels


@njit(cache=True, error_model="numpy")
def plane_of_face(vertices, faces, normals, f):
    """Return the plane (4,) of a face: its unit normal and its signed distance from the origin."""
    plane = np.empty(4)
    plane[:3] = normals[f]
    plane[3] = np.sum(normals[f] * vertices[faces[f, 0]])
    return plane


@njit(cache=True, error_model="numpy")
def grow(vertices, faces, starts, incident, labels, seed, plane, tolerance, stamp, stamps, seen, members, corners):
    """Write the free faces near a plane that are connected to a seed, and their corners; return the numbers of both."""
    if not near(vertices, faces, seed, plane, tolerance):
        return 0, 0
    members[0] = seed
    stamps[seed] = stamp
    count, done, reached = 1, 0, 0
    while done < count:
        f = members[done]
        done += 1
        for k in range(3):
            v = faces[f, k]
            if seen[v] == stamp:
                continue
            seen[v] = stamp
            corners[reached] = v
            reached += 1
            for i in range(starts[v], starts[v + 1]):
                g = incident[i]
                if labels[g] != FREE or stamps[g] == stamp:
                    continue
                stamps[g] = stamp
                if near(vertices, faces, g, plane, tolerance):
                    members[count] = g
                    count += 1
    return count, reached


@njit(cache=True, error_model="numpy")
def near(vertices, faces, f, plane, tolerance):
    """Return whether all corners of a face lie within the tolerance of a plane."""
    for k in range(3):
        v = faces[f, k]
        d = vertices[v, 0] * plane[0] + vertices[v, 1] * plane[1] + vertices[v, 2] * plane[2] - plane[3]
        if not abs(d) <= tolerance:
            return False
    return True


@njit(cache=True, error_model="numpy")
def fit_plane(vertices, corners):
    """Return the least-squares plane, moved to the middle between the outermost points."""
    mean = np.zeros(3)
    for v in corners:
        mean += vertices[v]
    mean /= len(corners)
    scatter = np.zeros((3, 3))
    for v in corners:
        x, y, z = vertices[v, 0] - mean[0], vertices[v, 1] - mean[1], vertices[v, 2] - mean[2]
        scatter[0, 0] += x * x
        scatter[0, 1] += x * y
        scatter[0, 2] += x * z
        scatter[1, 1] += y * y
        scatter[1, 2] += y * z
        scatter[2, 2] += z * z
    scatter[1, 0], scatter[2, 0], scatter[2, 1] = scatter[0, 1], scatter[0, 2], scatter[1, 2]
    normal = np.linalg.eigh(scatter)[1][:, 0]
    low, high = np.inf, -np.inf
    for v in corners:
        d = vertices[v, 0] * normal[0] + vertices[v, 1] * normal[1] + vertices[v, 2] * normal[2]
        low, high = min(low, d), max(high, d)
    plane = np.empty(4)
    plane[:3] = normal
    plane[3] = (low + high) / 2
    return plane
