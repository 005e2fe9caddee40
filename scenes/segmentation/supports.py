"""What stands on a table top or is pushed against it, and is an object of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..scans.cells import cells
from .clusters import Box, bounding_box, euclidean_clusters, members_of

_BIN = 0.01  # metres, of the heights that are compared
_BOARD = 6  # bins that a table top may be thick
_SIDES = 0.6  # of its lower side's area that its upper one has at least
_AROUND = 10  # bins to either side that show how much of a height is upright
_CELL = 0.05  # metres: a top fills cells of that side, while the sides of objects only cross them
_FILLED = 0.42  # of such a cell: two rows of voxels, as a chair and the very edge of a top make, are not enough
_OVER = 10  # bins above a top in which what crosses it goes on
_APART = 0.12  # metres between the middles of cells of two tops of one height
_CLEAR = 0.015  # metres above the top at which another object begins, noise apart
_MOST_CLEAR = 0.04  # metres, however noisy
_GAP = 0.05  # metres: what begins higher above the top does not stand on it
_INSIDE = 0.02  # metres from the top's edge
_AREA = 0.12  # square metres: the least of a top, or of a seat
_SMALL = 0.4  # of a seat's area: what is larger is part of the seat
_TABLE_AREA, TABLE_HEIGHT = 0.25, 0.6  # square metres and metres: from there on a top is no seat
_SPANS = 0.7  # of a top's side: what rises from its edge and is as wide is its own back, or a desk's shelf
_FEWEST = 10  # voxels of an object


@dataclass(frozen=True, kw_only=True, eq=False)
class Top:
    """A level surface that objects can stand on."""

    height: float  # metres
    equations: np.ndarray  # (E, 3) of its outline's edges: negative inside
    area: float  # of its outline, and of those of the same height, square metres
    box: Box  # around it

    @property
    def is_table(self) -> bool:
        """Whether it is too large or too high for a seat, so that nothing above it is its own back."""
        return self.area >= _TABLE_AREA and self.height >= TABLE_HEIGHT

    def outside(self, points: np.ndarray) -> np.ndarray:
        """Return how far points (N, 3) lie outside the outline seen from above, metres, negative inside."""
        return (points[:, :2] @ self.equations[:, :2].T + self.equations[:, 2]).max(axis=1)


def split_off(points: np.ndarray, cluster_of: np.ndarray, tolerance: float, noise: float = 0.0) -> np.ndarray:
    """Return clusters (N,) int32 in which what stands on a level top, or leans on it, is parted from it.

    A cup on a table touches it, as does a chair pushed against it, and clusters by distance alone hold all of them.
    The back of a chair rises from the edge of its seat, and stays with it.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
        Voxels of a centimetre or so.
    cluster_of : (N,) int32
        Clusters by distance.
    tolerance : float
        As for the clusters, metres.
    noise : float
        Standard deviation of level surfaces, metres.
    """
    cluster_of, clusters = cluster_of.copy(), members_of(cluster_of)
    new = len(clusters)
    clear = min(max(_CLEAR, 2.5 * noise), _MOST_CLEAR)
    for members in clusters:
        if len(members) < _AREA / _BIN**2 / 4:  # too few for a top
            continue
        for part in standing_apart(points[members], tolerance, clear):
            cluster_of[members[part]] = new
            new += 1
    return cluster_of


def standing_apart(points: np.ndarray, tolerance: float, clear: float) -> list[np.ndarray]:
    """Return the indices of each object that a level top of one cluster (N, 3) carries or that leans on it."""
    parts = []
    left = np.ones(len(points), bool)
    for top in tops(points, clear):
        above = points[:, 2] > top.height + clear
        outside = top.outside(points)
        apart = np.flatnonzero(left & (above | (outside > clear / 2) if top.is_table else above))
        clusters = euclidean_clusters(points[apart], tolerance)
        for item in (apart[members] for members in members_of(clusters)):
            if not above[item].any():
                continue  # a leg that spreads outward
            # Crumbs over a table are noise, and would make it higher than it is.
            if top.is_table if len(item) < _FEWEST else stands_apart(points[item], outside[item], top):
                parts.append(item)
                left[item] = False
    return parts


def stands_apart(item: np.ndarray, outside: np.ndarray, top: Top) -> bool:
    """Return whether an object (T, 3), at distances (T,) outside a top's outline, is no part of what has the top."""
    if not top.is_table:
        return stands_within(item, outside, top)
    if outside.max() < -_INSIDE:
        return True
    own = bounding_box(item)
    along = abs(np.cos(own.yaw - top.box.yaw)) > np.sqrt(0.5)
    return bool(own.size[0] < _SPANS * top.box.size[0 if along else 1])


def stands_within(item: np.ndarray, outside: np.ndarray, top: Top) -> bool:
    """Return whether an object (T, 3) stands on a seat, away from its edges, and is small beside it."""
    foot = item[:, 2] < item[:, 2].min() + 2 * _GAP
    area = np.prod(np.ptp(item[:, :2], axis=0))
    near = item[:, 2].min() <= top.height + _GAP
    return bool(near and area < _SMALL * top.area and outside[foot].max() < -_INSIDE)


def tops(points: np.ndarray, clear: float = _CLEAR) -> list[Top]:
    """Return the large level tops among voxels (N, 3), from the highest.

    A level surface puts its whole area into one or two bins of height, upright ones a little into each.
    """
    lowest = np.floor(points[:, 2].min() / _BIN)
    bins = (np.floor(points[:, 2] / _BIN) - lowest).astype(int)
    width = 1 + int(clear > 1.5 * _CLEAR)
    area = np.convolve(np.bincount(bins), np.ones(2 * width + 1))[width:-width] * _BIN**2
    surfaces = []
    while area[largest := int(np.argmax(area))] >= _AREA:
        # A board has an upper and a lower side, and objects stand on the upper one.
        peak = max(k for k in range(largest, min(largest + _BOARD, len(area))) if area[k] >= _SIDES * area[largest])
        around = area[max(0, peak - _AROUND) : peak + _AROUND + 1]
        if area[peak] - np.median(around) >= _AREA / 2:
            over = (bins > peak + width) & (bins <= peak + width + _OVER)
            surfaces += tops_at(points[np.abs(bins - peak) <= width], points[over])
        area[max(0, largest - 3) : peak + 4] = 0
    return sorted(surfaces, key=lambda top: -top.height)


def tops_at(slab: np.ndarray, over: np.ndarray) -> list[Top]:
    """Return the tops that a slice (N, 3) of voxels holds; of two tables of one height each is one.

    Where as much lies over (M, 3) the slice as in it something taller crosses it: a chair's back at a table's edge.
    """
    from scipy.spatial import ConvexHull

    columns = cells(slab * [1, 1, 0], _BIN)  # an upright side has many voxels but few columns
    grid, above = cells(columns.means, _CELL), cells(cells(over * [1, 1, 0], _BIN).means, _CELL)
    filled = grid.counts >= _FILLED * (_CELL / _BIN) ** 2
    filled &= ~np.isin(grid.keys, above.keys[above.counts >= _FILLED * (_CELL / _BIN) ** 2])
    top_of_cell = np.full(len(filled), -1)
    top_of_cell[filled] = euclidean_clusters(grid.means[filled], _APART)
    number = top_of_cell[grid.cell_of[columns.cell_of]]
    areas = np.bincount(top_of_cell[filled]) * _CELL**2
    slabs = [slab[number == k] for k in np.flatnonzero(areas >= _AREA)]
    hulls = [ConvexHull(points[:, :2]) for points in slabs]
    together = float(sum(hull.volume for hull in hulls))  # a shadow may cut the top of one table in two
    return [
        Top(height=float(np.median(points[:, 2])), equations=hull.equations, area=together, box=bounding_box(points))
        for points, hull in zip(slabs, hulls, strict=True)
        if hull.volume >= _AREA
    ]


def top_below(own: int, parts: list[np.ndarray], lows: np.ndarray, highs: np.ndarray) -> float:
    """Return the height of the level top that an object stands on, 0 for the floor, metres.

    What carries an object reaches as far as it does: a table stands on the floor, though its pillar be a piece apart.

    Parameters
    ----------
    own : int
        The object.
    parts : list of (N, 3) float64, metres, level frame
        The points of all objects.
    lows, highs : (K, 3) float64, metres
        Their lowest and highest corners.
    """
    low, high, best = lows[own], highs[own], 0.0
    if low[2] < _GAP:
        return best
    reaches = (lows[:, :2] <= low[:2] + _GAP) & (highs[:, :2] >= high[:2] - _GAP)
    begins = (lows[:, 2] < low[2] + _CLEAR) & (highs[:, 2] > low[2] - _GAP)
    for k in np.flatnonzero(reaches.all(axis=1) & begins):
        other = parts[k]
        under = other[(other[:, 2] < low[2] + _CLEAR) & (other[:, 2] > low[2] - _GAP)]
        under = under[((under[:, :2] > low[:2] - _GAP) & (under[:, :2] < high[:2] + _GAP)).all(axis=1)]
        if k != own and len(under) >= _FEWEST and np.ptp(under[:, :2], axis=0).min() > 0:
            best = max(best, float(np.median(under[:, 2])))
    return best
