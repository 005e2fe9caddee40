"""Places on an object where something can be put: where the first spheres that are dropped on it come to rest.

Found by rolling, since the places are a question to put to a body and not its answer.
"""

from __future__ import annotations

import numpy as np

from ..clouds.cloud import Cloud
from ..simulator import DropResult, DropSettings, make_simulator

DROPS = 200
ACROSS = 40  # radii to the largest extent, about
LIMITS = (0.005, 0.03)  # metres, of the radius
SMALL = LIMITS[0]  # of the spheres that water is to stand among


def place_radius(cloud: Cloud) -> float:
    """Return the radius of spheres that find places on an object, metres."""
    return float(np.clip(cloud.size.max() / ACROSS, *LIMITS))


def resting_places(cloud: Cloud, radius: float | None = None, seed: int = 0) -> np.ndarray:
    """Return where spheres that touch the object rest on it, (P, 3) metres, below their centres."""
    length = place_radius(cloud) if radius is None else radius
    result = rolled(cloud, length, seed)
    return result.centers[result.on_object] - [0, 0, length]


def rolled(cloud: Cloud, radius: float, seed: int) -> DropResult:
    """Return what becomes of the first spheres of a radius in metres."""
    settings = DropSettings(radius=radius, miss_limit=DROPS, max_drops=DROPS)
    return make_simulator("fast").drop(cloud, settings, seed)


def loses_water(cloud: Cloud) -> bool:
    """Return whether water runs out from among small spheres that stay in an object; never of points alone."""
    if cloud.mesh is None:
        return False
    from ..clouds.water import leaks  # of cups alone

    return leaks(cloud, rolled(cloud, SMALL, 0).centers)
