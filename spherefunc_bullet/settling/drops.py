"""The spheres that were dropped on an object: where each was dropped, how its fall ended, where it rests.

Spheres that do not settle are evidence too: they fall through a hole or a missing seat, or roll off a slope.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..clouds.preparation import turned
from ..errors import InputError, warn_renamed
from ..simulator import MISS_LIMIT, DropResult, Outcome

WALL_TESTS = 50  # settled spheres tested for walls around them, about; the others are NaN
DROPS = 200  # at each radius, where a stated number of them is read as quantities
EARLY_DROPS = 40  # at each radius: enough to classify most objects (docs/studies.md)
FEW = 5  # settled spheres of all radii together from which much can be concluded
NOT_SETTLED = -1  # in place of an `Outcome`: did not settle; older files do not say how it ended
_ROW_WIDTH = 6  # numbers of a drop in a file: x, y of its column; x, y, z of its rest, and walled in, or NaN


@dataclass(frozen=True, kw_only=True, eq=False)
class Drops:
    """The spheres of one radius that were dropped on one object, in its frame, in the order in which they ended."""

    radius: float  # metres
    places: np.ndarray  # (D, 2) float, metres: the column in which each began; NaN where that is not kept
    outcomes: np.ndarray  # (D,) int8, each an `Outcome`, or `NOT_SETTLED`
    rests: np.ndarray  # (S, 3) float, metres: the centres of those that settled
    walled_in: np.ndarray  # (S,) float: 1 with the object on every side, 0 without; NaN where nobody looked
    losses_known: bool = True  # False for runs that end by misses: only settled spheres are kept
    provenance: dict[str, Any] = field(default_factory=dict, repr=False)  # see `simulator.provenance_of`

    def __len__(self) -> int:
        return len(self.outcomes)

    @property
    def settled(self) -> np.ndarray:
        """Which drops settled, (D,) bool."""
        return self.outcomes == Outcome.SETTLED

    @property
    def room(self) -> float:
        """How many spheres would lie side by side, in rows, where they were dropped; NaN where that is not kept."""
        return float(np.prod(np.ptp(self.places, axis=0))) / (4 * self.radius**2) if len(self) else 0.0

    def first(self, count: int) -> Drops:
        """Return the first drops: what a run of so many would have been."""
        kept = np.count_nonzero(self.settled[:count])
        return replace(
            self,
            places=self.places[:count],
            outcomes=self.outcomes[:count],
            rests=self.rests[:kept],
            walled_in=self.walled_in[:kept],
        )

    def turned(self, angle: float) -> Drops:
        """Return the drops turned about z by an angle, radians, counterclockwise seen from above."""
        if not angle:
            return self
        places, rests = turned(self.places, angle), turned(self.rests, angle)
        return replace(self, places=places.astype(self.places.dtype), rests=rests.astype(self.rests.dtype))

    def rows(self) -> np.ndarray:
        """Return them as they are kept in files: (D, 6) float32, or (S, 3) where losses are not known, metres."""
        if not self.losses_known:
            return self.rests.astype(np.float32)
        rows = np.full((len(self), _ROW_WIDTH), np.nan, np.float32)
        rows[:, :2] = self.places
        rows[self.settled, 2:] = np.column_stack([self.rests, self.walled_in])
        return rows


DropsByRadius = dict[float, Drops]  # radius in metres -> the drops of one object


def resting_drops(radius: float, rests: np.ndarray, *, losses_known: bool = False) -> Drops:
    """Return drops of which only the settled ones are known, at centres (S, 3), metres."""
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
    """Return drops from the rows of a file, see `Drops.rows`; older files have no outcomes of lost drops."""
    if rows.shape[1] != _ROW_WIDTH:
        return replace(resting_drops(radius, rows), **about)
    settled = ~np.isnan(rows[:, 4])
    if outcomes is None:
        outcomes = np.where(settled, np.int8(Outcome.SETTLED), np.int8(NOT_SETTLED))
    rests, walled_in = rows[settled, 2:5], rows[settled, 5]
    return Drops(radius=radius, places=rows[:, :2], outcomes=outcomes, rests=rests, walled_in=walled_in, **about)


NO_DROPS = drops_from_rows(0.0, np.empty((0, _ROW_WIDTH), np.float32))


def drops_of(result: DropResult, points: np.ndarray, radius: float) -> Drops:
    """Return every drop of a run on an object's points (N, 3), metres."""
    drops = fallen_where_they_rest(result.centers, points, radius)
    if len(result.columns) >= result.settled:  # else nothing is known of what was lost
        drops = replace(drops, places=result.columns, outcomes=result.outcomes)
    short = {name: getattr(drops, name).astype(np.float32) for name in ("places", "rests", "walled_in")}
    return replace(drops, **short, provenance=result.provenance)


def fallen_where_they_rest(rests: np.ndarray, points: np.ndarray, radius: float) -> Drops:
    """Return drops that settled in their own column, at centres (S, 3) on an object's points (N, 3), metres."""
    from .enclosure import walled_in  # compiled, so not where all that is read was kept

    walls = np.full(len(rests), np.nan)
    asked = slice(None, None, max(1, len(rests) // WALL_TESTS))
    walls[asked] = walled_in(points, rests[asked], radius)
    return replace(resting_drops(radius, rests, losses_known=True), places=rests[:, :2], walled_in=walls)


def typed_drops(objects: Iterable[Mapping[float, Drops | np.ndarray]]) -> list[DropsByRadius]:
    """Return the drops of objects; of rows of numbers, as versions before had them, with a warning."""
    return [{radius: typed(radius, drops) for radius, drops in each.items()} for each in objects]


def typed(radius: float, drops: Drops | np.ndarray) -> Drops:
    """Return drops of a radius, also of rows of numbers, see `Drops.rows`."""
    if isinstance(drops, Drops):
        return drops
    warn_renamed("drops as an array", "Drops, see drops_from_rows")
    return drops_from_rows(radius, np.asarray(drops))


def first_drops(drops: DropsByRadius, count: int) -> DropsByRadius:
    """Return the first drops of each radius."""
    return {radius: one.first(count) for radius, one in drops.items()}


def settled_count(drops: Mapping[float, Drops], radius: float) -> int:
    """Return how many spheres of a radius settled."""
    return len(drops.get(radius, NO_DROPS).rests)


@dataclass(frozen=True, kw_only=True)
class RunLimit:
    """When a run ends: by default after a number of misses in a row, or of settled spheres."""

    drops: int | None = None  # exactly so many, whatever becomes of them
    to_the_end: bool = False  # by the paper's rule alone, without the limit of settled spheres
    miss_limit: int = MISS_LIMIT  # of the paper's rule: consecutive spheres not placed that end the run

    def ending(self, miss_limit: int | None) -> RunLimit:
        """Return the same with another miss limit; None: as it is.

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
