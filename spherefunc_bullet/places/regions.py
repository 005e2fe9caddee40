"""Level regions of a surface, and their outlines as rings."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from ..clouds.cloud import Cloud
from ..clouds.water import SIXTH
from ..processes.compilation import njit

CELL = 0.01  # metres
COARSE = 1.4  # distances to a point's sixth neighbour: the least side of a cell of a cloud
STRAY = 3.0  # such distances, from which on a point is a stray one
ACROSS = 400  # cells at most


@dataclass(frozen=True, eq=False)
class HeightMap:
    """A grid of cells, each with the height of its highest point; lengths in metres."""

    origin: np.ndarray  # (2,) the corner of the first cell
    cell: float  # side
    heights: np.ndarray  # (X, Y), -inf in cells without points
    rough: float  # difference of heights of neighbours on a level surface, in addition to its slope
    whole: np.ndarray | None = None  # (X, Y) bool, where it carries a hand's breadth, see `whole_cells`; None: all

    def middles(self, cells: np.ndarray) -> np.ndarray:
        """Return the middles (N, 2) of cells (N, 2), metres."""
        return self.origin + (cells + 0.5) * self.cell

    def closed(self, mask: np.ndarray) -> np.ndarray:
        """Return a mask without its narrow gaps, such as those between slats."""
        return ndimage.binary_closing(np.pad(mask, 2), iterations=2)[2:-2, 2:-2]


def surface_of(cloud: Cloud, cell: float = CELL) -> HeightMap:
    """Return the surface of a cloud as seen from above.

    A mesh is sampled to 5 mm, so each cell that it covers has a point.
    """
    rough, least = 0.002, cell
    if cloud.mesh is None:
        apart = cloud.to_neighbour(SIXTH)
        least, rough = max(cell, COARSE * apart), 0.004 + 0.2 * apart
    side = max(least, float(cloud.size[:2].max()) / ACROSS)
    origin = cloud.bounds[0, :2] - 2 * side
    shape = np.ceil((cloud.bounds[1, :2] - origin) / side).astype(int) + 2
    heights = np.full(shape, -np.inf)
    raise_to(cloud.points, origin, side, heights)
    return HeightMap(origin, side, heights, rough)


def without_strays(cloud: Cloud) -> Cloud:
    """Return a cloud without its stray points, each of which would be the highest of its cell; a mesh has none."""
    if cloud.mesh is not None:
        return cloud
    if not cloud.some_to_neighbour(SIXTH).all():
        cloud = cloud.distinct  # among many equal points a search takes long, and they are zero apart
    apart = cloud.tree.query(cloud.points, SIXTH + 1)[0][:, SIXTH]
    near = apart < STRAY * np.median(apart)
    return cloud if near.all() else Cloud(cloud.points[near], cloud.name, unfilled=cloud.unfilled)


@njit(cache=True, error_model="numpy")
def raise_to(points, origin, side, heights):
    """Raise the height of each cell to its highest point; points outside the grid are left out."""
    for n in range(len(points)):
        i, j = int((points[n, 0] - origin[0]) / side), int((points[n, 1] - origin[1]) / side)
        if 0 <= i < heights.shape[0] and 0 <= j < heights.shape[1] and points[n, 2] > heights[i, j]:
            heights[i, j] = points[n, 2]


SLOPE_DEG = 5.0  # steepest slope of a level region


@dataclass(frozen=True, eq=False)
class Region:
    """Connected cells that are level, and the plane through them."""

    cells: np.ndarray  # (X, Y) bool
    room: np.ndarray  # (X, Y) metres from the middle of each cell to the edge of the region
    plane: np.ndarray  # (3,): height = plane @ (x, y, 1)

    @property
    def normal(self) -> np.ndarray:
        """The upward unit normal (3,)."""
        return normal_of(self.plane)

    @property
    def slope_deg(self) -> float:
        """The slope of the plane."""
        return float(np.degrees(np.arccos(self.normal[2])))

    def height_at(self, xy: np.ndarray) -> np.ndarray:
        """Return the plane's height at places (..., 2)."""
        return xy @ self.plane[:2] + self.plane[2]


def normal_of(plane: np.ndarray) -> np.ndarray:
    """Return the upward normal (3,) of a plane (3,), see `Region`."""
    normal = np.array([-plane[0], -plane[1], 1.0])
    return normal / np.linalg.norm(normal)


def level_regions(surface: HeightMap, least_radius: float, lowest: float) -> list[Region]:
    """Return the level regions in which a disc fits, the largest first.

    Parameters
    ----------
    least_radius : float, metres
    lowest : float, metres
        Lower cells are the ground.
    """
    flat = flat_cells(surface) & (surface.heights > lowest)
    labels, count = ndimage.label(flat)
    room = surface.cell * (ndimage.distance_transform_edt(flat) - 0.5)
    roomy = ndimage.maximum(room, labels, np.arange(1, count + 1)) if count else np.empty(0)
    every = [labels == 1 + k for k in np.flatnonzero(np.asarray(roomy) >= least_radius)]
    regions = [Region(cells, np.where(cells, room, 0.0), plane_through(surface, cells)) for cells in every]
    level = [region for region in regions if region.slope_deg <= SLOPE_DEG]
    return sorted(level, key=lambda region: -int(region.cells.sum()))


def flat_cells(surface: HeightMap) -> np.ndarray:
    """Return the cells (X, Y) bool whose neighbours, also diagonal ones, are about as high; edges are excluded."""
    low = ndimage.minimum_filter(surface.heights, 3, mode="constant", cval=-np.inf)
    high = ndimage.maximum_filter(surface.heights, 3, mode="constant", cval=-np.inf)
    with np.errstate(invalid="ignore"):
        return (high - low <= rise_of(surface, SLOPE_DEG)) & np.isfinite(low)


def rise_of(surface: HeightMap, slope_deg: float) -> float:
    """Return by how much a cell's neighbours, also diagonal ones, differ in height at most on a slope, metres."""
    return 2 * surface.cell * np.sqrt(2) * np.tan(np.radians(slope_deg)) + surface.rough


SEAT_CELL = 0.025  # metres
HAND = 0.09  # metres: a hand's breadth
STEEP_DEG = 30.0  # steepest slope that carries a person
WHOLE = 0.5  # least share of a hand's breadth that carries


def whole_cells(surface: HeightMap, middles: np.ndarray) -> np.ndarray:
    """Return the places (..., 2) bool where a surface carries on most of a hand's breadth, unlike spikes.

    Gaps, as between slats, do not count, since they are not too steep.
    """
    seen, heights = np.isfinite(surface.heights), surface.heights
    low = ndimage.minimum_filter(np.where(seen, heights, np.inf), 3)
    high = ndimage.maximum_filter(np.where(seen, heights, -np.inf), 3)
    with np.errstate(invalid="ignore"):
        gentle = seen & (high - low <= rise_of(surface, STEEP_DEG))
    share = [ndimage.uniform_filter(cells.astype(float), across_hand(surface)) for cells in (gentle, seen)]
    whole = share[0] >= WHOLE * share[1]
    at = np.floor((middles - surface.origin) / surface.cell).astype(int)
    return whole[tuple(np.moveaxis(np.clip(at, 0, np.array(whole.shape) - 1), -1, 0))]


def across_hand(surface: HeightMap) -> int:
    """Return how many cells a hand is broad, an odd number."""
    return 2 * int(HAND / 2 / surface.cell) + 1


FINGER = 0.01  # metres: what stands out by more can be felt
SAME_SURFACE = 0.25  # metres: what is farther above or below is another part of the object, as the ground between slats


def spiky_share(surface: HeightMap) -> float:
    """Return the share of the largest part that stands out or lies deep, compared with a hand's breadth around it.

    A part consists of connected cells; the medians of a hand's breadth around them are no steeper than what carries a
    person. What lies on a seat, slats, cushions and slopes leave most cells near these medians, and spikes do not.
    """
    medians, apart = medians_of(surface, across_hand(surface))
    gentle = ndimage.maximum_filter(medians, 3) - ndimage.minimum_filter(medians, 3) <= rise_of(surface, STEEP_DEG)
    labels, count = ndimage.label(gentle & (medians > 0) & (apart < SAME_SURFACE) & np.isfinite(surface.heights))
    if count == 0:
        return 0.0
    return float(np.mean(apart[labels == 1 + np.argmax(np.bincount(labels.ravel())[1:])] > FINGER))


def medians_of(surface: HeightMap, across: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the medians (X, Y) of so many cells across around each cell, and how far each cell is from its median."""
    heights = np.where(np.isfinite(surface.heights), surface.heights, 0.0)
    medians = ndimage.median_filter(heights, across)
    return medians, np.abs(heights - medians)


def level_breadth(surface: HeightMap, slope_deg: float, lowest: float, highest: float) -> float:
    """Return how broad the largest disc is on a surface between two heights that is no steeper than a slope, metres.

    The slope is that of the medians of half a hand's breadth, from which cells differ by less than twice `FINGER`.
    """
    medians, apart = medians_of(surface, across_hand(surface) // 2 + 1)
    slopes = np.hypot(*np.gradient(ndimage.uniform_filter(medians, 3), surface.cell))
    level = (slopes <= np.tan(np.radians(slope_deg))) & (apart < 2 * FINGER)
    level &= (medians > lowest) & (medians < highest)
    return 2 * surface.cell * float(ndimage.distance_transform_edt(np.pad(level, 1)).max() - 0.5)


def seat_surface(cloud: Cloud, fine: HeightMap | None = None) -> HeightMap:
    """Return a surface in cells for a sitter; ``whole`` is computed on the surface in finer cells."""
    coarse = surface_of(cloud, SEAT_CELL)
    middles = coarse.middles(np.moveaxis(np.indices(coarse.heights.shape), 0, -1))
    return replace(coarse, whole=whole_cells(surface_of(cloud) if fine is None else fine, middles))


def plane_through(surface: HeightMap, cells: np.ndarray) -> np.ndarray:
    """Return the least-squares plane (3,) through cells of a surface."""
    where = np.argwhere(cells)
    across = np.column_stack([surface.middles(where), np.ones(len(where))])
    return np.linalg.lstsq(across, surface.heights[cells], rcond=None)[0]


def rings_of(surface: HeightMap, cells: np.ndarray, plane: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the outline of the largest connected part of cells and its holes, rings (K, 3) on a plane, metres."""
    from contourpy import FillType, contour_generator

    generator = contour_generator(z=np.pad(cells, 1).astype(float).T, fill_type=FillType.OuterOffset)
    shapes, offsets = generator.filled(0.5, 2.0)
    if not shapes:
        return ()
    largest = max(range(len(shapes)), key=lambda k: abs(doubled_area(shapes[k][: offsets[k][1]])))
    parts = [shapes[largest][a:b] for a, b in zip(offsets[largest][:-1], offsets[largest][1:], strict=True)]
    return tuple(on_plane(surface.middles(simplified(part[:-1]) - 1), plane) for part in parts)


def doubled_area(ring: np.ndarray) -> float:
    """Return twice the signed area of a ring (K, 2)."""
    return float(np.sum(ring[:, 0] * np.roll(ring[:, 1], -1) - ring[:, 1] * np.roll(ring[:, 0], -1)))


def simplified(ring: np.ndarray) -> np.ndarray:
    """Return a ring (K, 2) without the points on straight lines between others."""
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    turns = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]) > 1e-9
    return ring[turns] if turns.sum() >= 3 else ring


def on_plane(xy: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """Return places (K, 2) as points (K, 3) of a plane."""
    return np.column_stack([xy, xy @ plane[:2] + plane[2]])
