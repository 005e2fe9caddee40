"""Every kind of change: of which functions' objects it is made, and whether they work afterwards."""

from __future__ import annotations

from collections.abc import Iterable

from spherefunc_bullet.errors import require_known

from . import cups, harmless, tops
from .specimen import FUNCTIONS, Change, Impairment
from .use.copies import AS_SENSED, IN_USE


def useless(function: str, **changes: Change) -> list[Impairment]:
    """Return kinds that spoil objects of one function."""
    return [
        Impairment(kind=kind, functions=(function,), works=False, change=change) for kind, change in changes.items()
    ]


def spared(functions: tuple[str, ...], **changes: Change) -> list[Impairment]:
    """Return kinds that must not matter."""
    return [Impairment(kind=kind, functions=functions, works=True, change=change) for kind, change in changes.items()]


IMPAIRMENTS = (
    *spared(FUNCTIONS, whole=harmless.whole),
    *useless(
        "cup",
        hole=cups.hole_in_bottom,
        slit=cups.slit_in_wall,
        lid=cups.lid_on_top,
        filled=cups.filled_to_brim,
        upside_down=cups.cup_upside_down,
        on_side=cups.cup_on_side,
    ),
    *useless(
        "sittable",
        missing=tops.missing,
        gaps=tops.gaps_in_seat,
        tilted=tops.tilted_seat,
        occupied=tops.box_on_seat,
        upside_down=tops.turned_over,
        on_back=tops.seat_on_back,
    ),
    *useless(
        "table",
        missing=tops.missing,
        half=tops.half_top,
        tilted=tops.tilted_top,
        upside_down=tops.turned_over,
        spikes=tops.spikes_on_top,
    ),
    *spared(("cup",), no_handle=harmless.without_handle),
    *spared(("sittable",), no_arms=harmless.without_arms),
    *spared(("sittable", "table"), other_legs=harmless.other_legs),
    *spared(
        FUNCTIONS,
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


def chosen_kinds(kinds: Iterable[str] | None) -> tuple[Impairment, ...]:
    """Return the impairments of some kinds, or all; what is whole is always among them.

    Raises
    ------
    InputError
        If there is no such kind.
    """
    if kinds is None:
        return COPIES
    wanted = set(kinds)
    require_known("--kinds", sorted(wanted), kinds_of())
    return tuple(impairment for impairment in COPIES if impairment.kind in wanted | {"whole"})
