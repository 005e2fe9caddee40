"""The cloud: an object as points in metres, z up, standing on the ground (paper, §III-A and §IV-A)."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError, explaining, one_line, warn_renamed
from ..formats.sources import Geometry, Source, as_source, read_geometry
from ..formats.units import BY_FILE
from .orientation import Report, corners_of, require_choices, require_size, to_metres, to_z_up, unit_question

MIN_POINTS = 10
MAX_SAMPLES = 8_000_000  # of 110 square metres, whose sampling takes less than 2 GiB
MAX_GAP = 0.005  # metres: the paper's half centimetre between a surface and its nearest sample
PITCH = 0.0035  # metres: median distance between samples along the surface of a mesh, see `sampling`
THINNED = 0.005  # metres: smallest cell for thinning
Derived = TypeVar("Derived")
_SPACING_POINTS = 2_000  # neighbour distances used for the median, whose error is then about one per cent
_ITSELF = object()  # stored instead of a derived value that is the cloud itself


@dataclass(frozen=True, eq=False)
class Mesh:
    """The surface that a cloud samples, in the cloud's frame."""

    vertices: np.ndarray  # (N, 3) float64, metres
    faces: np.ndarray  # (M, 3) int64


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points of one object in metres, z up; as loaded, centred on the z axis and resting on z = 0.

    If the points sample a mesh, the cloud contains it as well.

    Raises
    ------
    InputError
        If the points are not (N, 3), not finite, or fewer than 10.
    """

    points: np.ndarray  # (N, 3) float64, metres
    name: str = "cloud"
    mesh: Mesh | None = None
    unfilled: float = 0.0  # metres to a point's sixth neighbour before gaps were filled; 0: they were not

    def __post_init__(self):
        object.__setattr__(self, "points", _require_points(self.points, self.name))

    def __len__(self) -> int:
        return len(self.points)

    @cached_property
    def bounds(self) -> np.ndarray:
        """Lowest and highest corner of the bounding box, (2, 3), metres."""
        return corners_of(self.points)

    @property
    def size(self) -> np.ndarray:
        """Extents of the bounding box, (3,), metres."""
        return self.bounds[1] - self.bounds[0]

    @cached_property
    def tree(self):
        """The points as a `scipy.spatial.cKDTree`."""
        from scipy.spatial import cKDTree

        return cKDTree(self.points)

    def cached(self, what: Hashable, derive: Callable[[], Derived]) -> Derived:
        """Return the value of ``derive``, computed once and kept as long as the cloud exists.

        Copies of the cloud, also in other processes, do not contain it. If ``derive`` returns the cloud itself, only
        that fact is stored, since a reference to itself would keep the cloud alive.
        """
        if what not in self._derived:
            derived = derive()
            self._derived[what] = _ITSELF if derived is self else derived
        kept = self._derived[what]
        return self if kept is _ITSELF else kept

    def once(self, what: Hashable, derive: Callable[[], Derived]) -> Derived:
        """Return the value of `cached`; this is its old name."""
        warn_renamed("Cloud.once", "Cloud.cached")
        return self.cached(what, derive)

    @cached_property
    def _derived(self) -> dict[Hashable, Any]:
        return {}

    def __getstate__(self) -> dict[str, Any]:
        return {part.name: getattr(self, part.name) for part in fields(self)}

    def thinned(self, side: float) -> np.ndarray:
        """Return one point (M, 3) in each cube of the largest side, `THINNED` times a power of two, up to ``side``.

        The result does not depend on the order of the points. If ``side`` is smaller than `THINNED`, it is all points.
        """
        from .thinning import one_per_cell

        points, cell = self.points, THINNED
        while cell <= side:  # each level from the previous one, which has fewer points
            points = self.cached(("thinned", cell), partial(one_per_cell, points, cell, self.bounds))
            cell *= 2
        return points

    @property
    def spacing(self) -> float:
        """Median distance from a point to its nearest neighbour, metres, over a regular choice of points."""
        return self.to_neighbour(1)

    def to_neighbour(self, rank: int) -> float:
        """Return the median distance from a point to its neighbour of a rank, metres; see `spacing`."""
        return float(np.median(self.some_to_neighbour(rank))) or self.distinct.to_neighbour(rank)

    def some_to_neighbour(self, rank: int) -> np.ndarray:
        """Return the distances (S,) from a regular choice of points to their neighbours of a rank, metres."""
        step = max(1, len(self.points) // _SPACING_POINTS)
        return self.tree.query(self.points[::step], k=rank + 1)[0][:, rank]

    @property
    def distinct(self) -> Cloud:
        """The cloud with each point once; programs repeat points to fill arrays."""
        return self.cached("distinct", lambda: replace(self, points=np.unique(self.points, axis=0)))


def _require_points(points: ArrayLike, name: str) -> np.ndarray:
    """Return points as float64 (N, 3), or raise InputError."""
    with explaining(f"{name}: expected points as numbers (N, 3), got another type", TypeError, ValueError):
        points = np.ascontiguousarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"{name}: expected points (N, 3), got an array of shape {points.shape}")
    if len(points) < MIN_POINTS:
        raise InputError(f"{name}: expected at least {MIN_POINTS} points, got {len(points)}; is it empty or cut off?")
    if not np.isfinite(points).all():
        broken = int((~np.isfinite(points)).any(axis=1).sum())
        raise InputError(f"{name}: expected finite points, got NaN or infinity in {broken}; drop those first")
    return points


def placed(points: np.ndarray) -> np.ndarray:
    """Return points (N, 3), metres, moved so that their bounding box is centred on the z axis and rests on z = 0."""
    return points - centre_on_ground(points)


def centre_on_ground(points: np.ndarray) -> np.ndarray:
    """Return the centre (3,) of the lower face of the bounding box of points (N, 3), metres."""
    low, high = corners_of(points)
    return np.array([low[0] + (high[0] - low[0]) / 2, low[1] + (high[1] - low[1]) / 2, low[2]])


def cloud_from_points(
    points: ArrayLike, name: str = "cloud", *, up: str = "z", units: str = "m", report: Report | None = None
) -> Cloud:
    """Return a cloud of points in their order, rotated, scaled and moved to the ground.

    Parameters
    ----------
    points : (N, 3) array_like, in ``units``, finite
    name : str
        Name in error messages and results.
    up, units, report
        See `load_cloud`.

    Raises
    ------
    InputError
        If the points are not (N, 3), not finite, fewer than 10, or of a size that only a wrong unit explains.
    """
    return cloud_of(Geometry(_require_points(points, name)), Path(name), up=up, units=units, report=report)


def _require_mesh(vertices: ArrayLike, faces: ArrayLike, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices that faces use and the faces, or raise InputError if they form no surface."""
    vertices, faces = np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int64)
    if vertices.ndim != 2 or vertices.shape[1:] != (3,) or faces.ndim != 2 or faces.shape[1:] != (3,):
        shapes = f"{vertices.shape} and {faces.shape}"
        raise InputError(f"{name}: expected vertices (N, 3) and faces (M, 3), got {shapes}")
    if not len(faces) or faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(f"{name}: expected faces that name its {len(vertices)} vertices, got others or none")
    used, faces = np.unique(faces, return_inverse=True)
    if not np.isfinite(vertices[used]).all():
        raise InputError(f"{name}: expected finite vertices, got NaN or infinity; repair the mesh")
    return vertices[used], faces.reshape(-1, 3)


def cloud_from_mesh(vertices: ArrayLike, faces: ArrayLike, name: str = "mesh", *, max_gap: float = MAX_GAP) -> Cloud:
    """Return a cloud that samples a mesh evenly, with no surface location farther than ``max_gap`` from a point.

    Parameters
    ----------
    vertices : (N, 3) array_like, metres, z up
    faces : (M, 3) array_like of int
    name : str
        Name in error messages and results.
    max_gap : float, metres
        The paper's half centimetre.

    Raises
    ------
    InputError
        If the mesh has no area, refers to missing vertices, or needs more than `MAX_SAMPLES`.
    """
    from .sampling import needed_samples, sample_surface, surface_area

    if not 0 < max_gap < np.inf:
        raise InputError(f"{name}: expected max_gap above zero metres, got {max_gap}")
    vertices, faces = _require_mesh(vertices, faces, name)
    vertices = placed(vertices)
    if surface_area(vertices, faces) <= max_gap**2:
        raise InputError(f"{name}: expected a mesh with a surface, got one without area; is it flat or damaged?")
    needed = needed_samples(vertices, faces, max_gap)
    if needed > MAX_SAMPLES:
        wide = unit_question(float(np.ptp(vertices, axis=0).max()))
        problem = f"this surface needs {needed:.2g}: {wide}, or a room instead of an object?"
        raise InputError(f"{name}: expected at most {MAX_SAMPLES} samples, {problem}")
    points = sample_surface(vertices, faces, max_gap)
    first = points[0].copy()
    points -= centre_on_ground(points)
    return Cloud(points, name, Mesh(vertices + (points[0] - first), faces))


def _clean(geometry: Geometry, name: str, report: Report) -> Geometry:
    """Return the vertices that faces use and the faces, or else the finite points."""
    points = geometry.vertices
    if len(geometry.faces):
        return Geometry(*_require_mesh(points, geometry.faces, name))
    seen = np.isfinite(points).all(axis=1)
    if not seen.all():
        report(f"{name}: dropped {len(points) - int(seen.sum())} of {len(points)} points that are not finite")
    return Geometry(_require_points(points[seen], name))


def load_cloud(
    file: str | Path | Source,
    *,
    up: str = BY_FILE,
    units: str = "m",
    max_gap: float = MAX_GAP,
    report: Report | None = None,
) -> Cloud:
    """Return the cloud of a file, in metres, z up, on the ground (paper, §IV-A).

    A mesh is sampled; a point cloud keeps its points and their order.

    Parameters
    ----------
    file : str, Path or Source
        PLY, PCD, OBJ, STL, 3DS, OFF, GLB, glTF, XYZ or NPZ.
    up : {"file", "z", "-z", "y", "-y", "x", "-x", "auto"}
        The file's axis that points up: by default y for glTF, as its standard says, and z for all others; ``auto``
        guesses and reports the guess.
    units : {"m", "cm", "mm", "in", "auto"}
        The file's unit of length; ``auto`` guesses and reports the guess.
    max_gap : float, metres
        The largest distance from the surface of a mesh to its nearest sample.
    report : callable, optional
        Receives one line of text for each guess and for whatever looks wrong; by default nothing is reported.

    Raises
    ------
    InputError
        If the file cannot be used; the message is one line and starts with the file's name.
    """
    source = as_source(file if isinstance(file, Source) else Path(file).expanduser())
    return cloud_of(read_geometry(source), source.path, up=up, units=units, max_gap=max_gap, report=report)


def cloud_of(
    geometry: Geometry,
    path: Path,
    *,
    up: str = "z",
    units: str = "m",
    max_gap: float = MAX_GAP,
    report: Report | None = None,
) -> Cloud:
    """Return the cloud of a mesh or of points, from a file or not; see `load_cloud`.

    Parameters
    ----------
    path : Path
        Its name is used in messages; its ending decides which axis is up, if ``up`` leaves that to the file.
    """
    report = report or (lambda line: None)
    require_choices(up, units)
    name = one_line(path.name)
    geometry = _clean(geometry, name, report)
    vertices = to_metres(to_z_up(geometry, up, path, report), units, name, report)
    require_size(vertices, name, report)
    if len(geometry.faces):
        return cloud_from_mesh(vertices, geometry.faces, name, max_gap=max_gap)
    return Cloud(placed(vertices), name)
