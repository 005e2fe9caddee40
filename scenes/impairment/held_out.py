"""Useless copies of kinds that no model learns: they test whether what was never seen is noticed.

`dataset impair` makes them only if ``--kinds`` names them.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from .levels import Cavity, LevelPart, cut_away
from .specimen import Impairment, Specimen, kinds, laid, level_direction, needs, turn, turned
from .surfaces import ObjectSurface
from .useless import bottom_of, slab_of, tilted_seat

ROOF_DEG = 40.0  # of both halves
LEANING_DEG = 25.0  # of objects and of seats: less than that of the learnt seats that slope
FOLDED = 0.1  # metres, how thick a folded chair is


@needs("cavity", useless=True)
def half_of_bottom(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface | None:
    """Take away half of the cavity's floor, on any side, with everything below it."""
    out = level_direction(rng.uniform(0, 2 * np.pi))
    bottom = bottom_of(specimen.surface, cup, share=1.0)
    if bottom is None:
        return None
    return specimen.surface.without(bottom & ((specimen.surface.centres[:, :2] - cup.axis) @ out > 0))


@needs("level", useless=True)
def folded_to_roof(specimen: Specimen, level: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Fold the seat or the top along the middle of its longer side, so that both halves slope down from a ridge."""
    rest = cut_away(specimen.surface, level)
    if rest is None:
        return None
    across = int((level.box[1] - level.box[0]).argmin())
    half, middle = (level.box[1] - level.box[0])[across] / 2, level.box.mean(axis=0)[across]

    def folded(points: np.ndarray) -> np.ndarray:
        rise = np.tan(np.radians(ROOF_DEG)) * (half - np.abs(points[:, across] - middle))
        return points + np.outer(rise, [0, 0, 1])

    return rest.joined(slab_of(specimen.surface, level).mapped(folded))


@needs("level", useless=True)
def leaning(specimen: Specimen, level: LevelPart, rng: np.random.Generator) -> ObjectSurface:
    """Tilt the whole object, any way, as if something lay under one side."""
    axis = np.array([*level_direction(rng.uniform(0, 2 * np.pi)), 0.0])
    return turned(specimen.surface, turn(axis, np.radians(LEANING_DEG)))


@needs("level", useless=True)
def toppled(specimen: Specimen, level: LevelPart, rng: np.random.Generator) -> ObjectSurface:
    """Lay the object on its side, the left or the right one; on any side if it has no back."""
    back = level_direction(rng.integers(4) * np.pi / 2) if specimen.back is None else specimen.back
    return laid(specimen.surface, rng.choice([-1, 1]) * np.array([-back[1], back[0]]))


@needs("level")
def pressed_flat(specimen: Specimen, level: LevelPart, rng: np.random.Generator) -> ObjectSurface:
    """Press a seat flat from its back to its front, as a folding chair that leans on a wall."""
    low, high = level.box
    axis = int((high - low).argmin()) if specimen.back is None else int(np.abs(specimen.back).argmax())
    pressed = np.ones(3)
    pressed[axis] = FOLDED / max(specimen.surface.size[axis], FOLDED)
    return specimen.surface.mapped(lambda points: points * pressed)


FURNITURE = ("sittable", "table")
HELD_OUT: tuple[Impairment, ...] = (
    *kinds(("cup",), False, half_bottom=half_of_bottom),
    *kinds(("sittable",), False, sloping=partial(tilted_seat, degrees=LEANING_DEG), folded=pressed_flat),
    *kinds(FURNITURE, False, roof=folded_to_roof, leaning=leaning, toppled=toppled),
)
