"""Axes and units: from a file's own to metres with z up."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .errors import InputError
from .lengths import METRES, format_length

Report = Callable[[str], None]

_AXES = {"z": ((0, 1, 2), (1, 1, 1)), "y": ((0, 2, 1), (1, -1, 1)), "x": ((1, 2, 0), (1, 1, 1))}
UPS = (*_AXES, "auto")
UNITS = (*METRES, "auto")
Y_UP_ENDINGS = (".glb", ".gltf")  # by the glTF standard

_LIKELY = (0.05, 3.0)  # metres, the largest extent of most household objects
_TRIED = ("m", "mm", "cm", "in")


def turned_up(points: np.ndarray, up: str) -> np.ndarray:
    """Return points turned, not mirrored, so that the axis ``up`` becomes z.

    Parameters
    ----------
    points : (N, 3) float64
    up : {"z", "y", "x"}

    Examples
    --------
    >>> turned_up(np.array([[1.0, 2.0, 3.0]]), "y")
    array([[ 1., -3.,  2.]])
    """
    order, sign = _AXES[up]
    return points[:, order] * np.array(sign, dtype=np.float64)


def likely_unit(extent: float) -> str:
    """Return the unit in which the largest extent is that of a household object.

    Metres win if they are plausible (5 cm to 3 m); then mm, cm, in; then whatever comes nearest.

    Examples
    --------
    >>> likely_unit(0.9), likely_unit(900), likely_unit(36)
    ('m', 'mm', 'cm')
    """
    low, high = _LIKELY
    ratio = {unit: max(extent * METRES[unit] / high, low / max(extent * METRES[unit], 1e-300)) for unit in _TRIED}
    return next((unit for unit in _TRIED if ratio[unit] <= 1), min(ratio, key=ratio.get))


def require_choice(option: str, value: str, choices: tuple[str, ...]) -> None:
    """Raise InputError unless an option's value is one of its choices."""
    if value not in choices:
        raise InputError(f"{option} {value!r}: expected one of {', '.join(choices)}")


def to_metres(points: np.ndarray, units: str, name: str, report: Report) -> np.ndarray:
    """Return points in metres; ``auto`` guesses the unit and reports the guess."""
    extent = float(np.ptp(points, axis=0).max())
    if units == "auto":
        units = likely_unit(extent)
        size = format_length(round(extent * METRES[units], 4))
        report(f"{name}: took the unit to be {units}, which makes it {size} large; --units says otherwise")
    return points * METRES[units]
