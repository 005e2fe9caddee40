"""What a model may ask for: its file may be anybody's, and runs without bounds would not end."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..errors import InputError
from ..formats.units import format_length

SPHERES = (0.0005, 0.2)  # metres of radius, of spheres that functions are told by: larger ones lie on no seat
MOST_RADII, MOST_DROPS = 20, 10_000  # the drops at each radius


def require_bounds(radii: Sequence[float], drops: int | None, path: str | Path):
    """Raise InputError for a model of more or other spheres than any object is worth."""
    if not (0 < len(radii) <= MOST_RADII and all(SPHERES[0] <= radius <= SPHERES[1] for radius in radii)):
        wanted = f"1 to {MOST_RADII} radii from {format_length(SPHERES[0])} to {format_length(SPHERES[1])}"
        raise InputError(f"{path}: expected a model of {wanted}, got {', '.join(map(str, radii[:MOST_RADII]))} m")
    if drops is not None and not 0 < drops <= MOST_DROPS:
        raise InputError(f"{path}: expected a model of 1 to {MOST_DROPS:,} drops at each radius, got {drops:,}")
