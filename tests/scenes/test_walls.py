"""What is taken for a wall: a plane that is filled, and not one that cuts across objects."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import level, sheet

from spherefunc_bullet.scenes.segmentation.segmentation import WALL, segment
from spherefunc_bullet.scenes.segmentation.walls import filled_share


def test_a_wall_is_filled_and_a_cut_across_a_room_is_not():
    along, heights = (grid.ravel() for grid in np.meshgrid(np.arange(0, 3, 0.02), np.arange(0, 2, 0.02)))
    assert filled_share(along, heights, 3.0, 2.0) == pytest.approx(1.0)
    door = (along > 1) & (along < 2) & (heights < 1.8)
    # The door's edges lie on the squares', so that a row of 10 and a column of 18 of the 600 may hold points of it.
    assert filled_share(along[~door], heights[~door], 3.0, 2.0) == pytest.approx(1 - 1.8 / 6, abs=0.05)
    cut = (along < 0.8) | (heights > 1.95)  # a wardrobe's side, and the ceiling's edge
    assert filled_share(along[cut], heights[cut], 3.0, 2.0) < 0.35


def wall(x: float, width: float, height: float) -> np.ndarray:
    """Return a stretch of the wall at y = 1.5 (N, 3), from x on."""
    return sheet([x, 1.5, 0.0], [width, 0, 0], [0, 0, height])[::2]


@pytest.mark.parametrize(("height", "is_wall"), [(0.95, True), (0.6, False)])
def test_cameras_that_look_down_see_low_stretches_of_wall(height, is_wall):
    seen = wall(-1.0, 1.8, height)
    labels = segment(np.vstack([seen, level(4.0, 3.0, 0.0)[::4]]))
    assert (labels[: len(seen)] == WALL).mean() > 0.9 if is_wall else (labels[: len(seen)] >= 0).mean() > 0.9
