"""Pieces of one object that the sensor saw apart, joined again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.clouds.cloud import corners_of

from ..scans.cells import Near
from .clusters import Box, bounding_box, members_of
from .walls import Wall

_FEWEST = 10  # voxels: what is smaller is noise
_REACH = 0.12  # metres: the widest gap that is bridged
_STANDS = 0.06  # metres above the ground: what begins lower stands on it
_BASE = 0.15  # metres: what stands on something lower stands on its own base, such as a lamp's
_SLENDER = 0.08  # of a top's footprint: a leg, or a pillar; a chair below a table is larger
_REACHES = 0.4  # of the height of a top that its legs are seen to reach at least
_LEG, _UPRIGHT = 0.2, 2.0  # metres: the widest leg; how many times as high as wide a piece of it is at least
_SEAT = 0.75  # metres: what is wider is no chair
_UNDER = 0.05  # metres below a piece in which something carries it
_FOOT = 0.01  # metres around what is seen of a foot: a stemmed glass's went with the top that it stands on
_WITHIN = 0.5  # of a piece that lies over or under another's outline, for the two to be one
_MARGIN = 0.03  # metres that the outline is widened by
_PROBES = 100  # points of a piece that are looked at for that
_HANGS = 0.06  # metres from a wall: what is nearer and stands on nothing hangs on it,
_LOW, _DEEP = 0.6, 0.35  # metres: unless it begins so low and reaches out so far, as an armchair does, its foot hidden
_VESSEL = 0.35  # metres: the largest vessel
_LEVEL_RIM = 0.02  # metres by which the rim of two pieces of a vessel may differ
_SAME_WIDTH = 1.25  # of the wider piece's width: both sides of one vessel are as wide as it is
_HIDDEN = 0.06  # metres: how much more of the near side is hidden, behind what stands in front
_OPEN = 0.3  # of the middle between two pieces: as much ground seen there parts them
_BOTTOM = 0.003  # metres above the ground: a vessel's own bottom, seen within it


@dataclass(frozen=True, kw_only=True, eq=False)
class Piece:
    """A cluster."""

    number: int
    points: np.ndarray  # (N, 3) float64, metres, level frame
    low: np.ndarray  # (3,) metres
    high: np.ndarray

    @classmethod
    def from_points(cls, number: int, points: np.ndarray) -> Piece:
        low, high = corners_of(points)
        return cls(number=number, points=points, low=low, high=high)


def join_pieces(
    points: np.ndarray, cluster_of: np.ndarray, wall: np.ndarray, ground: np.ndarray, walls: Sequence[Wall] = ()
) -> np.ndarray:
    """Return clusters (N,) int32 in which pieces of one object are one; -1 for what hangs on a wall.

    What neither stands nor is carried by anything belongs to the object right above, below or around it. The near and
    the far side of a cup, whose bottom is not seen, belong together.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    cluster_of : (N,) int32
        Clusters, numbered from 0.
    wall, ground : (W, 3), (G, 3) float64, metres
        Voxels of walls and of the ground.
    walls : sequence of Wall
        Their planes.
    """
    pieces = [Piece.from_points(number, points[members]) for number, members in enumerate(members_of(cluster_of))]
    links, hanging = vessel_sides(pieces, ground), []
    near_wall, along_x = Near(wall, _HANGS), np.argsort(points[:, 0], kind="stable")
    x = points[along_x, 0]
    lows, highs = (np.array([getattr(piece, end) for piece in pieces]).reshape(-1, 3) for end in ("low", "high"))
    for piece in pieces:
        if len(piece.points) < _FEWEST:
            continue
        if piece.low[2] < _STANDS:
            links += [(piece.number, whole) for whole in whole_of_leg(piece, pieces, lows, highs)]
            continue
        first, last = np.searchsorted(x, [piece.low[0] - _REACH, piece.high[0] + _REACH])
        near = points_around(piece, points, along_x[first:last])
        near = near[cluster_of[near] != piece.number]
        carried = is_carried(piece, points[near])
        if carried and piece.low[2] > _BASE:
            continue
        whole = whole_of(piece, points[near], cluster_of[near])
        if not carried and hangs(piece, near_wall) and not reaches_out(piece, walls):
            hanging.append(piece.number)
        elif whole is not None:
            links.append((piece.number, whole))
        if not carried:
            links += [(piece.number, leg) for leg in legs_of(piece, lows, highs)]
    return wholes_of(len(pieces), links, hanging)[cluster_of] if pieces else cluster_of


def wholes_of(count: int, links: list[tuple[int, int]], hanging: list[int]) -> np.ndarray:
    """Return the number of the whole (K,) int64 for each of a count of pieces, -1 for those that hang."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    pairs = np.array(links, np.int64).reshape(-1, 2)
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))
    wholes = connected_components(graph, directed=False)[1].astype(np.int64)
    wholes[hanging] = -1
    return wholes


def legs_of(piece: Piece, lows: np.ndarray, highs: np.ndarray) -> list[int]:
    """Return the slender pieces, of corners (K, 3), below one that nothing carries: its legs, or its pillar."""
    within = (lows[:, :2] > piece.low[:2] - _MARGIN) & (highs[:, :2] < piece.high[:2] + _MARGIN)
    below = (highs[:, 2] > _REACHES * piece.low[2]) & (highs[:, 2] < piece.low[2] + _MARGIN)
    slender = np.prod(highs[:, :2] - lows[:, :2], axis=1) < _SLENDER * np.prod(piece.high[:2] - piece.low[:2])
    return [int(k) for k in np.flatnonzero(within.all(axis=1) & below & slender) if k != piece.number]


def whole_of_leg(piece: Piece, pieces: list[Piece], lows: np.ndarray, highs: np.ndarray) -> list[int]:
    """Return the piece, of all those of corners (K, 3), whose leg or base one on the floor is, if there is any.

    Of a table seen from above what joins a leg to the top is often hidden, or too thin to be seen. Under a table there
    may be other objects, but hardly flat ones; under a chair there is room for none.
    """
    size = piece.high - piece.low
    is_leg = size[:2].max() < _LEG and size[2] > _UPRIGHT * size[:2].max()
    around = (lows[:, :2] < piece.low[:2] + _MARGIN) & (highs[:, :2] > piece.high[:2] - _MARGIN)
    footprints = np.prod(highs[:, :2] - lows[:, :2], axis=1)
    larger = footprints > np.prod(size[:2]) / _SLENDER
    if not is_leg and size[2] < _BASE:
        larger = footprints > np.prod(size[:2])
    elif not is_leg:
        larger = (footprints > np.prod(size[:2])) & ((highs - lows)[:, :2].max(axis=1) < _SEAT)
    for k in np.flatnonzero(around.all(axis=1) & larger & (highs[:, 2] > piece.high[2])):
        above = pieces[k].points[pieces[k].points[:, 2] > piece.high[2] - _MARGIN, :2]
        near = (above > piece.low[:2] - _MARGIN) & (above < piece.high[:2] + _MARGIN)
        if near.all(axis=1).sum() >= _FEWEST:
            return [int(k)]
    return []


def hangs(piece: Piece, wall: Near) -> bool:
    """Return whether a piece comes near a wall."""
    return bool(wall.to(piece.points[:: -(-len(piece.points) // _PROBES)]).any())


def reaches_out(piece: Piece, walls: Sequence[Wall]) -> bool:
    """Return whether a piece is low and reaches far into the room from all walls: furniture with its back to one."""
    depths = [np.percentile(wall.ahead(piece.points), 90) for wall in walls]
    return bool(depths) and bool(piece.low[2] < _LOW and min(depths) > _DEEP)


def points_around(piece: Piece, points: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Return the indices of those among the chosen points (N, 3) that lie within reach of a piece's sides and ends."""
    inside = np.ones(len(chosen), bool)
    for axis in (1, 2):
        column = points[chosen, axis]
        inside &= (column > piece.low[axis] - _REACH) & (column < piece.high[axis] + _REACH)
    return np.sort(chosen[inside])


def is_carried(piece: Piece, near: np.ndarray) -> bool:
    """Return whether something (N, 3) is right below the lowest part of a piece."""
    bottom = piece.low[2]
    foot = piece.points[piece.points[:, 2] < bottom + _UNDER]
    low, high = foot[:, :2].min(axis=0) - _FOOT, foot[:, :2].max(axis=0) + _FOOT
    below = near[(near[:, 2] < bottom + 0.01) & (near[:, 2] > bottom - _UNDER)]
    return bool(((below[:, :2] > low) & (below[:, :2] < high)).all(axis=1).sum() >= 3)


def whole_of(piece: Piece, near: np.ndarray, cluster_of: np.ndarray) -> int | None:
    """Return the nearest larger cluster within reach over or under whose outline a piece lies."""
    from scipy.spatial import cKDTree

    if not len(near):
        return None
    distances = cKDTree(piece.points).query(near, distance_upper_bound=_REACH)[0]
    best, nearest = None, _REACH
    for number in np.unique(cluster_of[distances < _REACH]):
        other = near[cluster_of == number]
        low, high = other[:, :2].min(axis=0) - _MARGIN, other[:, :2].max(axis=0) + _MARGIN
        within = ((piece.points[:, :2] > low) & (piece.points[:, :2] < high)).all(axis=1).mean()
        distance = distances[cluster_of == number].min()
        if within >= _WITHIN and distance < nearest:
            best, nearest = int(number), distance
    return best


def vessel_sides(pieces: list[Piece], ground: np.ndarray) -> list[tuple[int, int]]:
    """Return pairs of pieces that are two sides of one vessel: of one height and width, and no ground between them."""
    small = [piece for piece in pieces if len(piece.points) >= 10 and (piece.high - piece.low).max() < _VESSEL]
    lows, highs = (np.array([getattr(piece, end) for piece in small]).reshape(-1, 3) for end in ("low", "high"))
    rims = np.abs(highs[:, None, 2] - highs[:, 2]) < _LEVEL_RIM
    feet = np.abs(lows[:, None, 2] - lows[:, 2]) < _HIDDEN
    gaps = np.maximum(lows[:, None] - highs, lows - highs[:, None])[..., :2].max(axis=-1, initial=-np.inf)
    likely = np.argwhere(np.tril(rims & feet & (gaps < _REACH), -1))
    boxes = {k: bounding_box(small[k].points) for k in np.unique(likely).tolist()}
    return [
        (small[one].number, small[other].number)
        for one, other in likely.tolist()
        if are_sides(small[one], small[other], [boxes[one], boxes[other]], ground)
    ]


def are_sides(one: Piece, other: Piece, parts: Sequence[Box], ground: np.ndarray) -> bool:
    """Return whether two pieces together are as wide as one of them, rounder than both, and closed to the ground."""
    both = bounding_box(np.vstack([one.points, other.points]))
    if both.size[0] > min(_SAME_WIDTH * max(part.size[0] for part in parts), _VESSEL):
        return False
    if both.size[1] / both.size[0] <= max(part.size[1] / part.size[0] for part in parts):
        return False
    radius = both.size[1] / 4
    seen = ground[np.linalg.norm(ground[:, :2] - both.center[:2], axis=1) < radius, 2]
    return bool(len(seen) * 1e-4 < _OPEN * np.pi * radius**2 or np.median(seen) > _BOTTOM)
