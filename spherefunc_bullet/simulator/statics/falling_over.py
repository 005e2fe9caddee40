"""The stability check: an object that would fall over when it is put down as it is has no function in that pose.

Asked of what claims a function by its spheres alone, which hold it still: an armchair upside down has a level between
parts that rise around it, and nobody can sit on it.
"""

from __future__ import annotations

import numpy as np

from ...clouds.cloud import Cloud
from ...errors import InputError
from ..mechanics import LEVEL, Matter, StandSettings

FALLS_DEG = 20.0  # by which it would turn: no useful one of 382 models by other people does so (tests)
SAFE = 0.01  # of the extent, within the polygon of its feet: how far sampled points may mistake where its weight acts
DIRECTIONS = 64  # in which feet have to reach so far beyond it: a circle's chords are a thousandth short


def falls_over(cloud: Cloud) -> bool:
    """Return whether an object turns by more than 20 degrees when it is let go as it stands.

    Of points alone nobody knows: what the sensor did not see has weight, too, and feet. Nor does a sheet fall.
    """
    if cloud.mesh is None or stands_safely(cloud):
        return False
    from .body import body_of  # scipy's hull, which takes longer to load than most answers
    from .standing import stand

    try:
        body = body_of(cloud, Matter())
    except InputError:
        return False
    return stand(body, StandSettings()).tilt_deg > FALLS_DEG


def stands_safely(cloud: Cloud) -> bool:
    """Return whether an object's weight acts well within the polygon of its feet: most do, which is quickly seen."""
    vertices, extent = cloud.mesh.vertices, cloud.size.max()
    feet = vertices[vertices[:, 2] < vertices[:, 2].min() + LEVEL * extent, :2]
    angles = np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS
    reach = ((feet - cloud.points[:, :2].mean(axis=0)) @ np.stack([np.cos(angles), np.sin(angles)])).max(axis=0)
    return bool(reach.min() > SAFE * extent)
