"""Kinds of copies in use and as sensed: of which functions' objects they are made, and whether they still work."""

from __future__ import annotations

import numpy as np

from ..kinds import FUNCTIONS, NONE, Change, Impairment
from ..levels import find_level
from ..specimen import Specimen
from ..surfaces import Surface
from . import cups, seats, sensed, tables
from .placing import with_objects
from .small_objects import small_object

VIEWPOINTS = 4  # that are tried
SHOWN = 0.35  # of the level's cells: from behind a chair nobody sees the seat
EVERYTHING = (*FUNCTIONS, NONE)


def used(function: str, **changes: Change) -> list[Impairment]:
    """Return kinds of use that objects of one function keep it in."""
    return [
        Impairment(kind=kind, functions=(function,), works=True, change=change, used=True)
        for kind, change in changes.items()
    ]


def used_up(function: str, **changes: Change) -> list[Impairment]:
    """Return kinds of use that leave nothing of a function."""
    return [
        Impairment(kind=kind, functions=(function,), works=False, change=change, used=True)
        for kind, change in changes.items()
    ]


def laden(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Put one to five objects on an object without a function, if it has a level."""
    if specimen.surface.is_cloud or specimen.surface.size[:2].min() < 0.15:
        return None
    level = find_level(specimen.surface, 0.1, 2.0)
    objects = [small_object(rng) for _ in range(rng.integers(1, 6))]
    return None if level is None else with_objects(specimen.surface, level, objects, rng)


def as_sensed(corrupt: sensed.Corrupt, least: float, most: float) -> Change:
    """Return the change that makes points of an object, corrupted between two severities, evenly by their logarithm."""

    def change(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
        """Return the points; None where those of the seat or the top are not among them."""
        for _ in range(VIEWPOINTS):
            how = float(np.exp(rng.uniform(np.log(least), np.log(most))))
            points = corrupt(specimen.cloud.points, how, rng)
            if len(points) >= sensed.LEFT and shows_level(specimen, points):
                return Surface(points=points)
        return None

    return change


def shows_level(specimen: Specimen, points: np.ndarray) -> bool:
    """Return whether points (N, 3) show enough of the seat or the top to tell, where there is one."""
    level = specimen.level
    if level is None:
        return True
    on_level = points[np.abs(points[:, 2] - level.height) < 0.15 * level.height]
    return len(np.unique(np.column_stack(level.grid.cells_of(on_level)), axis=0)) > SHOWN * level.flat.sum()


IN_USE = (
    *used(
        "table",
        laid=tables.laid(1, 1),
        laid_few=tables.laid(2, 4),
        laid_many=tables.laid(5, 8),
        cloth=tables.cloth,
        chairs_under=tables.chairs_under,
        at_wall=tables.at_wall,
    ),
    *used_up("table", full=tables.full),
    *used(
        "sittable",
        book=seats.with_book,
        cushion=seats.with_cushion,
        bag=seats.with_bag,
        coat=seats.with_coat,
    ),
    *used_up("sittable", spikes=seats.spikes_on_seat, taken=seats.taken),
    *used("cup", spoon=cups.with_spoon, liquid=cups.with_liquid, saucer=cups.on_saucer, held=cups.held),
    *used(NONE, laden=laden),
)
AS_SENSED = tuple(
    Impairment(kind=kind, functions=EVERYTHING, works=True, change=change, used=True)
    for kind, change in (
        ("noisy", as_sensed(sensed.noise, 0.003, 0.025)),
        ("sparse", as_sensed(sensed.sparse, 0.04, 0.5)),
        ("one_view", as_sensed(sensed.views, 1, 1)),
        ("some_views", as_sensed(sensed.views, 2, 3)),
        ("stray_points", as_sensed(sensed.outliers, 0.005, 0.05)),
    )
)
