"""Axes, units and bounding boxes: conversion from those of a file to metres with z up."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..errors import InputError, one_line
from ..formats.ply import COARSE, step_of_float32
from ..formats.sources import Geometry
from ..formats.units import BY_FILE, METRES, format_length

Report = Callable[[str], None]
UPS = ("z", "-z", "y", "-y", "x", "-x", "auto", BY_FILE)
UNITS = (*METRES, "auto")
MAX_EXTENT, MIN_EXTENT = 100.0, 0.005  # metres: outside this range the unit must be wrong
ODD_EXTENTS = (0.02, 20.0)  # metres: outside this range the unit may be wrong
_Y_UP = (".glb", ".gltf")  # by their standard
_STATED_UP = (".dae", ".usd", ".usda", ".usdc", ".usdz")  # files that state their axis and unit, which readers follow
_STATED_UNIT = (*_STATED_UP, ".3mf")
STRAY, ALONE = 0.02, 100.0  # share of points at each end that may be stray, and by what factor they widen the object
LIKELY = (0.05, 3.0)  # metres, the largest extent of most household objects
_TRIED_UNITS = ("m", "mm", "cm", "in")  # the first that is likely wins
# By how much an object must stand more safely with y up than with z up. On the 382 clear models of the
# development set, 0.05 keeps 93 % of those with z up unchanged and rotates 83 % of those with y up.
_CLEARLY = 0.05
_TURNS = {  # the axes that become x, y and z, and their signs: rotated, never mirrored
    "z": ((0, 1, 2), (1, 1, 1)),
    "-z": ((0, 1, 2), (1, -1, -1)),
    "y": ((0, 2, 1), (1, -1, 1)),
    "-y": ((0, 2, 1), (1, 1, -1)),
    "x": ((1, 2, 0), (1, 1, 1)),
    "-x": ((1, 2, 0), (-1, 1, -1)),
}
_TOUCHING = 0.02  # of the largest extent: lower points count as touching the ground


def require_choices(up: str, units: str) -> None:
    """Raise InputError for an unknown axis or unit."""
    for option, value, choices in (("up", up, UPS), ("units", units, UNITS)):
        if value not in choices:
            raise InputError(f'{option}="{value}": expected one of {", ".join(choices)}')


def corners_of(points: np.ndarray) -> np.ndarray:
    """Return the lowest and the highest corner (2, 3) of the bounding box of points (N, 3), metres."""
    return np.array([[axis.min() for axis in points.T], [axis.max() for axis in points.T]])


def turned_up(points: np.ndarray, up: str) -> np.ndarray:
    """Return points rotated so that the axis ``up`` becomes z.

    Parameters
    ----------
    points : (N, 3) float64
    up : {"z", "-z", "y", "-y", "x", "-x"}

    Examples
    --------
    >>> turned_up(np.array([[1.0, 2.0, 3.0]]), "y")
    array([[ 1., -3.,  2.]])
    """
    order, sign = _TURNS[up]
    return points[:, order] * np.array(sign, dtype=np.float64)


def likely_up(geometry: Geometry) -> tuple[str, str]:
    """Return "z" or "y", whichever direction lets an object stand more safely, and the reason; if in doubt, z.

    X is never guessed: hardly any program writes it, and every further axis is another possible mistake.
    """
    margins = {up: standing_margin(turned_up(geometry.vertices, up), geometry.faces) for up in "zy"}
    if margins["y"] > max(margins["z"], 0.0) + _CLEARLY:
        return "y", "it stands more safely that way"
    return "z", "it stands safely that way" if margins["z"] > 0 else "no other axis lets it stand more safely"


def promised_up(path: Path) -> str:
    """Return the axis that points up in the format of a file, by its ending.

    Examples
    --------
    >>> promised_up(Path("chair.glb")), promised_up(Path("chair.ply"))
    ('y', 'z')
    """
    return "y" if path.suffix.lower() in _Y_UP else "z"


def to_z_up(geometry: Geometry, up: str, path: Path, report: Report) -> np.ndarray:
    """Return a geometry's vertices with z up, and report a guess or a likely mistake.

    Parameters
    ----------
    geometry : Geometry
    up : one of `UPS`
    path : Path
        Its source: by their standard, .glb and .gltf files are y up.
    report : callable
        Receives one line of text.
    """
    name, promised, stated = one_line(path.name), promised_up(path), path.suffix.lower() in _STATED_UP
    if up == "auto" and stated:
        up = "z"
    elif up == "auto":
        up, reason = (promised, "glTF files are by their standard") if promised == "y" else likely_up(geometry)
        report(f"{name}: took {up} to be up, because {reason}; up= says otherwise")
    elif up == BY_FILE:
        up = promised
    elif promised == "y" and up == "z":
        report(f'{name}: taken as z up, but glTF files are y up by their standard; up="y" may be meant')
    elif stated and up != "z":
        report(f'{name}: turned by up="{up}" in addition to the axis that the file states, which was followed')
    return turned_up(geometry.vertices, up)


def likely_unit(extent: float) -> str:
    """Return the unit in which a largest extent is typical of a household object.

    The first unit of m, mm, cm and in that gives 5 cm to 3 m; if none does, the one that comes nearest.

    Examples
    --------
    >>> likely_unit(0.9), likely_unit(900), likely_unit(36)
    ('m', 'mm', 'cm')
    """
    metres = {unit: max(extent * METRES[unit], 1e-300) for unit in _TRIED_UNITS}
    excess = {unit: max(metres[unit] / LIKELY[1], LIKELY[0] / metres[unit], 1.0) for unit in _TRIED_UNITS}
    return min(excess, key=excess.get)  # the first of equals


def to_metres(points: np.ndarray, units: str, name: str, report: Report) -> np.ndarray:
    """Return points in metres, and report a guess.

    Parameters
    ----------
    points : (N, 3) float64, in ``units``
    units : {"m", "cm", "mm", "in", "auto"}
    """
    stated = name.lower().endswith(_STATED_UNIT)
    if stated and units not in ("m", "auto"):
        report(f'{name}: scaled by units="{units}" in addition to the unit that the file states, which was followed')
    if units == "auto" and stated:
        units = "m"
    elif units == "auto":
        extent = float(np.ptp(points, axis=0).max())
        units = likely_unit(extent)
        size = _rounded(extent * METRES[units])
        report(f"{name}: took its unit to be {units}, so it is {size} large; units= says otherwise")
    report_coarse(points, METRES[units], name, report)
    return points * METRES[units]


def report_coarse(points: np.ndarray, metre: float, name: str, report: Report) -> None:
    """Report coordinates (N, 3) of 32 bits so far from the origin that they lost shape; ``metre`` is their unit."""
    step = metre * step_of_float32(points)
    with np.errstate(over="ignore"):
        is_coarse = step > COARSE and (points == points.astype(np.float32)).all()
    if is_coarse:
        report(f"{name}: 32-bit coordinates this far from the origin are {step:.2g} m apart; subtract an offset first")


def _rounded(metres: float) -> str:
    return format_length(float(f"{metres:.3g}"))


def require_size(points: np.ndarray, name: str, report: Report) -> None:
    """Raise InputError for points (N, 3), metres, of impossible size; report an unlikely size."""
    with np.errstate(over="ignore"):
        extent = float(np.ptp(points, axis=0).max())
    if not MIN_EXTENT <= extent <= MAX_EXTENT:
        limits = f"between {_rounded(MIN_EXTENT)} and {_rounded(MAX_EXTENT)}"
        raise InputError(f"{name}: expected an object {limits} wide, got {stray_points(points, extent)}")
    if not ODD_EXTENTS[0] <= extent <= ODD_EXTENTS[1]:
        report(f"{name}: odd for a household object: {unit_question(extent)}")


def stray_points(points: np.ndarray, extent: float) -> str:
    """Return a description of an impossible size of points (N, 3), and whether stray points or the unit explain it."""
    low, high = np.quantile(points, [STRAY, 1 - STRAY], axis=0)
    most = float((high - low).max())
    if not MIN_EXTENT <= most <= extent / ALONE:
        return unit_question(extent)
    beside = ((points < low - (high - low)) | (points > high + (high - low))).any(axis=1)
    stray = "1 stray point" if beside.sum() == 1 else f"{int(beside.sum())} stray points"
    return f"{_rounded(most)} and {stray} that make it {_rounded(extent)}; drop what is stray first"


def unit_question(extent: float) -> str:
    """Return an unlikely size in metres as text, with the unit that would explain it, if one does.

    Examples
    --------
    >>> unit_question(300.0), unit_question(0.0003)
    ('300 m wide; in millimetres? units="mm"', '0.3 mm wide; is the unit right?')
    >>> unit_question(1e200)
    '1e+200 m wide, which no unit explains'
    """
    if extent == 0:
        return "all points at one place"
    tiny = extent < LIKELY[0]
    unit = "m" if tiny else likely_unit(extent)
    if not MIN_EXTENT <= (extent / METRES["mm"] if tiny else extent * METRES[unit]) <= MAX_EXTENT:
        return f"{_rounded(extent)} wide, which no unit explains"
    if unit == "m":  # which it was taken for, unless another was given
        return f"{_rounded(extent)} wide; is the unit right?"
    names = {"mm": "in millimetres?", "cm": "in centimetres?", "in": "in inches?"}
    return f'{_rounded(extent)} wide; {names[unit]} units="{unit}"'


def centroid(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the centroid (3,) of a surface, or of points if there are no faces."""
    if not len(faces):
        return vertices.mean(axis=0)
    corners = vertices[faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.average(corners.mean(axis=1), axis=0, weights=areas + 1e-300)


def standing_margin(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Return the distance of the centroid inside the support polygon, relative to the side of the footprint.

    The support polygon is the convex hull, seen from above, of the points that touch the ground.

    Parameters
    ----------
    vertices : (N, 3) float64, z up
    faces : (M, 3) int64; empty for a cloud

    Returns
    -------
    float
        Negative if the object would tip over; minus infinity if it touches the ground in a line or a point.
    """
    from scipy.spatial import ConvexHull, QhullError

    heights = vertices[:, 2] - vertices[:, 2].min()
    touching = vertices[heights <= _TOUCHING * np.ptp(vertices, axis=0).max(), :2]
    try:
        support, footprint = ConvexHull(touching), ConvexHull(vertices[:, :2])
    except (QhullError, ValueError):  # too few points, or all in a line
        return -np.inf
    outside = support.equations[:, :2] @ centroid(vertices, faces)[:2] + support.equations[:, 2]
    return float(-outside.max() / np.sqrt(footprint.volume))  # a polygon's "volume" is its area
