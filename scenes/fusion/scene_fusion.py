"""A room from depth images over time, whose objects are updated as the map grows."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from spherefunc_bullet.errors import InputError, require_kind, require_known
from spherefunc_bullet.formats.units import Stopwatch
from spherefunc_bullet.learning.model_file import inference_model, shipped_model
from spherefunc_bullet.places.place import Place

from ..recognition.completion import DEFAULT, STEPS
from ..recognition.objects import FoundObject, found_object
from ..recognition.partial_places import room_places
from ..recognition.proposals import KINDS
from ..recognition.recognition import TABLE_TOP, Room, RoomFrame, SceneObject, recognise
from ..scans.camera import Intrinsics
from ..scans.cells import cells
from ..scans.depth_image import checked_camera, in_metres, matrix_of, require_depth
from ..scans.gravity import up_vector
from ..scans.levelling import Levelling, level
from ..scans.scan import Scan, require_surfaces, scan_from_points
from ..segmentation.segmentation import LEFT_OVER, Segmentation, find_shell
from ..settings import SCAN
from .alignment import aligned
from .changes import Region, changed_region, renewed
from .point_map import FusionSettings, PointMap, View, smoothed_depth, view_of
from .tracking import KnownObject, Tracker, motion

if TYPE_CHECKING:
    from spherefunc_bullet.learning.classifier import CloudClassifier

one_blas_thread = threadpool_limits.wrap(limits=1, user_api="blas")  # as in `recognise`: more would wait

_ORTHONORMAL = 1e-3  # deviation of a pose's axes from unit vectors at right angles, at most
_VOXELS = 1_000_000  # from the origin to a camera, at most: voxels farther than that have no number
_NEAREST = 1e-3  # metres, the least depth that was measured: smaller numbers are not, such as 1e-38 of an empty buffer
_KEPT = 1000  # newest images of which a view is kept: 150 MB for 640 x 480 pixels
_GROWN = 1.25  # times the voxels at the last look at all of the map, above which all is looked at again,
_PART = 0.5  # or of the voxels, around what has changed
_HEADING = 0.1  # weight of the cameras' own up, relative to their level axes


@dataclass(frozen=True, kw_only=True, eq=False)
class FusedObject(FoundObject):
    """One object of a fused room, in the world's frame."""

    id: int  # the same in every update
    label: int  # its place in `Room.objects`, and in `Room.labels`
    seen: int  # images that show it; of those before it was found, of the newest 1000
    moved: np.ndarray | None  # (3,) metres that its middle went when it last moved; None: it stayed


class SceneFusion:
    """Fused depth images over time, with the functions of their objects; for one thread at a time.

    Parameters
    ----------
    model : path or CloudClassifier, optional
        By default the one for scans that ships with the package.
    backend : str, optional
        The simulator that the model must be for; by default ``fast`` where no model is given.
    fusion, settings : FusionSettings, Segmentation, optional
    up : str or (3,) array_like
        ``auto`` (by floor and cameras), an axis (``z``, ``-y``), numbers ``x,y,z``, or a vector.
    completion, proposals : as of `recognition.recognise`
    """

    def __init__(
        self,
        model: str | Path | CloudClassifier | None = None,
        backend: str | None = None,
        *,
        fusion: FusionSettings | None = None,
        settings: Segmentation | None = None,
        up: str | ArrayLike = "auto",
        completion: Sequence[str] = DEFAULT,
        proposals: Sequence[str] = KINDS,
    ):
        require_known("completion", completion, STEPS)
        require_known("proposals", proposals, KINDS)
        require_kind("fusion", fusion, FusionSettings)
        require_kind("settings", settings, Segmentation)
        shipped = shipped_model(backend or "fast", scans=True) if model is None else model
        self.model, self.up = inference_model(shipped, backend), up_vector(up)
        self.how = {"settings": settings, "completion": completion, "proposals": proposals}
        self.fusion = fusion or FusionSettings()
        self.map, self.tracker = PointMap(self.fusion), Tracker()
        self.views: deque[View] = deque(maxlen=_KEPT)  # of the newest images
        self.count = 0  # number of images,
        self.updated = 0  # and at the last update
        self.looked_at = 0  # number of voxels when all of the map was recognised last
        self.frame: RoomFrame | None = None  # found then
        self.room: Room | None = None  # of the last update
        self.ids: dict[int, int] = {}  # of its objects, by their labels
        self.scan: Scan | None = None  # its points
        self._last: tuple[np.ndarray, np.ndarray] | None = None  # depth and pose, for odometry
        self.stages: dict[str, float] = {}  # seconds of the last image and the last update

    @one_blas_thread
    def add(
        self, depth: ArrayLike, intrinsics: Intrinsics | ArrayLike, pose: ArrayLike | None = None, name: str = "depth"
    ) -> SceneFusion:
        """Add a depth image, and return self.

        Parameters
        ----------
        depth : (H, W) array_like
            Integers are millimetres, others metres; 0, NaN and infinity are unseen.
        intrinsics : Intrinsics, Open3D's PinholeCameraIntrinsic, or (3, 3) or (9,) array_like in pixels
        pose : (4, 4) array_like, optional
            T_world_camera; the camera looks along z, y is down. Without one, Open3D's odometry estimates it from the
            previous image, and the first camera's frame is the world's.
        name : str
            Of the image, in errors.

        Raises
        ------
        InputError
            If image, camera or pose cannot be used, or odometry is lost; the map is then unchanged.
        """
        watch = Stopwatch()
        depth = checked_depth(depth, self.fusion.farthest, name)
        camera = checked_camera(intrinsics, depth, name)
        depth = smoothed_depth(depth, self.fusion.smoothing)
        watch.lap("smoothing")
        reach = _VOXELS * self.fusion.voxel_size
        T = self.tracked(depth, camera, name) if pose is None else checked_pose(pose, reach, name)
        self.require_near(T, name)
        watch.lap("odometry")
        view = aligned(view_of(depth, camera, T), depth, self.map.points, self.fusion.pose_error)
        watch.lap("alignment")
        self.map.add(depth, view)
        self.views.append(view)
        self.count += 1
        self._last = depth, view.T_world_camera
        watch.lap("fusing")
        self.stages = watch.seconds
        return self

    def tracked(self, depth: np.ndarray, camera: Intrinsics, name: str) -> np.ndarray:
        """Return T_world_camera (4, 4) by odometry, of a depth image (H, W)."""
        if self._last is None:
            return np.eye(4)
        before, T_world_before = self._last
        if before.shape != depth.shape:
            came = f"{depth.shape[1]} x {depth.shape[0]} after {before.shape[1]} x {before.shape[0]}"
            raise InputError(f"{name}: expected images of one size for odometry, got {came}; give poses")
        return T_world_before @ motion(depth, before, camera, name, farthest=self.fusion.farthest)

    def require_near(self, T: np.ndarray, name: str):
        """Raise InputError for a camera (4, 4) so far from the first that objects of no scan so large are found."""
        far = np.abs(T[:3, 3] - self.views[0].T_world_camera[:3, 3]).max() if self.views else 0.0
        if far > SCAN.largest:
            came = f"got one {far:.3g} m away; is its pose right, and in metres? Larger places need several maps"
            raise InputError(f"{name}: expected a camera within {SCAN.largest:g} m of the map's first, {came}")

    @one_blas_thread
    def objects(self, whole: bool = False) -> list[FusedObject]:
        """Recognise the objects of the current map and return them; known objects keep their ids.

        Parameters
        ----------
        whole : bool
            Whether all of the map is looked at; else what has changed, while that is less than half (docs/scenes.md).

        Raises
        ------
        InputError
            If the images show too few points, no surfaces, or little of each other's.
        """
        if not self.views:
            raise InputError("fusion: expected a depth image first, got none; call add")
        self.map.require_agreement()
        watch = Stopwatch()
        new = list(self.views)[max(len(self.views) + self.updated - self.count, 0) :]
        for gone in self.tracker.missing(new):
            self.map.forget(gone.points, new)
        watch.lap("forgetting")
        region = None if whole else self.changed()
        # An update that does not come to its end, as by Ctrl-C, is made up for by a look at all of the map.
        known, self.looked_at = self.looked_at, 0
        watch.lap("comparing")
        same = self.recognise_all() if region is None else self.recognise_within(region)
        watch.lap("recognition")
        others = [item for item in self.room.objects if item.id not in same]
        clouds = [self.room.levelling.to_scan(item.points) for item in others]
        found = self.tracker.update(others, clouds, self.views, new, same=list(same.values()))
        self.ids = same | {item.id: number for item, number in zip(others, found, strict=True)}
        watch.lap("tracking")
        self.updated, self.looked_at = self.count, len(self.map.points) if region is None else known
        self.stages |= watch.seconds
        places = cache(partial(room_places, self.scan, self.room))
        return [self.fused_object(item, lambda own=item.id: places().get(own, ())) for item in self.room.objects]

    def changed(self) -> Region | None:
        """Return the part of the map that has changed since the last update; None if all of it is to be looked at."""
        if self.room is None or self.scan.dropped or self.room.levelling.source == TABLE_TOP:
            return None
        if len(self.map.points) > _GROWN * self.looked_at:
            return None
        lost = [label for label, number in self.ids.items() if self.tracker.known[number].gone]
        region = changed_region(self.map, self.frame, lost)
        return None if region is None or region.around.mean() > _PART else region

    def recognise_all(self) -> dict[int, int]:
        """Recognise the whole map; no object is known to be the same as before."""
        scan = scan_from_points(self.map.points, "fused")
        frame = self.found_frame(scan.points)
        room = recognise(scan, self.model, frame=frame, **self.how)
        self.scan, self.frame, self.room = scan, frame, room
        if not scan.dropped:
            self.map.relabel(room.labels)
        return {}

    def recognise_within(self, region: Region) -> dict[int, int]:
        """Recognise a region of the map, and return the ids of the objects that stay as they were, by their labels."""
        scan = Scan(name="fused", points=self.map.points)
        part = recognise(replace(scan, points=scan.points[region.around]), self.model, frame=self.frame, **self.how)
        room, now = renewed(self.room, part, region, self.map.labels)
        self.map.relabel(room.labels, ~region.holds(self.frame.levelling.to_level(self.map.gone)))
        self.scan, self.room = scan, replace(room, labels=np.maximum(room.labels, LEFT_OVER))
        return {int(now[label]): number for label, number in self.ids.items() if now[label] >= 0}

    def found_frame(self, points: np.ndarray) -> RoomFrame:
        """Return the level frame of the map's points (N, 3), with its walls and ceiling."""
        require_surfaces(points, "fused")
        levelling = upright_by_cameras(points, self.views) if self.up is None else level(points, self.up, "fused")
        leaf = (self.how["settings"] or Segmentation()).leaf_size
        return RoomFrame(levelling=levelling, shell=find_shell(cells(levelling.to_level(points), leaf).means))

    def fused_object(self, item: SceneObject, find: Callable[[], Sequence[Place]]) -> FusedObject:
        """Return one object of the last update, whose places a function finds."""
        known, found = self.tracker.known[self.ids[item.id]], found_object(item, self.room, self.scan, find)
        return FusedObject(**vars(found), id=known.id, label=item.id, seen=known.seen, moved=known.moved)

    @property
    def gone(self) -> list[KnownObject]:
        """Objects whose place was seen to be free and that were not found elsewhere."""
        return [item for item in self.tracker.known if item.gone]


def upright_by_cameras(points: np.ndarray, views: Iterable[View]) -> Levelling:
    """Return the levelling of a map (N, 3), whatever the orientation of its frame."""
    T_turned_scan = turned_by_cameras(points, [view.T_world_camera for view in views])
    levelling = level(points @ T_turned_scan[:3, :3].T + T_turned_scan[:3, 3], name="fused")
    return replace(levelling, T_level_scan=levelling.T_level_scan @ T_turned_scan)


def turned_by_cameras(points: np.ndarray, poses: list[np.ndarray]) -> np.ndarray:
    """Return a transform (4, 4) of the cameras' common up to z, and of the points' middle to the origin.

    Cameras are mostly held level, so that their x axes are perpendicular to up; the sign comes from their y axes, which
    point down. Around the origin, the points are not mistaken for the view of one camera there.
    """
    x, up = (np.array([sign * pose[:3, axis] for pose in poses]) for sign, axis in ((1, 0), (-1, 1)))
    mean = up.mean(axis=0)
    _, vectors = np.linalg.eigh(x.T @ x / len(x) - _HEADING * np.outer(mean, mean))
    z = vectors[:, 0] * (1.0 if vectors[:, 0] @ mean >= 0 else -1.0)
    side = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    side /= np.linalg.norm(side)
    T = np.eye(4)
    T[:3, :3] = np.stack([np.cross(side, z), side, z])
    T[:3, 3] = -T[:3, :3] @ np.median(points, axis=0)
    return T


def checked_depth(depth: ArrayLike, farthest: float, name: str) -> np.ndarray:
    """Return a depth image (H, W) float64, metres, NaN where nothing was measured within the farthest depth."""
    measured = require_depth(depth, name)
    depth = in_metres(measured, None, name)
    depth = np.where((depth >= _NEAREST) & (depth < farthest), depth, np.nan)
    if not np.isfinite(depth).any():
        unit = "metres" if measured.dtype.kind == "f" else "millimetres"
        raise InputError(f"{name}: expected surfaces within {farthest:g} m, found none; is it in {unit}?")
    return depth


def checked_pose(pose: ArrayLike, farthest: float, name: str) -> np.ndarray:
    """Return a pose T_world_camera (4, 4) float64 of a camera at most so many metres from the origin."""
    T = matrix_of(pose, (4, 4), f"{name}: expected a pose (4, 4)")
    if not np.isfinite(T).all():
        raise InputError(f"{name}: expected a pose of finite numbers, got NaN or infinity; was tracking lost there?")
    if np.abs(T[:3, :3] @ T[:3, :3].T - np.eye(3)).max() > _ORTHONORMAL or np.linalg.det(T[:3, :3]) < 0:
        raise InputError(f"{name}: expected a rotation and a translation as pose, got other axes")
    if np.abs(T[3] - [0, 0, 0, 1]).max() > _ORTHONORMAL:
        raise InputError(f"{name}: expected 0 0 0 1 as the last row of a pose, got {T[3]}; is it transposed?")
    if (far := np.abs(T[:3, 3]).max()) > farthest:
        came = f"got {far / 1000:.0f} km; subtract the same offset from all poses"
        raise InputError(f"{name}: expected a camera within {farthest / 1000:.0f} km of the origin, {came}")
    return T
