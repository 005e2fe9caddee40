"""From a levelled scan to objects: floor, walls and ceiling off, the rest in Euclidean clusters (paper, §IV-C)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from spherefunc_bullet.errors import InputError

from ..scans.cells import cells
from ..scans.patches import find_patches
from ..settings import SCAN, SEGMENTATION
from .clusters import euclidean_clusters
from .walls import Wall, ceiling_height, find_walls

FLOOR, WALL, LEFT_OVER = range(-1, -4, -1)  # what a point is of that is of no object


@dataclass(frozen=True, kw_only=True)
class Segmentation:
    """How a scan falls into objects; named as PCL's filters and EuclideanClusterExtraction name it."""

    # Metres, side of the voxels that thin the scan first.
    leaf_size: float = field(default_factory=lambda: SEGMENTATION.leaf_size)
    # Metres between neighbours of one cluster (paper, §IV-C).
    cluster_tolerance: float = field(default_factory=lambda: SEGMENTATION.cluster_tolerance)
    min_cluster_size: int = field(default_factory=lambda: SEGMENTATION.min_cluster_size)  # voxels
    max_cluster_size: int = 2**31 - 1  # voxels; PCL's default

    def __post_init__(self):
        for name in ("leaf_size", "cluster_tolerance"):
            if not 0 < getattr(self, name) < 1:
                raise InputError(f"{name}: expected between 0 and 1 m, got {getattr(self, name):g}")
        if not 1 <= self.min_cluster_size <= self.max_cluster_size:
            sizes = f"{self.min_cluster_size} and {self.max_cluster_size}"
            raise InputError(f"min_cluster_size and max_cluster_size: expected 1 or more, ascending, got {sizes}")


def segment(points: np.ndarray, settings: Segmentation | None = None, *, noise: float | None = None) -> np.ndarray:
    """Return which object each point is of (paper, §IV-C).

    Parameters
    ----------
    points : (N, 3) float64, metres
        In the level frame: z up, the floor, or the table top that carries the scene, at z = 0.
    settings : Segmentation
    noise : float, optional
        Standard deviation of the floor's points, metres, if known: the floor is taken to be thinner or thicker by it.

    Returns
    -------
    (N,) int32
        Objects are numbered from 0, the one of most voxels first; -1 the floor, -2 a wall or the ceiling, -3 what is
        too small, or below the floor. The order of the points does not matter.
    """
    settings = settings or Segmentation()
    thinned = cells(points, settings.leaf_size)
    return labelled_voxels(thinned.means, settings, noise)[thinned.cell_of]


def labelled_voxels(voxels: np.ndarray, settings: Segmentation, noise: float | None) -> np.ndarray:
    """Return the label (C,) int32 of each voxel (C, 3) of a thinned scan; see `segment`."""
    patches = find_patches(voxels)
    labels = np.full(len(voxels), LEFT_OVER, np.int32)
    labels[is_floor(voxels, noise)] = FLOOR
    above = voxels[:, 2] > 0
    labels[above & is_wall(voxels, find_walls(voxels, patches), ceiling_height(patches))] = WALL
    rest = np.flatnonzero(above & (labels == LEFT_OVER))
    labels[rest] = numbered_by_size(euclidean_clusters(voxels[rest], settings.cluster_tolerance), settings)
    return labels


def is_floor(voxels: np.ndarray, noise: float | None) -> np.ndarray:
    """Return which voxels (C, 3) belong to the floor, (C,) bool: within four deviations of it, where noise is known."""
    return np.abs(voxels[:, 2]) <= (SCAN.cell if noise is None else np.clip(4 * noise, SCAN.cell / 2, SCAN.fit))


def is_wall(voxels: np.ndarray, walls: Sequence[Wall], ceiling: float) -> np.ndarray:
    """Return which voxels (C, 3) belong to walls or the ceiling, or lie beyond, (C,) bool."""
    outside = voxels[:, 2] > ceiling
    for wall in walls:
        outside |= wall.holds(voxels)
    return outside


def numbered_by_size(cluster_of: np.ndarray, settings: Segmentation) -> np.ndarray:
    """Return clusters (C,) numbered by size, -3 for those of a size that is not wanted.

    Of equals the one that has the first voxel comes first; voxels stand in the order of their place in space.
    """
    _, first, member, counts = np.unique(cluster_of, return_index=True, return_inverse=True, return_counts=True)
    order = np.lexsort((first, -counts))
    wanted = order[(counts[order] >= settings.min_cluster_size) & (counts[order] <= settings.max_cluster_size)]
    number = np.full(len(counts), LEFT_OVER, np.int32)
    number[wanted] = np.arange(len(wanted))
    return number[member.ravel()]
