"""The resting profile: settled spheres as quantities that a person would name, whatever the heading and the place.

Cubes say where spheres lie, so they change when an object turns, moves or grows. A seat is a seat because a level
at knee height carries spheres, with a back above it on one side; these are the quantities here. The first few
hundred spheres of a run say it, so it does not matter how long runs are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from sklearn.base import BaseEstimator, TransformerMixin

from .columns import Columns, columns_of, fullest_level, largest_piece, near_pairs

FIRST = 250  # settled spheres that are read, at most
TOUCHING = 2.1  # radii between centres: 2, and 2 % that spheres may overlap or miss each other by, either side
HIGHER = 3.0  # radii over the level's centres: what begins there is no second layer
RIM = 2.0  # radii within the outline: the outermost ring of spheres


@dataclass(frozen=True)
class Quantity:
    """What one column of the profile is."""

    name: str
    unit: str  # m, m2, share, spheres, ratio or degrees
    meaning: str


QUANTITIES = (
    Quantity("settled", "spheres", "how many settled, of those that are read"),
    Quantity("columns", "spheres", "how many stand side by side"),
    Quantity("covered", "share", "area under spheres, of that within their outline"),
    Quantity("area", "m2", "area within the outline of all spheres"),
    Quantity("width", "m", "shorter side of that outline"),
    Quantity("length", "m", "longer side of that outline"),
    Quantity("extent", "m", "from the lowest sphere to the highest"),
    Quantity("low_bottom", "m", "height under which a tenth of the columns begin"),
    Quantity("middle_bottom", "m", "height under which half of the columns begin"),
    Quantity("high_bottom", "m", "height under which nine tenths of the columns begin"),
    Quantity("low_top", "m", "height under which a tenth of the columns end"),
    Quantity("middle_top", "m", "height under which half of the columns end"),
    Quantity("high_top", "m", "height under which nine tenths of the columns end"),
    Quantity("spread_of_bottoms", "m", "standard deviation of the heights at which columns begin"),
    Quantity("spread_of_tops", "m", "standard deviation of the heights at which columns end"),
    Quantity("depth", "m", "mean depth of spheres"),
    Quantity("high_depth", "m", "depth that a tenth of the columns exceed"),
    Quantity("one_deep", "share", "columns one sphere deep"),
    Quantity("on_spheres", "share", "spheres that touch a lower one"),
    Quantity("crowding", "ratio", "spheres that each sphere touches, in the mean"),
    Quantity("rim_depth", "m", "mean depth of spheres along the outline"),
    Quantity("rim_to_middle", "ratio", "depth along the outline over mean depth: 1 where walls hold the pile"),
    Quantity("slope", "ratio", "rise of the pile's top over a metre, as a plane"),
    Quantity("unevenness", "m", "standard deviation of the pile's top from that plane"),
    Quantity("level_height", "m", "height of the surface that carries most columns"),
    Quantity("level_share", "share", "columns that this level carries"),
    Quantity("level_piece", "share", "of these, those in its largest connected piece"),
    Quantity("level_area", "m2", "area of that piece"),
    Quantity("level_area_share", "share", "its area, of that within the outline of all spheres"),
    Quantity("level_width", "m", "its shorter side"),
    Quantity("level_length", "m", "its longer side"),
    Quantity("level_depth", "m", "mean depth of spheres over it"),
    Quantity("level_unevenness", "m", "standard deviation of the heights of the spheres that rest on it"),
    Quantity("level_slope", "ratio", "rise of the pile's top over it, as a plane"),
    Quantity("above_share", "share", "columns that begin above the level and its second layer"),
    Quantity("above_height", "m", "how far above it they reach, nine tenths of them"),
    Quantity("above_one_side", "share", "how much they lie on one side of it: 1 on one side, 0 all around"),
    Quantity("above_opening", "degrees", "widest angle, seen from its middle, in which nothing settled above it"),
    Quantity("above_distance", "ratio", "how far from its middle they are, over half its width"),
    Quantity("below_share", "share", "columns that begin below the level"),
    Quantity("below_depth", "m", "how far below it they reach, nine tenths of them"),
)
NAMES = tuple(quantity.name for quantity in QUANTITIES)
Profile = dict[str, float]


class RestingProfile(TransformerMixin, BaseEstimator):
    """Turn settled spheres of one radius into named quantities.

    Turning the object about the vertical, moving it on the ground, or giving the spheres that are read in another
    order changes nothing but the last digits.

    Parameters
    ----------
    radius : float
        Of the spheres, metres.
    first : int
        How many are read, those that settled first.
    """

    def __init__(self, radius: float = 0.02, *, first: int = FIRST):
        self.radius = radius
        self.first = first

    def fit(self, X: object = None, y: object = None) -> RestingProfile:
        """Do nothing: quantities have a meaning of their own."""
        return self

    def transform(self, X: Sequence[np.ndarray]) -> np.ndarray:
        """Return the quantities (N, Q) of objects.

        Parameters
        ----------
        X : sequence of (S, 3) float
            Settled centres of each object in the order in which they settled, metres, z up, the ground at 0.
        """
        rows = [profile_of(np.asarray(centers, float)[: self.first], self.radius) for centers in X]
        return np.array([[row[name] for name in NAMES] for row in rows], float).reshape(len(rows), len(NAMES))

    def get_feature_names_out(self, input_features: object = None) -> np.ndarray:
        """Return the names of the quantities (Q,), see `QUANTITIES`."""
        return np.array(NAMES, dtype=object)

    def __sklearn_is_fitted__(self) -> bool:
        return True


def profile_of(centers: np.ndarray, radius: float) -> Profile:
    """Return the quantities of settled centres (S, 3), metres, by name; all 0 where nothing settled."""
    if not len(centers):
        return dict.fromkeys(NAMES, 0.0)
    columns = columns_of(centers, radius)
    height, level = fullest_level(columns)
    piece = largest_piece(level)
    return (
        {"settled": float(len(centers))}
        | extents(columns)
        | heights(columns)
        | pile(columns)
        | carrying_level(columns, height, level, piece)
        | above_and_below(columns, height, piece)
    )


def extents(columns: Columns) -> Profile:
    """Return how far the spheres reach and how much of the ground they cover."""
    outline, z = columns.outline, columns.centers[:, 2]
    count = float(columns.weights.sum())
    return {
        "columns": count,
        "covered": count * np.pi * columns.radius**2 / outline.area,
        "area": outline.area,
        "width": outline.width,
        "length": outline.length,
        "extent": float(np.ptp(z)) + 2 * columns.radius,
    }


def heights(columns: Columns) -> Profile:
    """Return where columns begin and end, at the spheres' lowest and highest points."""
    begin, end = columns.bottoms - columns.radius, columns.tops + columns.radius
    shares = (0.1, 0.5, 0.9)
    return (
        dict(zip(("low_bottom", "middle_bottom", "high_bottom"), columns.quantiles(begin, shares), strict=True))
        | dict(zip(("low_top", "middle_top", "high_top"), columns.quantiles(end, shares), strict=True))
        | {"spread_of_bottoms": columns.spread(begin), "spread_of_tops": columns.spread(end)}
    )


def pile(columns: Columns) -> Profile:
    """Return how deep the spheres lie, what they rest on, and the shape of their upper side."""
    radius, depths = columns.radius, columns.depths
    first, second = near_pairs(columns.centers, TOUCHING * radius)
    z = columns.centers[:, 2]
    higher = np.where(z[first] > z[second], first, second)
    resting = np.unique(higher[np.abs(z[first] - z[second]) > 0.5 * radius])
    inside = columns.outline.depths(columns.centers[:, :2])
    rim = columns.kept(inside.min(axis=0) <= RIM * radius)
    slope, rest = plane(columns)
    mean = columns.mean(depths)
    return {
        "depth": mean,
        "high_depth": columns.quantiles(depths, (0.9,))[0],
        "one_deep": columns.mean(depths < 2.5 * radius),
        "on_spheres": len(resting) / len(columns),
        "crowding": 2 * len(first) / len(columns),
        "rim_depth": rim.mean(rim.depths),
        "rim_to_middle": rim.mean(rim.depths) / mean,
        "slope": slope,
        "unevenness": rest,
    }


def plane(columns: Columns) -> tuple[float, float]:
    """Return the slope of the plane through the tops of columns, and their standard deviation from it in metres.

    The plane is kept from tipping where the spheres are as good as on one line, by one radius squared of variance.
    """
    place = columns.centers[:, :2] - np.average(columns.centers[:, :2], axis=0, weights=columns.weights)
    tops = columns.tops - columns.mean(columns.tops)
    shares = columns.weights / columns.weights.sum()
    spread = (place * shares[:, None]).T @ place + columns.radius**2 * np.eye(2)
    tilt = np.linalg.solve(spread, place.T @ (shares * tops))
    return float(np.hypot(*tilt)), columns.spread(tops - place @ tilt)


def carrying_level(columns: Columns, height: float, level: Columns, piece: Columns) -> Profile:
    """Return what the level is like that carries most columns, and its largest connected piece."""
    carried = float(level.weights.sum())
    return {
        "level_height": height - columns.radius,
        "level_share": carried / float(columns.weights.sum()),
        "level_piece": float(piece.weights.sum()) / carried,
        "level_area": piece.outline.area,
        "level_area_share": piece.outline.area / columns.outline.area,
        "level_width": piece.outline.width,
        "level_length": piece.outline.length,
        "level_depth": piece.mean(piece.depths),
        "level_unevenness": piece.spread(piece.bottoms),
        "level_slope": plane(piece)[0],
    }


def above_and_below(columns: Columns, height: float, piece: Columns) -> Profile:
    """Return what settled above the level, such as on a back or arms, on which side of it, and what below."""
    rise, count = columns.bottoms - height, float(columns.weights.sum())
    above, below = columns.kept(rise > HIGHER * columns.radius), columns.kept(rise < -HIGHER * columns.radius)
    sides = {"above_one_side": 0.0, "above_opening": 360.0, "above_distance": 0.0, "above_height": 0.0}
    if len(above):
        sides = sides_of(above, piece) | {"above_height": above.quantiles(above.bottoms, (0.9,))[0] - height}
    return sides | {
        "above_share": float(above.weights.sum()) / count,
        "below_share": float(below.weights.sum()) / count,
        "below_depth": height - below.quantiles(below.bottoms, (0.1,))[0] if len(below) else 0.0,
    }


def sides_of(above: Columns, piece: Columns) -> Profile:
    """Return on which sides of the level's middle the columns above it stand."""
    middle = np.average(piece.centers[:, :2], axis=0, weights=piece.weights)
    away = above.centers[:, :2] - middle
    distances = np.maximum(np.hypot(*away.T), 1e-3 * above.radius)  # over the middle: on no side
    angles = np.sort(np.arctan2(away[:, 1], away[:, 0]))
    gaps = np.diff(angles, append=angles[0] + 2 * np.pi)
    return {
        "above_one_side": float(np.hypot(*[above.mean(away[:, k] / distances) for k in range(2)])),
        "above_opening": float(np.rad2deg(gaps.max())),
        "above_distance": above.mean(distances) / (piece.outline.width / 2),
    }
