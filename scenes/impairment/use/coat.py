"""A jacket that hangs over the back of a seat, close to it in front and behind."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..levels import LevelPart
from ..specimen import Specimen, box

COAT = (0.35, 0.03, 0.45)  # metres: width, thickness of each side, how far it hangs down
STRIP = 0.05  # metres of height of which a back has one thickness
THICKEST = 0.25  # metres of a back: what lies farther before its rear is an arm, or the seat


def coat_over_back(specimen: Specimen, seat: LevelPart, rng: np.random.Generator) -> np.ndarray:
    """Return the triangles (K, 3, 3) of a jacket that hangs over the middle of a seat's back."""
    wide, thick, down = np.array(COAT) * rng.uniform(0.8, 1.3, 3)
    toward, points = specimen.back, specimen.cloud.points
    across = np.abs(toward[::-1])
    above = points[points[:, 2] > seat.upper + 0.15]
    middle = np.median(above[:, :2] @ across)
    covered = np.abs(above[:, :2] @ across - middle) < wide / 2
    below_coat = above[covered] if covered.any() else above
    back = np.column_stack([below_coat[:, :2] @ toward, below_coat[:, 2]])
    hanging = list(strips(back, max(below_coat[:, 2].max() - down, seat.height + 0.03)))
    _, top, front, rear = hanging[0]
    parts = [(front - thick, rear + thick, top, top + thick)]
    for lower, upper, front, rear in hanging:
        parts += [(front - thick, front, lower, upper), (rear, rear + thick, lower, upper)]
    sides = middle - wide / 2, middle + wide / 2
    return np.concatenate([slab(toward, across, part, sides) for part in parts])


def strips(back: np.ndarray, lowest: float) -> Iterator[tuple[float, float, float, float]]:
    """Yield the strips of a back from its top down: lower and upper height, and where its front and its rear are.

    Where a strip has nothing, as between slats, the coat goes on as it hung above.

    Parameters
    ----------
    back : (N, 2) float
        Distance towards the back, and height, metres.
    """
    upper = back[:, 1].max()
    while upper > lowest:
        lower = max(upper - STRIP, lowest)
        row = back[(back[:, 1] >= lower) & (back[:, 1] <= upper), 0]
        if len(row):
            rear = row.max()
            front = row[row > rear - THICKEST].min()
        yield lower, upper, front, rear
        upper = lower


def slab(
    toward: np.ndarray, across: np.ndarray, part: tuple[float, float, float, float], sides: tuple[float, float]
) -> np.ndarray:
    """Return a box's triangles, given where it begins and ends: towards the back, in height, and to the sides."""
    front, rear, lower, upper = part
    corners = np.array([[*(front * toward + sides[0] * across), lower], [*(rear * toward + sides[1] * across), upper]])
    return box(corners.min(axis=0), corners.max(axis=0))
