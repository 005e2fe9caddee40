"""Scans of virtual rooms: whole surfaces, or the views of virtual Kinects from one or several places."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.errors import InputError

from ..recognition.completion import DEFAULT
from ..recognition.judging import object_cloud
from ..scans.cells import cells
from .furnishing import FLOOR, SMALL, VirtualRoom, shell_meshes
from .kinect import KINECT, Kinect, Surfaces, look_at, photograph

SHELL_PITCH = 0.01  # metres between the points of floor and walls in a whole scan
EYE_HEIGHT = 1.5  # metres
WALL_CLEARANCE = 0.4  # metres from the walls to a camera
CLEARANCE = 0.3  # metres from a camera to any object
TARGET_HEIGHT = 0.5  # metres: cameras look at the room's middle, so high
CANDIDATES = 8  # places tried for each view
MIN_POINTS = 100  # an object counts as seen if a scan holds at least this many of its points,
MIN_SHARE = 0.1  # and at least this share of its surface has a scanned point within
NEAR = 0.02  # metres, checked at
PROBES = 2_000  # places of the surface
WHOLE = "whole"


@dataclass(frozen=True, kw_only=True)
class Resolution:
    """How dense a scan is: as the sensors see it, unless it is fused or thinned."""

    leaf: float | None = None  # metres, side of the cells that each hold one point, the mean, as in a fused scan
    points: int | None = None  # at most, chosen at random

    def __post_init__(self):
        if self.leaf is not None and not 0.001 <= self.leaf <= 0.2:
            raise InputError(f"--fused {self.leaf:g}: expected a length from 1 mm to 20 cm")
        if self.points is not None and self.points < MIN_POINTS:
            raise InputError(f"--points {self.points}: expected at least {MIN_POINTS}")

    def of(self, scan: VirtualScan, rng: np.random.Generator) -> VirtualScan:
        """Return a scan in this resolution."""
        if self.leaf is not None:
            scan = fused(scan, self.leaf)
        if self.points is not None and self.points < len(scan.points):
            chosen = np.sort(rng.permutation(len(scan.points))[: self.points])
            scan = replace(scan, points=scan.points[chosen], labels=scan.labels[chosen])
        return scan


AS_SEEN = Resolution()


def fused(scan: VirtualScan, leaf: float) -> VirtualScan:
    """Return a scan with one point in each cell of a side in metres: the mean, labelled as most of the cell's points.

    Like a fused scan it is sparser and less noisy than the views, and its edges are rounded.
    """
    grid = cells(scan.points, leaf)
    owners, owner = np.unique(scan.labels, return_inverse=True)
    pairs, counts = np.unique(grid.cell_of * len(owners) + owner.ravel(), return_counts=True)
    order = np.lexsort((-counts, pairs // len(owners)))
    first = order[np.unique(pairs[order] // len(owners), return_index=True)[1]]
    return replace(scan, points=grid.means, labels=owners[pairs[first] % len(owners)])


@dataclass(frozen=True, eq=False)
class VirtualScan:
    """A scan in which it is known of every point whether it belongs to an object, the floor or a wall."""

    room: VirtualRoom
    points: np.ndarray  # (N, 3) float64, metres, in the room's frame
    labels: np.ndarray  # (N,) int32: an object's number, FLOOR or WALL
    poses: tuple[np.ndarray, ...] = ()  # T_room_camera (4, 4) of each view; none for whole surfaces

    def seen(self) -> np.ndarray:
        """Return the numbers of the objects of which the scan holds enough points and enough of the surface."""
        from scipy.spatial import cKDTree

        seen = []
        for number, placed in enumerate(self.room.objects):
            points = self.points[self.labels == number]
            if len(points) >= MIN_POINTS:
                probes = placed.points[:: max(1, len(placed.points) // PROBES)]
                near, _ = cKDTree(points).query(probes, distance_upper_bound=NEAR)
                if np.isfinite(near).mean() >= MIN_SHARE:
                    seen.append(number)
        return np.array(seen, int)

    def functions(self) -> dict[int, frozenset[str]]:
        """Return the functions of each object that is seen, by its number."""
        return {number: self.room.objects[number].item.functions for number in self.seen().tolist()}


def whole_scan(room: VirtualRoom) -> VirtualScan:
    """Return the surfaces of a room, complete and without noise, sampled as the objects' own clouds are."""
    parts = [(label, lattice(mesh.vertices[np.unique(mesh.faces)])) for label, mesh in shell_meshes(room.size)]
    parts += [(number, placed.points) for number, placed in enumerate(room.objects)]
    labels = [np.full(len(points), label, np.int32) for label, points in parts]
    return VirtualScan(room, np.concatenate([points for _, points in parts]), np.concatenate(labels))


def lattice(corners: np.ndarray) -> np.ndarray:
    """Return a grid of points (N, 3) over the axis-aligned rectangle that corners (4, 3) span."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    steps = [np.linspace(a, b, int(np.ceil((b - a) / SHELL_PITCH)) + 1) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)


def seen_scan(room: VirtualRoom, views: int, kinect: Kinect, rng: np.random.Generator) -> VirtualScan:
    """Return the views of Kinects from places all around the room, fused by their true poses."""
    surfaces = Surfaces(room.meshes())
    poses = viewpoints(room, surfaces, views, kinect, rng)
    seen = [photograph(surfaces, pose, kinect, rng).points() for pose in poses]
    points, labels = (np.concatenate(parts) for parts in zip(*seen, strict=True))
    return VirtualScan(room, points, labels, tuple(poses))


def viewpoints(
    room: VirtualRoom, surfaces: Surfaces, views: int, kinect: Kinect, rng: np.random.Generator
) -> list[np.ndarray]:
    """Return camera poses in even sectors around the room's middle, each where it sees most objects.

    A camera is at eye height near a wall, away from objects, and looks at the middle. A few places are tried in each
    sector, since a person would not hold the sensor behind a wardrobe either.
    """
    start = rng.uniform(0, 2 * np.pi)
    poses = []
    for view in range(views):
        angles = start + 2 * np.pi * (view + (np.arange(CANDIDATES) + 0.5) / CANDIDATES - 0.5) / max(views, 2)
        candidates = [pose_at(room, angle) for angle in angles]
        clear = surfaces.clearance(np.array([pose[:3, 3] for pose in candidates])) >= CLEARANCE
        overviews = [overview(surfaces, pose, kinect) for pose in candidates]
        poses.append(candidates[int(np.argmax(np.where(clear, overviews, -1)))])
    return poses


def pose_at(room: VirtualRoom, angle: float) -> np.ndarray:
    """Return the pose of a camera near the wall in a direction from the room's middle, looking at the middle."""
    middle = np.array([room.size[0] / 2, room.size[1] / 2])
    direction = np.array([np.cos(angle), np.sin(angle)])
    reach = np.min((middle - WALL_CLEARANCE) / np.maximum(np.abs(direction), 1e-9))
    eye = np.append(middle + reach * direction, EYE_HEIGHT)
    return look_at(eye, np.append(middle, TARGET_HEIGHT))


def overview(surfaces: Surfaces, pose: np.ndarray, kinect: Kinect) -> int:
    """Return the number of objects that are visible from a pose, in a coarse image."""
    coarse = Kinect(width=64, height=48, field_of_view_deg=kinect.field_of_view_deg)
    _, labels, _ = surfaces.first_hits(pose[:3, 3], coarse.camera.rays() @ pose[:3, :3].T)
    return len(np.unique(labels[labels > FLOOR]))


def scan_room(
    room: VirtualRoom,
    views: int | None,
    noise: float,
    seed: int,
    resolution: Resolution = AS_SEEN,
    sensor: Kinect = KINECT,
) -> VirtualScan:
    """Return the scan of a room, by a number of views or of whole surfaces; reproducible for the same arguments."""
    rng = np.random.default_rng([seed, int(room.name.rpartition("_")[2]), views or 0])
    scan = whole_scan(room) if views is None else seen_scan(room, views, sensor.noisy(noise), rng)
    return resolution.of(scan, rng)


def parse_views(text: str) -> int | None:
    """Return a number of views, None for whole surfaces.

    Raises
    ------
    InputError
        If it is neither.
    """
    if text.strip() == WHOLE:
        return None
    if not text.strip().isdecimal() or int(text) < 1:
        raise InputError(f"--views {text}: expected a number from 1, or {WHOLE}")
    return int(text)


_NEAR, _FAR = (0.6, 1.3), (1.3, 2.3)  # metres from the camera to small and to large objects
_DOWN_DEG = (18.0, 55.0)  # by which it looks down
_ASIDE = 0.4  # metres by which it looks past the object's middle, at most
_TRIED = 12  # places of the camera
_LOWEST = 0.4  # metres above the floor


def close_ups(room: VirtualRoom, count: int, noise: float, seed: int, sensor: Kinect = KINECT) -> Iterator[VirtualScan]:
    """Yield single views of a room, each of one object from close up; reproducible for the same arguments.

    Parameters
    ----------
    room : VirtualRoom
    count : int
    noise : float
        As a multiple of the sensor's.
    seed : int
    sensor : Kinect
    """
    rng = np.random.default_rng([seed, int(room.name.rpartition("_")[2]), count])
    surfaces, kinect = Surfaces(room.meshes()), sensor.noisy(noise)
    for _ in range(count if room.objects else 0):
        pose = pose_near(room, surfaces, rng)
        if pose is not None:
            points, labels = photograph(surfaces, pose, kinect, rng).points()
            if len(points):
                yield VirtualScan(room, points, labels, (pose,))


def pose_near(room: VirtualRoom, surfaces: Surfaces, rng: np.random.Generator) -> np.ndarray | None:
    """Return the pose (4, 4) of a camera near one of a room's objects, looking at it; None if there is no room."""
    points = room.objects[rng.integers(len(room.objects))].points
    low, high = points.min(axis=0), points.max(axis=0)
    near, far = _NEAR if (high - low).max() <= SMALL else _FAR
    for _ in range(_TRIED):
        target = (low + high) / 2 + np.append(rng.uniform(-_ASIDE, _ASIDE, 2) * near / far, 0.0)
        around, down, distance = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(*_DOWN_DEG)), rng.uniform(near, far)
        way = np.array([np.cos(around) * np.cos(down), np.sin(around) * np.cos(down), np.sin(down)])
        eye = target + distance * way
        inside = (eye[:2] > WALL_CLEARANCE).all() and (eye[:2] < room.size[:2] - WALL_CLEARANCE).all()
        if inside and eye[2] > _LOWEST and surfaces.clearance(eye[None])[0] >= CLEARANCE:
            return look_at(eye, target)
    return None


def partial_views(scan: VirtualScan, completion: Sequence[str] = DEFAULT) -> Iterator[tuple[int, Cloud]]:
    """Yield the number and the cloud of every object that the scan shows enough of.

    They are perfectly segmented, so that errors in their functions are not the segmentation's. As training examples
    they are as one-sided as the objects in real scans.

    Parameters
    ----------
    completion : sequence of str
        See `completion.complete`.
    """
    for number in scan.seen().tolist():
        placed = scan.room.objects[number]
        height = float(placed.T_room_object[2, 3])
        points = scan.points[scan.labels == number]
        yield number, object_cloud(points, completion, height)[0]
