"""The drops on an object: where each sphere was dropped, how its drop ended, and where it rests.

Spheres that do not settle are evidence too: they fall through a hole or a missing seat, or roll off a slope.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..clouds.preparation import turned
from ..errors import CheckedSettings, InputError, amount, warn_renamed
from ..simulator import MISS_LIMIT, DropResult, Outcome

WALL_TESTS = 50  # approximate number of settled spheres that are tested for walls around them; others are NaN
DROPS = 200  # at each radius, for resting profiles
EARLY_DROPS = 40  # at each radius: enough to classify most objects (docs/studies.md)
FEW = 5  # settled spheres of all radii together: with fewer, little can be concluded
NOT_SETTLED = -1  # in place of another `Outcome`, which older files do not have
_ROW_WIDTH = 6  # numbers of a drop in a file: x, y of its column; x, y, z of its rest, and walled in; or NaN


@dataclass(frozen=True, kw_only=True, eq=False)
class Drops:
    """The drops of one radius on one object, in its frame, in the order in which they ended."""

    radius: float  # metres
    places: np.ndarray  # (D, 2) float, metres: the column of each drop; NaN if unknown
    outcomes: np.ndarray  # (D,) int8, each an `Outcome`, or `NOT_SETTLED`
    rests: np.ndarray  # (S, 3) float, metres: the centres of settled spheres
    walled_in: np.ndarray  # (S,) float: 1 if the object is on every side, else 0; NaN if not tested
    losses_known: bool = True  # False for runs that end by misses: only settled spheres are recorded
    provenance: dict[str, Any] = field(default_factory=dict, repr=False)  # see `simulator.provenance_of`

    def __len__(self) -> int:
        return len(self.outcomes)

    @property
    def settled(self) -> np.ndarray:
        """Whether each drop settled, (D,) bool."""
        return self.outcomes == Outcome.SETTLED

    @property
    def room(self) -> float:
        """Number of spheres that fit side by side in the area of the drops; NaN if the places are unknown."""
        return float(np.prod(np.ptp(self.places, axis=0))) / (4 * self.radius**2) if len(self) else 0.0

    def first(self, count: int) -> Drops:
        """Return the first drops, as a run of this number would give them."""
        settled = np.count_nonzero(self.settled[:count])
        return replace(
            self,
            places=self.places[:count],
            outcomes=self.outcomes[:count],
            rests=self.rests[:settled],
            walled_in=self.walled_in[:settled],
        )

    def turned(self, angle: float) -> Drops:
        """Return the drops rotated about z by an angle, radians, counterclockwise seen from above."""
        if not angle:
            return self
        places, rests = turned(self.places, angle), turned(self.rests, angle)
        return replace(self, places=places.astype(self.places.dtype), rests=rests.astype(self.rests.dtype))

    def rows(self) -> np.ndarray:
        """Return the drops as rows of a file: (D, 6) float32, or (S, 3) where losses are not known, metres."""
        if not self.losses_known:
            return self.rests.astype(np.float32)
        rows = np.full((len(self), _ROW_WIDTH), np.nan, np.float32)
        rows[:, :2] = self.places
        rows[self.settled, 2:] = np.column_stack([self.rests, self.walled_in])
        return rows


DropsByRadius = dict[float, Drops]  # radius in metres -> the drops of one object


def resting_drops(radius: float, rests: np.ndarray, *, losses_known: bool = False) -> Drops:
    """Return drops of which only the settled spheres are known, at centres (S, 3), metres."""
    unknown = np.full((len(rests), 3), np.nan, np.float32)
    outcomes = np.full(len(rests), Outcome.SETTLED, np.int8)
    return Drops(
        radius=radius,
        places=unknown[:, :2],
        outcomes=outcomes,
        rests=rests,
        walled_in=unknown[:, 2],
        losses_known=losses_known,
    )


def drops_from_rows(radius: float, rows: np.ndarray, outcomes: np.ndarray | None = None, **about: Any) -> Drops:
    """Return drops from the rows of a file, see `Drops.rows`; older files have no outcomes."""
    if rows.shape[1] != _ROW_WIDTH:
        return replace(resting_drops(radius, rows), **about)
    settled = ~np.isnan(rows[:, 4])
    if outcomes is None:
        outcomes = np.where(settled, np.int8(Outcome.SETTLED), np.int8(NOT_SETTLED))
    rests, walled_in = rows[settled, 2:5], rows[settled, 5]
    return Drops(radius=radius, places=rows[:, :2], outcomes=outcomes, rests=rests, walled_in=walled_in, **about)


NO_DROPS = drops_from_rows(0.0, np.empty((0, _ROW_WIDTH), np.float32))


def drops_of(result: DropResult, points: np.ndarray, radius: float) -> Drops:
    """Return the drops of a run on an object with points (N, 3), metres."""
    drops = settled_in_column(result.centers, points, radius)
    if len(result.columns) >= result.settled:  # else the drops that did not settle are unknown
        drops = replace(drops, places=result.columns, outcomes=result.outcomes)
    arrays = {name: getattr(drops, name).astype(np.float32) for name in ("places", "rests", "walled_in")}
    return replace(drops, **arrays, provenance=result.provenance)


def settled_in_column(rests: np.ndarray, points: np.ndarray, radius: float) -> Drops:
    """Return drops that settled in their own column, at centres (S, 3) on an object with points (N, 3), metres."""
    from .enclosure import walled_in  # imported here: its kernels are compiled, and cached drops do not need them

    walls = np.full(len(rests), np.nan)
    tested = slice(None, None, max(1, len(rests) // WALL_TESTS))
    walls[tested] = walled_in(points, rests[tested], radius)
    return replace(resting_drops(radius, rests, losses_known=True), places=rests[:, :2], walled_in=walls)


def typed_drops(objects: Iterable[Mapping[float, Drops | np.ndarray]]) -> list[DropsByRadius]:
    """Return the drops of objects; arrays of rows, as in earlier versions, are converted with a warning."""
    return [{radius: typed(radius, drops) for radius, drops in each.items()} for each in objects]


def typed(radius: float, drops: Drops | np.ndarray) -> Drops:
    """Return drops as they are, or from an array of rows, see `Drops.rows`."""
    if isinstance(drops, Drops):
        return drops
    warn_renamed("drops as an array", "Drops, see drops_from_rows")
    return drops_from_rows(radius, np.asarray(drops))


def first_drops(drops: DropsByRadius, count: int) -> DropsByRadius:
    """Return the first drops of each radius."""
    return {radius: of_radius.first(count) for radius, of_radius in drops.items()}


def settled_count(drops: Mapping[float, Drops], radius: float) -> int:
    """Return how many spheres of a radius settled."""
    return len(drops.get(radius, NO_DROPS).rests)


@dataclass(frozen=True, kw_only=True)
class RunLimit(CheckedSettings):
    """When a run ends: by default after a number of misses in a row, or of settled spheres."""

    drops: int | None = amount(None, least=1)  # exact number of drops, whatever their outcomes
    to_the_end: bool = False  # end by the rule of the paper only, without a limit of settled spheres
    miss_limit: int = MISS_LIMIT  # consecutive spheres not placed that end the run (paper, §III-A)

    def ending(self, miss_limit: int | None) -> RunLimit:
        """Return this limit with another miss limit; with None, unchanged.

        Raises
        ------
        InputError
            If runs do not end by misses.
        """
        if miss_limit is None:
            return self
        if self.drops is not None:
            raise InputError(
                f"miss limit {miss_limit}: expected with method cubes or paper; runs of profile are {self.drops} drops"
            )
        return replace(self, miss_limit=miss_limit)


LIMITED = RunLimit()
TO_THE_END = RunLimit(to_the_end=True)
