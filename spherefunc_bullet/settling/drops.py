"""Drops as rows: where each sphere was dropped, and where it came to rest if it did.

What falls through is evidence too: a hole in the bottom, a missing seat and a slope let spheres go.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..clouds.heading import turned
from ..errors import InputError
from ..simulator import MISS_LIMIT, DropResult, Outcome

# Numbers of a drop: x and y of its column; x, y and z of the centre at rest, and whether it is walled in there, all NaN
# where it did not settle.
WIDTH = 6
ASKED = 50  # settled spheres that are asked whether they are walled in, about; of the others that is NaN too
DROPS = 200  # at each radius, where a stated number of them is read as quantities
EARLY_DROPS = 40  # at each radius, of which most objects need no more to be told (compare/evaluation/stopping.py)
NO_DROPS = np.empty((0, WIDTH), np.float32)


@dataclass(frozen=True, kw_only=True)
class Length:
    """When a run for features ends: after so many misses in a row or settled spheres, unless it says otherwise."""

    drops: int | None = None  # exactly so many, whatever becomes of them
    to_the_end: bool = False  # by the paper's rule alone, without the limit of settled spheres
    miss_limit: int = MISS_LIMIT  # of the paper's rule: consecutive spheres not placed that end the run

    def ending(self, miss_limit: int | None) -> Length:
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


LIMITED = Length()
TO_THE_END = Length(to_the_end=True)


def drop_array(result: DropResult, points: np.ndarray, radius: float) -> np.ndarray:
    """Return every drop of a run on an object's points (N, 3), (D, 6) float32, metres, in the order of their ends."""
    if len(result.columns) < result.settled:  # a backend that does not tell: nothing is known of what was lost
        return as_drops(result.centers, points, radius).astype(np.float32)
    rows, settled = np.full((result.drops, WIDTH), np.nan), result.outcomes == Outcome.SETTLED
    rows[:, :2] = result.columns
    rows[settled] = as_drops(result.centers, points, radius)
    rows[settled, :2] = result.columns[settled]
    return rows.astype(np.float32)


def turned_drops(drops: np.ndarray, angle: float) -> np.ndarray:
    """Return drops (D, 6) turned about z by an angle, radians."""
    if not angle:
        return drops
    rows = drops.copy()
    rows[:, 0:2], rows[:, 2:4] = (turned(np.pad(rows[:, k : k + 2], ((0, 0), (0, 1))), angle)[:, :2] for k in (0, 2))
    return rows


def settled_centers(drops: np.ndarray) -> np.ndarray:
    """Return the centres (S, 3) of the drops (D, 6) that settled, metres; settled centres pass through."""
    return drops[settled_rows(drops), 2:5] if drops.shape[1] == WIDTH else drops


def first_drops(settled: dict[float, np.ndarray], count: int) -> dict[float, np.ndarray]:
    """Return the first drops of each radius: what a run of so many would have been."""
    return {radius: drops[:count] for radius, drops in settled.items()}


def settled_count(settled: dict[float, np.ndarray], radius: float) -> int:
    """Return how many spheres of a radius settled."""
    return int(settled_rows(settled[radius]).sum()) if len(settled.get(radius, ())) else 0


def settled_rows(drops: np.ndarray) -> np.ndarray:
    """Return which drops (D, 6) settled, (D,) bool."""
    return ~np.isnan(drops[:, 4])


def as_drops(centers: np.ndarray, points: np.ndarray, radius: float) -> np.ndarray:
    """Return centres (S, 3) on an object's points (N, 3), metres, as drops that settled where they fell, (S, 6)."""
    from .enclosure import walled_in  # compiled, so not where all that is read was kept

    walls = np.full(len(centers), np.nan)
    asked = slice(None, None, max(1, len(centers) // ASKED))
    walls[asked] = walled_in(points, centers[asked], radius)
    return np.column_stack([centers[:, :2], centers, walls])
