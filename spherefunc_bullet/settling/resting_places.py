"""Resting places: where the first spheres dropped on an object come to rest, so that something can be put there."""

from __future__ import annotations

import numpy as np

from ..clouds.cloud import Cloud
from ..simulator import DropSettings, make_simulator

DROPS = 200
ACROSS = 40  # approximate number of radii along the largest extent
LIMITS = (0.005, 0.03)  # metres, range of the radius


def place_radius(cloud: Cloud) -> float:
    """Return the radius of the spheres that find resting places on an object, metres."""
    return float(np.clip(cloud.size.max() / ACROSS, *LIMITS))


def resting_places(cloud: Cloud, radius: float | None = None, seed: int = 0) -> np.ndarray:
    """Return where spheres that touch the object rest on it, (P, 3) metres, below their centres.

    They are found with ``fast``; rigid bodies only test the places.
    """
    radius = place_radius(cloud) if radius is None else radius
    settings = DropSettings(radius=radius, miss_limit=DROPS, max_drops=DROPS)
    result = make_simulator("fast").drop(cloud, settings, seed)
    return result.centers[result.on_object] - [0, 0, radius]
