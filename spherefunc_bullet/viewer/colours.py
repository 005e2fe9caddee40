"""Colours by height, for spheres on pictures and pages."""

from __future__ import annotations

import numpy as np

# Viridis, thinned: even in lightness, and readable without colour vision.
HEIGHT_COLOURS = (
    np.array([[68, 1, 84], [65, 68, 135], [42, 120, 142], [34, 168, 132], [122, 209, 81], [253, 231, 37]], float) / 255
)
FLAT = 12  # radii: a thinner layer gets only a part of the colours


def sphere_colours(heights: np.ndarray, least_span: float = 1e-9) -> np.ndarray:
    """Return colours (S, 3) in 0..1, dark to bright from the lowest height (S,) to the highest, metres.

    Heights that differ by less than ``least_span`` take only a part of the colours.
    """
    span = max(np.ptp(heights), least_span)
    at = (heights - heights.min()) / span * (len(HEIGHT_COLOURS) - 1)
    return np.stack([np.interp(at, range(len(HEIGHT_COLOURS)), channel) for channel in HEIGHT_COLOURS.T], axis=1)
