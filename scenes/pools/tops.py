"""Tops: parts of a scene cut out around pools, objects on these surfaces or on a table top as ground, and levelling.

A real flat surface is level, even, and continues below the objects that hide it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from spherefunc_bullet.clouds.cloud import corners_of

from ..scans.cells import Cells, cells
from ..segmentation.clusters import euclidean_clusters, members_of
from ..settings import POOL, SCAN, SEGMENTATION
from .ground_squares import GroundSquares
from .surfaces import Pool, upper_face


def cut_out(points: np.ndarray, pool: Pool, gap: float) -> np.ndarray:
    """Return which points may be a pool's object, (N,) bool: also those that rise from its edge, unless it is a table.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
        Of the scene without ground and walls.
    pool : Pool
    gap : float
        Largest distance of a back's lower edge above the surface, metres.
    """
    ground = pool.footprint
    bare = ground.grown(2 * SCAN.cell).holds(points) & (points[:, 2] < pool.height + POOL.slab)
    if pool.is_table:
        return bare
    free = ~bare & (points[:, 2] >= pool.height + POOL.slab) & (points[:, 2] < POOL.highest)
    rising, middle = np.flatnonzero(ground.grown(POOL.back_reach).holds(points) & free), ground.shrunk(POOL.back_reach)
    for members in members_of(euclidean_clusters(points[rising], POOL.slab)):
        if is_back(points[rising[members]], pool, middle, gap):
            bare[rising[members]] = True
    return bare


def is_back(part: np.ndarray, pool: Pool, middle: GroundSquares, gap: float) -> bool:
    """Return whether a part (P, 3) that rises around a pool is a back or an arm, not an object that stands on it."""
    if part[:, 2].min() > pool.height + gap or middle.holds(part).mean() >= 0.5:
        return False
    least = (POOL.back_area * pool.area + 0.02) / SCAN.cell**2  # squares of an object that stands on it
    return len(part) < least or len(cells(part * [1, 1, 0], SCAN.cell).keys) < least


@dataclass(frozen=True, kw_only=True, eq=False)
class Top:
    """A nearly level surface, and the points of objects on it."""

    plane: np.ndarray  # (3,) of its height a x + b y + c, metres
    points: np.ndarray  # (N, 3) float64, metres, level frame, of objects on it
    indices: np.ndarray  # (N,) int64, of these points in the scene
    is_table: bool = True  # whether objects on it are not parts of its own object

    def height_at(self, points: np.ndarray) -> np.ndarray:
        """Return the plane's heights (N,) below points (N, 3), metres."""
        return points[:, :2] @ self.plane[:2] + self.plane[2]


def top_of_pool(points: np.ndarray, pool: Pool, voxels: Cells) -> Top:
    """Return a pool's surface as a plane, since few tables are level to the centimetre, with the points on it.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    pool : Pool
    voxels : Cells
        Of these points.
    """
    ground = pool.footprint.grown(POOL.slab)
    near = rows_along_x(voxels, *ground.range_x)
    near = np.sort(near[ground.holds(points[near])])
    part = points[near]
    on_top = np.abs(part[:, 2] - pool.height) < POOL.slab
    top = top_at(part, near, fitted_height(part[on_top], pool.height))
    return replace(top, is_table=pool.is_table)


def rows_along_x(voxels: Cells, low: float, high: float) -> np.ndarray:
    """Return the rows (K,) int64, in any order, of the points in voxels that reach between two values of x, metres."""
    x = voxels.indices[:, 0]  # ascends
    first, last = np.searchsorted(x, [np.floor(low / voxels.side), np.floor(high / voxels.side) + 1])
    return voxels.order[voxels.start[first] : voxels.start[last]]


def ground_top(points: np.ndarray) -> Top:
    """Return the ground z = 0, if that is a table's top, with the points on it."""
    return top_at(points, np.arange(len(points)), np.zeros(3))


def top_at(points: np.ndarray, indices: np.ndarray, plane: np.ndarray) -> Top:
    """Return the top of a plane (3,) with those of some points (N, 3) that stand on it; `indices` (N,) are theirs."""
    near = Top(plane=plane, points=points, indices=indices)
    above = points[:, 2] - near.height_at(points)
    over = (above > SCAN.cell / 2) & (above < SEGMENTATION.large)
    return replace(near, points=points[over], indices=indices[over])


def fitted_height(points: np.ndarray, height: float) -> np.ndarray:
    """Return the plane (3,) through the upper face of a nearly level surface (N, 3), without points far from it."""
    points = points[upper_face(points)]
    plane = np.array([0.0, 0.0, height])
    for reach in POOL.top_fits:
        inside = np.abs(points[:, 2] - points[:, :2] @ plane[:2] - plane[2]) < reach
        if inside.sum() < POOL.min_points:
            return plane
        rows = np.column_stack([points[inside, :2], np.ones(inside.sum())])
        plane = np.linalg.lstsq(rows, points[inside, 2], rcond=None)[0]
    return plane


def objects_on(top: Top) -> list[np.ndarray]:
    """Return the members of each object that stands on a top, as indices of the scene's points."""
    if not len(top.points):
        return []
    fine = cells(top.points, POOL.spacing)
    found = members_of(euclidean_clusters(fine.means, SEGMENTATION.cluster_tolerance)[fine.cell_of])
    found = [rows for rows in found if len(rows) >= POOL.min_points]
    sizes = [np.subtract(*corners_of(top.points[rows])[::-1]) for rows in found]
    return [
        top.indices[rows]
        for rows, size in zip(found, sizes, strict=True)
        if size[2] > SCAN.cell and size.max() < SEGMENTATION.large
    ]


def levelled(points: np.ndarray, pool: Pool) -> np.ndarray:
    """Return an object's points (N, 3) with its flat surface even and without gaps; unchanged if it is not flat.

    For spheres, a sensor's noise of a centimetre makes hollows, and a top that is tilted by a degree is a slope.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    pool : Pool
        Whose surface the object has.
    """
    ground = pool.footprint
    near = ground.grown(POOL.slab).holds(points) & (np.abs(points[:, 2] - pool.height) < POOL.slab)
    if not near.any():
        return points
    plane = fitted_height(points[near], pool.height)
    rise = points[:, 2] - points[:, :2] @ plane[:2] - plane[2]
    if np.median(np.abs(rise[near])) > SCAN.cell / 2:  # a cushion, for example
        return points
    on_plane = near & (np.abs(rise) < SCAN.cell)
    even = points.copy()
    even[on_plane, 2] = pool.height
    return np.vstack([even, bare_places(ground, points[on_plane], pool.height)])


def bare_places(ground: GroundSquares, points: np.ndarray, height: float) -> np.ndarray:
    """Return points (M, 3) a centimetre apart at a height, where a footprint has none of the points (N, 3)."""
    bare = ground.mask.copy()
    place = np.floor(points[:, :2] / SCAN.cell).astype(np.int64) - ground.corner
    bare[tuple(place[((place >= 0) & (place < bare.shape)).all(axis=1)].T)] = False
    corners = (np.argwhere(bare) + ground.corner) * SCAN.cell
    offsets = np.array([[x, y] for x in (0.25, 0.75) for y in (0.25, 0.75)]) * SCAN.cell
    places = (corners[:, None] + offsets).reshape(-1, 2)
    return np.column_stack([places, np.full(len(places), height)])
