"""Every kind of change: the functions of the objects that it is made of, and whether they still work afterwards."""

from __future__ import annotations

from collections.abc import Iterable

from spherefunc_bullet.errors import require_known

from . import harmless, useless
from .held_out import HELD_OUT
from .specimen import FUNCTIONS, Impairment, kinds
from .use.copies import AS_SENSED, IN_USE

IMPAIRMENTS = (
    *kinds(FUNCTIONS, True, whole=harmless.whole),
    *kinds(
        ("cup",),
        False,
        hole=useless.hole_in_bottom,
        slit=useless.slit_in_wall,
        lid=useless.lid_on_top,
        filled=useless.filled_to_brim,
        upside_down=useless.cup_upside_down,
        on_side=useless.cup_on_side,
    ),
    *kinds(
        ("sittable",),
        False,
        missing=useless.missing,
        gaps=useless.gaps_in_seat,
        tilted=useless.tilted_seat,
        occupied=useless.box_on_seat,
        upside_down=useless.turned_over,
        on_back=useless.seat_on_back,
    ),
    *kinds(
        ("table",),
        False,
        missing=useless.missing,
        half=useless.half_top,
        tilted=useless.tilted_top,
        upside_down=useless.turned_over,
        spikes=useless.spikes_on_top,
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
COPIES = (*IMPAIRMENTS, *IN_USE, *AS_SENSED)  # every kind that models learn


def kinds_of(impairments: Iterable[Impairment] = COPIES) -> list[str]:
    """Return the names of the kinds, each once, in order."""
    return list(dict.fromkeys(impairment.kind for impairment in impairments))


def chosen_kinds(names: Iterable[str] | None) -> tuple[Impairment, ...]:
    """Return the impairments of some kinds, or all that models learn; unchanged copies are always among them.

    Raises
    ------
    InputError
        If there is no such kind.
    """
    if names is None:
        return COPIES
    wanted = set(names)
    every = (*COPIES, *HELD_OUT)
    require_known("--kinds", sorted(wanted), kinds_of(every))
    return tuple(impairment for impairment in every if impairment.kind in wanted | {"whole"})
