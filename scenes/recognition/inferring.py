"""Unseen seats: an upright back at a table's edge probably has a seat below the table.

No sphere rests on a back, so such a seat is inferred and not found. It is reported separately with its reason, and not
counted.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..scans.cells import cells
from ..segmentation.clusters import Box, bounding_box, euclidean_clusters, members_of
from ..settings import POOL, RECOGNITION, SCAN
from .room import InferredObject, SceneObject
from .surroundings import level_of

SEAT, TABLE = "sittable", "table"  # the functions


def inferred_seats(points: np.ndarray, labels: np.ndarray, objects: Sequence[SceneObject]) -> list[InferredObject]:
    """Return the seats whose backs stand at the edges of tables and belong to no object with a function.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    labels : (N,) int
        The object of each point from 0, -1 the floor, -2 walls, -3 points that are left over.
    objects : sequence of SceneObject
    """
    of_use = np.array([bool(item.members) for item in objects] + [False])
    free = (labels != -1) & (labels != -2) & ~of_use[np.where(labels >= 0, labels, len(objects))]
    seats, taken = [], [item.box for item in objects if SEAT in item.members]
    for table in (item for item in objects if TABLE in item.members):
        top = level_of(cells(table.points, SCAN.cell).means, SCAN.cell).height
        edge = bounding_box(table.points[np.abs(table.points[:, 2] - top) < POOL.slab])
        beside = free & (points[:, 2] > top - 2 * SCAN.cell)
        joined = (labels == table.id) & (points[:, 2] > top + SCAN.cell)  # in one cluster with the table
        for back in backs_at(points[beside | joined], edge, top):
            seat = seat_of(back, table)
            if all(np.linalg.norm(seat.center[:2] - other.center[:2]) > RECOGNITION.tucked_depth for other in taken):
                taken.append(seat)
                seats.append(InferredObject(function=SEAT, box=seat, table=table.id, reason=reason_of(back, table)))
    return seats


def backs_at(points: np.ndarray, table: Box, top: float) -> list[Box]:
    """Return the boxes of the backs among points (N, 3) at the edge of a table whose top has a height in metres."""
    beside = beyond_edge(points, table)
    around = (beside > -2 * SCAN.cell) & (beside < RECOGNITION.tucked_reach) & (points[:, 2] < POOL.highest)
    if not around.any():
        return []
    voxels = cells(points[around], SCAN.cell).means
    members = members_of(euclidean_clusters(voxels, 2 * SCAN.cell))
    boxes = [bounding_box(voxels[rows]) for rows in members if len(rows) > 10]
    return [box for box in boxes if is_back(box, top)]


def beyond_edge(points: np.ndarray, box: Box) -> np.ndarray:
    """Return the distances of points (N, 3) outside a box seen from above, metres, negative inside."""
    outside = np.abs(box.to_own(points)[:, :2]) - box.size[:2] / 2
    return np.where((outside > 0).all(axis=1), np.linalg.norm(outside, axis=1), outside.max(axis=1))


def is_back(box: Box, top: float) -> bool:
    """Return whether a box is upright, thin, as wide as a chair, and taller than a table's top."""
    width, thickness, height = box.size
    narrowest, widest = RECOGNITION.tucked_width
    thin = thickness <= min(RECOGNITION.tucked_thickness, 0.6 * width)
    tall = height >= 2 * SCAN.cell and box.center[2] + height / 2 > top + 2 * SCAN.cell
    return bool(narrowest <= width <= widest and thin and tall)


def seat_of(back: Box, table: SceneObject) -> Box:
    """Return the box of the chair whose back is seen: from the back towards the table, down to the floor."""
    across = back.axes[1, :2]
    toward = across if across @ (table.box.center[:2] - back.center[:2]) > 0 else -across
    height, depth = back.center[2] + back.size[2] / 2, RECOGNITION.tucked_depth
    middle = back.center[:2] + toward * (depth - back.size[1]) / 2
    return Box(center=np.array([*middle, height / 2]), size=np.array([back.size[0], depth, height]), yaw=back.yaw)


def reason_of(back: Box, table: SceneObject) -> str:
    """Return the reason for an inferred seat, as a text."""
    height = back.center[2] + back.size[2] / 2
    return (
        f"an upright back {100 * back.size[0]:.0f} cm wide and {100 * height:.0f} cm high stands at the edge of table "
        f"{table.id}; its seat, below the table, was not seen"
    )
