"""What makes objects useless: cups that hold no water; seats and tops that are gone, tilted, covered or turned over.

Each change takes a specimen and a generator, and returns a surface, or None where it cannot be made.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .levels import Cavity, LevelPart, cut_away
from .specimen import Specimen, box, circle, laid, level_direction, loft, needs, spike, upside_down
from .surfaces import ObjectSurface

HOLE = 0.7  # of the cavity's radius at its floor
STEM = 0.3  # of the cup's height: a bowl that begins higher stands on a stem, which a hole would cut off
SLIT = 0.6  # of the cavity's largest radius, the width
HANDLE_ANGLES = 72  # directions, of which one away from the handle is chosen


@needs("cavity", useless=True)
def hole_in_bottom(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface | None:
    """Take away everything under the middle of the cavity, down to the ground."""
    bottom = bottom_of(specimen.surface, cup, HOLE)
    return None if bottom is None else specimen.surface.without(bottom)


def bottom_of(surface: ObjectSurface, cup: Cavity, share: float) -> np.ndarray | None:
    """Return the pieces (P,) bool below the cavity, within a share of its radius; None if it stands on a stem."""
    if cup.floor > STEM * surface.size[2]:
        return None
    inside = np.interp(cup.floor + 0.15 * (cup.brim - cup.floor), cup.heights, cup.radii)
    radius = max(share * inside, 2 * cup.grid.cell)
    rounded = cup.floor + 0.2 * (cup.brim - cup.floor)
    return (cup.distances(surface.centres) < radius) & (surface.centres[:, 2] < rounded)


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
    """Return the coordinates of pieces, (P,) and (P,) metres, along a direction away from a handle and across it."""
    places = surface.centres[:, :2] - cup.axis
    every = np.linspace(0, 2 * np.pi, HANDLE_ANGLES, endpoint=False) + rng.uniform(0, 2 * np.pi / HANDLE_ANGLES)
    extents = [(places @ level_direction(angle)).max() for angle in every]
    nearest = np.flatnonzero(extents <= min(extents) + 0.02 * max(extents))  # where no handle makes it reach farther
    out = level_direction(float(every[rng.choice(nearest)]))
    return places @ out, places @ [-out[1], out[0]]


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
    """Turn the cup over; left out where its foot is as hollow as its bowl."""
    return upside_down(specimen.surface, rng)


@needs("cavity", useless=True)
def cup_on_side(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface:
    """Lay the cup on its side, any side."""
    return laid(specimen.surface, level_direction(rng.uniform(0, 2 * np.pi)))


TILT_DEG = 35.0  # far steeper than anything stays on


@needs("level", useless=True)
def missing(specimen: Specimen, level: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Take away the seat or top with everything close below it."""
    return cut_away(specimen.surface, level)


def tilted(
    surface: ObjectSurface, level: LevelPart, downhill: np.ndarray, degrees: float = TILT_DEG
) -> ObjectSurface | None:
    """Return a surface whose level slopes down along a level unit vector (2,); the rest is unchanged."""
    rest = cut_away(surface, level)
    if rest is None:
        return None
    slope, middle = np.tan(np.radians(degrees)), level.box.mean(axis=0)

    def sloped(points: np.ndarray) -> np.ndarray:
        return points + np.outer(-slope * ((points[:, :2] - middle) @ downhill), [0, 0, 1])

    top = slab_of(surface, level).mapped(sloped)
    sunk = max(0.02 - top.bounds[0, 2], 0.0)
    return rest.joined(top.mapped(lambda points: points + [0, 0, sunk]))


def slab_of(surface: ObjectSurface, level: LevelPart) -> ObjectSurface:
    """Return a level alone, as thick as a board."""
    height = surface.centres[:, 2]
    return surface.only(level.over(surface.centres) & (height >= 0.85 * level.height) & (height <= level.upper + 0.012))


@needs("level", useless=True)
def turned_over(specimen: Specimen, level: LevelPart, rng: np.random.Generator) -> ObjectSurface:
    """Turn furniture over; left out where a block is then as high and level as before."""
    return upside_down(specimen.surface, rng)


SPIKE = 0.06  # metres, the side of a spike's foot; they stand side by side
SPIKES = 40  # at most along the longer side of a top
TALL = (0.1, 0.2)  # metres


@needs("level")
def half_top(specimen: Specimen, top: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Take away half of the top, across its longer side."""
    axis, side = int((top.box[1] - top.box[0]).argmax()), rng.choice([-1, 1])
    middle = top.box.mean(axis=0)
    return cut_away(specimen.surface, top, lambda places: side * (places[:, axis] - middle[axis]) > 0)


@needs("level", useless=True)
def tilted_top(specimen: Specimen, top: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Let the top slope across its shorter side, one way or the other."""
    axis = int((top.box[1] - top.box[0]).argmin())
    return tilted(specimen.surface, top, rng.choice([-1, 1]) * np.eye(2)[axis])


@needs("level", triangles=True)
def spikes_on_top(specimen: Specimen, top: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Cover the top with pyramids of different heights, side by side."""
    pitch = max(SPIKE, (top.box[1] - top.box[0]).max() / SPIKES)
    return spiked(specimen.surface, top, pitch, lambda count: rng.uniform(*TALL, count))


def spiked(
    surface: ObjectSurface, level: LevelPart, pitch: float, draw: Callable[[int], np.ndarray]
) -> ObjectSurface | None:
    """Return a surface whose level is covered with pyramids a pitch apart, of a random height, metres."""
    low, high = level.box
    xs, ys = (np.arange(start + pitch / 2, end + pitch / 4, pitch) for start, end in zip(low, high, strict=True))
    feet = np.array([(x, y) for x in xs for y in ys]).reshape(-1, 2)
    feet = feet[level.flat[level.grid.cells_of(feet)]]
    if not len(feet):
        return None
    tips = level.height + draw(len(feet))
    spikes = [spike(foot, pitch, level.height - 0.01, tip) for foot, tip in zip(feet, tips, strict=True)]
    return surface.joined(ObjectSurface(np.concatenate(spikes)))


GAP = 0.3  # metres, wider than a person's thighs are deep
LEAST_GAP = 0.2  # metres, on small stools
BAR = 0.05  # metres between gaps, at least
BOX = 0.4  # metres, the height of the box on a seat


@needs("level")
def gaps_in_seat(specimen: Specimen, seat: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Leave bars of the seat, with gaps between them through which a person falls."""
    low, high = seat.box
    axis = int((high - low).argmax())
    length = high[axis] - low[axis]
    count = max(int((length - BAR) / (GAP + BAR)), 1)
    gap = min(GAP, 0.75 * length)
    if gap < LEAST_GAP:
        return None
    pitch = length / count

    def between_bars(places: np.ndarray) -> np.ndarray:
        return np.abs((places[:, axis] - low[axis]) % pitch - pitch / 2) < (pitch - max(pitch - gap, BAR)) / 2

    return cut_away(specimen.surface, seat, between_bars)


@needs("level", useless=True)
def tilted_seat(
    specimen: Specimen, seat: LevelPart, rng: np.random.Generator, degrees: float = TILT_DEG
) -> ObjectSurface | None:
    """Let the seat slope away from the back, or any way where there is no back."""
    anywhere = level_direction(rng.integers(4) * np.pi / 2)
    return tilted(specimen.surface, seat, anywhere if specimen.back is None else -specimen.back, degrees)


@needs("level", triangles=True, useless=True)
def box_on_seat(specimen: Specimen, seat: LevelPart, rng: np.random.Generator) -> ObjectSurface:
    """Put a box on the seat, as large as the seat."""
    low, high = seat.box
    foot = seat.height - 0.01
    body = box(np.array([*low, foot]), np.array([*high, foot + BOX + rng.uniform(0, 0.1)]))
    return specimen.surface.joined(ObjectSurface(body))


@needs("level", useless=True)
def seat_on_back(specimen: Specimen, seat: LevelPart, rng: np.random.Generator) -> ObjectSurface:
    """Lay the seat on its back, or on any side where it has none; left out where it serves as well then."""
    anywhere = level_direction(rng.integers(4) * np.pi / 2)
    return laid(specimen.surface, anywhere if specimen.back is None else specimen.back)
