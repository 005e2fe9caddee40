"""The stability check: an object that would fall over when it is put down as it is has no function in that pose.

Asked of what claims a function by its spheres alone, which hold it still: an armchair upside down has a level between
parts that rise around it, and nobody can sit on it.
"""

from __future__ import annotations

from ...clouds.cloud import Cloud
from ...errors import InputError
from ..mechanics import LEVEL, Matter, StandSettings
from .levelling import SAFE, reach_around

FALLS_DEG = 20.0  # by which it would turn: no useful one of 382 models by other people does so (tests)


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
    return bool(reach_around(feet, cloud) > SAFE * extent)
