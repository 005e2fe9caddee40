"""The resting profile: quantities of the drops that a person would name.

Cubes depend on where spheres lie, so they change when an object turns, moves or grows. A table is a table because a
level at hip height carries most of the settled spheres, one sphere deep, and lets nothing through, whatever its heading
and place. The quantities here measure that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...settling.drops import NO_DROPS, Drops, DropsByRadius
from .columns import SphereColumns, columns_of, fullest_level, largest_piece, near_pairs

TOUCHING = 2.1  # radii between centres: 2, and 2 % of overlap or gap on either side
_BLOCK = 512  # training objects whose distances are computed at once: their differences stay in the cache
RIM = 2.0  # radii within the outline: the outermost ring of spheres
MANY_ENOUGH = 6  # least number of spheres through which a plane is fitted
GAP, REACH = 0.01, 0.15  # metres: least height of a gap, and how far below a sphere smaller ones are looked for


@dataclass(frozen=True)
class Quantity:
    """One quantity of the profile."""

    name: str
    unit: str  # m, m2, degrees, share, spheres, radii or ratio
    meaning: str  # in words that fit into a sentence


QUANTITIES = (
    Quantity("settled", "spheres", "spheres that settled"),
    Quantity("area", "m2", "area within the outline of all spheres"),
    Quantity("width", "m", "shorter side of the outline of all spheres"),
    Quantity("middle_bottom", "m", "height under which half of the columns begin"),
    Quantity("high_bottom", "m", "height under which nine tenths of the columns begin"),
    Quantity("middle_top", "m", "height under which half of the columns end"),
    Quantity("high_top", "m", "height under which nine tenths of the columns end"),
    Quantity("one_deep", "share", "columns one sphere deep"),
    Quantity("on_spheres", "share", "spheres that touch a lower one"),
    Quantity("rim_to_middle", "ratio", "depth along the outline over mean depth"),  # 1 where walls hold the pile
    Quantity("level_height", "m", "height of the level that carries most columns"),
    Quantity("level_share", "share", "columns that begin at that level"),
    Quantity("level_piece", "share", "of the columns on the level, those in its largest connected piece"),
    Quantity("level_area", "m2", "area of the level's largest piece"),
    Quantity("level_area_share", "share", "area of the level's largest piece within the outline of all spheres"),
    Quantity("level_width", "m", "shorter side of the level's largest piece"),
    Quantity("level_depth", "m", "mean depth of spheres over the level"),
    Quantity("level_unevenness", "m", "unevenness of what rests on the level"),
    Quantity("level_range", "m", "range of heights that holds eight tenths of what rests on the level"),
    Quantity("level_tilt", "degrees", "slope of the level"),
    Quantity("level_roughness", "m", "median distance of what rests on the level from a plane"),
    Quantity("stays", "share", "drops within the outline that stayed"),
    Quantity("stays_early", "share", "early drops that stayed, until half of all that settled had settled"),
    Quantity("middle_stays", "share", "early drops over the middle of the object that stayed"),
    Quantity("level_stays", "share", "early drops over the level that stayed"),
    Quantity("rolled", "radii", "mean distance from where spheres fell to where they rest"),
    Quantity("walled_in", "share", "spheres with the object on every side"),
    Quantity("gap", "m", "mean gap under spheres into which smaller ones go"),  # centimetres on spikes
    Quantity("middle_gap", "m", "median gap under spheres into which smaller ones go"),
    Quantity("over_gaps", "share", "spheres over a gap of more than a centimetre"),
)
QUANTITY = {quantity.name: quantity for quantity in QUANTITIES}
NAMES = tuple(QUANTITY)
Profile = dict[str, float]


def profiles_over(dropped: Sequence[DropsByRadius], radii: Sequence[float], names: Sequence[str] = NAMES) -> np.ndarray:
    """Return some quantities (N, R * Q) of objects, radius by radius; all 0 where no sphere was dropped."""
    rows = []
    for drops in dropped:
        row, smaller = [], None
        for radius in radii:
            profile = profile_of(drops.get(radius, NO_DROPS), radius, smaller)
            row += [profile[name] for name in names]
            smaller = drops.get(radius)
        rows.append(row)
    return np.array(rows, float).reshape(len(rows), len(radii) * len(names))


def profile_of(drops: Drops, radius: float, smaller: Drops | None = None) -> Profile:
    """Return the quantities of drops by name; all 0 where nothing settled, gaps too where no smaller spheres did."""
    if not len(drops.rests):
        return dict.fromkeys(NAMES, 0.0)
    columns = columns_of(np.asarray(drops.rests, float), radius)
    height, level = fullest_level(columns)
    piece = largest_piece(level)
    return (
        {"settled": float(len(drops.rests))}
        | whole(columns)
        | pile(columns)
        | carrying_level(columns, height, level, piece)
        | staying(drops, columns, piece)
        | {"walled_in": walled_in(drops)}
        | gaps(columns, smaller)
    )


def walled_in(drops: Drops) -> float:
    """Return the share of the examined spheres that have the object on every side; NaN if none was examined."""
    looked = np.asarray(drops.walled_in, float)
    looked = looked[~np.isnan(looked)]
    return float(looked.mean()) if len(looked) else np.nan


def whole(columns: SphereColumns) -> Profile:
    """Return the extent of the spheres on the ground, and the heights at which columns begin and end."""
    profile = {"area": columns.outline.area, "width": columns.outline.width}
    ends = {"bottom": columns.bottoms - columns.radius, "top": columns.tops + columns.radius}
    for end, heights in ends.items():
        profile[f"middle_{end}"], profile[f"high_{end}"] = columns.quantiles(heights, (0.5, 0.9))
    return profile


def pile(columns: SphereColumns) -> Profile:
    """Return the depth of the spheres, overall and along the outline, and how many rest on other spheres."""
    inside = columns.outline.depths(columns.centers[:, :2]).min(axis=0)
    rim = columns.kept(inside <= RIM * columns.radius)
    return {
        "one_deep": columns.mean(columns.depths < 2.5 * columns.radius),
        "on_spheres": float(on_spheres(columns.centers, columns.radius).mean()),
        "rim_to_middle": rim.mean(rim.depths) / columns.mean(columns.depths),
    }


def on_spheres(centers: np.ndarray, radius: float) -> np.ndarray:
    """Return which spheres (S, 3), metres, touch one that is at least half a radius lower, (S,) bool."""
    first, second = near_pairs(centers, TOUCHING * radius)
    rise = centers[first, 2] - centers[second, 2]
    resting = np.where(rise > 0, first, second)[np.abs(rise) > 0.5 * radius]
    return np.bincount(resting, minlength=len(centers)) > 0


def gaps(columns: SphereColumns, smaller: Drops | None) -> Profile:
    """Return the height of the gaps between spheres that rest on the object and smaller ones beneath them.

    A seat carries large spheres where it carries small ones; spikes carry the large ones only.
    """
    lowest = np.empty(0)
    if smaller is not None and len(smaller.rests):
        large = columns.centers[~on_spheres(columns.centers, columns.radius)]
        small = np.asarray(smaller.rests, float)
        beneath = ((large[:, None, :2] - small[None, :, :2]) ** 2).sum(axis=2) <= columns.radius**2
        hung = (large[:, 2] - columns.radius)[:, None] - (small[:, 2] - smaller.radius)
        beneath &= (hung > -GAP / 2) & (hung < REACH)  # spheres a little higher lie beside it
        lowest = np.where(beneath, hung, -np.inf).max(axis=1)
        lowest = lowest[np.isfinite(lowest)]
    gap, middle, over = (lowest.mean(), np.median(lowest), (lowest > GAP).mean()) if len(lowest) else (0.0, 0.0, 0.0)
    return {"gap": float(gap), "middle_gap": float(middle), "over_gaps": float(over)}


def carrying_level(columns: SphereColumns, height: float, level: SphereColumns, piece: SphereColumns) -> Profile:
    """Return the quantities of the level that carries most columns, and of its largest connected piece."""
    carried = float(level.weights.sum())
    low, high = piece.quantiles(piece.bottoms, (0.1, 0.9))
    tilt, roughness = evenness(piece)
    return {
        "level_height": height - columns.radius,
        "level_share": carried / float(columns.weights.sum()),
        "level_piece": float(piece.weights.sum()) / carried,
        "level_area": piece.outline.area,
        "level_area_share": piece.outline.area / columns.outline.area,
        "level_width": piece.outline.width,
        "level_depth": piece.mean(piece.depths),
        "level_unevenness": piece.spread(piece.bottoms),
        "level_range": high - low,
        "level_tilt": tilt,
        "level_roughness": roughness,
    }


def evenness(piece: SphereColumns) -> tuple[float, float]:
    """Return the slope of the plane through the spheres on a level, degrees, and their median distance, metres."""
    if len(piece) < MANY_ENOUGH:
        return 0.0, 0.0
    across = np.column_stack([piece.centers[:, :2] - piece.centers[:, :2].mean(axis=0), np.ones(len(piece))])
    by_weight = np.sqrt(piece.weights)
    plane = np.linalg.lstsq(across * by_weight[:, None], piece.bottoms * by_weight, rcond=None)[0]
    distances = np.abs(piece.bottoms - across @ plane)
    return float(np.degrees(np.arctan(np.hypot(*plane[:2])))), float(np.median(distances))


def staying(drops: Drops, columns: SphereColumns, piece: SphereColumns) -> Profile:
    """Return the share of the drops over the object that stay, and how far they rolled.

    A full cup holds no more spheres, so shares are also counted until half of all settled spheres have settled.
    """
    settled, places = drops.settled, np.asarray(drops.places, float)
    inside = columns.outline.inside(places)
    early = np.arange(len(drops)) <= np.flatnonzero(settled)[len(columns) // 2]
    rolled = np.linalg.norm(np.asarray(drops.rests, float)[:, :2] - places[settled], axis=1)
    return {
        "stays": share(settled, inside > -columns.radius),
        "stays_early": share(settled, early & (inside > -columns.radius)),
        "middle_stays": share(settled, early & (inside > 0.5 * max(inside.max(), 0))),
        "level_stays": share(settled, early & (piece.outline.inside(places) > 0)),
        "rolled": float(rolled.mean()) / columns.radius,
    }


def share(settled: np.ndarray, which: np.ndarray) -> float:
    """Return the share of some drops (D,) bool that settled (D,) bool; 0 where there are none."""
    return float(settled[which].mean()) if which.any() else 0.0


class Ranks:
    """Quantities (N, D) of training objects as ranks from 0 to 1, so that metres and shares count equally."""

    def __init__(self, learnt: np.ndarray):
        self.learnt = learnt
        columns = np.ascontiguousarray(learnt.T)  # so that no quantity is copied to be searched
        order = np.argsort(columns, axis=1)
        self.ordered = np.take_along_axis(columns, order, axis=1)
        self.ranks = np.empty(learnt.shape)  # found in order, which is twice as quick
        np.put_along_axis(self.ranks, order.T, ranks_among(self.ordered, self.ordered.T), axis=0)

    def distances(self, queries: np.ndarray) -> np.ndarray:
        """Return the distances (A, N) from objects, given as quantities (A, D), to the training objects."""
        rows, distances = ranks_among(self.ordered, queries), np.empty((len(queries), len(self.learnt)))
        for start in range(0, len(self.learnt), _BLOCK):
            block = self.ranks[start : start + _BLOCK]
            for row, out in zip(rows, distances[:, start : start + _BLOCK], strict=True):
                np.abs(row - block).mean(axis=1, out=out)
        return distances


def ranks_among(ordered: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the ranks (A, D) of quantities (A, D) among sorted ones (D, N), 0 to 1; equal ones get the mean rank."""
    places = [
        learnt.searchsorted(queried, "left") + learnt.searchsorted(queried, "right")
        for learnt, queried in zip(ordered, rows.T, strict=True)
    ]
    return np.column_stack(places) / (2 * ordered.shape[1])
