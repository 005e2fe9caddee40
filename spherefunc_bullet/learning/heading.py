"""Which way an object faces: the paper does not say how its models were turned about the vertical."""

from __future__ import annotations

import numpy as np

from ..errors import InputError

HEADINGS = ("as_given", "long_side", "front")


def turned(centers: np.ndarray, heading: str) -> np.ndarray:
    """Return settled centres (S, 3) turned about z by a multiple of 90 degrees.

    ``as_given`` leaves them. ``long_side`` lays the longer side of their footprint along x. ``front`` does so
    too, where one side is a quarter longer, and then puts the higher spheres (against a back) to +y, so that
    all seats face the same way.
    """
    if heading not in HEADINGS:
        raise InputError(f"heading: expected one of {', '.join(HEADINGS)}, got {heading!r}")
    if heading == "as_given" or len(centers) == 0:
        return centers
    width, depth = np.ptp(centers[:, :2], axis=0)
    if heading == "long_side":
        return quarter_turns(centers, 1) if depth > width else centers
    return _front_first(centers, width, depth)


def quarter_turns(centers: np.ndarray, turns: int) -> np.ndarray:
    """Return centres (S, 3) turned counterclockwise about z, exactly."""
    x, y, z = centers.T
    turned_xy = [(x, y), (-y, x), (-x, -y), (y, -x)][turns % 4]
    return np.column_stack([*turned_xy, z])


def _front_first(centers: np.ndarray, width: float, depth: float) -> np.ndarray:
    # How height goes along with x and y: towards the back it rises.
    along_x, along_y = (centers[:, 2] - centers[:, 2].mean()) @ centers[:, :2]
    if max(width, depth) > 1.25 * min(width, depth):
        across = depth > width
    else:
        across = abs(along_x) > abs(along_y)
    # Turned once counterclockwise, what rose along +x rises along +y.
    rise = along_x if across else along_y
    return quarter_turns(centers, (1 if across else 0) + (2 if rise < 0 else 0))
