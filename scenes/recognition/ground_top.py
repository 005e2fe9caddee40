"""The table top that serves as ground, as an object of its own: a robot in front of a table sees no floor."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..scans.cells import cells
from ..scans.levelling import Levelling
from ..segmentation.box import bounding_box
from ..segmentation.clusters import euclidean_clusters, members_of
from ..segmentation.segmentation import FLOOR
from .judging import Part, RecognitionContext, classify_parts
from .proposals import CLUSTERS, Proposal
from .room import SceneObject

TABLE_TOP = "table top"  # `Levelling.source`, and where the object comes from
USUAL_HEIGHT = 0.73  # metres: of dining tables and desks (EN 527-1: 0.72 to 0.74), where no floor tells
HEIGHTS = (0.3, 1.3)  # metres above z = 0 of a level frame between which that is a floor and the top a table's
UPRIGHT = 0.999  # cosine of 2.6 degrees: a scan's own z axis that is gravity's
BELOW = 0.05  # metres below z = 0 that a sensor's noise puts points
APART = 0.05  # metres between parts of one top
_VOXEL = 0.01  # metres: the top as it is parted, and the sheet that spheres fall on


@dataclass(frozen=True, kw_only=True, eq=False)
class GroundTop:
    """The table top at z = 0 of the level frame."""

    members: np.ndarray  # (K,) int64, ascending, of the scene's points
    height: float | None  # over the floor, metres; None where nothing tells it


def ground_top_of(points: np.ndarray, labels: np.ndarray, levelling: Levelling) -> GroundTop | None:
    """Return the table top that carries a scene of points (N, 3) and labels (N,); None where a floor does."""
    on_ground = np.flatnonzero(labels == FLOOR)
    if levelling.source != TABLE_TOP or not len(on_ground):
        return None
    voxels = cells(points[on_ground], _VOXEL)
    parts = members_of(euclidean_clusters(voxels.means, APART))
    largest = np.zeros(len(voxels.means), bool)
    largest[max(parts, key=len)] = True
    return GroundTop(members=on_ground[largest[voxels.cell_of]], height=height_in_scan(points, levelling))


def height_in_scan(points: np.ndarray, levelling: Levelling) -> float | None:
    """Return the height of the level frame's z = 0 over that of the scan's, if the latter is a floor's; metres.

    It is where the scan's z axis points up, all points (N, 3) lie above its z = 0, and tables are so high.
    """
    height, lowest = levelling.height, float(points[:, 2].min())
    on_floor = levelling.up[2] > UPRIGHT and lowest + height > -BELOW
    return height if on_floor and HEIGHTS[0] < height < HEIGHTS[1] else None


def object_of_top(top: GroundTop, points: np.ndarray, context: RecognitionContext, number: int) -> SceneObject:
    """Return the top as an object, classified as a whole sheet: what stands on it hides the rest.

    Spheres fall on the convex outline of what is seen, at its height over the floor, or at the usual one of tables
    where nothing tells it. ``number`` is its id.
    """
    own = points[top.members]
    height = USUAL_HEIGHT if top.height is None else top.height
    box = bounding_box(own)
    sheet = sheet_within(own)
    proposal = Proposal(by=CLUSTERS, members=top.members, support=-height, box=box)
    alone = replace(context, completion=(), ground_seen=True, surroundings=None)
    functions = classify_parts([Part(proposal, sheet, bounding_box(sheet))], alone)[0]
    return SceneObject(
        id=number,
        points=own,
        support=-(top.height or 0.0),
        box=box if top.height is None else box.lowered(-top.height),
        fragment=False,
        functions=functions,
        made_from=TABLE_TOP,
        height=top.height,
    )


def sheet_within(points: np.ndarray) -> np.ndarray:
    """Return a level sheet (M, 3) at z = 0 over the convex outline of points (N, 3), metres."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points[:, :2])
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    x, y = (np.arange(low[k], high[k], _VOXEL / 2) for k in range(2))
    sheet = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    inside = (hull.equations[:, :2] @ sheet.T + hull.equations[:, 2:] <= 0).all(axis=0)
    return np.column_stack([sheet[inside], np.zeros(inside.sum())])
