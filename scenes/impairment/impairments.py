"""Every kind of change: of which functions' objects it is made, and whether they work afterwards."""

from __future__ import annotations

from collections.abc import Iterable

from spherefunc_bullet.errors import require_known

from . import cups, harmless, tops
from .specimen import FUNCTIONS, Impairment, kinds
from .use.copies import AS_SENSED, IN_USE

IMPAIRMENTS = (
    *kinds(FUNCTIONS, True, whole=harmless.whole),
    *kinds(
        ("cup",),
        False,
        hole=cups.hole_in_bottom,
        slit=cups.slit_in_wall,
        lid=cups.lid_on_top,
        filled=cups.filled_to_brim,
        upside_down=cups.cup_upside_down,
        on_side=cups.cup_on_side,
    ),
    *kinds(
        ("sittable",),
        False,
        missing=tops.missing,
        gaps=tops.gaps_in_seat,
        tilted=tops.tilted_seat,
        occupied=tops.box_on_seat,
        upside_down=tops.turned_over,
        on_back=tops.seat_on_back,
    ),
    *kinds(
        ("table",),
        False,
        missing=tops.missing,
        half=tops.half_top,
        tilted=tops.tilted_top,
        upside_down=tops.turned_over,
        spikes=tops.spikes_on_top,
    ),
    *kinds(("cup",), True, no_handle=harmless.without_handle),
    *kinds(("sittable",), True, no_arms=harmless.without_arms),
    *kinds(("sittable", "table"), True, other_legs=harmless.other_legs),
    *kinds(
        FUNCTIONS,
        True,
        smaller=harmless.smaller,
        larger=harmless.larger,
        turned=harmless.heading,
        sensor=harmless.sensor,
        triangulation=harmless.triangulation,
    ),
)
COPIES = (*IMPAIRMENTS, *IN_USE, *AS_SENSED)  # all that `dataset impair` makes


def kinds_of(impairments: Iterable[Impairment] = COPIES) -> list[str]:
    """Return the names of the kinds, each once, in order."""
    return list(dict.fromkeys(impairment.kind for impairment in impairments))


def chosen_kinds(names: Iterable[str] | None) -> tuple[Impairment, ...]:
    """Return the impairments of some kinds, or all; what is whole is always among them.

    Raises
    ------
    InputError
        If there is no such kind.
    """
    if names is None:
        return COPIES
    wanted = set(names)
    require_known("--kinds", sorted(wanted), kinds_of())
    return tuple(impairment for impairment in COPIES if impairment.kind in wanted | {"whole"})
