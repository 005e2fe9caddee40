"""The cheapest shape of convex pieces that keeps what an object is for."""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

from .candidates import Make, made, of_hull, of_vhacd
from .comparison import Subject, row_of
from .exposure import of_fitting
from .rows import Kept, Row

if TYPE_CHECKING:
    from .solid import Solid

SCALES = (3.0, 2.0, 1.2, 0.8)  # of the tolerances, the coarsest first
BUDGET = 50.0  # seconds, after which no further candidate is made
Tried = tuple["Solid", Row]


def best_shape(subject: Subject, kept: Kept) -> Tried:
    """Return the cheapest candidate that keeps everything, with its row; where none does, the one that keeps most.

    Cheapest by its pieces, since what a step costs is noise between runs.
    """
    started, tried = time.perf_counter(), []
    for name, make in ways(subject):
        solid = made(name, make)
        tried.append((solid, row_of(subject, solid, kept)))
        if tried[-1][1].keeps or time.perf_counter() - started > BUDGET:
            break
    return min(tried, key=lambda pair: (not pair[1].keeps, shortfall(pair[1]), pair[1].pieces))


def ways(subject: Subject) -> Iterator[tuple[str, Make]]:
    """Yield what can be tried, by name, with few pieces first."""
    yield "hull", partial(of_hull, subject.cloud)
    for scale in SCALES:
        yield f"fitted {scale:g}", partial(of_fitting, subject, scale)
    yield "vhacd 64", partial(of_vhacd, subject.cloud, 64)


def shortfall(row: Row) -> float:
    """Return what a shape lacks, 0 for one that keeps everything."""
    if row.keeps:
        return 0.0
    kept = [row.level_kept, row.settled_kept, *([] if row.capacity_kept is None else [row.capacity_kept])]
    return 1 - min(kept) + 0.05 * row.openings_closed
