"""Places on an object where something can be put: where the first spheres that are dropped on it come to rest."""

from __future__ import annotations

import numpy as np

from ..clouds.cloud import Cloud
from ..simulator import DropSettings, make_simulator

DROPS = 200
ACROSS = 40  # radii to the largest extent, about
LIMITS = (0.005, 0.03)  # metres, of the radius


def place_radius(cloud: Cloud) -> float:
    """Return the radius of spheres that find places on an object, metres."""
    return float(np.clip(cloud.size.max() / ACROSS, *LIMITS))


def resting_places(cloud: Cloud, radius: float | None = None, seed: int = 0) -> np.ndarray:
    """Return where spheres that touch the object rest on it, (P, 3) metres, below their centres.

    Found by rolling, since the places are a question to put to a body and not its answer.
    """
    length = place_radius(cloud) if radius is None else radius
    settings = DropSettings(radius=length, miss_limit=DROPS, max_drops=DROPS)
    result = make_simulator("fast").drop(cloud, settings, seed)
    return result.centers[result.on_object] - [0, 0, length]
