"""Drops as rows: where each sphere was dropped, and where it came to rest if it did.

What falls through is evidence too: a hole in the bottom, a missing seat and a slope let spheres go.
"""

from __future__ import annotations

import numpy as np

from ..simulator import DropResult, Outcome

WIDTH = 5  # numbers of a drop: x and y of its column; x, y and z of the centre at rest, NaN where it did not settle


def drop_array(result: DropResult) -> np.ndarray:
    """Return every drop of a run (D, 5) float32, metres, in the order in which they ended."""
    settled = result.outcomes == Outcome.SETTLED
    centers = np.full((len(settled), 3), np.nan)
    centers[settled] = result.centers
    return np.hstack([result.columns, centers]).astype(np.float32)


def settled_centers(drops: np.ndarray) -> np.ndarray:
    """Return the centres (S, 3) of the drops (D, 5) that settled, metres; settled centres pass through."""
    return drops[settled_rows(drops), 2:] if drops.shape[1] == WIDTH else drops


def settled_rows(drops: np.ndarray) -> np.ndarray:
    """Return which drops (D, 5) settled, (D,) bool."""
    return ~np.isnan(drops[:, 4])


def as_drops(centers: np.ndarray) -> np.ndarray:
    """Return centres (S, 3), metres, as drops (S, 5) that settled where they were dropped; drops pass through."""
    return centers if centers.shape[1] == WIDTH else np.hstack([centers[:, :2], centers])
