"""Tops: parts of a scene cut out around pools, objects on these surfaces or on a table top as ground, and levelling.

A real flat surface is level, even, and continues below the objects that hide it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from spherefunc_bullet.clouds.cloud import corners_of
from spherefunc_bullet.processes.compilation import njit

from ..scans.cells import Cells, cells
from ..segmentation.clusters import euclidean_clusters, members_of
from ..settings import POOL, SCAN, SEGMENTATION
from .ground_squares import GroundSquares
from .surfaces import Pool, upper_face


def cut_out(voxels: Cells, pool: Pool, gap: float) -> np.ndarray:
    """Return the points (K,) int64 that may be a pool's object, ascending: also what rises from the edge of a seat.

    Parameters
    ----------
    voxels : Cells
        Of the scene's points without ground and walls, level frame.
    pool : Pool
    gap : float
        Largest distance of a back's lower edge above the surface, metres.
    """
    ground = pool.footprint
    beside = voxels.along_x(*ground.x_range)
    points = voxels.means[beside]
    bare = ground.grown(2 * SCAN.cell).holds(points) & (points[:, 2] < pool.height + POOL.slab)
    if pool.is_table:
        return voxels.points_in(beside.start + np.flatnonzero(bare))
    free = ~bare & (points[:, 2] >= pool.height + POOL.slab) & (points[:, 2] < POOL.highest)
    rising, middle = np.flatnonzero(ground.grown(POOL.back_reach).holds(points) & free), ground.shrunk(POOL.back_reach)
    for members in members_of(euclidean_clusters(points[rising], POOL.slab)):
        if is_back(points[rising[members]], pool, middle, gap):
            bare[rising[members]] = True
    return voxels.points_in(beside.start + np.flatnonzero(bare))


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
    beside = voxels.along_x(*ground.x_range)
    # A point is at most a square away from the mean of its voxel.
    within_reach = ground.grown(1.5 * SCAN.cell).holds(voxels.means[beside])
    near = voxels.points_in(beside.start + np.flatnonzero(within_reach))
    near = near[ground.holds(points[near])]
    part = points[near]
    on_top = np.abs(part[:, 2] - pool.height) < POOL.slab
    top = top_at(part, near, fitted_height(part[on_top], pool.height))
    return replace(top, is_table=pool.is_table)


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
    points, plane = points[upper_face(points)], np.array([0.0, 0.0, height])
    for reach in POOL.top_fits:
        if not fit_plane(points, reach, POOL.min_points, plane):
            break
    return plane


@njit(cache=True, error_model="numpy")
def fit_plane(points, reach, least, plane):
    """Fit the plane (3,) of heights to the points (N, 3) within a reach of it, if there are at least some; return that.

    Parameters
    ----------
    plane : (3,) float64
        The plane before, in the form of `Top.plane`; receives the fitted one.
    """
    count, mean_x, mean_y, mean_z = 0, 0.0, 0.0, 0.0
    near = np.empty(len(points), np.int64)
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        if abs(z - x * plane[0] - y * plane[1] - plane[2]) < reach:
            near[count] = i
            count, mean_x, mean_y, mean_z = count + 1, mean_x + x, mean_y + y, mean_z + z
    if count < least:
        return False
    mean_x, mean_y, mean_z = mean_x / count, mean_y / count, mean_z / count
    xx, xy, yy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in near[:count]:
        x, y, z = points[i, 0] - mean_x, points[i, 1] - mean_y, points[i, 2] - mean_z
        xx, xy, yy, xz, yz = xx + x * x, xy + x * y, yy + y * y, xz + x * z, yz + y * z
    determinant = xx * yy - xy * xy
    if determinant > 1e-9 * (xx + yy) ** 2:  # points on a line do not show a slope across it
        plane[0], plane[1] = (xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant
    plane[2] = mean_z - plane[0] * mean_x - plane[1] * mean_y
    return True


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
