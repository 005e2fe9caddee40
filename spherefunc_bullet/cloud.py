"""The cloud: an object as points in metres, z up, standing on the ground (paper, §III-A and §IV-A)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .errors import InputError
from .orientation import UNITS, UPS, Report, require_choice, to_metres, turned_up
from .reading import read_geometry

MIN_POINTS = 10
MAX_SAMPLES = 20_000_000
MAX_GAP = 0.005  # metres: the paper's half centimetre between a surface and its nearest sample
_SPACING_POINTS = 2_000  # for the median distance between neighbours; its error is a few per cent


@dataclass(frozen=True)
class Cloud:
    """Points of one object, in metres, z up; as loaded, centred on the z axis and standing on z = 0."""

    points: np.ndarray  # (N, 3) float64, metres
    name: str = "cloud"

    def __post_init__(self):
        points = np.ascontiguousarray(self.points, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise InputError(f"{self.name}: expected points (N, 3), got an array of shape {points.shape}")
        if len(points) < MIN_POINTS:
            raise InputError(f"{self.name}: expected at least {MIN_POINTS} points, got {len(points)}; is it empty?")
        if not np.isfinite(points).all():
            raise InputError(f"{self.name}: expected finite points, got NaN or infinity; drop those first")
        object.__setattr__(self, "points", points)

    def __len__(self) -> int:
        return len(self.points)

    @property
    def bounds(self) -> np.ndarray:
        """Lowest and highest corner of the bounding box, (2, 3), metres."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    @property
    def size(self) -> np.ndarray:
        """Extents of the bounding box, (3,), metres."""
        return np.ptp(self.points, axis=0)

    @property
    def spacing(self) -> float:
        """Median distance from a point to its nearest neighbour, metres, over evenly chosen points."""
        from scipy.spatial import cKDTree

        step = max(1, len(self.points) // _SPACING_POINTS)
        distances, _ = cKDTree(self.points).query(self.points[::step], k=2)
        return float(np.median(distances[:, 1]))


def placed(points: np.ndarray) -> np.ndarray:
    """Return points moved so that their bounding box is centred on the z axis and rests on z = 0."""
    low, high = points.min(axis=0), points.max(axis=0)
    return points - [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]


def cloud_from_points(points: np.ndarray, name: str = "cloud") -> Cloud:
    """Return a cloud of the points as they are, only placed on the ground."""
    cloud = Cloud(points, name)
    return Cloud(placed(cloud.points), name)


def cloud_from_mesh(vertices, faces, name: str = "mesh", *, max_gap: float = MAX_GAP) -> Cloud:
    """Return a cloud that samples a mesh, no surface location farther than ``max_gap`` from a point."""
    from .sampling import needed_samples, sample_surface

    vertices = placed(np.asarray(vertices, dtype=np.float64))
    needed = needed_samples(vertices, faces, max_gap)
    if needed > MAX_SAMPLES:
        raise InputError(f"{name}: its surface needs {needed:.0f} samples, at most {MAX_SAMPLES} are made; --units?")
    return cloud_from_points(sample_surface(vertices, faces, max_gap), name)


def load_cloud(path, *, up="z", units="m", max_gap: float = MAX_GAP, report: Report | None = None) -> Cloud:
    """Return the cloud of a file: a mesh is sampled, a point cloud comes as it is; placed on the ground."""
    report = report or (lambda line: None)
    require_choice("--up", up, UPS)
    require_choice("--units", units, UNITS)
    name = Path(path).name
    geometry = read_geometry(path)
    vertices = to_metres(turned_up(geometry.vertices, up), units, name, report)
    if len(geometry.faces):
        return cloud_from_mesh(vertices, geometry.faces, name, max_gap=max_gap)
    return cloud_from_points(vertices, name)
