"""Vessels with a hole in the wall at a stated height: they keep what lies below it, and only that.

Kinds beside `IMPAIRMENTS`, as sawn furniture: who learns from impaired copies does not learn these.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .cavities import Cavity
from .cups import away_from_handle
from .impairments import Impairment, useless
from .poses import level_direction
from .specimen import Specimen
from .surfaces import Surface

HEIGHTS = (0.25, 0.5, 0.75)  # of the way from a cavity's floor to its brim: the middle of the hole
ACROSS = 16.0  # radii of the carried spheres to an object's largest extent, see `simulator.mechanics`
WIDE = 1.5  # such radii, the hole's radius: a sphere passes with room to spare


def hole_in_wall(height: float) -> Callable[[Specimen, np.random.Generator], Surface | None]:
    """Return the change that cuts a round hole into a vessel's wall, away from a handle, at a share of its depth."""

    def cut(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
        """Return the surface with the hole; None where there is no cavity, or no triangles to cut."""
        cup, surface = specimen.cavity, specimen.surface
        if cup is None or surface.is_cloud:
            return None
        gone = in_hole(surface, cup, level_direction(away_from_handle(surface, cup, rng)), height)
        return surface.without(gone) if gone.any() else None

    return cut


def in_hole(surface: Surface, cup: Cavity, out: np.ndarray, height: float) -> np.ndarray:
    """Return which pieces of a surface are within a level bore towards a direction (2,), (P,) bool."""
    middle = cup.floor + height * (cup.brim - cup.floor)
    radius = max(WIDE * surface.size.max() / ACROSS, 2 * cup.grid.cell)
    places = surface.centres[:, :2] - cup.axis
    along, across = places @ out, places @ [-out[1], out[0]]
    beyond = along > 0.5 * np.interp(middle, cup.heights, cup.radii)
    return beyond & (np.hypot(across, surface.centres[:, 2] - middle) < radius)


HOLED = tuple(
    impairment
    for height in HEIGHTS
    for impairment in useless("cup", **{f"hole_at_{round(100 * height)}": hole_in_wall(height)})
)


def holed_copies(specimen: Specimen, name: str, seed: int) -> list[tuple[Impairment, Surface]]:
    """Return a vessel with a hole at each height at which one can be made, each with its kind."""
    made = [(kind, kind.applied(specimen, name, seed)) for kind in HOLED]
    return [(kind, surface) for kind, surface in made if surface is not None]
