"""The cheapest shape of convex pieces that keeps what an object is for."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING

from .candidates import Make, made, of_hull, of_mesh
from .comparison import Subject, row_of
from .exposure import Fitting
from .rows import Kept, Row, judged

if TYPE_CHECKING:
    from .solid import Solid

SCALES = (2.0, 1.2, 0.8, 0.5)  # of the tolerances, the coarsest first
BUDGET = 30.0  # seconds of the processor (a busy machine finds the same), after which nothing more is begun
STRICT = Kept(share=0.95, moved=0.002)
OTHERS = ("vhacd", "coacd")  # by whose pieces an object may be written as well; compounds have hundreds of them
Tried = tuple["Solid", Row]


def best_shape(subject: Subject, kept: Kept, still: bool = False, compared: Iterable[Tried] = ()) -> Tried:
    """Return the cheapest candidate that keeps everything, with its row; where none does, the one that keeps most.

    Cheapest by a measured step with spheres in contact. Of each kind the first that keeps everything is taken, since
    the finer ones that follow are dearer. What loses water, level or openings is not asked about spheres. What stands
    ``still`` may also be the concave mesh.

    Parameters
    ----------
    compared : iterable of (Solid, Row)
        What has been measured of the object already: of these, `decomposed` ones are candidates as well.
    """
    until, tried = time.process_time() + BUDGET, []

    def enough() -> bool:
        return time.process_time() > until

    for kind in kinds(subject, enough, still):
        for name, make in kind:
            if tried and enough():
                break
            solid = made(name, make)
            tried.append((solid, row_of(subject, solid, kept, early=True)))
            if tried[-1][1].keeps:
                break
        if tried[-1][1].keeps and len(tried[-1][0].pieces or ()) == 1:
            break  # nothing is cheaper than one convex piece
    tried += [(solid, judged(row, subject.truth, kept)) for solid, row in compared if decomposed(solid, row)]
    solid, row = min(tried, key=lambda pair: (not pair[1].keeps, shortfall(pair[1]), pair[1].step_us))
    return (solid, row) if row.measured else (solid, row_of(subject, solid, kept))


def decomposed(solid: Solid, row: Row) -> bool:
    """Return whether a shape is of convex pieces that another program cut, and all is known of it."""
    return row.measured and solid.pieces is not None and solid.name.split()[0] in OTHERS


def kinds(subject: Subject, enough: Callable[[], bool], still: bool) -> Iterator[list[tuple[str, Make]]]:
    """Yield what can be tried of each kind, by name, the coarsest first."""
    if still:
        yield [("mesh", partial(of_mesh, subject.cloud))]
    yield [("hull", partial(of_hull, subject.cloud))]
    fitting = Fitting(subject, enough)
    yield [(f"fitted {scale:g}", partial(fitting.of, scale)) for scale in SCALES]


def shortfall(row: Row) -> float:
    """Return what a shape lacks, 0 for one that keeps everything."""
    if row.keeps:
        return 0.0
    shares = (row.level_kept, row.settled_kept, row.capacity_kept)
    return 1 - min(share for share in shares if share is not None) + 0.05 * row.openings_closed
