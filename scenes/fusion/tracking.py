"""Known objects over time: which objects of the map are known, gone or moved, and the camera's motion by odometry."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from spherefunc_bullet.clouds.cloud import corners_of
from spherefunc_bullet.errors import InputError

from ..recognition.room import SceneObject
from ..scans.camera import Intrinsics
from ..scans.cells import cells
from .point_map import FREE, PRESENT, View

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

SHARED = 0.04  # metres around an object's points that count as its volume
CELL = 0.02  # metres: one point in each cell of this side is compared, the mean
SAME = 0.3  # of the volume of two objects that they share at least, if they are one
SIMILAR = 0.4  # by which the spread of an object that has moved may differ, since other parts of it are hidden
JUDGED = 0.2  # of an object's points that a view must show present or free, to count
GONE = 0.6  # of those, the least free share of an object that is gone
LEAST_MOVE = 0.05  # metres by which the middle of a moved object shifts, at least


@dataclass(frozen=True, kw_only=True, eq=False)
class KnownObject:
    """An object of the map in its latest known state."""

    id: int  # never given to another object
    points: np.ndarray  # (N, 3) float64, metres, one in each cell, in the world's frame
    functions: frozenset[str]
    seen: int = 0  # images that show it
    moved: np.ndarray | None = None  # (3,) metres that its middle went when it last moved; None: it stayed
    gone: bool = False

    @cached_property
    def corners(self) -> np.ndarray:
        """The lowest and the highest corner (2, 3) of its points' bounding box, metres."""
        return corners_of(self.points)

    @cached_property
    def tree(self) -> cKDTree:
        """Its points, sorted for the search of neighbours."""
        from scipy.spatial import cKDTree

        return cKDTree(self.points)

    @property
    def center(self) -> np.ndarray:
        """The middle (3,) of its points without outliers, metres."""
        return np.percentile(self.points, [5, 95], axis=0).mean(axis=0)

    @property
    def spread(self) -> np.ndarray:
        """The deviations (3,) of its points along their principal axes, ascending, metres."""
        return np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(self.points.T)), 0.0))


@dataclass
class Tracker:
    """All objects that have ever been found."""

    known: list[KnownObject] = field(default_factory=list)

    def missing(self, views: Sequence[View]) -> list[KnownObject]:
        """Mark objects as gone whose place is free in the newest view of it, and return them."""
        found = []
        for place, item in enumerate(self.known):
            if not item.gone and is_free(item.points, views):
                self.known[place] = replace(item, gone=True)
                found.append(self.known[place])
        return found

    def update(
        self,
        objects: Sequence[SceneObject],
        points: Sequence[np.ndarray],
        views: Sequence[View],
        new: Sequence[View],
        same: Sequence[int] = (),
    ) -> list[int]:
        """Return the ids of the objects of a map, in their order.

        An object that shares its place with a known one gets its id; so does one that looks like an object that is
        gone.

        Parameters
        ----------
        points : sequence of (N, 3) float64
            Of each object, metres, in the world's frame.
        views, new : sequence of View
            All of the map, and those since the last update.
        same : sequence of int
            Ids of known objects that are in the map as before, and not among the objects.
        """
        pairs = zip(objects, points, strict=True)
        found = [KnownObject(id=-1, points=cells(cloud, CELL).means, functions=item.members) for item, cloud in pairs]
        for place in same:
            old = self.known[place]
            self.known[place] = replace(old, seen=old.seen + times_seen(old.points, new))
        staying = [place for place, one in enumerate(self.known) if not one.gone and place not in same]
        shared = table(found, self.known, staying, shared_volume)
        matches = {i: staying[k] for i, k in assigned(shared, SAME)}
        lost = [place for place, one in enumerate(self.known) if one.gone]
        rest = [i for i in range(len(found)) if i not in matches]
        alike = table([found[i] for i in rest], self.known, lost, likeness)
        matches |= {rest[i]: lost[k] for i, k in assigned(alike, 1 - SIMILAR)}
        return [self.remember(one, matches.get(i), views, new) for i, one in enumerate(found)]

    def remember(self, found: KnownObject, place: int | None, views: Sequence[View], new: Sequence[View]) -> int:
        """Store a found object as the known one at an index, or as a new one; return its id."""
        if place is None:
            self.known.append(replace(found, id=len(self.known), seen=times_seen(found.points, views)))
            return self.known[-1].id
        old = self.known[place]
        shift = found.center - old.center
        moved = shift if old.gone and np.linalg.norm(shift) >= LEAST_MOVE else old.moved
        seen = old.seen + times_seen(found.points, new)
        self.known[place] = replace(found, id=old.id, seen=seen, moved=moved)
        return old.id


def is_free(points: np.ndarray, views: Sequence[View]) -> bool:
    """Return whether an object's points (N, 3) are gone in the newest view that shows enough of their place."""
    for view in reversed(views):
        verdicts = view.verdicts(points)
        free, present = int((verdicts == FREE).sum()), int((verdicts == PRESENT).sum())
        if free + present >= JUDGED * len(points):
            return free >= GONE * (free + present)
    return False


def times_seen(points: np.ndarray, views: Sequence[View]) -> int:
    """Return the number of views in which enough of an object's points (N, 3) is present."""
    return sum(int((view.verdicts(points) == PRESENT).sum() >= JUDGED * len(points)) for view in views)


def shared_volume(one: KnownObject, other: KnownObject) -> float:
    """Return the share of two objects' points that lie within the other's volume, 0 to 1."""
    low, high = np.maximum(one.corners[0], other.corners[0]), np.minimum(one.corners[1], other.corners[1])
    if (low - SHARED > high + SHARED).any():
        return 0.0
    near = sum(
        np.isfinite(b.tree.query(a.points, distance_upper_bound=SHARED)[0]).sum()
        for a, b in ((one, other), (other, one))
    )
    return float(near / (len(one.points) + len(other.points)))


def likeness(one: KnownObject, other: KnownObject) -> float:
    """Return the similarity of the spreads of two objects' points, 0 to 1; 0 if they have functions, but no common one.

    Boxes are not suitable, since a strip of floor left at an object's foot makes them much longer. A function with a
    score near its threshold may be lost in another place.
    """
    if one.functions and other.functions and one.functions.isdisjoint(other.functions):
        return 0.0
    low, high = np.minimum(one.spread, other.spread), np.maximum(one.spread, other.spread)
    return float(np.min(low / np.maximum(high, CELL)))


def table(
    found: Sequence[KnownObject],
    known: Sequence[KnownObject],
    places: Sequence[int],
    measure: Callable[[KnownObject, KnownObject], float],
) -> np.ndarray:
    """Return a measure of each object found and each known at the places, (F, P) float64."""
    scores = [measure(item, known[place]) for item in found for place in places]
    return np.array(scores, float).reshape(len(found), len(places))


def assigned(scores: np.ndarray, least: float) -> list[tuple[int, int]]:
    """Return the one-to-one pairs with the largest sum of scores (F, K), none below the least (Kuhn 1955)."""
    from scipy.optimize import linear_sum_assignment

    useful = np.where(scores >= least, scores, 0.0)
    rows, columns = linear_sum_assignment(useful, maximize=True)
    return [(int(i), int(k)) for i, k in zip(rows, columns, strict=True) if useful[i, k] > 0]


LEAST_FITNESS = 0.3  # of the pixels that must agree
LARGEST_STEP = 0.3  # metres between two images: after a larger motion they do not overlap enough
LARGEST_TURN = 30.0  # degrees
_ROUNDS = (20, 10, 5)  # of each scale, from the coarsest


def motion(
    depth: np.ndarray, before: np.ndarray, camera: Intrinsics, name: str, *, farthest: float = 5.0
) -> np.ndarray:
    """Return T_before_now (4, 4) of a camera between two depth images (H, W), metres, NaN where nothing was measured.

    By point-to-plane distances (Open3D's `rgbd_odometry_multi_scale`); colour is not used.

    Raises
    ------
    OdometryLost
        If the motion is not determined: little overlap, a fast motion, or a single plane in view.
    """
    import open3d as o3d

    odometry, core = o3d.t.pipelines.odometry, o3d.core
    matrix = core.Tensor(np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1.0]]))
    try:
        result = odometry.rgbd_odometry_multi_scale(
            rgbd(depth), rgbd(before), matrix, core.Tensor(np.eye(4)), 1.0, farthest,
            [odometry.OdometryConvergenceCriteria(rounds) for rounds in _ROUNDS], odometry.Method.PointToPlane,
        )  # fmt: skip
    except RuntimeError as error:  # equations without a solution
        raise lost(name, "the images have no unique motion") from error
    T = result.transformation.numpy()
    if not np.isfinite(T).all() or result.fitness < LEAST_FITNESS:
        raise lost(name, f"{100 * result.fitness:.0f} % of the pixels agree")
    step = np.linalg.norm(T[:3, 3])
    turn = np.degrees(np.arccos(np.clip((np.trace(T[:3, :3]) - 1) / 2, -1, 1)))
    if step > LARGEST_STEP or turn > LARGEST_TURN:
        raise lost(name, f"a motion of {step:.2f} m and {turn:.0f} degrees from one image to the next")
    return T


def rgbd(depth: np.ndarray):
    """Return a depth image (H, W) as Open3D's odometry needs it, with black colours."""
    import open3d as o3d

    image = np.nan_to_num(depth, nan=0.0).astype(np.float32)[..., None].copy()
    empty = np.zeros((*depth.shape, 3), np.float32)
    return o3d.t.geometry.RGBDImage(*(o3d.t.geometry.Image(o3d.core.Tensor(array)) for array in (empty, image)))


class OdometryLost(InputError):
    """The camera's motion between two images is not determined, so that later images have no place in the map."""


def lost(name: str, why: str) -> OdometryLost:
    """Return the error of lost odometry."""
    return OdometryLost(f"{name}: odometry is lost, {why}; give poses, or images that overlap more")
