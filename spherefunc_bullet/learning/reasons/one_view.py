"""Clouds of which a sensor saw one side, so that spheres find no hold: completed, and told by the model for scans.

What completes them is found through the entry-point group ``spherefunc.completions``: a function of a cloud's points
(N, 3) in metres, z up, on the ground, that returns as many points and more.
"""

from __future__ import annotations

from functools import partial
from importlib.metadata import entry_points

import numpy as np

from ...clouds.cloud import Cloud, placed
from ...settling.drops import settled_centers
from ...settling.settling import Settled, settle
from ..function_model import FunctionModel
from ..profiles.profile_model import FEW

GROUP = "spherefunc.completions"
NOTHING = (
    "hardly anything settled on it; it looks like one view of an object, "
    "whose far side and bottom the sensor did not see"
)
COMPLETED = "it looks like one view of an object, so it was completed as objects of a scan are, and told by their model"
_SQUARE, _SPACINGS = 0.005, 1.5  # metres, and of the points: side of the squares that an underside is looked for in
_LOW, _LOW_SHARE = 0.015, 0.1  # metres, and of the height: what is no higher is of the underside
_UNDERSIDE = 0.5  # of the outline's area, from which on an object's underside was seen


def nothing_settled(settled: Settled) -> bool:
    """Return whether hardly a sphere of all radii together stayed."""
    return sum(len(settled_centers(rows)) for rows in settled.values()) < FEW


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


def settled_on_completed(cloud: Cloud, model: FunctionModel) -> Settled | None:
    """Return where spheres settle on a cloud that is completed; None where none does, or nothing completes clouds."""
    for point in entry_points(group=GROUP):
        whole = Cloud(placed(point.load()(cloud.points)), cloud.name)
        settled = model.settled_by(partial(settle, whole, model.simulator, model.chosen_radii(), model.seed))
        if not nothing_settled(settled):
            return settled
    return None
