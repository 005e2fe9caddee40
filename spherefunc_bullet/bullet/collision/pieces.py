"""Decomposition of a surface of triangles into few convex pieces: flat sides, and the bends between them.

Connected faces within a tolerance of one plane form a side. The faces that remain at an edge connect two sides: all
such faces of the same two sides form one bend, whose hull is a thin wedge along the edge. The faces that remain on
curved parts are grouped in the same way with a larger tolerance, and in the last round any few faces form a side.
Sides and bends are cut where their convex hulls would bridge a hole or a notch.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .cuts import hull_of, parts_without_bridges
from .sides import grow_sides

# For each round, the factor of the tolerance and the smallest number of faces of a side: the few faces of a chamfer
# must not form one, or edges would fall to pieces.
ROUNDS = ((1, 30), (3, 15), (8, 1))
SLIVER = 0.25  # of the tolerance: corners of hulls that stand out less are dropped


def convex_pieces(vertices: np.ndarray, faces: np.ndarray, tolerance: float, reach: float) -> list[np.ndarray]:
    """Return the corners (K, 3) of convex pieces that cover all faces.

    Parameters
    ----------
    vertices : (N, 3) float64, any unit
        Sorted, so that the order of a cloud's points has no influence.
    faces : (M, 3) integers
        They need not form a manifold, and may overlap.
    tolerance : float, unit of the vertices
        Largest distance of the vertices of a flat piece from its plane; three or eight times that on curved parts.
    reach : float, unit of the vertices
        No location in the hull of a piece is farther than this, plus one cell of a grid, from all vertices around it.
    """
    faces = np.ascontiguousarray(faces, dtype=np.int32)
    pieces = []
    for members, support in groups(vertices, faces, tolerance):
        pieces += group_pieces(vertices, faces[members], support, tolerance, reach)
    return pieces


def groups(vertices: np.ndarray, faces: np.ndarray, tolerance: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield the face indices of each side or bend, and the vertices where adjacent pieces continue it seamlessly.

    Every face is in one set.
    """
    free, count = np.arange(len(faces)), 0
    owners = np.empty((0, 2), np.int64)  # pairs of a vertex and a side that contains it, without duplicates
    for times, least in ROUNDS:
        if len(free) == 0:
            return
        side_of = grow_sides(vertices, faces[free], times * tolerance)
        large = int((np.bincount(side_of) >= least).sum())
        big = side_of < large
        for members in split_by(free[big], side_of[big]):
            yield members, members[:0]
        new = np.column_stack([faces[free[big]].ravel(), np.repeat(side_of[big] + count, 3)])
        owners = np.concatenate([owners, unique_rows(new)])
        count += large
        bends, free = bends_between(faces, free[~big], owners, count, len(vertices))
        yield from bends


def bends_between(
    faces: np.ndarray, free: np.ndarray, owners: np.ndarray, count: int, vertices: int
) -> tuple[list[tuple[np.ndarray, np.ndarray]], np.ndarray]:
    """Return the sets of faces between the same two sides, with the vertices that these share, and the other faces."""
    first, second = first_sides(owners, count, vertices)
    sides = np.sort(first[faces[free]], axis=1)
    between = sides[:, 2] < count
    sides, bent = sides[between], free[between]
    # Faces in a corner of three sides go to the larger two.
    names = sides[:, 0] * count + np.where(sides[:, 1] == sides[:, 0], sides[:, 2], sides[:, 1])
    shared = np.flatnonzero(second < count)
    shared_names = first[shared] * count + second[shared]
    order = np.argsort(shared_names, kind="stable")
    shared, shared_names = shared[order], shared_names[order]
    bends = []
    for which in split_by(np.arange(len(bent)), names):
        low, high = np.searchsorted(shared_names, (names[which[0]], names[which[0]] + 1))
        bends.append((bent[which], shared[low:high]))
    return bends, free[~between]


def first_sides(owners: np.ndarray, count: int, vertices: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the two lowest numbers of the sides that contain each vertex; ``count`` if there are fewer."""
    first, second = np.full(vertices, count), np.full(vertices, count)
    np.minimum.at(first, owners[:, 0], owners[:, 1])
    others = owners[owners[:, 1] != first[owners[:, 0]]]
    np.minimum.at(second, others[:, 0], others[:, 1])
    return first, second


def unique_rows(pairs: np.ndarray) -> np.ndarray:
    """Return pairs of numbers without duplicates."""
    width = pairs[:, 1].max(initial=0) + 1
    keys = np.unique(pairs[:, 0] * width + pairs[:, 1])
    return np.column_stack([keys // width, keys % width])


def split_by(items: np.ndarray, names: np.ndarray) -> list[np.ndarray]:
    """Return the items grouped by name, in the order of the names."""
    if len(items) == 0:
        return []
    order = np.argsort(names, kind="stable")
    return np.split(items[order], np.flatnonzero(np.diff(names[order])) + 1)


def group_pieces(
    vertices: np.ndarray, faces: np.ndarray, support: np.ndarray, tolerance: float, reach: float
) -> list[np.ndarray]:
    """Return the convex pieces (K, 3) of one set of faces."""
    used, local = np.unique(faces, return_inverse=True)
    local = local.reshape(-1, 3)
    points = vertices[used]
    if len(points) == 3:
        return [points]
    mean = points.mean(axis=0)
    axes = np.linalg.eigh((points - mean).T @ (points - mean))[1][:, ::-1]
    placed, around = (points - mean) @ axes, (vertices[support] - mean) @ axes
    parts = parts_without_bridges(placed[:, :2].copy(), local, around[:, :2], reach)
    return [points[part][corners(placed[part], tolerance)] for part in parts]


def corners(placed: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the indices of the points (N, 3), given along their principal axes, that represent their hull."""
    if len(placed) <= 4:
        return np.arange(len(placed))
    slack = SLIVER * tolerance
    outline = hull_of(placed[:, :2].copy(), slack)
    if len(outline) < 3:
        return np.unique(np.append(outline, range(3)))
    if np.ptp(placed[:, 2]) <= 2 * tolerance:
        return outline
    return np.unique(np.concatenate([outline, *(hull_of(placed[:, axes], slack) for axes in ([0, 2], [1, 2]))]))
