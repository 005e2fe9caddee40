"""Sampling of meshes: at least one point every half centimetre along the faces (paper, §IV-A).

Each plane in space has one triangular lattice, fixed to the origin, so that all triangles of a flat panel share it and
the panel is sampled regularly. The candidates of a triangle are its points nearest to the lattice points within
``cover``. The lattice covers the plane with that radius, and moving a lattice point to the nearest point of a convex
set moves it away from no point of the set: so no location of the triangle is farther than ``cover`` from a candidate.
Thinning drops a candidate only if a kept point is nearer than ``max_gap - cover``; the two add up to ``max_gap``. The
kept point must also be within ``aside`` of the triangle's plane, so that both sides of a thin wall have samples.
"""

from __future__ import annotations

import math

import numpy as np

from ..processes.compilation import lean_njit
from .orientation import corners_of
from .outline import merge_vertices, outline_points
from .thinning import Planes, thin

COVER = 0.46  # of max_gap: a lattice pitch of 4 mm for 5 mm; the rest is for thinning
ASIDE = 0.1  # of max_gap, half a millimetre: a point farther from a sample's plane does not replace the sample
_SLIVER = 0.02  # of cover: flatter triangles are sampled along their longest edge, since their normals are unreliable


@lean_njit(cache=True)
def _normal(triangle):
    """Return the normal of a triangle, whose length is twice the area."""
    x, y, z = triangle[0, 0], triangle[0, 1], triangle[0, 2]
    ax, ay, az = triangle[1, 0] - x, triangle[1, 1] - y, triangle[1, 2] - z
    bx, by, bz = triangle[2, 0] - x, triangle[2, 1] - y, triangle[2, 2] - z
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@lean_njit(cache=True)
def _longest_edge(triangle):
    """Return the first corner of the longest edge, its length, and the triangle's height above it."""
    best, longest = 0, 0.0
    for e in range(3):
        squared = 0.0
        for axis in range(3):
            squared += (triangle[(e + 1) % 3, axis] - triangle[e, axis]) ** 2
        if squared > longest:
            best, longest = e, squared
    x, y, z = _normal(triangle)
    length = math.sqrt(longest)
    return best, length, math.sqrt(x * x + y * y + z * z) / max(length, 1e-300)


@lean_njit(cache=True)
def _write_corners(triangle, corners):
    """Write the corners (3, 2) of a triangle along two axes of its plane.

    The axes depend on the normal of the plane only and, except for their sign, which does not matter for the lattice,
    not on its sign: so neighbours in one plane get the same axes, whatever their winding.
    """
    x, y, z = _normal(triangle)
    length = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    ux, uy, uz = -y, x, 0.0
    if abs(z) > 0.9:
        ux, uy, uz = 1.0 - x * x, -x * y, -x * z
    length = math.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = ux / length, uy / length, uz / length
    vx, vy, vz = y * uz - z * uy, z * ux - x * uz, x * uy - y * ux
    for c in range(3):
        corners[c, 0] = triangle[c, 0] * ux + triangle[c, 1] * uy + triangle[c, 2] * uz
        corners[c, 1] = triangle[c, 0] * vx + triangle[c, 1] * vy + triangle[c, 2] * vz


@lean_njit(cache=True)
def _row_span(corners, low, high):
    """Return the range of u of the part of a triangle between two values of v; inf, -inf if it is empty."""
    left, right = np.inf, -np.inf
    for e in range(3):
        xa, ya = corners[e, 0], corners[e, 1]
        xb, yb = corners[(e + 1) % 3, 0], corners[(e + 1) % 3, 1]
        if ya > yb:
            xa, ya, xb, yb = xb, yb, xa, ya
        if ya > high or yb < low:
            continue
        slope = (xb - xa) / (yb - ya) if yb > ya else 0.0
        x0 = xa + (low - ya) * slope if ya < low else xa
        x1 = xa + (high - ya) * slope if yb > high else xb
        left, right = min(left, x0, x1), max(right, x0, x1)
    return left, right


@lean_njit(cache=True)
def _rows(corners, cover):
    """Return the first and the last row of the lattice within ``cover`` of a triangle."""
    low = min(corners[0, 1], corners[1, 1], corners[2, 1]) - cover
    high = max(corners[0, 1], corners[1, 1], corners[2, 1]) + cover
    rise = 1.5 * cover
    return int(math.ceil(low / rise)), int(math.floor(high / rise))


@lean_njit(cache=True)
def _on_edge(corners, a, b, x, y):
    """Return the parameter of the point of edge ab nearest to (x, y) and its squared distance."""
    dx, dy = corners[b, 0] - corners[a, 0], corners[b, 1] - corners[a, 1]
    px, py = x - corners[a, 0], y - corners[a, 1]
    t = min(max((px * dx + py * dy) / (dx * dx + dy * dy), 0.0), 1.0)
    return t, (px - t * dx) ** 2 + (py - t * dy) ** 2


@lean_njit(cache=True)
def _nearest_on_border(corners, x, y):
    """Return the point of a triangle's border nearest to (x, y), as weights of the edges 01 and 02."""
    t, squared = _on_edge(corners, 0, 1, x, y)
    s, r = t, 0.0
    t, other = _on_edge(corners, 0, 2, x, y)
    if other < squared:
        s, r, squared = 0.0, t, other
    t, other = _on_edge(corners, 1, 2, x, y)
    if other < squared:
        s, r, squared = 1.0 - t, t, other
    return s, r, squared


@lean_njit(cache=True)
def _place(out, row, triangle, s, r):
    """Write the point with weights s and r of two edges; the result is exact on planes parallel to the axes."""
    for axis in range(3):
        origin = triangle[0, axis]
        out[row, axis] = origin + s * (triangle[1, axis] - origin) + r * (triangle[2, axis] - origin)


@lean_njit(cache=True)
def _sliver_points(triangle, first, length, cover, out, row):
    """Write points along the longest edge of a sliver, backwards from ``row``; return the row before them."""
    count = max(1, int(math.ceil(length / (1.9 * cover))))
    for step in range(count):
        t = (step + 0.5) / count
        for axis in range(3):
            start = triangle[first, axis]
            out[row, axis] = start + t * (triangle[(first + 1) % 3, axis] - start)
        row -= 1
    return row


@lean_njit(cache=True)
def _bound(triangles, cover, corners):
    """Return an upper bound of the number of candidates; ``corners`` (3, 2) is scratch."""
    pitch, rise = math.sqrt(3.0) * cover, 1.5 * cover
    total = 0
    for t in range(len(triangles)):
        triangle = triangles[t]
        _, length, height = _longest_edge(triangle)
        if height <= _SLIVER * cover:
            total += max(1, int(math.ceil(length / (1.9 * cover))))
            continue
        _write_corners(triangle, corners)
        first_row, last_row = _rows(corners, cover)
        for j in range(first_row, last_row + 1):
            left, right = _row_span(corners, j * rise - cover, j * rise + cover)
            if left <= right:  # rounding may leave nothing of the first or the last row
                total += int((right - left + 2.0 * cover) / pitch) + 2
    return total


@lean_njit(cache=True)
def _lattice_points(triangle, cover, corners, out, front, back):
    """Write the candidates of a triangle: those inside it from the front, those moved onto it from the back."""
    pitch, rise = math.sqrt(3.0) * cover, 1.5 * cover
    _write_corners(triangle, corners)
    ax, ay = corners[1, 0] - corners[0, 0], corners[1, 1] - corners[0, 1]
    bx, by = corners[2, 0] - corners[0, 0], corners[2, 1] - corners[0, 1]
    inverse = 1.0 / (ax * by - ay * bx)
    first_row, last_row = _rows(corners, cover)
    for j in range(first_row, last_row + 1):
        y = j * rise
        shift = 0.5 * (j & 1)
        left, right = _row_span(corners, y - cover, y + cover)
        if left > right:
            continue
        first, last = (left - cover) / pitch - shift, (right + cover) / pitch - shift
        for i in range(int(math.ceil(first)), int(math.floor(last)) + 1):
            x = (i + shift) * pitch
            px, py = x - corners[0, 0], y - corners[0, 1]
            s, r = (px * by - py * bx) * inverse, (ax * py - ay * px) * inverse
            if s >= 0.0 and r >= 0.0 and s + r <= 1.0:
                _place(out, front, triangle, s, r)
                front += 1
                continue
            s, r, squared = _nearest_on_border(corners, x, y)
            if squared <= cover * cover * (1.0 + 1e-9):  # the distance may be exactly ``cover``
                _place(out, back, triangle, s, r)
                back -= 1
    return front, back


@lean_njit(cache=True)
def _candidates(triangles, cover, corners, out, front, normals, ends):
    """Fill ``out`` from ``front`` and from its end; return the first free row and the last free row.

    The normal of each triangle (M), 0 for a sliver, and the ends of its points are written into ``normals``
    (2 M + 1, 3) and ``ends`` (2 M + 1,): first the entry of the first points, then those of all points from the front,
    then those of all points from the back. ``corners`` (3, 2) is scratch.
    """
    count, back = len(triangles), len(out) - 1
    for t in range(len(triangles)):
        triangle = triangles[t]
        first, length, height = _longest_edge(triangle)
        if height <= _SLIVER * cover:
            back = _sliver_points(triangle, first, length, cover, out, back)
        else:
            front, back = _lattice_points(triangle, cover, corners, out, front, back)
            x, y, z = _normal(triangle)
            area = math.sqrt(x * x + y * y + z * z)
            for row in (1 + t, 1 + count + t):  # element by element: kernels with array expressions load slowly
                normals[row, 0], normals[row, 1], normals[row, 2] = x / area, y / area, z / area
        ends[1 + t], ends[1 + count + t] = front, len(out) - 1 - back
    for row in range(1 + count, len(ends)):
        ends[row] += front
    return front, back


def surface_candidates(
    triangles: np.ndarray, cover: float, first: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return points on triangles such that no location of the triangles is farther than ``cover`` from one.

    Parameters
    ----------
    triangles : (M, 3, 3) float64, metres
    cover : float, metres
    first : (F, 3) float64, metres
        Points that precede them.

    Returns
    -------
    inside, border : (F + I, 3) and (B, 3) float64, metres
        The first points, followed by the lattice points inside triangles; and those moved onto the borders, in reverse
        order.
    normals, ends : (2 M + 1, 3) float64 and (2 M + 1,) int64
        See `Planes`; the first points lie in none.
    """
    corners = np.empty((3, 2))
    out = np.empty((len(first) + _bound(triangles, cover, corners), 3))
    out[: len(first)] = first
    normals, ends = np.zeros((2 * len(triangles) + 1, 3)), np.full(2 * len(triangles) + 1, len(first))
    front, back = _candidates(triangles, cover, corners, out, len(first), normals, ends)
    return out[:front], out[back + 1 :], normals, ends


def surface_area(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Return the area of a mesh, square metres."""
    edges = vertices[faces[:, 1:]] - vertices[faces[:, :1]]
    return float(np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum() / 2)


def needed_samples(vertices: np.ndarray, faces: np.ndarray, max_gap: float) -> float:
    """Return the approximate number of samples of a surface, from its area and the borders of its larger faces."""
    cover = COVER * max_gap
    edges = np.roll(vertices[faces], -1, axis=1) - vertices[faces]
    lengths = np.linalg.norm(edges, axis=2)
    perimeters = np.where(lengths.max(axis=1) > max_gap, lengths.sum(axis=1), 0.0).sum()
    return (surface_area(vertices, faces) + cover * perimeters) / (1.5 * math.sqrt(3.0) * cover**2)


def sample_surface(vertices: np.ndarray, faces: np.ndarray, max_gap: float = 0.005) -> np.ndarray:
    """Return points on a mesh such that no location of its surface is farther than ``max_gap`` from one.

    The same mesh gives the same points. Flat panels get a triangular lattice of pitch ``0.8 max_gap``; no two points of
    one plane are nearer than ``0.54 max_gap``, however fine the mesh, and the nearest sample of a face is no farther
    than a tenth of ``max_gap`` from its plane. Corners and sharp edges come first, so that the outline is preserved.

    Parameters
    ----------
    vertices : (N, 3) float64, metres
    faces : (M, 3) int64
    max_gap : float, metres
        The paper's half centimetre.

    Returns
    -------
    (K, 3) float64, metres
    """
    cover = COVER * max_gap
    vertices, faces = merge_vertices(np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int64))
    outline = outline_points(vertices, faces, math.sqrt(3.0) * cover)
    inside, border, normals, ends = surface_candidates(vertices[faces], cover, outline)
    planes = Planes(normals, ends, ASIDE * max_gap)
    return thin(inside, max_gap - cover, border, planes, corners_of(vertices))
