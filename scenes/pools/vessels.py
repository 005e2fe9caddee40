"""Vessels: places on tops where small spheres rest with a wall around them.

A sphere in a vessel that moves along the ground meets the wall in most directions. If the sensor did not see the far
wall, it still meets the wall in more than half of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.processes.compilation import njit
from spherefunc_bullet.simulator import Simulator

from ..scans.cells import cells
from ..segmentation.clusters import euclidean_clusters, members_of
from ..settings import POOL
from .surfaces import resting_places
from .tops import Top

_WIDEST = 0.10  # metres from a resting place to the wall: half of a bowl
_RISES = (0.012, 0.14)  # metres above a sphere's lowest point between which walls are searched


@dataclass(frozen=True, kw_only=True, eq=False)
class VesselPool:
    """Small spheres that rest together with a wall around them."""

    center: np.ndarray  # (3,) metres, level frame, of the spheres' lowest points
    support: float  # metres, level frame, height of the surface that the vessel stands on
    reach: float  # metres from the centre to the wall
    rim: float  # metres, level frame, height of the wall's upper edge


def vessel_pools(top: Top, simulator: str | Simulator, *, seed: int = 0) -> list[VesselPool]:
    """Return the pools of small spheres on a top that walls enclose, the one of most spheres first."""
    if len(top.points) < 10:
        return []
    flat = np.column_stack([top.points[:, :2], top.points[:, 2] - top.height_at(top.points)])
    objects = cells(flat, POOL.spacing).means
    corner = objects.min(axis=0)
    moved = objects - [*corner[:2], 0]
    centers = resting_places(np.vstack([moved, sheet_below(moved)]), simulator, POOL.vessel_radius, seed=seed)
    feet = centers - [0, 0, POOL.vessel_radius]
    walls, rims = surroundings(moved, feet)
    enclosed = np.flatnonzero(np.isfinite(walls).mean(axis=1) >= POOL.enclosed)
    pools = []
    for members in members_of(euclidean_clusters(feet[enclosed], POOL.linked * POOL.vessel_radius)):
        if len(members) >= POOL.min_rests:
            pools.append((len(members), pool_of(feet[enclosed[members]] + [*corner[:2], 0], top, flat)))
    return [pool for _, pool in sorted(pools, key=lambda pair: -pair[0]) if pool is not None]


def sheet_below(points: np.ndarray) -> np.ndarray:
    """Return a grid of points (M, 3) on the ground below points (N, 3), the bottom that scans of deep vessels lack."""
    high = points.max(axis=0)
    x, y = (np.arange(0, high[axis] + POOL.vessel_radius / 2, POOL.vessel_radius / 2) for axis in range(2))
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.column_stack([places, np.full(len(places), 1e-4)])


def surroundings(points: np.ndarray, feet: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the distance of the wall in each direction from spheres' lowest points (S, 3), and its height there.

    Returns
    -------
    (S, D) and (S, D) float64, metres
        Infinite and 0 where no wall is near.
    """
    walls, rims = np.full((len(feet), POOL.directions), np.inf), np.zeros((len(feet), POOL.directions))
    meet_walls(np.ascontiguousarray(points), np.ascontiguousarray(feet), walls, rims)
    return walls, rims


@njit(cache=True, error_model="numpy")
def meet_walls(points, feet, walls, rims):
    """Write the distances and heights of walls of points (N, 3) around spheres' feet (S, 3); see `surroundings`."""
    directions = walls.shape[1]
    for k in range(len(feet)):
        for i in range(len(points)):
            x, y, rise = points[i, 0] - feet[k, 0], points[i, 1] - feet[k, 1], points[i, 2] - feet[k, 2]
            square = x * x + y * y
            if square <= _WIDEST * _WIDEST and _RISES[0] < rise < _RISES[1]:
                sector = int(math.atan2(y, x) / (2 * math.pi) * directions) % directions
                walls[k, sector] = min(walls[k, sector], math.sqrt(square))
                rims[k, sector] = max(rims[k, sector], points[i, 2])


def pool_of(feet: np.ndarray, top: Top, objects: np.ndarray) -> VesselPool | None:
    """Return the pool of spheres with feet (S, 3) above a top; None if no wall surrounds its middle."""
    middle = np.append(feet[:, :2].mean(axis=0), feet[:, 2].min())
    walls, rims = surroundings(objects, middle[None])
    seen = np.isfinite(walls[0])
    if seen.mean() < POOL.enclosed:
        return None
    level = float(middle[:2] @ top.plane[:2] + top.plane[2])
    return VesselPool(
        center=np.append(middle[:2], level + middle[2]),
        support=level,
        reach=float(np.median(walls[0][seen])),
        rim=level + float(np.median(rims[0][seen])),
    )


def cut_vessel(points: np.ndarray, pool: VesselPool) -> np.ndarray:
    """Return which points (N, 3) belong to a vessel, (N,) bool: those within its wall, and the wall itself."""
    inside = np.linalg.norm(points[:, :2] - pool.center[:2], axis=1) < pool.reach + POOL.vessel_radius
    return inside & (points[:, 2] > pool.support + 0.003) & (points[:, 2] < pool.rim + POOL.vessel_radius)
