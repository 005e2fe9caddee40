"""What a file holds: vertices, triangles where there are any, and what it says of each vertex beside."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from . import FormatError
from .limits import require_counts


def _no_faces() -> np.ndarray:
    return np.empty((0, 3), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Geometry:
    """A mesh or a cloud, in the file's own units and axes."""

    vertices: np.ndarray  # (N, 3) float64; of a cloud NaN where a sensor saw nothing
    faces: np.ndarray = field(default_factory=_no_faces)  # (M, 3) int64; none: a cloud
    colors: np.ndarray | None = None  # (N, 3) uint8
    labels: np.ndarray | None = None  # (N,) int64

    def checked(self) -> Geometry:
        """Return the same as contiguous arrays, or raise FormatError for what is no mesh and no cloud."""
        vertices = np.ascontiguousarray(self.vertices, dtype=np.float64)
        faces = np.ascontiguousarray(self.faces, dtype=np.int64)
        _require_consistent(vertices, faces)
        return Geometry(vertices, faces, self.colors, self.labels)


def _require_consistent(vertices: np.ndarray, faces: np.ndarray) -> None:
    """Raise FormatError for arrays that are no mesh and no cloud."""
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not len(vertices):
        raise FormatError(f"expected vertices or points, got {len(vertices)}; is the file empty?")
    require_counts(vertices=len(vertices), triangles=len(faces))
    if not len(faces):
        return
    if faces.min() < 0 or faces.max() >= len(vertices):
        wrong = faces.min() if faces.min() < 0 else faces.max()
        raise FormatError(f"expected faces of its {len(vertices)} vertices, got one of number {wrong}; is it damaged?")
    broken = int((~np.isfinite(vertices)).any(axis=1).sum())
    if broken:
        raise FormatError(f"expected finite vertices, got NaN or infinity in {broken} of {len(vertices)}; repair it")


def fan_triangles(counts: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the triangles of polygons, each a fan around its first corner (exact for convex ones).

    Parameters
    ----------
    counts : (P,) int
        Corners of each polygon, at least 1; those of 1 or 2, which some programs write, have no surface.
    corners : (sum of counts,) int
        The polygons' vertex numbers, one after the other.

    Returns
    -------
    (M, 3) int64

    Examples
    --------
    >>> fan_triangles(np.array([3, 4]), np.array([0, 1, 2, 3, 4, 5, 6]))
    array([[0, 1, 2],
           [3, 4, 5],
           [3, 5, 6]])
    """
    counts, corners = np.asarray(counts, dtype=np.int64), np.asarray(corners, dtype=np.int64)
    if len(counts) and counts.min() < 1:
        raise FormatError(f"expected faces of 3 corners or more, got one of {counts.min()}; is it damaged?")
    fans = np.maximum(counts - 2, 0)
    first = np.repeat(np.cumsum(counts) - counts, fans)
    step = np.arange(len(first)) - np.repeat(np.cumsum(fans) - fans, fans)
    return np.column_stack([corners[first], corners[first + step + 1], corners[first + step + 2]]).reshape(-1, 3)
