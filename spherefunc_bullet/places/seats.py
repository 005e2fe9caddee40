"""Whether what spheres take for a seat is one; docs/studies.md says what each check gains.

Nothing else is imported until a seat is checked: most first classifications need none of it.
"""

from __future__ import annotations

from ..clouds.cloud import Cloud

SPIKY = 1 / 3  # of a part: seats in use have less than 1/4, most spikes more than 2/5
FLOOR_SEAT = 0.05  # metres: the height of a floor chair


def has_no_place_to_sit(cloud: Cloud) -> bool:
    """Return whether `places` finds no place to sit on an object."""
    from .regions import seat_surface, without_strays  # needed for seats only
    from .sitting import sit_places

    return not sit_places(seat_surface(without_strays(cloud)), sittable=1.0)


def is_nowhere_level(cloud: Cloud) -> bool:
    """Return whether no points of an object are level over a hand's breadth at the height of a seat; False for a mesh.

    A bag on the seat of a mesh may leave less than that.
    """
    if cloud.mesh is not None:
        return False
    from .regions import HAND, level_breadth, surface_of, without_strays
    from .sitting import HIGH_SEAT, STEEPEST_DEG

    return level_breadth(surface_of(without_strays(cloud)), STEEPEST_DEG, FLOOR_SEAT, HIGH_SEAT) < HAND


def is_full_of_spikes(cloud: Cloud) -> bool:
    """Return whether most of an object's largest part is spikes; False without a mesh."""
    if cloud.mesh is None:
        return False
    from .regions import spiky_share, surface_of

    return spiky_share(surface_of(cloud)) > SPIKY
