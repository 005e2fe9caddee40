"""Clouds of which a sensor saw one side, so that spheres find no hold: recognised, and completed.

What completes them is found through the entry-point group ``spherefunc.completions``: a function of a cloud's points
(N, 3) in metres, z up, on the ground, that returns as many points and more.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import entry_points

import numpy as np

from .cloud import Cloud, placed

GROUP = "spherefunc.completions"
_SQUARE, _SPACINGS = 0.005, 1.5  # metres, and of the points: side of the squares that an underside is looked for in
_LOW, _LOW_SHARE = 0.015, 0.1  # metres, and of the height: what is no higher is of the underside
_UNDERSIDE = 0.5  # of the outline's area, from which on an object's underside was seen


def looks_like_one_view(cloud: Cloud) -> bool:
    """Return whether a cloud is points alone, and little of the ground within its outline has points."""
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
    """Yield a cloud completed in each way that is installed."""
    for point in entry_points(group=GROUP):
        yield Cloud(placed(point.load()(cloud.points)), cloud.name)
