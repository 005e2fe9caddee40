"""Places to put: level regions with free height above, and poses at which a given object stands there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import ConvexHull, QhullError

from ..clouds.cloud import Cloud
from .place import FUNCTION, Place
from .regions import HeightMap, Region, level_regions, rings_of

DISC = 0.04  # metres, radius of the disc for which there must be room if no object is given
OFF_EDGES = 0.02  # metres between a base and edges, if there is room for it
OFF_OTHERS = 0.01  # metres between an object and others that stand there
TOUCHING = 0.003  # metres above the lowest point of an object up to which points belong to its base
LIFT = 0.001  # metres of poses above the surface
HEADINGS = 4  # number of headings in a quarter turn that are tried for objects that are not round
MOST_POSES = 60  # of a region
STEEPEST_DEG = 3.0  # steepest region on which an object can stand upright
LOWEST = 0.01  # metres: lower cells are the ground


@dataclass(frozen=True, eq=False)
class ObjectFootprint:
    """An object seen from above, standing."""

    cloud: Cloud
    base: np.ndarray  # (K, 2) corners of the convex hull of what touches the ground
    outline: np.ndarray  # (L, 2) corners of the convex hull of all of it

    @property
    def height(self) -> float:
        """The height of the object, metres."""
        return float(self.cloud.size[2])

    @property
    def round(self) -> bool:
        """Whether the object is so round that its heading hardly matters."""
        radii = np.linalg.norm(self.outline - self.outline.mean(axis=0), axis=1)
        return len(self.outline) > 8 and radii.max() < 1.1 * radii.min()


def footprint_of(cloud: Cloud) -> ObjectFootprint:
    """Return the footprint of an object as it stands in its own frame."""
    corners = cloud.points if cloud.mesh is None else np.vstack([cloud.mesh.vertices, cloud.points])
    low = corners[corners[:, 2] <= corners[:, 2].min() + TOUCHING]
    return ObjectFootprint(cloud, hull(low[:, :2]), hull(corners[:, :2]))


def hull(points: np.ndarray) -> np.ndarray:
    """Return the corners of the convex hull of points (N, 2); the two ends if all points are on a line."""
    try:
        return points[ConvexHull(points).vertices]
    except (QhullError, ValueError):
        along = points @ (points.max(axis=0) - points.min(axis=0))
        return points[[along.argmin(), along.argmax()]]


def put_places(surface: HeightMap, put: Cloud | None = None, lowest: float = LOWEST) -> list[Place]:
    """Return the level regions on which something can be put, each with its best position.

    Parameters
    ----------
    put : Cloud, optional
        An object, as it stands, for which poses are searched.
    lowest : float, metres
        Lower cells are the ground.
    """
    footprint = None if put is None else footprint_of(put)
    least = DISC if footprint is None else 0.01
    places = [put_place(surface, region, footprint) for region in level_regions(surface, least, lowest)]
    return [place for place in places if place is not None]


def put_place(surface: HeightMap, region: Region, footprint: ObjectFootprint | None) -> Place | None:
    """Return a region as a place; None if there is no room for the object that is put there."""
    poses, margins = ((), ()) if footprint is None else poses_on(surface, region, footprint)
    if footprint is not None and not poses:
        return None
    middle, room = poses[0][:2, 3] if poses else roomiest(surface, region), float(region.room.max())
    return Place(
        kind="put",
        function=FUNCTION["put"],
        position=np.array([*middle, float(region.height_at(middle))]),
        normal=region.normal,
        region=rings_of(surface, region.cells, region.plane),
        area=float(region.cells.sum()) * surface.cell**2,
        height=float(region.height_at(middle)),
        score=float(np.clip(room / 0.1, 0.1, 1.0) * (1 - region.slope_deg / 20)),
        radius=room,
        poses=poses,
        margins=margins,
    )


def roomiest(surface: HeightMap, region: Region) -> np.ndarray:
    """Return the place (2,) with the most room; of equal ones, as along a long top, the one nearest to the middle."""
    alike = surface.middles(np.argwhere(region.room >= region.room.max() - surface.cell / 2))
    middle = surface.middles(np.argwhere(region.cells)).mean(axis=0)
    return alike[np.linalg.norm(alike - middle, axis=1).argmin()]


def poses_on(surface: HeightMap, region: Region, footprint: ObjectFootprint) -> tuple[tuple[np.ndarray, ...], tuple]:
    """Return poses (4, 4) on a region, spread over it, those with the largest margin first; and the margins."""
    if region.slope_deg > STEEPEST_DEG:
        return (), ()
    level = region.height_at(surface.middles(np.stack(np.indices(surface.heights.shape), axis=-1)))
    low = surface.heights <= level + 3 * surface.rough
    free = surface.cell * (ndimage.distance_transform_edt(low) - 0.5)  # distance to what stands above the region
    headings = [0.0] if footprint.round else np.arange(2 * HEADINGS) * np.pi / (2 * HEADINGS)
    found = []
    for heading in headings:
        found += [(xy, heading, margin) for xy, margin in positions(surface, region, free, footprint, heading)]
    found.sort(key=lambda place: -place[2])
    apart = 0.8 * surface.cell * np.sqrt(region.cells.sum() / MOST_POSES)  # so that they cover the whole region
    chosen = spread(found, max(0.05, float(apart)))
    poses = tuple(pose_at(surface, footprint, xy, heading) for xy, heading, _ in chosen)
    return poses, tuple(float(margin) for *_, margin in chosen)


def positions(
    surface: HeightMap, region: Region, free: np.ndarray, footprint: ObjectFootprint, heading: float
) -> list[tuple[np.ndarray, float]]:
    """Return places (2,) where the base is supported and the rest is clear, with their margins, metres."""
    base = samples(turned(footprint.base, heading), surface.cell)
    outline = samples(turned(footprint.outline, heading), surface.cell)
    cells = np.argwhere(region.room >= min(OFF_EDGES, 0.5 * region.room.max()))
    if len(cells) > 3000:
        cells = cells[:: -(-len(cells) // 3000)]
    middles = surface.middles(cells)
    held = least_at(surface, region.room, middles, base)
    clear = least_at(surface, free, middles, outline)
    good = (held >= OFF_EDGES / 2) & (clear >= OFF_OTHERS)
    margin = np.minimum(held, clear - OFF_OTHERS + OFF_EDGES / 2)
    return list(zip(middles[good], margin[good], strict=True))


def turned(points: np.ndarray, heading: float) -> np.ndarray:
    """Return points (K, 2) turned about the origin."""
    cosine, sine = np.cos(heading), np.sin(heading)
    return points @ np.array([[cosine, sine], [-sine, cosine]])


def samples(corners: np.ndarray, cell: float) -> np.ndarray:
    """Return points (N, 2) on a convex polygon, a cell apart, or a twelfth of its width if that is more."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    step = max(cell, float((high - low).max()) / 12)
    grid = np.stack(np.meshgrid(*[np.arange(a, b, step) for a, b in zip(low, high, strict=True)]), -1).reshape(-1, 2)
    edges = np.roll(corners, -1, axis=0) - corners
    sides = edges[:, 0] * (grid[:, None, 1] - corners[:, 1]) - edges[:, 1] * (grid[:, None, 0] - corners[:, 0])
    inside = (sides >= 0).all(axis=1) | (sides <= 0).all(axis=1)
    return np.vstack([along_edges(corners, step), grid[inside]])


def along_edges(corners: np.ndarray, step: float) -> np.ndarray:
    """Return places (N, 2) along the edges of a polygon (K, 2), no farther apart than a step."""
    ends = np.roll(corners, -1, axis=0)
    counts = np.maximum(1, np.ceil(np.linalg.norm(ends - corners, axis=1) / step)).astype(int)
    return np.vstack([a + (b - a) * np.arange(n)[:, None] / n for a, b, n in zip(corners, ends, counts, strict=True)])


def least_at(surface: HeightMap, room: np.ndarray, middles: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the least value (N,) of a map (X, Y) at all offsets (K, 2) from each place (N, 2); -1 outside the map."""
    least = np.full(len(middles), np.inf)
    for offset in offsets:
        index = np.floor((middles + offset - surface.origin) / surface.cell).astype(int)
        inside = ((index >= 0) & (index < room.shape)).all(axis=1)
        value = np.full(len(middles), -1.0)
        value[inside] = room[tuple(index[inside].T)]
        least = np.minimum(least, value)
    return least


def spread(found: list[tuple[np.ndarray, float, float]], apart: float) -> list[tuple[np.ndarray, float, float]]:
    """Return the first place, and each later one that is not near one chosen before, up to `MOST_POSES`."""
    chosen: list[tuple[np.ndarray, float, float]] = []
    taken = np.empty((0, 2))
    for place in found:
        if len(chosen) == MOST_POSES:
            break
        if not len(taken) or np.abs(taken - place[0]).max(axis=1).min() >= apart:
            chosen.append(place)
            taken = np.vstack([taken, place[0]])
    return chosen


def pose_at(surface: HeightMap, footprint: ObjectFootprint, xy: np.ndarray, heading: float) -> np.ndarray:
    """Return the pose (4, 4) in which the base is just above the highest point under it."""
    offsets = samples(turned(footprint.base, heading), surface.cell)
    index = np.floor((xy + offsets - surface.origin) / surface.cell).astype(int)
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]]
    pose[:3, 3] = [*xy, float(surface.heights[tuple(index.T)].max()) + LIFT]
    return pose
