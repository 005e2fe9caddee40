"""What spoils a seat and a table top alike: gone, tilted, turned over."""

from __future__ import annotations

import numpy as np

from .levels import cut_away, still_serves
from .specimen import Specimen, box, laid, level_direction, spike, upside_down
from .surfaces import Surface

TILT_DEG = 35.0  # far beyond what anything stays on


def missing(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Take away the seat or top with all that lies close below it."""
    level = specimen.level
    impaired = None if level is None else cut_away(specimen.surface, level)
    return None if impaired is None or still_serves(impaired, level) else impaired


def tilted(surface: Surface, specimen: Specimen, downhill: np.ndarray, degrees: float = TILT_DEG) -> Surface | None:
    """Return a surface whose level slopes down along a level unit vector (2,), the rest as it was."""
    level, rest = specimen.level, cut_away(surface, specimen.level)
    if rest is None:
        return None
    height = surface.centres[:, 2]
    slab = level.over(surface.centres) & (height >= 0.85 * level.height) & (height <= level.upper + 0.012)
    slope, middle = np.tan(np.radians(degrees)), level.box.mean(axis=0)

    def sloped(points: np.ndarray) -> np.ndarray:
        rise = -slope * ((points[:, :2] - middle) @ downhill)
        return points + np.outer(rise, [0, 0, 1])

    top = surface.only(slab).mapped(sloped)
    sunk = max(0.02 - top.bounds[0, 2], 0.0)
    impaired = rest.joined(top.mapped(lambda points: points + [0, 0, sunk]))
    return None if still_serves(impaired, level) else impaired


def turned_over(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Turn furniture over; a block that is then as high and level as before is left out."""
    if specimen.level is None:
        return None
    impaired = upside_down(specimen.surface, rng)
    return None if still_serves(impaired, specimen.level) else impaired


SPIKE = 0.06  # metres, the side of a spike's foot; they stand side by side
SPIKES = 40  # at most along the longer side of a top
TALL = (0.1, 0.2)  # metres


def half_top(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Take away half of the top, across its longer side."""
    top = specimen.level
    if top is None:
        return None
    axis, side = int((top.box[1] - top.box[0]).argmax()), rng.choice([-1, 1])
    middle = top.box.mean(axis=0)
    return cut_away(specimen.surface, top, lambda places: side * (places[:, axis] - middle[axis]) > 0)


def tilted_top(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Let the top slope across its shorter side, one way or the other."""
    if specimen.level is None:
        return None
    axis = int((specimen.level.box[1] - specimen.level.box[0]).argmin())
    return tilted(specimen.surface, specimen, rng.choice([-1, 1]) * np.eye(2)[axis])


def spikes_on_top(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Cover the top with pyramids of different heights, side by side."""
    top = specimen.level
    if top is None or specimen.surface.is_cloud:
        return None
    low, high = top.box
    pitch = max(SPIKE, (high - low).max() / SPIKES)
    xs, ys = (np.arange(start + pitch / 2, end + pitch / 4, pitch) for start, end in zip(low, high, strict=True))
    feet = np.array([(x, y) for x in xs for y in ys])
    feet = feet[top.flat[top.grid.cells_of(feet)]]
    if not len(feet):
        return None
    tips = top.height + rng.uniform(*TALL, len(feet))
    spikes = [spike(foot, pitch, top.height - 0.01, tip) for foot, tip in zip(feet, tips, strict=True)]
    return specimen.surface.joined(Surface(np.concatenate(spikes)))


GAP = 0.3  # metres, wider than a person's thighs are deep
LEAST_GAP = 0.2  # metres, on small stools
BAR = 0.05  # metres between gaps, at least
BOX = 0.4  # metres, the height of what occupies the seat


def gaps_in_seat(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Leave bars of the seat, with gaps between them through which a person falls."""
    seat = specimen.level
    if seat is None:
        return None
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


def tilted_seat(specimen: Specimen, rng: np.random.Generator, degrees: float = TILT_DEG) -> Surface | None:
    """Let the seat slope away from the back, or any way where there is no back."""
    if specimen.level is None:
        return None
    anywhere = level_direction(rng.integers(4) * np.pi / 2)
    return tilted(specimen.surface, specimen, anywhere if specimen.back is None else -specimen.back, degrees)


def box_on_seat(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Put a box on the seat, as large as the seat."""
    seat = specimen.level
    if seat is None or specimen.surface.is_cloud:
        return None
    low, high = seat.box
    foot = seat.height - 0.01
    body = box(np.array([*low, foot]), np.array([*high, foot + BOX + rng.uniform(0, 0.1)]))
    occupied = specimen.surface.joined(Surface(body))
    return None if still_serves(occupied, seat) else occupied


def seat_on_back(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Lay the seat on its back, or on any side where it has none; blocks that serve as well there are left out."""
    if specimen.level is None:
        return None
    anywhere = level_direction(rng.integers(4) * np.pi / 2)
    impaired = laid(specimen.surface, anywhere if specimen.back is None else specimen.back)
    return None if still_serves(impaired, specimen.level) else impaired
