"""What carries an object in its place: it is lowered along the vertical until it touches something.

It stands on what is below it where the two touch. An object that it interpenetrates does not carry it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import format_length
from spherefunc_bullet.simulator.mechanics import LEVEL
from spherefunc_bullet.simulator.statics.body import PATCH, moments_of_triangles, surface_of

from .levels import SUNK, crossing
from .placing import ArrangedObject
from .surfaces import WorldSurface, rise_over

GROUND = "ground"
CONTACT = 5e-4  # metres between places that touch, at most, where surfaces are meshes
SAMPLED = 0.5  # of the spacing, likewise where they are known by points alone
NEAR = (0.005, 0.01, 0.02, 0.05, 1.0)  # metres above contacts: the nearest decides which is above, not a higher board
CLEARLY = 2  # times as many places
GIVEN = 0.005  # metres: the gap that a typed height may leave below an object


@dataclass(frozen=True, eq=False)
class Feet:
    """The places where an object may be carried, and their height above what is below."""

    points: np.ndarray  # (U, 3) metres, the world's frame
    gaps: np.ndarray  # (U, K + 1) metres to each of the others, and to the ground; infinite where that carries nothing
    touch: np.ndarray  # (K + 1,) metres: the largest gap at which two places touch
    level: float  # metres above the lowest contact, up to which places are feet too

    @property
    def nearest(self) -> float:
        """How far the object can be lowered, metres."""
        return float(self.gaps.min())

    @property
    def carried(self) -> np.ndarray:
        """Which points are carried by something, (U,) bool; as in `statics`, feet need not be quite level."""
        slack = max(self.nearest, 0.0) + np.maximum(self.touch, self.level)
        return (self.gaps <= slack)[:, self.carries].any(axis=1)

    @property
    def carries(self) -> np.ndarray:
        """Which of the other objects and the ground it stands on, (K + 1,) bool."""
        return (self.gaps <= max(self.nearest, 0.0) + self.touch).any(axis=0)

    def carriers(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return which of the other objects, by their names, and the ground the object stands on."""
        return tuple(name for name, carries in zip([*names, GROUND], self.carries, strict=True) if carries)


def feet_over(item: ArrangedObject, others: Sequence[ArrangedObject]) -> Feet:
    """Return the places where an object is above the others or the ground, and how far."""
    contacts = [contacts_over(item, other) for other in others]
    ground = item.surface.points
    points = np.concatenate([*(places for places, _ in contacts), ground])
    gaps, first = np.full((len(points), len(others) + 1), np.inf), 0
    for column, part in enumerate([*(gap for _, gap in contacts), ground[:, 2]]):
        gaps[first : first + len(part), column] = part
        first += len(part)
    touch = np.array([*(touching(item.surface, other.surface) for other in others), touching(item.surface)])
    return Feet(points, gaps, touch, LEVEL * float(item.own.size.max()))


def touching(*surfaces: WorldSurface) -> float:
    """Return the largest gap at which places of surfaces touch, metres."""
    return max(CONTACT, *(SAMPLED * surface.grain for surface in surfaces))


def contacts_over(item: ArrangedObject, other: ArrangedObject) -> tuple[np.ndarray, np.ndarray]:
    """Return places (N, 3) where an object is above another, and how far, (N,) metres.

    There are none where the two touch and the other is the upper one, or where they interpenetrate.
    """
    places, gaps = gaps_over(item.surface, other.surface)
    if not (gaps <= GIVEN).any():
        return places, gaps
    carried = is_above(item.surface, other.surface) and crossing(item, other) is None
    return (places, gaps) if carried else (np.empty((0, 3)), np.empty(0))


def is_above(one: WorldSurface, other: WorldSurface) -> bool:
    """Return whether one of two touching surfaces is the upper one: near the contacts, more of it is above the other.

    If neither is clearly above, as for two boxes of the same size, the one with the higher middle is.
    """
    least = max(SUNK, touching(one, other))
    gaps, others = (gaps_over(*pair)[1] for pair in ((one, other), (other, one)))
    for reach in NEAR:
        counts = [int(((part > least) & (part < least + reach)).sum()) for part in (gaps, others)]
        if max(counts) > CLEARLY * min(counts):
            return counts[0] > counts[1]
    return one.height > other.height


def gaps_over(upper: WorldSurface, lower: WorldSurface) -> tuple[np.ndarray, np.ndarray]:
    """Return the places (N, 3) of a surface that have another below them, and how far below, (N,) metres.

    Places that are sunk in by no more than a contact's tolerance count as above.
    """
    sunk = max(SUNK, SAMPLED * upper.grain, SAMPLED * lower.grain)
    upper_points, lower_points = upper.over(lower), lower.over(upper)
    down = lower.below(upper_points + [0, 0, sunk]) - sunk
    up = upper.above(lower_points - [0, 0, sunk]) - sunk
    met = lower_points + np.column_stack([np.zeros((len(up), 2)), np.where(np.isfinite(up), up, 0)])
    places, gaps = np.concatenate([upper_points, met]), np.concatenate([down, up])
    return places[np.isfinite(gaps)], gaps[np.isfinite(gaps)]


def set_down(item: ArrangedObject, others: Sequence[ArrangedObject]) -> ArrangedObject:
    """Return an object lowered from above until one of the others or the ground carries it."""
    low = item.at(0.0)
    rises = [rise_over(low.surface, other.surface) for other in others]
    return item.at(max(0.0, -float(low.surface.bounds[0, 2]), *rises))


def require_carried(item: ArrangedObject, others: Sequence[ArrangedObject]) -> Feet:
    """Return the feet of an object in its place.

    Raises
    ------
    InputError
        If nothing carries it there.
    """
    feet = feet_over(item, others)
    if feet.nearest > GIVEN:
        pierced = [other.name for other in others if crossing(item, other) is not None]
        gap = f"nothing for {format_length(round(feet.nearest, 3))} below it"
        gap += f", and what it interpenetrates ({', '.join(pierced)}) carries nothing" if pierced else ""
        raise InputError(
            f"{item.name}: expected something that carries it at {item.height:g} m, got {gap}; "
            "leave its height out, and it is set down"
        )
    return feet


def tips_by(item: ArrangedObject, feet: Feet, loads: Sequence[ArrangedObject] = ()) -> float:
    """Return how far the weight of an object, and of loads on it, acts outside its support polygon, metres.

    As elsewhere, the weight is distributed evenly over the surface.
    """
    weights, centers = zip(*[weight_of(one) for one in (item, *loads)], strict=True)
    center = np.average(centers, axis=0, weights=weights)
    places = feet.points[feet.carried, :2]
    try:
        polygon = ConvexHull(places)
    except (QhullError, ValueError):  # a point or a line
        return float(np.linalg.norm(places - center, axis=1).min())
    return float((polygon.equations[:, :2] @ center + polygon.equations[:, 2]).max())


def weight_of(item: ArrangedObject) -> tuple[float, np.ndarray]:
    """Return the area of an object's surface, m2, and where its weight acts, (2,) metres."""
    triangles = surface_of(item.cloud)
    if triangles is None:
        points = item.cloud.thinned(PATCH)
        return PATCH**2 * len(points), points.mean(axis=0)[:2]
    areas, center, _ = moments_of_triangles(triangles)
    return float(areas.sum()), center[:2]
