"""What is taken for a wall: a plane that is filled, and not one that cuts across objects."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import level, sheet

from spherefunc_bullet.scenes.segmentation.segmentation import WALL, segment


def wall(x: float, width: float, height: float) -> np.ndarray:
    """Return a stretch of the wall at y = 1.5 (N, 3), from x on."""
    return sheet([x, 1.5, 0.0], [width, 0, 0], [0, 0, height])[::2]


@pytest.mark.parametrize(("height", "is_wall"), [(0.95, True), (0.6, False)])
def test_cameras_that_look_down_see_low_stretches_of_wall(height, is_wall):
    seen = wall(-1.0, 1.8, height)
    labels = segment(np.vstack([seen, level(4.0, 3.0, 0.0)[::4]]))
    assert (labels[: len(seen)] == WALL).mean() > 0.9 if is_wall else (labels[: len(seen)] >= 0).mean() > 0.9
