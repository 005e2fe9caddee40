"""Seats that nobody can sit on. Each takes a specimen and a generator, and returns a surface, or None."""

from __future__ import annotations

import numpy as np

from .levels import cut_away, still_serves
from .poses import laid, level_direction
from .specimen import Specimen, box
from .surfaces import Surface
from .tops import TILT_DEG, tilted

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
