"""From a tilted scan to the level frame: z up, in metres, the floor at z = 0 (paper, §IV-C: the floor by RANSAC)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from spherefunc_bullet.errors import InputError

from ..settings import SCAN
from .cells import cells
from .gravity import Patches, camera_frame, facing_normals, find_patches, refined_up, seen_gravity, up_vector

_FAR = 1000.0  # metres from the origin, as in maps of countries: products of such coordinates lose digits


@dataclass(frozen=True, kw_only=True, eq=False)
class Levelling:
    """The transform of a scan to the level frame, and how it was found."""

    T_level_scan: np.ndarray  # (4, 4) float64, from the scan's frame to the level one
    source: str  # "floor", "table top", "given" (--up, no floor seen) or "assumed" (the sensor's own up)
    floor_seen: bool  # whether z = 0 is a plane in the scan, or only the lowest point
    noise: float | None  # standard deviation of the floor's points about it, metres; None without a floor

    @property
    def up(self) -> np.ndarray:
        """Unit vector (3,) that points up, in the scan's frame."""
        return self.T_level_scan[2, :3]

    @property
    def height(self) -> float:
        """Height of z = 0 along ``up``, in the scan's frame, metres."""
        return float(-self.T_level_scan[2, 3])

    def to_level(self, points: np.ndarray) -> np.ndarray:
        """Return points (N, 3) of the scan's frame in the level one."""
        return points @ self.T_level_scan[:3, :3].T + self.T_level_scan[:3, 3]

    def to_scan(self, points: np.ndarray) -> np.ndarray:
        """Return points (N, 3) of the level frame in the scan's."""
        return (points - self.T_level_scan[:3, 3]) @ self.T_level_scan[:3, :3]

    def of_shifted(self, shift: np.ndarray) -> Levelling:
        """Return the levelling of a scan that becomes this one's if its points are moved by a shift (3,), metres."""
        T_level_scan = self.T_level_scan.copy()
        T_level_scan[:3, 3] += T_level_scan[:3, :3] @ shift
        return replace(self, T_level_scan=T_level_scan)


def level(points: np.ndarray, up: str | ArrayLike = "auto", name: str = "scan") -> Levelling:
    """Find gravity and the floor of a scan (paper, §IV-C).

    The floor is the lowest large level plane, not the largest, since a wall or a table top can be larger. If no floor
    is seen, the table top that carries the scene serves as ground, otherwise the lowest point along the given or the
    sensor's own up.

    Parameters
    ----------
    points : (N, 3) float64, metres, finite
    up : str or (3,) array_like
        ``auto``, or the axis or the vector that points up, which is then used unchanged.
    name : str
        What errors call the scan.

    Raises
    ------
    InputError
        If ``up`` is no direction, or the points have no extent.
    """
    middle = np.median(points, axis=0)
    if np.abs(middle).max() > _FAR:
        return level(points - middle, up, name).of_shifted(-middle)
    given, patches = up_vector(up), find_patches(points)
    likely, camera = camera_frame(points) if given is None else (given, None)
    seen = seen_gravity(patches, likely, camera) if given is None and len(patches) else None
    upward = likely if seen is None else seen
    facing = facing_normals(patches, upward, camera) @ upward > np.cos(SCAN.aligned)
    plane = lowest_large_plane(points, patches[facing], upward)
    if plane is None:
        transform = level_transform(upward, float(np.percentile(points @ upward, 0.5)))
        source = "assumed" if given is None else "given"
        return Levelling(T_level_scan=transform, source=source, floor_seen=False, noise=None)
    height, area = plane
    upward, height, noise = fitted_plane(points, upward, height, given is not None)
    if seen is not None:
        joint = refined_up(patches.normals, patches.areas, seen, upward * np.sqrt(area))
        inside = np.abs(points @ upward - height) < SCAN.fit
        height, upward = float(np.median(points[inside] @ joint)) if inside.any() else height, joint
    if not np.isfinite(height):
        raise InputError(f"{name}: expected a scan of surfaces, found none; is it a line or a point?")
    # A table top is small, with only low objects on it.
    on_top = area < SCAN.largest_top and np.percentile(points @ upward, 99) - height < SCAN.on_top
    source = "table top" if on_top else "floor"
    return Levelling(T_level_scan=level_transform(upward, height), source=source, floor_seen=True, noise=noise)


def lowest_large_plane(points: np.ndarray, patches: Patches, up: np.ndarray) -> tuple[float, float] | None:
    """Return the height along ``up`` and the area of the lowest large level plane, metres and square metres.

    Parameters
    ----------
    points : (N, 3) float64, metres
        All of the scan's.
    patches : Patches
        The level ones, facing up.
    up : (3,) float64
    """
    if not len(patches):
        return None
    heights = patches.centers @ up
    lowest = np.floor(heights.min() / SCAN.cell)
    bins = np.floor(heights / SCAN.cell).astype(int) - int(lowest)
    area = np.bincount(bins, patches.areas, bins.max() + 1)
    width = 2 * round(SCAN.fit / SCAN.cell) + 1
    around = np.convolve(area, np.ones(width), "same") if len(area) >= width else np.full(len(area), area.sum())
    large = around >= SCAN.least_floor * around.max()
    along = np.sort(points @ up)
    for peak in np.flatnonzero(large):
        height = (lowest + peak + 0.5) * SCAN.cell
        near = slice(peak, peak + width)
        if around[peak] < around[near].max():
            continue  # a larger sum is just above: this is its slope
        below = np.searchsorted(along, height - 2 * SCAN.fit) / len(along)
        return (height, float(around[peak])) if below <= SCAN.stray else None
    return None


def fitted_plane(points: np.ndarray, up: np.ndarray, height: float, fixed: bool) -> tuple[np.ndarray, float, float]:
    """Return up (3,), height and spread of the plane fitted to the points near a level one.

    Each cell of 2 cm counts once, so that points near the sensor do not outweigh the others.
    """
    near = np.abs(points @ up - height) < 2 * SCAN.fit
    if near.sum() < 3:
        return up, height, 0.0
    means = cells(points[near], SCAN.cell).means
    for reach in (2 * SCAN.fit, SCAN.fit, SCAN.fit):
        offset = means @ up - height
        inside = np.abs(offset) < reach
        if inside.sum() < 10:
            break
        if not fixed:
            axes = np.linalg.eigh(np.cov(means[inside].T))[1]
            normal = axes[:, 0] * np.sign(axes[:, 0] @ up)
            up = normal if normal @ up > np.cos(SCAN.aligned) else up
        height = float(np.median(means[inside] @ up))
    offset = points[near] @ up - height
    inside = np.abs(offset) < SCAN.fit
    return up, height, float(1.4826 * np.median(np.abs(offset[inside]))) if inside.any() else 0.0


def level_transform(up: np.ndarray, height: float) -> np.ndarray:
    """Return the transform (4, 4) that rotates ``up`` to z by the smallest angle and puts its height at z = 0."""
    from scipy.spatial.transform import Rotation

    z = np.array([0.0, 0.0, 1.0])
    axis = np.cross(up, z)
    sine, cosine = np.linalg.norm(axis), float(up @ z)
    axis = axis / sine if sine > 1e-12 else np.array([1.0, 0.0, 0.0])
    transform = np.eye(4)
    transform[:3, :3] = Rotation.from_rotvec(axis * np.arctan2(sine, cosine)).as_matrix()
    transform[2, 3] = -height
    return transform


def level_by_ransac(points: np.ndarray, up: str | ArrayLike = "auto", name: str = "scan") -> Levelling:
    """Level a scan by the plane of most points, which is taken for the floor.

    Parameters
    ----------
    points : (N, 3) float64, metres, finite
    up : str or (3,) array_like
        ``auto``, or the axis or the vector that the plane's upper side faces.
    name : str
        What errors call the scan.

    Raises
    ------
    InputError
        If ``up`` is no direction, or no three points span a plane.
    """
    given = up_vector(up)
    likely = camera_frame(points)[0] if given is None else given
    normal, height = largest_plane(cells(points, SCAN.cell).means, np.random.default_rng(0))
    if not np.isfinite(height):
        raise InputError(f"{name}: expected a scan of surfaces, found none; is it a line or a point?")
    side = 1.0 if normal @ likely >= 0 else -1.0
    transform = level_transform(side * normal, side * height)
    return Levelling(T_level_scan=transform, source="floor", floor_seen=True, noise=None)


def largest_plane(points: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, float]:
    """Return the normal (3,) and the height along it of the plane near most points (N, 3); NaN where there is none."""
    best, most = (np.array([0.0, 0.0, 1.0]), np.nan), 0
    for _ in range(SCAN.tried):
        a, b, c = points[rng.integers(len(points), size=3)]
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal)
        if length < 1e-9:
            continue
        near = np.abs(points @ (normal / length) - a @ (normal / length)) < SCAN.cell
        if near.sum() > most:
            best, most = fitted(points[near]), int(near.sum())
    return best


def fitted(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the normal (3,) and the height along it of the plane through points (N, 3), in least squares."""
    centre = points.mean(axis=0)
    normal = np.linalg.svd(points - centre, full_matrices=False)[2][-1] if len(points) > 2 else np.array([0, 0, 1.0])
    return normal, float(centre @ normal)
