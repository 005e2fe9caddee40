"""Which part of a map has changed since the last update, and a room with the objects of that part found anew."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..recognition.recognition import Room, RoomFrame
from ..recognition.room import SceneObject
from ..segmentation.segmentation import FLOOR, LEFT_OVER, WALL, shell_labels
from ..settings import RECOGNITION, SCAN, SEGMENTATION
from .point_map import NEW, PointMap

BOX = np.array([0.20, 0.20, 0.05])  # metres, sides of the boxes that are looked at together; see docs/scenes.md
CHANGED = 0.5  # of a box's voxels that are new or gone, from which on it has changed: noise adds some every time
LEAST_CHANGED = 40  # voxels; a small cup has some hundred
TOUCHED = 0.1  # of an object's voxels in such squares, from which on it is recognised anew, and
MOSTLY = 0.5  # in the squares of others that are


@dataclass(frozen=True, kw_only=True, eq=False)
class Region:
    """The part of a map in which objects are recognised anew."""

    corner: np.ndarray  # (2,) int64, the first square
    core: np.ndarray  # (X, Y) bool, the squares that have changed, and those of objects that reach into them
    in_core: np.ndarray  # (N,) bool, the map's voxels in these squares
    around: np.ndarray  # (N,) bool, and those around them, which help to decide

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Return which points (N, 3) of the level frame are in the core's squares, (N,) bool."""
        x, y = boxes_of(points)[:2] - self.corner[:, None]
        inside = (x >= 0) & (y >= 0) & (x < self.core.shape[0]) & (y < self.core.shape[1])
        return inside & self.core[np.where(inside, x, 0), np.where(inside, y, 0)]


def boxes_of(points: np.ndarray) -> np.ndarray:
    """Return the box (3, N) int64 of each point (N, 3) of the level frame, metres; one for all above any use."""
    columns = points[:, 0], points[:, 1], np.clip(points[:, 2], 0, SEGMENTATION.high)
    return np.stack([np.floor(column / side) for column, side in zip(columns, BOX, strict=True)]).astype(np.int64)


def changed_region(points: PointMap, frame: RoomFrame, lost: Sequence[int] = ()) -> Region | None:
    """Return the part of a map that has changed since objects were last recognised in it; None if it is no room's size.

    New voxels of the floor and the walls are labelled, and change nothing. Objects that are lost, by their labels, are
    searched anew.
    """
    from scipy.ndimage import binary_dilation

    level, count = frame.levelling.to_level(np.vstack([points.points, points.gone])), len(points.points)
    fresh = np.flatnonzero(points.labels == NEW)
    shell = shell_labels(level[fresh], frame.shell, frame.levelling.noise)
    points.labels[fresh] = np.where(shell == LEFT_OVER, NEW, shell)
    boxes = boxes_of(level)
    corner, shape = boxes.min(axis=1), np.ptp(boxes, axis=1) + 1
    if (shape * BOX).max() > SCAN.largest:  # by a wrong pose; so many boxes would fill the memory
        return None
    box, size = np.ravel_multi_index(tuple(boxes - corner[:, None]), shape), int(np.prod(shape))
    here, is_new = box[:count], points.labels == NEW
    is_old = ~is_new & (points.labels != FLOOR) & (points.labels != WALL)
    old, new, gone = (np.bincount(some, minlength=size) for some in (here[is_old], here[is_new], box[count:]))
    changed = (new + gone >= LEAST_CHANGED) & (new + gone > CHANGED * (old + np.maximum(new, gone)))
    square = here // shape[2]
    core = with_objects(changed.reshape(-1, shape[2]).any(axis=1), square, points.labels, lost).reshape(shape[:2])
    near = binary_dilation(core, iterations=round(RECOGNITION.far_level / BOX[0]))
    return Region(corner=corner[:2], core=core, in_core=core.ravel()[square], around=near.ravel()[square])


def with_objects(changed: np.ndarray, here: np.ndarray, labels: np.ndarray, lost: Sequence[int]) -> np.ndarray:
    """Return the squares (S,) bool that have changed, and those of objects that reach into them or are lost.

    Parameters
    ----------
    changed : (S,) bool
    here, labels : (N,) int
        The square and the object of each voxel.
    """
    core, on_object = changed.copy(), labels >= 0
    here, labels = here[on_object], labels[on_object]
    sizes = np.bincount(labels)
    anew, last = np.bincount(labels, changed[here], len(sizes)) > TOUCHED * sizes, None
    anew |= np.isin(np.arange(len(sizes)), lost)
    while last is None or (anew != last).any():
        core[here[anew[labels]]] = True
        anew, last = anew | (np.bincount(labels, core[here], len(sizes)) > MOSTLY * sizes), anew
    return core


def renewed(room: Room, part: Room, region: Region, labels: np.ndarray) -> tuple[Room, np.ndarray]:
    """Return a room with the objects of a region as they were recognised anew.

    Parameters
    ----------
    room : Room
    part : Room
        Recognised in the voxels around the region alone.
    region : Region
    labels : (N,) int32
        The object of each of the map's voxels before.

    Returns
    -------
    Room
    (K,) int64
        The number in it of each object of the room before; LEFT_OVER for those that are replaced.
    """
    found = np.full(len(labels), LEFT_OVER, np.int32)
    found[region.around] = part.labels
    stays = ~mostly(labels, region.in_core, len(room.objects))
    old = numbered(stays, 0)
    kept = relabelled(labels, old)
    enters = mostly(found, region.in_core, len(part.objects)) & ~mostly(found, kept >= 0, len(part.objects))
    new = numbered(enters, np.count_nonzero(stays))
    found = relabelled(found, new)
    objects = [*chosen(room.objects, stays), *chosen(part.objects, enters)]
    proposals = [
        *chosen(room.proposals, ~in_region(room.proposals, region)),
        *chosen(part.proposals, in_region(part.proposals, region)),
    ]
    inferred = [one.at(int(old[one.table])) for one in room.inferred if stays[one.table]]
    inferred += [one.at(int(new[one.table])) for one in part.inferred if enters[one.table]]
    return replace(
        room,
        labels=np.where((region.in_core & (kept < 0)) | (found >= 0), found, kept),
        objects=[replace(item, id=number) for number, item in enumerate(objects)],
        proposals=[replace(item, id=number) for number, item in enumerate(proposals)],
        inferred=inferred,
        stages=part.stages,
    ), old


def mostly(labels: np.ndarray, some: np.ndarray, count: int) -> np.ndarray:
    """Return which objects of voxels (N,) have none, or half of theirs among some (N,) bool; (count,) bool."""
    on_object = labels >= 0
    inside = np.bincount(labels[on_object & some], minlength=count)
    return inside >= MOSTLY * np.bincount(labels[on_object], minlength=count)


def numbered(chosen: np.ndarray, first: int) -> np.ndarray:
    """Return the new numbers (K,) int64 of the objects chosen (K,) bool, from the first on; LEFT_OVER for others."""
    return np.where(chosen, np.cumsum(chosen) - 1 + first, LEFT_OVER)


def relabelled(labels: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Return labels (N,) int32 with other numbers (K,) for objects; floor, walls and others keep their labels."""
    return np.append(numbers, [NEW, LEFT_OVER, WALL, FLOOR])[labels].astype(np.int32)  # negative: from the end


def chosen(items: Sequence[SceneObject], which: np.ndarray) -> list[SceneObject]:
    """Return some objects, by (K,) bool."""
    return [item for item, wanted in zip(items, which, strict=True) if wanted]


def in_region(items: Sequence[SceneObject], region: Region) -> np.ndarray:
    """Return which objects' middles are in a region, (K,) bool."""
    return region.holds(np.array([item.box.center for item in items]).reshape(-1, 3))
