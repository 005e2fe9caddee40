"""Checks of an object that seems to have a function: whether it holds water, and whether a person has a place on it.

Spheres are no sharp judges of holes, spikes and slopes; docs/studies.md says what each check gains.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

from .clouds.cloud import Cloud
from .clouds.one_view import looks_like_one_view
from .settling.cached_runs import Check
from .settling.settling import loses_water

CUP, SITTABLE, TABLE = "cup", "sittable", "table"
LEAKS = "spheres stay in it as in a cup, but water runs out through a hole or a slit"
OPEN = "spheres stay in it as in a cup, but water would run out where no surface was seen"
HOLE_SEEN = "at least half of its bottom was seen, so it probably has a hole"
NO_PLACE = "spheres stay on it as on a seat, but there is no place on it where a person would fit"
SLOPING = "none of it is level over a hand's breadth at the height of a seat"
SPIKES = "spheres stay on it as on a seat, but it is full of spikes"
SPIKY = 1 / 3  # of a part: seats in use have less than 1/4, most spikes more than 2/5
FLOOR_SEAT = 0.05  # metres: the height of a floor chair


def mesh_leaks(cloud: Cloud) -> bool:
    """Return whether water runs out of an object through a hole; False without a mesh."""
    return cloud.mesh is not None and loses_water(cloud)


def points_leak(cloud: Cloud) -> bool:
    """Return whether water would run out between the points of an object that has no mesh."""
    return cloud.mesh is None and loses_water(cloud)


def bottom_was_seen(cloud: Cloud) -> bool:
    """Return whether points lie low within half of an object's outline: its underside, or the floor of a vessel."""
    return not looks_like_one_view(cloud)


def has_no_place_to_sit(cloud: Cloud) -> bool:
    """Return whether `places` finds no place to sit on an object."""
    from .places.regions import seat_surface, without_strays  # needed for seats only
    from .places.sitting import sit_places

    return not sit_places(seat_surface(without_strays(cloud)), sittable=1.0)


def is_nowhere_level(cloud: Cloud) -> bool:
    """Return whether no points of an object are level over a hand's breadth at the height of a seat; False for a mesh.

    A bag on the seat of a mesh may leave less than that.
    """
    if cloud.mesh is not None:
        return False
    from .places.regions import HAND, level_breadth, surface_of, without_strays
    from .places.sitting import HIGH_SEAT, STEEPEST_DEG

    return level_breadth(surface_of(without_strays(cloud)), STEEPEST_DEG, FLOOR_SEAT, HIGH_SEAT) < HAND


def is_full_of_spikes(cloud: Cloud) -> bool:
    """Return whether most of an object's largest part is spikes; False without a mesh."""
    if cloud.mesh is None:
        return False
    from .places.regions import spiky_share, surface_of

    return spiky_share(surface_of(cloud)) > SPIKY


@dataclass(frozen=True, kw_only=True)
class UseCheck:
    """A check of an object that seems to have a function; if the object fails it, the answer is unsure."""

    name: str  # under which the result is cached; a check that changes needs another name
    function: str
    fails: Callable[[Cloud], bool]
    doubt: str
    excludes: bool  # whether an object that fails does not have the function
    after: str = ""  # the name of a check before it, which such an object also fails


USE_CHECKS = (
    UseCheck(name="leaks", function=CUP, fails=mesh_leaks, doubt=LEAKS, excludes=True),
    # A scan from above may not show the bottom of a cup, so this is only a doubt.
    UseCheck(name="points_leak", function=CUP, fails=points_leak, doubt=OPEN, excludes=False),
    UseCheck(
        name="hole_seen", function=CUP, fails=bottom_was_seen, doubt=HOLE_SEEN, excludes=True, after="points_leak"
    ),
    # A seat on which a bag lies may have no place to sit and is still a seat, so this is only a doubt.
    UseCheck(name="nowhere_to_sit", function=SITTABLE, fails=has_no_place_to_sit, doubt=NO_PLACE, excludes=False),
    UseCheck(
        name="spikes", function=SITTABLE, fails=is_full_of_spikes, doubt=SPIKES, excludes=True, after="nowhere_to_sit"
    ),
    UseCheck(
        name="level_nowhere",
        function=SITTABLE,
        fails=is_nowhere_level,
        doubt=SLOPING,
        excludes=True,
        after="nowhere_to_sit",
    ),
)


def failed_uses(functions: Collection[str], check: Check) -> tuple[UseCheck, ...]:
    """Return the failed checks of an object, among those for functions that it seems to have."""
    failed: dict[str, UseCheck] = {}
    for use in USE_CHECKS:
        if use.function in functions and (not use.after or use.after in failed) and check(use.name, use.fails):
            failed[use.name] = use
    return tuple(failed.values())
