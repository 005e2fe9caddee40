"""What spoils a seat and a table top alike: gone, tilted, turned over."""

from __future__ import annotations

import numpy as np

from .levels import cut_away, still_serves
from .poses import upside_down
from .specimen import Specimen, spike
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
