"""The cheapest shape of convex pieces that keeps what an object is for."""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING

from .candidates import Make, made, of_hull, of_vhacd
from .comparison import Subject, row_of
from .exposure import of_fitting
from .rows import Kept, Row
from .solid import MOST_CORNERS

if TYPE_CHECKING:
    from .solid import Solid

SCALES = (2.0, 1.2, 0.8)  # of the tolerances, the coarsest first
HULLS = (8, 32)  # of V-HACD, at most
BUDGET = 40.0  # seconds of the processor (a busy machine finds the same), after which nothing more is made
STRICT = Kept(capacity=0.95, moved=0.002)
Tried = tuple["Solid", Row]


def best_shape(subject: Subject, kept: Kept) -> Tried:
    """Return the cheapest candidate that keeps everything, with its row; where none does, the one that keeps most.

    Cheapest by a measured step with spheres in contact. Of each kind the first that keeps everything is taken, since
    the finer ones that follow are dearer.
    """
    started, tried = time.process_time(), []
    for kind in kinds(subject):
        for name, make in kind:
            if tried and time.process_time() - started > BUDGET:
                break
            solid = made(name, make)
            tried.append((solid, row_of(subject, solid, kept)))
            if tried[-1][1].keeps:
                break
        if tried[-1][1].keeps and tried[-1][1].pieces == 1:
            break  # nothing is cheaper than one piece
    return min(tried, key=lambda pair: (not pair[1].keeps, shortfall(pair[1]), pair[1].step_us))


def kinds(subject: Subject) -> Iterator[list[tuple[str, Make]]]:
    """Yield what can be tried of each kind, by name, the coarsest first."""
    yield [("hull", partial(of_hull, subject.cloud))]
    yield [(f"fitted {scale:g}", partial(of_fitting, subject, scale)) for scale in SCALES]
    if find_spec("vhacdx"):
        yield [(f"vhacd {hulls}", partial(of_vhacd, subject.cloud, hulls, MOST_CORNERS)) for hulls in HULLS]


def shortfall(row: Row) -> float:
    """Return what a shape lacks, 0 for one that keeps everything."""
    if row.keeps:
        return 0.0
    kept = [row.level_kept, row.settled_kept, *([] if row.capacity_kept is None else [row.capacity_kept])]
    return 1 - min(kept) + 0.05 * row.openings_closed
