"""Cuts of a flat set of faces until no part's convex hull bridges a hole or a notch."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import label

from ...clouds.outline import chain, cross
from ...processes.compilation import njit

CELLS = 4  # of the grid on which hulls are checked, per reach
MAX_CELLS = 4_000_000  # with more, the grid is coarser
MAX_JUDGED = 20_000  # bare cells by which cuts are compared
NONE = np.empty((0, 2))
DIRECTIONS = 8  # of cuts, starting along the longest edge of the hull


def parts_without_bridges(flat: np.ndarray, faces: np.ndarray, around: np.ndarray, reach: float) -> list[np.ndarray]:
    """Return the corners, as indices, of each part of the faces.

    Parameters
    ----------
    flat : (N, 2) float64
        Corners of the faces in their plane.
    faces : (M, 3) integers
    around : (A, 2) float64
        Further points that hulls may cover.
    reach : float, unit of the corners
        No cell of a grid inside a hull is farther than this from all points.
    """
    parts, waiting = [], [faces]
    order = np.lexsort((flat[:, 1], flat[:, 0]))
    while waiting:
        part = waiting.pop()
        used = corners_of_faces(order, part, np.ones(len(part), bool), True)
        points, hull = flat[used], flat[chain(flat, used)]
        bare = bare_cells(np.concatenate([points, around]), hull, reach) if len(part) > 1 else NONE
        if len(bare) == 0:
            parts.append(used)
            continue
        side = best_cut(flat, part, order, hull, largest_patch(bare, reach), bare, reach)
        waiting += [part[side], part[~side]]
    return parts


def hull_of(points: np.ndarray, slack: float) -> np.ndarray:
    """Return the indices of the corners of the convex hull, counterclockwise (Andrew's monotone chain).

    Corners that stand out by no more than the slack are dropped.
    """
    hull = chain(points, np.lexsort((points[:, 1], points[:, 0])))
    return hull if slack == 0 else prominent_corners(points, hull, slack)


@njit(cache=True, error_model="numpy")
def prominent_corners(points, hull, slack):
    """Return the corners of a hull without those near the line from the last kept corner to the next one."""
    corners = np.empty(len(hull), np.int64)
    corners[0] = hull[0]
    count, last = 1, 0
    for h in range(1, len(hull)):
        # All corners dropped since the last kept one must be near the new line, too.
        end = hull[(h + 1) % len(hull)]
        length = math.hypot(
            points[end, 0] - points[corners[count - 1], 0], points[end, 1] - points[corners[count - 1], 1]
        )
        for m in range(last + 1, h + 1):
            if abs(cross(points, corners[count - 1], end, hull[m])) > slack * length:
                corners[count] = hull[h]
                count, last = count + 1, h
                break
    return corners[:count]


def bare_cells(points: np.ndarray, hull: np.ndarray, reach: float) -> np.ndarray:
    """Return the centres (B, 2) of the cells inside a hull that have no point within reach."""
    low, size = hull.min(axis=0), np.ptp(hull, axis=0)
    if np.hypot(*size) <= reach:
        return NONE
    side = max(reach / CELLS, np.sqrt(size.prod() / MAX_CELLS))
    return bare_centers(points, hull, low, np.ceil(size / side).astype(np.int64) + 1, side, reach)


@njit(cache=True, error_model="numpy")
def bare_centers(points, hull, low, dims, side, reach):
    """Return the nodes (B, 2) of a grid inside a hull that have no point within reach."""
    covered = np.zeros((dims[0], dims[1]), np.bool_)
    for p in points:
        x, y = (p[0] - low[0]) / side, (p[1] - low[1]) / side
        r = reach / side
        for i in range(max(0, int(np.ceil(x - r))), min(dims[0] - 1, int(x + r)) + 1):
            h = np.sqrt(max(0.0, r * r - (i - x) ** 2))
            for j in range(max(0, int(np.ceil(y - h))), min(dims[1] - 1, int(y + h)) + 1):
                covered[i, j] = True
    count = 0
    bare = np.empty((dims[0] * dims[1], 2))
    for i in range(dims[0]):
        x = low[0] + i * side
        bottom, top = vertical_span(hull, x)
        for j in range(dims[1]):
            y = low[1] + j * side
            if bottom < y < top and not covered[i, j]:
                bare[count, 0], bare[count, 1] = x, y
                count += 1
    return bare[:count]


@njit(cache=True, error_model="numpy")
def vertical_span(hull, x):
    """Return the lower and upper y at which a vertical line crosses a convex polygon."""
    bottom, top = np.inf, -np.inf
    for a in range(len(hull)):
        b = (a + 1) % len(hull)
        if (hull[a, 0] - x) * (hull[b, 0] - x) <= 0 and hull[a, 0] != hull[b, 0]:
            y = hull[a, 1] + (x - hull[a, 0]) / (hull[b, 0] - hull[a, 0]) * (hull[b, 1] - hull[a, 1])
            bottom, top = min(bottom, y), max(top, y)
    return bottom, top


def largest_patch(bare: np.ndarray, reach: float) -> np.ndarray:
    """Return the cells of the largest connected patch."""
    side = max(reach / CELLS, 1e-12)
    cells = np.rint((bare - bare.min(axis=0)) / side).astype(np.int64)
    if cells.max(axis=0).prod() > MAX_CELLS:
        return bare
    grid = np.zeros(cells.max(axis=0) + 1, bool)
    grid[cells[:, 0], cells[:, 1]] = True
    patches = label(grid)[0][cells[:, 0], cells[:, 1]]
    return bare[patches == np.argmax(np.bincount(patches))]


def best_cut(
    flat: np.ndarray,
    faces: np.ndarray,
    order: np.ndarray,
    hull: np.ndarray,
    patch: np.ndarray,
    bare: np.ndarray,
    reach: float,
) -> np.ndarray:
    """Return the mask of the faces on one side of the cut that leaves the fewest bare cells inside the two hulls."""
    middles = flat[faces].mean(axis=1)
    bare = bare[:: len(bare) // MAX_JUDGED + 1]
    edges = np.roll(hull, -1, axis=0) - hull
    first = np.arctan2(*edges[np.argmax((edges**2).sum(axis=1))][::-1])
    best, chosen = np.inf, None
    for turn in range(DIRECTIONS):
        angle = first + np.pi / DIRECTIONS * turn
        along = np.array([np.cos(angle), np.sin(angle)])
        at, patch_at = middles @ along, patch @ along
        for offset in (patch_at.min() - reach, patch_at.max() + reach, (patch_at.min() + patch_at.max()) / 2):
            side = at < offset
            if not side.any() or side.all():
                continue
            halves = (flat[chain(flat, corners_of_faces(order, faces, side, half))] for half in (True, False))
            left = sum(count_inside(bare, half) for half in halves)
            if left < best:
                best, chosen = left, side
    return chosen if chosen is not None else in_halves(middles)


@njit(cache=True, error_model="numpy")
def corners_of_faces(order, faces, side, wanted):
    """Return the corners of the faces whose side is ``wanted``, in the given order."""
    corner = np.zeros(len(order), np.bool_)
    for f in range(len(faces)):
        if side[f] == wanted:
            for k in range(3):
                corner[faces[f, k]] = True
    return order[corner[order]]


@njit(cache=True, error_model="numpy")
def count_inside(bare, hull):
    """Return the number of cells inside a hull."""
    count = 0
    for p in bare:
        within = True
        for a in range(len(hull)):
            b = (a + 1) % len(hull)
            ux, uy = hull[b, 0] - hull[a, 0], hull[b, 1] - hull[a, 1]
            if ux * (p[1] - hull[a, 1]) - uy * (p[0] - hull[a, 0]) < 0:
                within = False
                break
        count += within
    return count


def in_halves(middles: np.ndarray) -> np.ndarray:
    """Return the mask of the first half of some points along the longer side of their bounding box."""
    order = np.argsort(middles[:, np.argmax(np.ptp(middles, axis=0))], kind="stable")
    side = np.zeros(len(middles), bool)
    side[order[: len(middles) // 2]] = True
    return side
