"""Single views: clouds of which a sensor saw one side only, so that no spheres settle; recognition and completion.

Completions are found through the entry-point group ``spherefunc.completions``: functions of the points (N, 3) of a
cloud, in metres, z up, on the ground, that return these points and more.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import entry_points

import numpy as np

from .cloud import Cloud, placed

GROUP = "spherefunc.completions"
_SQUARE, _SPACINGS = 0.005, 1.5  # metres, and in spacings of the points: smallest side of the squares of an underside
_LOW, _LOW_SHARE = 0.015, 0.1  # metres, and of the height: lower points belong to the underside
_UNDERSIDE = 0.5  # of the area of the outline: with less, the underside was not seen


def looks_like_one_view(cloud: Cloud) -> bool:
    """Return whether a cloud has no mesh, and few points on the ground within its outline."""
    from scipy.spatial import ConvexHull, QhullError

    if cloud.mesh is not None:
        return False
    side = max(_SQUARE, _SPACINGS * cloud.spacing)
    low = cloud.points[:, 2] - cloud.bounds[0, 2] < max(_LOW, _LOW_SHARE * cloud.size[2])
    squares = np.unique(np.floor(cloud.points[low, :2] / side).astype(np.int64), axis=0)
    try:
        return bool(len(squares) * side**2 < _UNDERSIDE * ConvexHull(cloud.points[:, :2]).volume)
    except QhullError:  # upright and flat
        return True


def completed_clouds(cloud: Cloud) -> Iterator[Cloud]:
    """Yield the cloud completed by each installed completion."""
    for point in entry_points(group=GROUP):
        yield Cloud(placed(point.load()(cloud.points)), cloud.name)
