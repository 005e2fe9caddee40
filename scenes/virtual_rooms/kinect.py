"""A virtual Kinect: depth images of labelled surfaces.

The camera's frame is the sensor's: x right, y down, z forward, metres. Noise in depth follows Nguyen, Izadi and Lovell
(3DIMPVT 2012): 2 mm at 1 m, 4 cm at 5 m. Pixels lose their depth where a real sensor's do: at grazing angles, at depth
edges, and in the shadow of the projector, which is next to the camera.

With a `window` the sensor matches windows as the real one does: fine relief and rims are smoothed, noise is shared by
neighbouring pixels, and depth comes in steps of disparity (Khoshelham and Oude Elberink, Sensors 2012). With `blur` it
is a stereo camera with smoothing filters: mugs are half filled, and false surfaces hang behind their edges.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from spherefunc_bullet.clouds.cloud import Mesh
from spherefunc_bullet.clouds.raycasting import raycasting_scene, rays_from

from ..scans.camera import Intrinsics

NOTHING = -3  # label of a ray that hits no surface
GRAZING_DEG = (70.0, 85.0)  # angles to the surface's normal at which no and all pixels are lost
NEAREST, FARTHEST = 0.5, 5.0  # metres of depth between which it measures
BASELINE = 0.075  # metres from the camera to the projector on its right
EDGE_STEP = 0.03  # of the depth: a larger jump to the next pixel is an edge
EDGE_LOSS = 0.5  # share of edge pixels without depth
MAX_EDGE_SHIFT = 0.06  # metres by which a stereo camera's filter moves a point at most
STEPS = 8  # of disparity to the pixel, where windows are matched


@dataclass(frozen=True, kw_only=True)
class Kinect:
    """The sensor's settings; by default a Kinect of the first generation."""

    width: int = 640  # pixels
    height: int = 480  # pixels
    field_of_view_deg: float = 57.0  # horizontal
    noise: float = 1.0  # times the sensor's own; 0 for an ideal camera
    dropouts: bool = True
    window: int = 1  # pixels along the side of the windows that are matched; 1: every pixel by itself
    blur: float = 0.0  # pixels, deviation of a stereo camera's smoothing filter; 0: none

    @property
    def focal_length(self) -> float:
        """Focal length in pixels."""
        return self.width / 2 / np.tan(np.radians(self.field_of_view_deg) / 2)

    def noisy(self, noise: float) -> Kinect:
        """Return the sensor with this many times its noise; 0 is without noise and lost pixels."""
        return replace(self, noise=noise, dropouts=noise > 0)

    @property
    def camera(self) -> Intrinsics:
        """The pinhole camera of its images."""
        middle = {"cx": (self.width - 1) / 2, "cy": (self.height - 1) / 2}
        return Intrinsics(width=self.width, height=self.height, fx=self.focal_length, fy=self.focal_length, **middle)


KINECT = Kinect()


@dataclass(frozen=True, eq=False)
class DepthImage:
    """Depth and label of every pixel, and the camera's pose."""

    depth: np.ndarray  # (H, W) float64, metres along the camera's z; NaN where nothing was measured
    labels: np.ndarray  # (H, W) int32, of the surface that was hit; NOTHING where none was
    T_room_camera: np.ndarray  # (4, 4)
    kinect: Kinect

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the measured points (N, 3) in the room's frame, and their labels (N,)."""
        seen = np.isfinite(self.depth)
        in_camera = self.kinect.camera.rays()[seen] * self.depth[seen][:, None]
        return in_camera @ self.T_room_camera[:3, :3].T + self.T_room_camera[:3, 3], self.labels[seen]


class Surfaces:
    """Labelled meshes for ray casting.

    Parameters
    ----------
    meshes : iterable of (label, Mesh)
        In the room's frame, metres.
    """

    def __init__(self, meshes: Iterable[tuple[int, Mesh]]):
        labels, surfaces = zip(*meshes, strict=True)
        self.raycaster = raycasting_scene(*((mesh.vertices, mesh.faces) for mesh in surfaces), threads=1)
        self.labels = np.array(labels, np.int32)

    def first_hits(self, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return each ray's hit in multiples of its direction (infinity: none), the label and the unit normal there."""
        hits = self.raycaster.cast_rays(rays_from(origins, directions))
        distance, owner = hits["t_hit"].numpy(), hits["geometry_ids"].numpy()
        hit = np.isfinite(distance)
        labels = np.where(hit, self.labels[np.where(hit, owner, 0)], np.int32(NOTHING))
        return distance, labels, hits["primitive_normals"].numpy()

    def hidden(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Return whether anything lies between each origin and the point one direction away."""
        return self.raycaster.test_occlusions(rays_from(origins, directions), tfar=0.99).numpy()

    def clearance(self, points: np.ndarray) -> np.ndarray:
        """Return each point's distance (N,) to the nearest surface, metres."""
        return self.raycaster.compute_distance(np.asarray(points, np.float32)).numpy()


def look_at(eye: ArrayLike, target: ArrayLike) -> np.ndarray:
    """Return T_room_camera (4, 4) of a camera at ``eye`` that looks at ``target`` and is held level."""
    forward = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    T_room_camera = np.eye(4)
    T_room_camera[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    T_room_camera[:3, 3] = eye
    return T_room_camera


def depth_noise(depth: np.ndarray) -> np.ndarray:
    """Return the standard deviation of a Kinect's depth, metres (Nguyen et al. 2012, equation 3).

    Examples
    --------
    >>> [round(float(depth_noise(depth)), 4) for depth in (1.0, 2.0, 5.0)]
    [0.0019, 0.0061, 0.0414]
    """
    return 0.0012 + 0.0019 * (np.asarray(depth) - 0.4) ** 2


def photograph(surfaces: Surfaces, T_room_camera: np.ndarray, kinect: Kinect, rng: np.random.Generator) -> DepthImage:
    """Return the depth image that the sensor measures from a pose."""
    directions = kinect.camera.rays() @ T_room_camera[:3, :3].T
    eye = T_room_camera[:3, 3]
    depth, labels, normals = surfaces.first_hits(eye, directions)
    depth = np.where((depth >= NEAREST) & (depth <= FARTHEST), depth.astype(np.float64), np.nan)
    if kinect.dropouts:
        lost = grazing(directions, normals, rng) | at_edges(depth, rng)
        projector = eye + T_room_camera[:3, 0] * BASELINE
        lost |= surfaces.hidden(projector, eye + directions * np.nan_to_num(depth)[..., None] - projector)
        depth[lost] = np.nan
    if kinect.window > 1:
        depth = matched(depth, kinect)
    if kinect.blur:
        depth = smoothed(depth, kinect.blur)
    if kinect.noise:
        depth += kinect.noise * depth_noise(depth) * scatter(depth.shape, kinect.window, rng)
    return DepthImage(in_steps(depth, kinect) if kinect.window > 1 else depth, labels, T_room_camera, kinect)


def matched(depth: np.ndarray, kinect: Kinect) -> np.ndarray:
    """Return depth (H, W) from matched windows: the median around each pixel that has depth, metres."""
    from scipy.ndimage import median_filter

    nearness = np.where(np.isfinite(depth), 1 / np.nan_to_num(depth, nan=1.0), 0.0).astype(np.float32)
    middle = median_filter(nearness, size=kinect.window).astype(float)
    # Where most of a window has no depth, at slender objects, the pixel keeps its own.
    return np.where(np.isfinite(depth) & (middle > 0), 1 / np.where(middle > 0, middle, 1.0), depth)


def smoothed(depth: np.ndarray, deviation: float) -> np.ndarray:
    """Return depth (H, W) after a stereo camera's filters, metres: shallower hollows, false surfaces behind edges.

    Pixels that would move by more than `MAX_EDGE_SHIFT` stay, since these filters spare the edges of distant surfaces.
    """
    from scipy.ndimage import gaussian_filter

    seen = np.isfinite(depth)
    nearness = gaussian_filter(np.where(seen, 1 / np.where(seen, depth, 1.0), 0.0), deviation)
    even = gaussian_filter(seen.astype(float), deviation) / np.maximum(nearness, 1e-9)
    return np.where(seen & (np.abs(even - depth) < MAX_EDGE_SHIFT), even, depth)


def scatter(shape: tuple[int, ...], window: int, rng: np.random.Generator) -> np.ndarray:
    """Return noise (H, W) of deviation 1; pixels of one window share most of it."""
    from scipy.ndimage import gaussian_filter

    noise = rng.standard_normal(shape)
    if window == 1:
        return noise
    shared = gaussian_filter(noise, window / 4)
    return shared / shared.std()


def in_steps(depth: np.ndarray, kinect: Kinect) -> np.ndarray:
    """Return depth (H, W) in steps of disparity, metres: 3 mm at 1 m, 2.5 cm at 3 m."""
    scale = kinect.focal_length * BASELINE * STEPS
    return scale / np.maximum(np.round(scale / depth), 1.0)


def grazing(directions: np.ndarray, normals: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return the pixels (H, W) lost because the surface is seen at a grazing angle."""
    cosine = np.abs(np.einsum("...k,...k", directions, normals)) / np.linalg.norm(directions, axis=-1)
    least, most = GRAZING_DEG
    share = (np.degrees(np.arccos(np.clip(cosine, 0, 1))) - least) / (most - least)
    return rng.random(share.shape) < share


def at_edges(depth: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return the pixels (H, W) lost because a neighbour is much nearer or farther."""
    edges = np.zeros(depth.shape, bool)
    for axis in (0, 1):
        step = np.abs(np.diff(depth, axis=axis)) > EDGE_STEP * np.minimum(*neighbours_along(depth, axis))
        for side in neighbours_along(edges, axis):
            side |= step
    return edges & (rng.random(depth.shape) < EDGE_LOSS)


def neighbours_along(image: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """Return views of all pixels but the last, and all but the first, along an axis."""
    return (image[:-1], image[1:]) if axis == 0 else (image[:, :-1], image[:, 1:])
