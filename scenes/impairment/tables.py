"""Tables that carry nothing. Each takes a specimen and a generator, and returns a surface, or None."""

from __future__ import annotations

import numpy as np

from .bodies import spike
from .levels import cut_away
from .specimen import Specimen
from .surfaces import Surface
from .tops import tilted

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
