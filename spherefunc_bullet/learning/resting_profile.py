"""The resting profile: settled spheres as quantities that a person would name, whatever the heading and the place.

Cubes say where spheres lie, so they change when an object turns, moves or grows. A table is a table because a level
at hip height carries most of what settles, one sphere deep; these are the quantities here. The first few hundred
spheres of a run say it, so it does not matter how long runs are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from sklearn.base import BaseEstimator, TransformerMixin

from .columns import Columns, columns_of, fullest_level, largest_piece, near_pairs

FIRST = 250  # settled spheres that are read, at most
TOUCHING = 2.1  # radii between centres: 2, and 2 % that spheres may overlap or miss each other by, either side
RIM = 2.0  # radii within the outline: the outermost ring of spheres


@dataclass(frozen=True)
class Quantity:
    """What one column of the profile is."""

    name: str
    unit: str  # m, m2, share, spheres or ratio
    meaning: str


QUANTITIES = (
    Quantity("settled", "spheres", "how many settled, of those that are read"),
    Quantity("area", "m2", "area within the outline of all spheres"),
    Quantity("width", "m", "shorter side of the outline of all spheres"),
    Quantity("middle_bottom", "m", "height under which half of the columns begin"),
    Quantity("high_bottom", "m", "height under which nine tenths of the columns begin"),
    Quantity("middle_top", "m", "height under which half of the columns end"),
    Quantity("high_top", "m", "height under which nine tenths of the columns end"),
    Quantity("one_deep", "share", "columns one sphere deep"),
    Quantity("on_spheres", "share", "spheres that touch a lower one"),
    Quantity("rim_to_middle", "ratio", "depth along the outline over mean depth: 1 where walls hold the pile"),
    Quantity("level_height", "m", "height of the surface that carries most columns"),
    Quantity("level_share", "share", "columns that begin at the level that carries most"),
    Quantity("level_piece", "share", "of the columns on the level, those in its largest connected piece"),
    Quantity("level_area", "m2", "area of the level's largest connected piece"),
    Quantity("level_area_share", "share", "area of the level's largest piece, of that within all spheres' outline"),
    Quantity("level_width", "m", "shorter side of the level's largest piece"),
    Quantity("level_depth", "m", "mean depth of spheres over the level's largest piece"),
    Quantity("level_unevenness", "m", "standard deviation of the heights of the spheres that rest on it"),
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
    return {"settled": float(len(centers))} | whole(columns) | pile(columns) | carrying_level(columns)


def whole(columns: Columns) -> Profile:
    """Return how far the spheres reach across the ground and where columns begin and end, at a sphere's own ends."""
    begin, end = columns.bottoms - columns.radius, columns.tops + columns.radius
    middle_bottom, high_bottom = columns.quantiles(begin, (0.5, 0.9))
    middle_top, high_top = columns.quantiles(end, (0.5, 0.9))
    return {
        "area": columns.outline.area,
        "width": columns.outline.width,
        "middle_bottom": middle_bottom,
        "high_bottom": high_bottom,
        "middle_top": middle_top,
        "high_top": high_top,
    }


def pile(columns: Columns) -> Profile:
    """Return how deep the spheres lie, in the middle and along the outline, and what they rest on."""
    inside = columns.outline.depths(columns.centers[:, :2]).min(axis=0)
    rim = columns.kept(inside <= RIM * columns.radius)
    return {
        "one_deep": columns.mean(columns.depths < 2.5 * columns.radius),
        "on_spheres": share_on_spheres(columns.centers, columns.radius),
        "rim_to_middle": rim.mean(rim.depths) / columns.mean(columns.depths),
    }


def share_on_spheres(centers: np.ndarray, radius: float) -> float:
    """Return the share of spheres (S, 3), metres, that touch one lower by half a radius."""
    first, second = near_pairs(centers, TOUCHING * radius)
    rise = centers[first, 2] - centers[second, 2]
    resting = np.where(rise > 0, first, second)[np.abs(rise) > 0.5 * radius]
    return len(np.unique(resting)) / len(centers)


def carrying_level(columns: Columns) -> Profile:
    """Return what the level is like that carries most columns, and its largest connected piece."""
    height, level = fullest_level(columns)
    piece, carried = largest_piece(level), float(level.weights.sum())
    return {
        "level_height": height - columns.radius,
        "level_share": carried / float(columns.weights.sum()),
        "level_piece": float(piece.weights.sum()) / carried,
        "level_area": piece.outline.area,
        "level_area_share": piece.outline.area / columns.outline.area,
        "level_width": piece.outline.width,
        "level_depth": piece.mean(piece.depths),
        "level_unevenness": piece.spread(piece.bottoms),
    }
