"""What carries a thing in its place: found by letting it down along the vertical until it touches.

Things touch where points of their surfaces lie above each other; samples are at most 5 mm from any place of a surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from spherefunc_bullet.clouds.cloud import MAX_GAP
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import format_length
from spherefunc_bullet.simulator.statics.body import moments_of_triangles, surface_of

from .placing import PlacedThing

GROUND = "ground"
TOUCHING = 0.005  # metres between a thing and what carries it, at most: a sampled slope explains as much
COLUMN = 0.01  # metres: of a thing's points in a square of this side, the lowest can be carried


@dataclass(frozen=True, eq=False)
class Feet:
    """The underside of a thing and how far each point of it is above what is below it."""

    points: np.ndarray  # (U, 3) metres, the world's frame
    gaps: np.ndarray  # (U, K + 1) metres to each of the others, and to the ground; infinite where nothing is below

    @property
    def nearest(self) -> float:
        """How far it can be let down, metres."""
        return float(self.gaps.min())

    @property
    def carried(self) -> np.ndarray:
        """Which points touch something, (U,) bool."""
        return self.gaps.min(axis=1) <= TOUCHING

    def carriers(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return what the thing stands on, of the others' names and the ground."""
        touched = (self.gaps <= TOUCHING).any(axis=0)
        return tuple(name for name, carries in zip([*names, GROUND], touched, strict=True) if carries)


def underside(points: np.ndarray) -> np.ndarray:
    """Return the lowest of points (N, 3) in each square column, (U, 3)."""
    order = np.argsort(points[:, 2], kind="stable")
    _, first = np.unique(np.floor(points[order, :2] / COLUMN).astype(np.int64), axis=0, return_index=True)
    return points[order[np.sort(first)]]


def feet_over(thing: PlacedThing, others: Sequence[PlacedThing], from_above: bool) -> Feet:
    """Return a thing's underside and its gaps to the others.

    Parameters
    ----------
    from_above : bool
        Whether the highest point of another counts, wherever the thing is; or the highest below it.
    """
    points = underside(thing.cloud.points)
    gaps = [gaps_to(points, other, thing, from_above) for other in others]
    return Feet(points, np.column_stack([*gaps, points[:, 2]]))


def gaps_to(points: np.ndarray, other: PlacedThing, thing: PlacedThing, from_above: bool) -> np.ndarray:
    """Return how far points (U, 3) are above another thing, (U,) metres; infinite where it is not below them."""
    surface, gaps = other.cloud.points, np.full(len(points), np.inf)
    aside = max(MAX_GAP, other.own.spacing, thing.own.spacing)
    low, high = points[:, :2].min(axis=0) - aside, points[:, :2].max(axis=0) + aside
    surface = surface[((surface[:, :2] >= low) & (surface[:, :2] <= high)).all(axis=1)]
    if not len(surface):
        return gaps
    near = cKDTree(surface[:, :2]).query_ball_point(points[:, :2], aside)
    for number, rows in enumerate(near):
        below = points[number, 2] - surface[rows, 2]
        below = below if from_above else below[below >= -TOUCHING]
        gaps[number] = below.min(initial=np.inf)
    return gaps


def set_down(thing: PlacedThing, others: Sequence[PlacedThing]) -> PlacedThing:
    """Return a thing that was let down from above, until one of the others or the ground carries it."""
    high = thing.at(1.0 + max((other.cloud.bounds[1, 2] for other in others), default=0.0))
    return high.at(high.height - feet_over(high, others, True).nearest)


def require_carried(thing: PlacedThing, others: Sequence[PlacedThing]) -> Feet:
    """Return the feet of a thing in its place.

    Raises
    ------
    InputError
        If nothing carries it there.
    """
    feet = feet_over(thing, others, False)
    if feet.nearest > TOUCHING:
        gap = format_length(round(feet.nearest, 3))
        raise InputError(
            f"{thing.name}: expected something that carries it at {thing.height:g} m, got nothing for {gap} below it; "
            "leave its height out, and it is set down"
        )
    return feet


def tips_by(thing: PlacedThing, feet: Feet) -> float:
    """Return how far a thing's weight acts beyond the polygon of what carries it, metres; below 0 within.

    Its weight is that of its surface, as elsewhere.
    """
    triangles = surface_of(thing.cloud)
    center = (thing.cloud.points.mean(axis=0) if triangles is None else moments_of_triangles(triangles)[1])[:2]
    places = feet.points[feet.carried, :2]
    try:
        polygon = ConvexHull(places)
    except (QhullError, ValueError):  # a point or a line
        return float(np.linalg.norm(places - center, axis=1).min())
    return float((polygon.equations[:, :2] @ center + polygon.equations[:, 2]).max())
