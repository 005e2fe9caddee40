"""Convex pieces that stay out of the free space that the function of an object needs.

The surface is cut by planes until no part's convex hull covers surface that a sphere can reach by more than a
tolerance; then neighbours whose common hull also stays within the tolerance are joined again. So pieces are used where
they are needed, the mesh need not be closed, and space that nothing can reach is filled. (Approximate convex
decomposition: Lien and Amato, 2007; Wei et al., 2022, whose concavity does not depend on the function.)
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ..processes.compilation import njit
from .solid import thickened

MOST = 400  # pieces
ASIDE = 0.25  # cosine of the largest angle between the normal of a hull's face and the way out of a place
TURNS = 4  # vertical planes through the middle, in addition to those along the axes
Corners = np.ndarray  # (K, 3)


@dataclass(frozen=True, kw_only=True, eq=False)
class ExposedSurface:
    """Places of a surface that a sphere can reach, each with the direction out into the free space."""

    places: np.ndarray  # (S, 3) metres
    outward: np.ndarray  # (S, 3) unit vectors; zero for places in the free space itself, which any direction leaves
    tolerance: np.ndarray  # (S,) metres by which a hull may cover a place
    reach: np.ndarray  # (S,) metres: radius of a place
    clear: np.ndarray  # (S,) metres of the way out that must stay free; 0: only the place itself

    def excess(self, hull: Hull) -> tuple[np.ndarray, np.ndarray]:
        """Return the places (K,) that a hull covers beyond their tolerance, and by how many tolerances (K,)."""
        ways = ways_out(self.places, self.outward, self.reach, self.clear, *ends(hull.corners), hull.planes)
        covered = ways / self.tolerance
        which = np.flatnonzero(covered > 1)
        return which, covered[which]


@dataclass(frozen=True, eq=False)
class Hull:
    """A convex hull."""

    corners: Corners
    planes: np.ndarray  # (F, 4), their normals outward


def hull_around(points: np.ndarray) -> Hull:
    """Return the hull of points (N, 3); for flat ones, that of a thin slab."""
    try:
        hull = ConvexHull(points)
        return Hull(points[hull.vertices], hull.equations)
    except (QhullError, ValueError):
        points = np.unique(points, axis=0)
        return Hull(points, ConvexHull(thickened(points), qhull_options="QJ").equations)


def ends(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest corner of the bounding box of points (N, 3)."""
    return points.min(axis=0), points.max(axis=0)


@njit(cache=True, error_model="numpy")
def ways_out(places, outward, reach, clear, low, high, planes):
    """Return how far outward the surface of a hull is from each place (S,) inside it; 0 for places outside.

    A place whose way out must stay clear leaves along this way only, also through a hull that hovers above it; other
    places leave through any face that points outward.
    """
    ways = np.zeros(len(places))
    for n in range(len(places)):
        x, y, z, slack = places[n, 0], places[n, 1], places[n, 2], reach[n]
        beside = slack + clear[n]
        if not (low[0] - beside < x < high[0] + beside and low[1] - beside < y < high[1] + beside):
            continue
        enters, leaves, aside, depth = 0.0, np.inf, np.inf, -np.inf
        for f in range(len(planes)):
            a, b, c = planes[f, 0], planes[f, 1], planes[f, 2]
            height = a * x + b * y + c * z + planes[f, 3] - slack
            speed = a * outward[n, 0] + b * outward[n, 1] + c * outward[n, 2]
            if height >= 1e-9:
                enters = max(enters, -height / speed) if speed < -1e-6 else np.inf
                if enters > clear[n]:
                    break
            elif speed > 1e-6:
                leaves = min(leaves, -height / speed)
            if speed > ASIDE:
                aside = min(aside, -height)
            depth = max(depth, height)
        if enters <= clear[n] and enters < leaves:
            if clear[n] > 0:
                ways[n] = leaves
            else:
                ways[n] = aside if aside < np.inf else -depth
    return ways


@dataclass(frozen=True, eq=False)
class SurfacePart:
    """A part of the surface, cut out by planes."""

    triangles: np.ndarray  # (T, 3, 3)
    hull: Hull
    which: np.ndarray  # (K,) places that it covers
    covered: np.ndarray  # (K,) by how many tolerances


def taken_space(covered: np.ndarray) -> float:
    """Return a measure of the free space that a hull takes if it covers places (K,) by so many tolerances."""
    return float(np.minimum(covered, 50).sum())


def part_of(triangles: np.ndarray, exposed: ExposedSurface) -> SurfacePart:
    """Return a part of the surface with its hull."""
    hull = hull_around(triangles.reshape(-1, 3))
    return SurfacePart(triangles, hull, *exposed.excess(hull))


def cut(
    parts: Iterable[np.ndarray], exposed: ExposedSurface, enough: Callable[[], bool], most: int = MOST
) -> list[SurfacePart]:
    """Return parts of a surface that take none of the free space, cut out of parts (T, 3, 3) of its triangles.

    The part that takes most is cut next, until none takes any, there are too many, or ``enough`` returns True.
    """
    whole = [part_of(triangles, exposed) for triangles in parts]
    waiting = [(-taken_space(part.covered), number, part) for number, part in enumerate(whole)]
    heapq.heapify(waiting)
    done, number = [], len(waiting)
    while waiting:
        cost, _, part = heapq.heappop(waiting)
        goes_on = cost < 0 and len(waiting) + len(done) < most and not enough()
        halves = best_cut(part, exposed) if goes_on else None
        if halves is None:
            done.append(part)
            continue
        for half in halves:
            number += 1
            heapq.heappush(waiting, (-taken_space(half.covered), number, half))
    return done


def best_cut(part: SurfacePart, exposed: ExposedSurface) -> list[SurfacePart] | None:
    """Return the two parts that together take the least of the free space; None if no plane cuts."""
    best, chosen, low = np.inf, None, max(np.ptp(part.hull.corners, axis=0).max() * 1e-4, 1e-9)
    for normal, offset in planes_for(part, exposed):
        height = part.triangles @ normal - offset
        if height.min() > -low or height.max() < low:
            continue
        sides = [clipped(part.triangles, sign * height) for sign in (1, -1)]
        halves = halves_within(best, sides, exposed) if all(map(len, sides)) else None
        if halves is None:
            continue
        cost = sum(taken_space(half.covered) for half in halves)
        cost += 1e-3 * sum(float(np.linalg.norm(np.ptp(half.hull.corners, axis=0))) for half in halves) / low * 1e-4
        if cost < best:
            best, chosen = cost, halves
    return chosen


def halves_within(most: float, sides: list[np.ndarray], exposed: ExposedSurface) -> list[SurfacePart] | None:
    """Return the parts of two sides (T, 3, 3); None if one takes ``most`` or more of the free space.

    The larger side is first, since hulls cost most of the time: if it takes too much, the other's is not needed.
    """
    halves = {}
    for number in sorted((0, 1), key=lambda number: -len(sides[number])):
        halves[number] = part_of(sides[number], exposed)
        if taken_space(halves[number].covered) >= most:
            return None
    return [halves[0], halves[1]]


def planes_for(part: SurfacePart, exposed: ExposedSurface) -> Iterator[tuple[np.ndarray, float]]:
    """Yield planes to cut a part: along the surface where the hull covers it most, and through the middle."""
    order = np.argsort(-part.covered)
    order = order[exposed.outward[part.which[order]].any(axis=1)]
    seen: list[np.ndarray] = []
    for n in order[: min(len(order), 400)]:
        normal, place = exposed.outward[part.which[n]], exposed.places[part.which[n]]
        if any(abs(normal @ other) > 0.95 for other in seen):
            continue
        seen.append(normal)
        yield normal, float(normal @ place)
        if len(seen) == 4:
            break
    low, high = ends(part.hull.corners)
    middle, places = (low + high) / 2, exposed.places[part.which]
    deep = np.average(places, axis=0, weights=part.covered)
    for axis in np.eye(3):
        yield axis, float(axis @ middle)
        yield axis, float(axis @ deep)
    away = part.hull.corners - part.hull.corners.mean(axis=0)
    axes = np.linalg.eigh(away.T @ away)[1].T  # defined even for a single corner
    for axis in axes:
        yield axis, float(axis @ middle)
    for angle in np.pi * (np.arange(TURNS) + 0.5) / TURNS:
        axis = np.array([np.cos(angle), np.sin(angle), 0.0])
        yield axis, float(axis @ middle)


def clipped(triangles: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return the part of triangles (T, 3, 3) where a height (T, 3), linear on each, is positive, as triangles."""
    above = height >= 0
    count = above.sum(axis=1)
    pieces = [triangles[count == 3]]
    for corners in (1, 2):
        cut = np.flatnonzero(count == corners)
        if not len(cut):
            continue
        lone = np.argmax(above[cut] == (corners == 1), axis=1)
        turn = (lone[:, None] + np.arange(3)) % 3
        points = np.take_along_axis(triangles[cut], turn[:, :, None], axis=1)
        heights = np.take_along_axis(height[cut], turn, axis=1)
        share = heights[:, :1] / (heights[:, :1] - heights[:, 1:])
        ends = points[:, :1] + share[:, :, None] * (points[:, 1:] - points[:, :1])
        if corners == 1:
            pieces.append(np.concatenate([points[:, :1], ends], axis=1))
        else:
            pieces.append(np.stack([points[:, 1], points[:, 2], ends[:, 1]], axis=1))
            pieces.append(np.stack([points[:, 1], ends[:, 1], ends[:, 0]], axis=1))
    return np.concatenate(pieces)


def joined(parts: Sequence[SurfacePart], exposed: ExposedSurface, enough: Callable[[], bool]) -> list[Corners]:
    """Return the convex pieces of parts; pairs whose common hull takes no more free space are joined."""
    pieces: list[Corners | None] = [part.hull.corners for part in parts]
    costs = [float(part.covered.sum()) for part in parts]
    waiting = [pair for a in range(len(pieces)) for pair in pairs_with(pieces, a, a)]
    heapq.heapify(waiting)
    while waiting and not enough():
        _, a, b = heapq.heappop(waiting)
        if pieces[a] is None or pieces[b] is None:
            continue
        hull = hull_around(np.concatenate([pieces[a], pieces[b]]))
        cost = float(exposed.excess(hull)[1].sum())
        if cost > costs[a] + costs[b] + 1e-9:
            continue
        pieces[a] = pieces[b] = None
        pieces.append(hull.corners)
        costs.append(cost)
        for pair in pairs_with(pieces, len(pieces) - 1, len(pieces) - 1):
            heapq.heappush(waiting, pair)
    return [piece for piece in pieces if piece is not None]


def pairs_with(pieces: Sequence[Corners | None], a: int, count: int) -> Iterator[tuple[float, int, int]]:
    """Yield the neighbours of piece ``a`` among the first ``count``, with the size of their common bounding box."""
    low, high = ends(pieces[a])
    slack = 0.02 * (high - low).max()
    for b in range(count):
        if pieces[b] is None:
            continue
        other_low, other_high = ends(pieces[b])
        if (other_low <= high + slack).all() and (low <= other_high + slack).all():
            size = np.maximum(high, other_high) - np.minimum(low, other_low)
            yield float(np.linalg.norm(size)), b, a
