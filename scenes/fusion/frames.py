"""Folders of depth images with their poses: TUM, 3DMatch (7-Scenes), Redwood."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spherefunc_bullet.errors import InputError, one_line, require_amount

from ..scans.camera import Intrinsics, as_number, kinect_like, lines_of, numbers_of, read_intrinsics
from ..scans.depth_image import SCALE, read_depth
from ..scans.scan import Report

TUM_SCALE = 5000.0  # depth values per metre of TUM's data sets; of all others `SCALE`
NEAR_IN_TIME = 0.02  # seconds between a depth image and its pose, as in TUM's own association
UNSEEN = 65_535  # of 16 bits: 7-Scenes' and 3DMatch's mark of pixels without a measurement
_SHOWN = 80  # letters of a line in an error
_DEPTH_PNG, _POSE_TXT = ".depth.png", ".pose.txt"


@dataclass(frozen=True, kw_only=True)
class Frame:
    """A depth image's file, and the source of its pose."""

    path: Path
    pose: np.ndarray | Path | None = None  # T_world_camera (4, 4), or its file; None: unknown
    scale: float = SCALE  # depth values per metre

    def depth(self) -> np.ndarray:
        """Read the image (H, W) float64, metres, NaN where nothing was measured.

        Raises
        ------
        InputError
            If the file is no depth image.
        """
        depth = read_depth(self.path)
        if depth.dtype.kind in "iu":
            return np.where((depth > 0) & (depth < UNSEEN), depth / self.scale, np.nan)
        return depth.astype(np.float64)

    def T_world_camera(self) -> np.ndarray:
        """Read the pose (4, 4).

        Raises
        ------
        InputError
            If there is none.
        """
        if self.pose is None:
            raise InputError(f"{one_line(self.path.name)}: expected a pose for this image, found none; it is left out")
        return numbers_of(self.pose, (4, 4)) if isinstance(self.pose, Path) else self.pose


@dataclass(frozen=True, kw_only=True)
class Frames:
    """The depth images of a folder, in their order."""

    frames: list[Frame]
    posed: bool  # whether any pose is known
    intrinsics: Intrinsics | None  # None: unknown

    def camera_of(self, depth: np.ndarray) -> Intrinsics:
        """Return the camera of a depth image (H, W)."""
        return self.intrinsics or kinect_like(depth.shape[1], depth.shape[0])


def open_frames(
    folder: Path,
    *,
    poses: Path | None = None,
    intrinsics: Path | None = None,
    depth_scale: float | None = None,
    report: Report | None = None,
) -> Frames:
    """Find the depth images of a folder, their poses and their camera.

    Parameters
    ----------
    folder : Path
        With ``frame-000000.depth.png`` and ``frame-000000.pose.txt`` (3DMatch, 7-Scenes), or with images named by their
        time or listed in ``depth.txt`` (TUM), or with images in order (Redwood), which may also be in ``depth/``.
    poses : Path, optional
        Poses of the camera in the world: ``.log`` (Redwood), or lines of ``timestamp tx ty tz qx qy qz qw`` (TUM); by
        default ``groundtruth.txt`` of the folder, if there is one.
    intrinsics : Path, optional
        JSON as Open3D writes it, or a camera matrix of 3 x 3 numbers; by default ``camera-intrinsics.txt`` in the
        folder or above it, if there is one.
    depth_scale : float, optional
        Depth values per metre; 5000 for TUM's, else 1000.
    report : callable, optional
        Takes one line of text for each guess.

    Raises
    ------
    InputError
        If there are no images, or a file of poses or of the camera cannot be used.
    """
    if not folder.is_dir():
        raise InputError(f"{one_line(folder)}: expected a folder of depth images, found none; check the path")
    if depth_scale is not None:
        require_amount("depth_scale=", depth_scale, above=0.0)
    report, named = report or (lambda line: None), one_line(folder.name)
    timed = timed_images(folder)
    paths = list(timed.values()) if timed else images_in(folder)
    if not paths:
        raise InputError(f"{one_line(folder)}: expected depth images (PNG) in the folder, found none")
    if poses is None and timed and (folder / "groundtruth.txt").is_file():
        poses = folder / "groundtruth.txt"
    known = poses_of(paths, timed, poses)
    camera, posed = camera_in(folder, intrinsics), any(pose is not None for pose in known)
    if camera is None:
        report(f"{named}: no camera given, so a first-generation Kinect's is assumed; --intrinsics sets another")
    if not posed:
        report(f"{named}: no poses found, so Open3D's odometry estimates them; --poses sets known ones")
    scale = depth_scale or (TUM_SCALE if timed else SCALE)
    frames = [Frame(path=path, pose=pose, scale=scale) for path, pose in zip(paths, known, strict=True)]
    return Frames(frames=frames, posed=posed, intrinsics=camera)


def timed_images(folder: Path) -> dict[float, Path]:
    """Return the images of a folder by their time, in seconds, from ``depth.txt`` or from their names."""
    listing = folder / "depth.txt"
    if listing.is_file():
        rows = [line.split() for line in lines_of(listing)]
        times = [as_number(row[0]) for row in rows if len(row) >= 2]
        if len(times) < len(rows) or any(time is None for time in times):
            raise InputError(f"{listing.name}: expected lines of a timestamp and a file's name, found others")
        return dict(sorted((time, folder / row[1]) for time, row in zip(times, rows, strict=True)))
    # Whole numbers are positions in a sequence, not times.
    times = {as_number(path.stem): path for path in images_in(folder) if "." in path.stem}
    return {} if None in times else dict(sorted(times.items()))


def images_in(folder: Path) -> list[Path]:
    """Return the depth images of a folder or of ``depth/`` in it, in the order of their names."""
    for place in (folder, folder / "depth"):
        paths = sorted((path for path in place.glob("*.png") if not path.name.startswith(".")), key=counting)
        depths = [path for path in paths if path.name.endswith(_DEPTH_PNG)]
        if paths:
            return depths or paths
    return []


def counting(path: Path) -> list[str | int]:
    """Return a key to sort files by, in which 2.png comes before 10.png.

    Examples
    --------
    >>> counting(Path("depth10.png"))
    ['depth', 10, '.png']
    """
    words: list[str | int] = list(re.split("([0-9]+)", path.name))
    return [int(word) if place % 2 else word for place, word in enumerate(words)]


def poses_of(paths: list[Path], timed: dict[float, Path], poses: Path | None) -> list[np.ndarray | Path | None]:
    """Return the pose of each image, or its file, or None."""
    if poses is not None and poses.suffix.lower() == ".log":
        return list(read_log(poses, len(paths)))
    if poses is not None:
        if not timed:
            raise InputError(f"{poses.name}: expected images named by their time, as poses are; found {paths[0].name}")
        times, known = read_tum(poses)
        nearest = [(time, int(np.argmin(np.abs(times - time)))) for time in timed]
        gaps = [abs(times[place] - time) for time, place in nearest]
        if not min(gaps) <= NEAR_IN_TIME:
            came = f"found the nearest {min(gaps):.6g} s away; is it another clock?"
            raise InputError(f"{poses.name}: expected poses within {NEAR_IN_TIME:g} s of the images, {came}")
        return [known[place] if gap <= NEAR_IN_TIME else None for (_, place), gap in zip(nearest, gaps, strict=True)]
    files = [path.with_name(path.name.removesuffix(_DEPTH_PNG) + _POSE_TXT) for path in paths]
    has_pose = [path.name.endswith(_DEPTH_PNG) and pose.is_file() for path, pose in zip(paths, files, strict=True)]
    return [pose if has else None for pose, has in zip(files, has_pose, strict=True)]


def read_tum(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return the times (P,), seconds, and the poses T_world_camera (P, 4, 4) of a file in TUM's format.

    Raises
    ------
    InputError
        If it is in no such format.
    """
    from scipy.spatial.transform import Rotation

    lines = lines_of(path)
    rows = [[as_number(word) for word in line.split()] for line in lines]
    wrong = next((line for line, row in zip(lines, rows, strict=True) if len(row) != 8 or None in row), None)
    if not rows or wrong is not None:
        came = one_line(wrong or "none")[:_SHOWN]
        raise InputError(f"{path.name}: expected lines of timestamp tx ty tz qx qy qz qw, found {came}")
    table = np.array(rows, float)
    poses = np.tile(np.eye(4), (len(table), 1, 1))
    poses[:, :3, 3] = table[:, 1:4]
    length = np.linalg.norm(table[:, 4:], axis=1)
    usable = np.isfinite(table).all(axis=1) & (length > 0.5)
    poses[usable, :3, :3] = Rotation.from_quat(table[usable, 4:]).as_matrix()
    poses[~usable] = np.nan  # reported for the image that has this pose
    return table[:, 0], poses


def read_log(path: Path, count: int) -> Iterator[np.ndarray | None]:
    """Yield T_world_camera (4, 4) for each of the images, from Redwood's log of three numbers and 4 x 4 for each.

    The third number is that of the image, from 1 on; where these do not count, poses are in the order of the images.
    """
    words = [as_number(word) for line in lines_of(path) for word in line.split()]
    if not words or len(words) % 19 or None in words:
        raise InputError(f"{path.name}: expected blocks of three whole numbers and a matrix of 4 x 4, found others")
    table = np.array(words, float).reshape(-1, 19)
    if len(table) > count:
        raise InputError(f"{path.name}: expected a pose for each of the {count} images, got {len(table)} poses")
    numbers = table[:, 2]
    if (np.diff(numbers, prepend=0) <= 0).any() or numbers[-1] > count:
        numbers = np.arange(1, len(table) + 1)
    known = dict(zip(numbers, table[:, 3:].reshape(-1, 4, 4), strict=True))
    yield from map(known.get, range(1, count + 1))


def camera_in(folder: Path, intrinsics: Path | None) -> Intrinsics | None:
    """Return the camera that is given, or found next to the images; its size is the first readable image's."""
    beside = (place / "camera-intrinsics.txt" for place in (folder, folder.parent))
    path = intrinsics or next((file for file in beside if file.is_file()), None)
    if path is None:
        return None
    size = (640, 480)
    for image in images_in(folder):
        with suppress(InputError):
            size = read_depth(image).shape[::-1]
            break
    return read_intrinsics(path, size)
