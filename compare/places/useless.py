"""Copies of seats on which nobody can sit, and whether that can be said of a seat's copies at all."""

from __future__ import annotations

from functools import partial

import numpy as np

from spherefunc_bullet.places.finding import places_of
from spherefunc_bullet.scenes.impairment.impairments import IMPAIRMENTS
from spherefunc_bullet.scenes.impairment.levels import Level
from spherefunc_bullet.scenes.impairment.specimen import Impairment, Specimen, kinds, needs
from spherefunc_bullet.scenes.impairment.surfaces import Surface
from spherefunc_bullet.scenes.impairment.tops import spikes_on_top, tilted_seat

SEAT, WHOLE = "sittable", "whole"
SURE = {SEAT: 1.0}
FOLDED = 0.1  # metres, how thick a folded chair is
APART = 0.1  # metres in height: another level


@needs("level")
def folded(specimen: Specimen, level: Level, rng: np.random.Generator) -> Surface:
    """Press a seat flat from its back to its front."""
    low, high = level.box
    axis = int((high - low).argmin()) if specimen.back is None else int(np.abs(specimen.back).argmax())
    pressed = np.ones(3)
    pressed[axis] = FOLDED / max(specimen.surface.size[axis], FOLDED)
    return specimen.surface.mapped(lambda points: points * pressed)


def useless_seats() -> list[Impairment]:
    """Return the kinds of copies on which nobody can sit."""
    more = {"tilted by 25 degrees": partial(tilted_seat, degrees=25.0), "spikes": spikes_on_top, "folded": folded}
    return [kind for kind in IMPAIRMENTS if SEAT in kind.functions and not kind.works] + kinds((SEAT,), False, **more)


def impairs_seat(specimen: Specimen) -> bool:
    """Return whether the level that is impaired is that of all places to sit; an ottoman beside it stays a seat."""
    places, level = [place for place in places_of(specimen.cloud, scores=SURE) if place.kind == "sit"], specimen.level
    if not places or level is None:
        return False
    on_it = level.flat[level.grid.cells_of(np.array([place.position for place in places]))]
    return bool(on_it.all() and all(abs(place.height - level.height) < APART for place in places))
