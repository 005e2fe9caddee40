"""Scans of depth sensors, as points in the sensor's or the room's own frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from spherefunc_bullet.clouds.orientation import report_coarse
from spherefunc_bullet.errors import InputError, one_line
from spherefunc_bullet.formats.sources import Geometry, read_geometry
from spherefunc_bullet.formats.units import METRES, format_length

from ..settings import SCAN
from .cells import cells

Report = Callable[[str], None]

UNITS = (*METRES, "auto")


@dataclass(frozen=True, kw_only=True, eq=False)
class Scan:
    """A point cloud of a room or a table top, in metres, in its own frame, which may be tilted."""

    name: str
    points: np.ndarray  # (N, 3) float64, metres, finite
    colors: np.ndarray | None = None  # (N, 3) uint8
    dropped: int = 0  # points that were not finite, where the sensor measured nothing, or strays far away
    level_frame: str | None = None  # name of the points' frame, where that is known to have z up

    def __len__(self) -> int:
        return len(self.points)


def require_surfaces(points: np.ndarray, name: str):
    """Raise InputError if points (N, 3), metres, fill space, as stray points do, instead of lying on surfaces."""
    share = cells(points, SCAN.block).interior.mean()
    if share > SCAN.most_interior:
        raise InputError(
            f"{name}: expected points on surfaces, got some everywhere: {share:.0%} of its cells of "
            f"{format_length(SCAN.block)} have others on all sides; if many are stray, filter them, "
            "such as by Open3D's remove_statistical_outlier"
        )


def scan_from_points(
    points: ArrayLike,
    name: str = "scan",
    *,
    colors: np.ndarray | None = None,
    units: str = "m",
    report: Report | None = None,
    level_frame: str | None = None,
) -> Scan:
    """Return the scan of points, without those that are not finite, or more than 60 m from the middle.

    Parameters
    ----------
    points : (N, 3) array_like, in ``units``
    name : str
        Used in messages.
    colors : (N, 3) uint8, optional
    units : {"m", "cm", "mm", "in", "auto"}
        ``auto`` takes metres, or millimetres where a scan of metres would be larger than 60 m, and reports that.
    report : callable, optional
        Takes one line of text for each guess; by default nothing is reported.
    level_frame : str, optional
        Name of the points' frame, where that is known to have z up.

    Raises
    ------
    InputError
        If fewer than 100 points are finite, or the unit is unknown.
    """
    points = np.asarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"{name}: expected points (N, 3), got an array of shape {points.shape}")
    seen = np.isfinite(points).all(axis=1)
    if seen.sum() < SCAN.min_points:
        raise InputError(
            f"{name}: expected at least {SCAN.min_points} points, got {int(seen.sum())}; is it empty or cut off?"
        )
    low, high = np.percentile(points[seen], [1, 99], axis=0)
    metre = metres_of(float((high - low).max()), units, name, report := report or (lambda line: None))
    seen &= (np.abs(points - (low + high) / 2) <= SCAN.largest / metre).all(axis=1)
    if not seen.all():
        points, colors = points[seen], None if colors is None else colors[seen]
    report_coarse(points, metre, name, report)
    return Scan(
        name=name,
        points=points * metre,
        colors=colors,
        dropped=int(len(seen) - seen.sum()),
        level_frame=level_frame,
    )


def metres_of(extent: float, units: str, name: str, report: Report) -> float:
    """Return the metres of a scan's unit, from the unit and the scan's extent in it."""
    if units not in UNITS:
        raise InputError(f'units="{units}": expected one of {", ".join(UNITS)}')
    if units == "auto":
        units = "mm" if extent > SCAN.largest else "m"
        if units == "mm":
            report(f"{name}: {extent:.3g} large, so millimetres are assumed; units= sets another unit")
    if not 0.05 <= extent * METRES[units] <= SCAN.largest:
        helps = any(0.05 <= extent * metres <= SCAN.largest for metres in METRES.values())
        came = f"got {extent * METRES[units]:.3g} m{'; set units=' if helps else ''}"
        raise InputError(f"{name}: expected a scan between 5 cm and {SCAN.largest:g} m large, {came}")
    return METRES[units]


def load_scan(path: str | Path, *, units: str = "auto", report: Report | None = None) -> Scan:
    """Return the scan of a point cloud's file, or of a mesh fused from depth images, in the file's own axes.

    Parameters
    ----------
    path : str or Path
        PLY, PCD (organised or not), XYZ, NPZ, or any other format that clouds and meshes are read from.
    units, report
        See `scan_from_points`.

    Raises
    ------
    InputError
        If the file cannot be used; the message is one line and begins with the file's name.
    """
    name = one_line(Path(path).name)
    geometry = read_geometry(path)
    if len(geometry.faces):
        return scan_from_points(surface_points(geometry, name), name, units=units, report=report)
    return scan_from_points(geometry.vertices, name, colors=geometry.colors, units=units, report=report)


def surface_points(geometry: Geometry, name: str = "scan") -> np.ndarray:
    """Return samples (N, 3) of a mesh's surface, in its own unit, a hundredth of a metre apart if that is metres."""
    from spherefunc_bullet.clouds.sampling import sample_surface

    extent = np.ptp(geometry.vertices, axis=0).max()
    if extent > SCAN.largest / METRES["mm"]:
        raise InputError(f"{name}: expected a scan of at most {SCAN.largest:g} m, got {extent:.3g} by the file's unit")
    gap = SCAN.cell / 2 if extent <= SCAN.largest else SCAN.cell / 2 * extent / 5
    return sample_surface(geometry.vertices, geometry.faces, gap)
