"""Completion: unseen parts of an object are added by guesses, in steps to choose (paper, §IV-C: cups lack bottoms)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from spherefunc_bullet.clouds.cloud import corners_of
from spherefunc_bullet.errors import require_known
from spherefunc_bullet.places.putting import along_edges
from spherefunc_bullet.processes.compilation import njit

from ..scans.cells import cells
from ..scans.neighbors import NearPoints, advance
from ..scans.spread import least_axis
from ..segmentation.clusters import bounding_box
from ..settings import POOL, RECOGNITION, SCAN, SEGMENTATION

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull


def smoothed(points: np.ndarray) -> np.ndarray:
    """Return thinned points (M, 3), each moved along the normal onto the plane through its neighbours, metres."""
    thinned = cells(points, POOL.spacing)
    places, counts = thinned.means, thinned.counts.astype(float)
    radius = RECOGNITION.smooth_radius
    for _ in range(RECOGNITION.smooth_passes):
        grid = cells(places, radius)
        moved = np.empty_like(places)
        project(np.ascontiguousarray(places[grid.order]), counts[grid.order], grid.keys, grid.start, radius, moved)
        places[grid.order] = moved
    return places


@njit(cache=True, error_model="numpy")
def project(points, counts, keys, start, radius, moved):
    """Move points onto the weighted planes through their neighbours.

    Parameters
    ----------
    points : (N, 3) float64, metres
        Sorted by the cell of a grid as wide as the radius.
    counts : (N,) float64
        The weight of each point.
    keys : (C,) int64
        Of the cells, ascending, as `cells` packs them.
    start : (C + 1,) int64
        The first point of each cell, and the number of all points.
    radius : float
        Metres.
    moved : (N, 3) float64, metres
        Receives the moved points.
    """
    columns = np.zeros((9, 2), np.int64)
    for cell in range(len(keys)):
        advance(columns, keys[cell], keys)
        for i in range(start[cell], start[cell + 1]):
            (x, y, z), spread = moments(points, counts, start, columns, radius, i)
            across, along, up = least_axis(*spread)[0]
            step = x * across + y * along + z * up
            moved[i, 0] = points[i, 0] + step * across
            moved[i, 1] = points[i, 1] + step * along
            moved[i, 2] = points[i, 2] + step * up


@njit(cache=True, error_model="numpy")
def moments(points, counts, start, columns, radius, i):
    """Return the weighted mean of a point's neighbours, relative to it, and their covariance, as for `least_axis`."""
    total, x, y, z = 0.0, 0.0, 0.0, 0.0
    xx, xy, xz, yy, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for column in range(9):
        for j in range(start[columns[column, 0]], start[columns[column, 1]]):
            a, b, c = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
            nearness = 1.0 - (a * a + b * b + c * c) / (radius * radius)
            if nearness > 0:
                weight = counts[j] * nearness * nearness
                total, x, y, z = total + weight, x + weight * a, y + weight * b, z + weight * c
                xx, xy, xz = xx + weight * a * a, xy + weight * a * b, xz + weight * a * c
                yy, yz, zz = yy + weight * b * b, yz + weight * b * c, zz + weight * c * c
    x, y, z = x / total, y / total, z / total
    spread = (xx / total - x * x, xy / total - x * y, xz / total - x * z)
    return (x, y, z), (*spread, yy / total - y * y, yz / total - y * z, zz / total - z * z)


TOP = "top"  # for objects that carry a known pool, see `pools.tops`
STEPS = ("smooth", "top", "bottom", "sides", "mirror")
DEFAULT = ("smooth", "top", "bottom", "mirror")


def steps_of(text: str | None) -> tuple[str, ...]:
    """Return the steps of a comma-separated list; ``none`` is without steps, None the default ones.

    Raises
    ------
    InputError
        If there is no such step.

    Examples
    --------
    >>> steps_of("bottom,mirror"), steps_of("none")
    (('bottom', 'mirror'), ())
    """
    if text is None:
        return DEFAULT
    steps = () if text.strip() in ("", "none") else tuple(part.strip() for part in text.split(","))
    require_known("completion", steps, (*STEPS, "none"))
    return steps


def complete(points: np.ndarray, steps: Sequence[str] = DEFAULT, *, support: float = 0.0) -> np.ndarray:
    """Return an object's points with guesses of those that its scan has not seen.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
        Of one object.
    steps : sequence of {"smooth", "top", "bottom", "sides", "mirror"}
        ``smooth`` removes the sensor's noise from objects small enough to be a vessel, which it would fill; ``bottom``
        closes the foot of an object on the support with a flat sheet, as the paper suggests for cups; ``sides``
        continues upright outlines down to the support; ``mirror`` adds mirror images of a large object about the middle
        planes of its box, if it mostly agrees with them.
    support : float
        The height of the object's support, metres.

    Returns
    -------
    (M, 3) float64, metres
        The points, smoothed or not, followed by those added.
    """
    small = np.ptp(corners_of(points), axis=0).max() <= SEGMENTATION.large
    if "smooth" in steps and small:
        points = smoothed(points)
    if "mirror" in steps and not small:  # mirror images of a vessel, slightly out of place, would fill it
        points = np.vstack([points, mirrored(points)])
    if "sides" in steps:
        points = np.vstack([points, continued_down(points, support)])
    if "bottom" in steps:
        points = np.vstack([points, closed_bottom(points, support)])
    return points


def closed_bottom(points: np.ndarray, support: float) -> np.ndarray:
    """Return a flat sheet (K, 3) at the support below a vessel's outline, and walls down to it.

    Only for small objects that stand on sides and not on legs, and have a rim or a top all around: otherwise a slice of
    something flat would become a vessel. The outline is the whole object's: of a cup seen from one side the lower part
    of the far wall is hidden, but the rim is seen all around. Parts of the sheet beyond a narrower foot lie below the
    walls, out of reach. The lowest centimetre or two of the walls were removed with the floor.
    """
    from scipy.spatial import ConvexHull, QhullError, cKDTree

    low, high = corners_of(points)
    if (high - low).max() > SEGMENTATION.large or bounding_box(points).size[1] < POOL.narrowest:
        return np.empty((0, 3))
    try:
        hull = ConvexHull(points[:, :2])
    except (QhullError, ValueError):
        return np.empty((0, 3))
    slice_height = RECOGNITION.lower_part * (high[2] - low[2])
    outline = along_edges(points[hull.vertices, :2], 0.01)
    for part in (points[points[:, 2] < low[2] + slice_height], points[points[:, 2] > high[2] - slice_height]):
        if np.mean(cKDTree(part[:, :2]).query(outline)[0] < SCAN.cell) < RECOGNITION.closed:
            return np.empty((0, 3))
    return np.vstack([sheet_within(hull, low, high + POOL.spacing, support), continued_down(points, support)])


def sheet_within(hull: ConvexHull, low: np.ndarray, high: np.ndarray, height: float) -> np.ndarray:
    """Return a level sheet (M, 3) within a hull in the plane, from one corner of a grid to another, metres."""
    x, y = (np.arange(low[k], high[k], POOL.spacing) for k in range(2))
    sheet = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    inside = (hull.equations[:, :2] @ sheet.T + hull.equations[:, 2:] <= 0).all(axis=0)
    return np.column_stack([sheet[inside], np.full(inside.sum(), height)])


def continued_down(points: np.ndarray, support: float) -> np.ndarray:
    """Return points (K, 3) from the lowest of each column of an object's outline down to the support."""
    column = np.floor(points[:, :2] / (SCAN.cell / 2)).astype(np.int64)
    order = np.lexsort((points[:, 2], column[:, 1], column[:, 0]))
    first = np.ones(len(order), bool)
    first[1:] = (np.diff(column[order], axis=0) != 0).any(axis=1)
    lowest = points[order[first]]
    edge = lowest[on_outline(column[order[first]])]
    levels = np.arange(support, points[:, 2].max(), POOL.spacing)
    counts = np.searchsorted(levels, edge[:, 2])
    upwards = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.column_stack([np.repeat(edge[:, :2], counts, axis=0), levels[upwards]])


def on_outline(columns: np.ndarray) -> np.ndarray:
    """Return which of an object's columns (C, 2) have a side without a neighbour, (C,) bool."""
    keys = columns[:, 0] << 32 | (columns[:, 1] & 0xFFFFFFFF)
    covered = np.ones(len(columns), bool)
    for step in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        near = columns + step
        covered &= np.isin(near[:, 0] << 32 | (near[:, 1] & 0xFFFFFFFF), keys)
    return ~covered


def mirrored(points: np.ndarray) -> np.ndarray:
    """Return the points (K, 3) that mirror images about the box's upright middle planes add, if they mostly agree."""
    box = bounding_box(points)
    local = box.to_own(points)
    seen, added = NearPoints(local, SCAN.cell / 2), [np.empty((0, 3))]
    for sign in ((-1, 1, 1), (1, -1, 1)):
        apart = ~seen.to(local * sign)
        if apart.mean() <= RECOGNITION.disagrees:
            added.append((local * sign)[apart])
    return np.vstack(added) @ box.axes + box.center
