"""From a levelled scan to objects: floor, walls and ceiling are removed, the rest is clustered (paper, §IV-C)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from spherefunc_bullet.errors import CheckedSettings, InputError, amount
from spherefunc_bullet.processes.compilation import njit

from ..scans.cells import cells
from ..scans.gravity import Patches, find_patches
from ..settings import SCAN, SEGMENTATION
from .clusters import euclidean_clusters

FLOOR, WALL, LEFT_OVER = range(-1, -4, -1)  # labels of points of no object


@dataclass(frozen=True, kw_only=True)
class Segmentation(CheckedSettings):
    """Settings of segmentation, named as in PCL's filters and EuclideanClusterExtraction."""

    # Metres, side of the voxels that thin the scan first.
    leaf_size: float = amount(lambda: SEGMENTATION.leaf_size, above=0.0, most=1.0)
    # Metres between neighbours of one cluster (paper, §IV-C).
    cluster_tolerance: float = amount(lambda: SEGMENTATION.cluster_tolerance, above=0.0, most=1.0)
    min_cluster_size: int = amount(lambda: SEGMENTATION.min_cluster_size, least=1)  # voxels
    max_cluster_size: int = amount(2**31 - 1, least=1)  # voxels; PCL's default

    def __post_init__(self):
        super().__post_init__()
        if self.min_cluster_size > self.max_cluster_size:
            sizes = f"{self.min_cluster_size} and {self.max_cluster_size}"
            raise InputError(f"min_cluster_size and max_cluster_size: expected ascending sizes, got {sizes}")


def segment(
    points: np.ndarray,
    settings: Segmentation | None = None,
    *,
    noise: float | None = None,
    shell: Shell | None = None,
) -> np.ndarray:
    """Return the object of each point (paper, §IV-C).

    Parameters
    ----------
    points : (N, 3) float64, metres
        In the level frame: z up, the floor, or the table top that carries the scene, at z = 0.
    settings : Segmentation
    noise : float, optional
        Standard deviation of the floor's points, metres, if known, from which the floor's thickness is chosen.
    shell : Shell, optional
        Walls and ceiling, if they are known; otherwise they are searched in the points.

    Returns
    -------
    (N,) int32
        Objects are numbered from 0, the one of most voxels first; -1 the floor, -2 a wall or the ceiling, -3 clusters
        that are too small, and points below the floor. The order of the points does not matter.
    """
    settings = settings or Segmentation()
    thinned = cells(points, settings.leaf_size)
    voxels = thinned.means
    shell = shell or find_shell(voxels)
    labels = shell_labels(voxels, shell, noise)
    rest = np.flatnonzero((voxels[:, 2] > 0) & (labels == LEFT_OVER))
    labels[rest] = numbered_by_size(euclidean_clusters(voxels[rest], settings.cluster_tolerance), settings)
    return labels[thinned.cell_of]


def shell_labels(voxels: np.ndarray, shell: Shell, noise: float | None) -> np.ndarray:
    """Return which voxels (C, 3) are of the floor, and which of walls or ceiling, (C,) int32; LEFT_OVER the others."""
    labels = np.full(len(voxels), LEFT_OVER, np.int32)
    labels[is_floor(voxels, noise)] = FLOOR
    labels[(voxels[:, 2] > 0) & shell.holds(voxels)] = WALL
    return labels


def is_floor(voxels: np.ndarray, noise: float | None) -> np.ndarray:
    """Return which voxels (C, 3) belong to the floor, (C,) bool: within four standard deviations, if noise is known."""
    return np.abs(voxels[:, 2]) <= (SCAN.cell if noise is None else np.clip(4 * noise, SCAN.cell / 2, SCAN.fit))


def numbered_by_size(cluster_of: np.ndarray, settings: Segmentation) -> np.ndarray:
    """Return clusters (C,) numbered by size, -3 for those that are too small or too large.

    Of equally large ones the one with the first voxel comes first; voxels are ordered by their place in space.
    """
    _, first, member, counts = np.unique(cluster_of, return_index=True, return_inverse=True, return_counts=True)
    order = np.lexsort((first, -counts))
    wanted = order[(counts[order] >= settings.min_cluster_size) & (counts[order] <= settings.max_cluster_size)]
    number = np.full(len(counts), LEFT_OVER, np.int32)
    number[wanted] = np.arange(len(wanted))
    return number[member.ravel()]


@dataclass(frozen=True, kw_only=True, eq=False)
class Wall:
    """An upright plane, and its extent."""

    normal: np.ndarray  # (2,) level unit vector into the room
    offset: float  # metres: normal @ xy on the plane
    span: tuple[float, float]  # metres along the wall, from and to
    thickness: float  # metres off the plane at which a point still belongs to it

    def along(self, points: np.ndarray) -> np.ndarray:
        """Return places (N,) of points (N, 3) along the wall, metres."""
        return points[:, :2] @ np.array([-self.normal[1], self.normal[0]])

    def ahead(self, points: np.ndarray) -> np.ndarray:
        """Return distances (N,) of points (N, 3) into the room, metres, negative behind the wall."""
        return points[:, :2] @ self.normal - self.offset

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Return which points (N, 3) belong to the wall or lie behind it, (N,) bool."""
        along = self.along(points)
        beside = (along > self.span[0] - SEGMENTATION.wall_margin) & (along < self.span[1] + SEGMENTATION.wall_margin)
        return beside & (self.ahead(points) < self.thickness)


@dataclass(frozen=True, kw_only=True, eq=False)
class Shell:
    """The walls and the ceiling of a room."""

    walls: list[Wall]
    ceiling: float  # its height, metres; infinity if none is seen

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Return which points (N, 3) belong to walls or ceiling, or lie behind them, (N,) bool."""
        outside = points[:, 2] > self.ceiling
        for wall in self.walls:
            outside |= wall.holds(points)
        return outside


def find_shell(points: np.ndarray) -> Shell:
    """Return the walls and the ceiling of a thinned scan (N, 3), metres, in the level frame."""
    patches = find_patches(points)
    return Shell(walls=find_walls(points, patches), ceiling=ceiling_height(patches))


def ceiling_height(patches: Patches) -> float:
    """Return the height of the ceiling, metres; infinity if none is seen."""
    level = patches[np.abs(patches.normals[:, 2]) > np.cos(SCAN.aligned)]
    high = level.centers[:, 2] > SEGMENTATION.high
    if level.areas[high].sum() < SEGMENTATION.wall_area:
        return np.inf
    return float(np.median(level.centers[high, 2])) - SEGMENTATION.wall_thickness


def find_walls(points: np.ndarray, patches: Patches) -> list[Wall]:
    """Return the walls of a room, the largest first.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
        The thinned scan.
    patches : Patches
        Of the same points.
    """
    left = patches[np.abs(patches.normals[:, 2]) < np.sin(SCAN.aligned)]
    walls = []
    while len(left) >= 3:
        plane, inside = largest_plane(left)
        if left.areas[inside].sum() < SEGMENTATION.wall_area:
            break
        wall = bounding_wall(points, plane, left[inside])
        if wall is not None:
            walls.append(wall)
        left = left[~inside]
    return walls


def largest_plane(patches: Patches) -> tuple[tuple[np.ndarray, float], np.ndarray]:
    """Return normal (2,) and offset of the upright plane of most area, and which patches lie in it (P,) bool."""
    normals = patches.normals[:, :2] / np.linalg.norm(patches.normals[:, :2], axis=1)[:, None]
    places = patches.centers[:, :2]
    tried = np.argsort(-patches.areas, kind="stable")[:: max(1, len(patches) // SCAN.tried)]
    area = np.empty(len(tried))
    limits = np.cos(SCAN.aligned), SEGMENTATION.wall_thickness
    add_coplanar(normals, places, patches.areas, tried, *limits, area)
    best = int(np.argmax(area))
    offsets = (places - places[tried[best]]) @ normals[tried[best]]
    inside = (np.abs(normals @ normals[tried[best]]) > limits[0]) & (np.abs(offsets) < limits[1])
    centre = np.average(places[inside], axis=0, weights=patches.areas[inside])
    normal = normals[tried[best]]
    if inside.sum() >= 3:
        normal = np.linalg.eigh(np.cov(places[inside].T, aweights=patches.areas[inside]))[1][:, 0]
    return (normal, float(normal @ centre)), inside


@njit(cache=True, error_model="numpy")
def add_coplanar(normals, places, areas, tried, cosine, thickness, coplanar):
    """Write the area (T,) of the patches that lie in the upright plane of each tried one.

    Parameters
    ----------
    normals, places : (P, 2) float64
        Of all patches, seen from above.
    """
    for k in range(len(tried)):
        x, y = normals[tried[k], 0], normals[tried[k], 1]
        offset, area = x * places[tried[k], 0] + y * places[tried[k], 1], 0.0
        for i in range(len(normals)):
            near = abs(x * places[i, 0] + y * places[i, 1] - offset) < thickness
            if near and abs(x * normals[i, 0] + y * normals[i, 1]) > cosine:
                area += areas[i]
        coplanar[k] = area


def bounding_wall(points: np.ndarray, plane: tuple[np.ndarray, float], patches: Patches) -> Wall | None:
    """Return the wall of a plane with its patches, or None if it is the side of an object."""
    normal, offset = plane
    into = 1.0 if np.median(points[:, :2] @ normal) >= offset else -1.0
    thickness = SEGMENTATION.wall_thickness
    wall = Wall(normal=into * normal, offset=into * offset, span=(0.0, 0.0), thickness=thickness)
    low, high = np.percentile(wall.along(patches.centers), [2, 98])
    spread = 1.4826 * np.median(np.abs(wall.ahead(patches.centers))) + np.median(patches.thickness)
    wall = replace(wall, span=(float(low), float(high)), thickness=float(np.clip(3 * spread, thickness, 2 * thickness)))
    along, ahead = wall.along(points), wall.ahead(points)
    on_wall = (along > low) & (along < high) & (np.abs(ahead) < wall.thickness)
    width, top = high - low, np.percentile(points[on_wall, 2], 98) if on_wall.any() else 0.0
    if width < SEGMENTATION.wall_width or top < SEGMENTATION.wall_top:
        return None
    beside = (along > low - SEGMENTATION.wall_margin) & (along < high + SEGMENTATION.wall_margin)
    behind = np.mean(ahead[beside] < -2 * thickness)
    return wall if behind < SCAN.stray else None
