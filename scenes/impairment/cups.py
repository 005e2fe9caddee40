"""Cups that hold nothing. Each takes a specimen and a generator, and returns a surface, or None where it cannot."""

from __future__ import annotations

import numpy as np

from .levels import Cavity
from .specimen import Specimen, circle, laid, level_direction, loft, needs, upside_down
from .surfaces import ObjectSurface

HOLE = 0.7  # of the cavity's radius at its floor
STEM = 0.3  # of the cup's height: a bowl that begins higher stands on a stem, which a hole would cut off
SLIT = 0.6  # of the cavity's largest radius, the width
HANDLE_ANGLES = 72  # directions from which the one farthest from a handle is chosen


@needs("cavity", useless=True)
def hole_in_bottom(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface | None:
    """Take away what lies under the middle of the cavity, down to the ground."""
    surface = specimen.surface
    if cup.floor > STEM * surface.size[2]:
        return None
    inside = np.interp(cup.floor + 0.15 * (cup.brim - cup.floor), cup.heights, cup.radii)
    radius = max(HOLE * inside, 2 * cup.grid.cell)
    rounded = cup.floor + 0.2 * (cup.brim - cup.floor)
    return surface.without((cup.distances(surface.centres) < radius) & (surface.centres[:, 2] < rounded))


@needs("cavity", useless=True)
def slit_in_wall(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface:
    """Cut the wall open from the brim to the floor, on the side away from a handle."""
    surface = specimen.surface
    along, across = along_and_across(surface, cup, rng)
    wide = max(SLIT * cup.radii.max(), 4 * cup.grid.cell)
    inside = (along > 0) & (np.abs(across) < wide / 2) & (surface.centres[:, 2] > cup.floor + cup.grid.cell)
    beyond = cup.distances(surface.centres) > 0.5 * np.interp(surface.centres[:, 2], cup.heights, cup.radii)
    return surface.without(inside & beyond)


def along_and_across(surface: ObjectSurface, cup: Cavity, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return where pieces are, (P,) and (P,) metres, along a direction away from a handle and across it."""
    places, out = surface.centres[:, :2] - cup.axis, level_direction(away_from_handle(surface, cup, rng))
    return places @ out, places @ [-out[1], out[0]]


def away_from_handle(surface: ObjectSurface, cup: Cavity, rng: np.random.Generator) -> float:
    """Return a direction, radians about z, in which a cup reaches hardly farther from its axis than in any other."""
    places = surface.centres[:, :2] - cup.axis
    every = np.linspace(0, 2 * np.pi, HANDLE_ANGLES, endpoint=False) + rng.uniform(0, 2 * np.pi / HANDLE_ANGLES)
    extents = [(places @ level_direction(angle)).max() for angle in every]
    nearest = np.flatnonzero(extents <= min(extents) + 0.02 * max(extents))
    return float(every[rng.choice(nearest)])


@needs("cavity", triangles=True)
def lid_on_top(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface:
    """Close the cup with a disc that reaches over its brim."""
    surface = specimen.surface
    radius = 1.03 * cup.reach
    foot = surface.centres[cup.distances(surface.centres) < radius, 2].max()
    rings = [circle(cup.axis, radius, height) for height in (foot, foot + 0.03 * surface.size[2])]
    return surface.joined(ObjectSurface(loft(rings)))


@needs("cavity", triangles=True, useless=True)
def filled_to_brim(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface:
    """Fill the cavity from its floor to its brim with something solid."""
    rings = [circle(cup.axis, radius, height) for height, radius in zip(cup.heights, cup.radii, strict=True)]
    return specimen.surface.joined(ObjectSurface(loft(rings)))


@needs("cavity", useless=True)
def cup_upside_down(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface:
    """Turn the cup over; one whose foot is as hollow as its bowl is left out."""
    return upside_down(specimen.surface, rng)


@needs("cavity", useless=True)
def cup_on_side(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface:
    """Lay the cup on its side, any side."""
    return laid(specimen.surface, level_direction(rng.uniform(0, 2 * np.pi)))
