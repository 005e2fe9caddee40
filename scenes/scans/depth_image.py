"""Depth images, alone or with their colour image, as scans in the camera's frame: z forward, y down."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from spherefunc_bullet.errors import InputError, explaining, one_line, require_amount
from spherefunc_bullet.formats.files import require_file

from ..settings import SCAN
from .camera import Intrinsics, camera_of_matrix, kinect_like, read_intrinsics
from .cells import cells
from .neighbors import NEIGHBORS, crowded, nearest_others
from .scan import Report, Scan, scan_from_points

SCALE = 1000.0  # depth values per metre
IMAGES = (".png", ".tif", ".tiff", ".npy")
_DAMAGE = (OSError, ValueError, EOFError, SyntaxError)  # what readers of images raise


def load_depth_image(
    image: Path | np.ndarray,
    *,
    intrinsics: Path | Intrinsics | ArrayLike | None = None,
    color: Path | ArrayLike | None = None,
    depth_scale: float | None = None,
    report: Report | None = None,
) -> Scan:
    """Return the scan of a depth image, in metres, z forward and y down.

    Parameters
    ----------
    image : Path, or (H, W) array
        PNG, TIFF or NPY. Whole numbers are divided by ``depth_scale``; others are metres. 0 and NaN are unseen.
    intrinsics : Path, Intrinsics, Open3D's PinholeCameraIntrinsic, or (3, 3) or (9,) array_like in pixels, optional
        The camera; without it a first-generation Kinect's is assumed, and that is reported.
    color : Path or (H, W, 3) uint8 array_like, optional
        An image of the same size, registered to the depth.
    depth_scale : float, optional
        Steps to the metre, of whole numbers; by default 1000 for millimetres, as Open3D's.
    report : callable, optional
        Takes one line of text for each guess.

    Raises
    ------
    InputError
        If a file cannot be used, or the sizes differ.
    """
    name = one_line(image.name) if isinstance(image, Path) else "depth"
    depth = read_depth(image) if isinstance(image, Path) else require_depth(image, name)
    depth = in_metres(depth, depth_scale, name)
    if intrinsics is not None:
        size = depth.shape[1], depth.shape[0]
        camera = read_intrinsics(intrinsics, size) if isinstance(intrinsics, Path) else intrinsics
        camera = checked_camera(camera, depth, name)
    else:
        camera = kinect_like(depth.shape[1], depth.shape[0])
        if report:
            report(
                f"{name}: no camera given, so a first-generation Kinect's is assumed, focal length {camera.fx:g} pixels"
            )
    seen = (depth > 0) & (depth < SCAN.largest)  # larger values mark pixels without a measurement, such as 65535
    if not seen.any():
        raise InputError(f"{name}: expected surfaces within {SCAN.largest:g} m, found none; is it in metres?")
    points = np.where(seen, depth, np.nan)[..., None] * camera.rays()
    colors = None if color is None else read_color(color, depth)
    return scan_from_points(points.reshape(-1, 3), name, colors=colors, units="m", report=report)


def in_metres(depth: np.ndarray, depth_scale: float | None, name: str) -> np.ndarray:
    """Return a depth image (H, W) float64 in metres: whole numbers are divided by the scale, others are metres."""
    if depth_scale is not None:
        require_amount("depth_scale=", depth_scale, above=0.0)
        if depth.dtype.kind == "f":
            raise InputError(f"depth_scale=: expected with a depth image of whole numbers, got metres in {name}")
    return depth.astype(np.float64) if depth.dtype.kind == "f" else depth / (depth_scale or SCALE)


def is_image_file(path: Path) -> bool:
    """Return whether a file is a depth image, by its ending; NPY files of shape (N, 3) are points."""
    if path.suffix.lower() == ".npy" and os.path.isfile(path):  # and no pipe
        with suppress(*_DAMAGE):  # which readers report
            return np.load(path, mmap_mode="r", allow_pickle=False).shape[1:] != (3,)
    return path.suffix.lower() in IMAGES


def require_depth_image(is_image: bool, name: str, options: dict[str, object]):
    """Raise InputError for options of depth images, where the scan is none."""
    for option, value in options.items():
        if value is not None and not is_image:
            raise InputError(f"{option}: expected with a depth image ({', '.join(IMAGES)}), got {name}")


def checked_camera(intrinsics: Intrinsics | ArrayLike, depth: np.ndarray, name: str) -> Intrinsics:
    """Return the camera of a depth image (H, W); an Open3D PinholeCameraIntrinsic is one as well."""
    if not isinstance(intrinsics, Intrinsics):
        size = getattr(intrinsics, "width", depth.shape[1]), getattr(intrinsics, "height", depth.shape[0])
        K = getattr(intrinsics, "intrinsic_matrix", intrinsics)
        K = matrix_of(K, (3, 3), f"{name}: expected intrinsics as a camera matrix (3, 3) in pixels")
        intrinsics = camera_of_matrix(K, size, name)
    require_same_size(name, (intrinsics.width, intrinsics.height), depth, "a camera")
    return intrinsics


def matrix_of(numbers: ArrayLike, shape: tuple[int, int], expected: str) -> np.ndarray:
    """Return numbers as a matrix, or raise InputError in a line that begins with what is expected."""
    with explaining(f"{expected}, got {type(numbers).__name__}", TypeError, ValueError):
        matrix = np.asarray(numbers, float)
    if matrix.shape == (9,):  # as in a sensor_msgs/CameraInfo
        matrix = matrix.reshape(3, 3)
    if matrix.shape != shape:
        raise InputError(f"{expected}, got shape {matrix.shape}")
    return matrix


def require_same_size(name: str, size: tuple[int, int], depth: np.ndarray, what: str):
    """Raise InputError if something is not as large, width and height, as the depth image (H, W)."""
    if size != depth.shape[::-1]:
        came = f"got {what} of {size[0]} x {size[1]}"
        raise InputError(f"{name}: expected {what} of {depth.shape[1]} x {depth.shape[0]} as the depth, {came}")


def read_depth(path: Path) -> np.ndarray:
    """Return a depth image (H, W) as the file has it."""
    from PIL import Image

    name = one_line(path.name)
    require_file(path)
    with (
        explaining(f"{name}: expected a depth image, could not read it; is it damaged?", *_DAMAGE),
        explaining(f"{name}: cannot be read: Permission denied; check its permissions", PermissionError),
    ):
        if path.suffix.lower() == ".npy":
            depth = np.load(path, allow_pickle=False)
        else:
            with Image.open(path) as image:
                mode, depth = image.mode, np.asarray(image)
    if path.suffix.lower() != ".npy" and mode not in ("I;16", "I;16B", "I", "F"):
        came = f"got one of mode {mode}; is it the colour image?"
        raise InputError(f"{name}: expected a depth image of one channel, 16 bits or float, {came}")
    return require_depth(depth, name)


def require_depth(depth: ArrayLike, name: str) -> np.ndarray:
    """Return a depth image (H, W) of numbers, 0 where it is masked, or raise InputError."""
    with explaining(f"{name}: expected a depth image (height, width)", ValueError, why="; "):  # rows differ in length
        depth = np.asarray(np.ma.filled(depth, 0))
    if depth.ndim != 2 or depth.dtype.kind not in "iuf":
        came = f"got an array of {depth.dtype} of shape {depth.shape}"
        raise InputError(f"{name}: expected a depth image (height, width) of numbers, {came}")
    return depth


def read_color(color: Path | ArrayLike, depth: np.ndarray) -> np.ndarray:
    """Return the colours (H * W, 3) uint8 of an image that is registered to a depth image (H, W)."""
    from PIL import Image

    if isinstance(color, Path):
        require_file(color)
        with explaining(f"{color.name}: expected a colour image, could not read it; is it damaged?", *_DAMAGE):
            with Image.open(color) as image:
                colors = np.asarray(image.convert("RGB"))
    else:
        colors = np.asarray(color)
        if colors.ndim != 3 or colors.shape[2] != 3 or colors.dtype != np.uint8:
            raise InputError(f"color: expected a path or (H, W, 3) uint8, got {colors.shape} {colors.dtype}")
    name = color.name if isinstance(color, Path) else "color"
    require_same_size(name, (colors.shape[1], colors.shape[0]), depth, "a colour image")
    return colors.reshape(-1, 3)


def filled(points: np.ndarray, side: float) -> np.ndarray:
    """Return a scan's points (N, 3) followed by points that fill the gaps (M, 3) between neighbours, metres.

    Fused scans are thinned to two or three centimetres and single views are sparser with distance, while tolerances and
    sizes are in voxels of one. Added points lie between two points that are among each other's six nearest, so that no
    surface grows beyond its edges. The order of the points does not matter.

    Parameters
    ----------
    points : (N, 3) float64, metres
    side : float
        Of the voxels to be filled, metres.
    """
    places = cells(points, side).means
    if len(places) <= NEIGHBORS:
        return points
    alone = ~crowded(places, SCAN.sparse * side)
    lone = np.flatnonzero(alone)
    nearest_other = nearest_others(places, lone, SCAN.widest_gap)
    is_other = np.zeros(len(places) + 1, bool)  # the last one is that of no neighbour
    is_other[nearest_other] = True
    others = np.flatnonzero(is_other[:-1] & ~alone)
    queries = np.append(lone, others)
    neighbors = np.vstack([nearest_other, nearest_others(places, others, SCAN.widest_gap)])
    return np.vstack([points, between(places, mutual_pairs(queries, neighbors, alone), side)])


def mutual_pairs(queries: np.ndarray, neighbors: np.ndarray, alone: np.ndarray) -> np.ndarray:
    """Return the pairs (P, 2) of points that are each other's neighbours, at least one of which stands alone.

    Parameters
    ----------
    queries : (A,) int64
        Indices of the points that stand alone, and of their neighbours.
    neighbors : (A, K) int64
        Indices of the nearest other points of each; N where there are no more.
    alone : (N,) bool
    """
    count = len(alone)
    first = np.repeat(queries, neighbors.shape[1])
    second = neighbors.ravel()
    known = second < count
    keys = np.sort((np.minimum(first, second) * (count + 1) + np.maximum(first, second))[known])
    keys = keys[1:][keys[1:] == keys[:-1]]
    pairs = np.column_stack([keys // (count + 1), keys % (count + 1)])
    return pairs[alone[pairs[:, 0]] | alone[pairs[:, 1]]]


def between(places: np.ndarray, pairs: np.ndarray, side: float) -> np.ndarray:
    """Return points (M, 3) a voxel's side apart between the two of each pair (P, 2) of places (N, 3)."""
    start, way = places[pairs[:, 0]], places[pairs[:, 1]] - places[pairs[:, 0]]
    steps = np.ceil(np.linalg.norm(way, axis=1) / side).astype(int)
    counts = np.maximum(steps - 1, 0)
    chosen = np.repeat(np.arange(len(pairs)), counts)
    rank = np.arange(len(chosen)) - np.repeat(np.cumsum(counts) - counts, counts) + 1
    return start[chosen] + way[chosen] * (rank / steps[chosen])[:, None]
