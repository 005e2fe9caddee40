"""What is taken for a wall: a plane that is filled, and not one that cuts across things."""

from __future__ import annotations

import numpy as np
import pytest

from scenes.walls import filled


def test_a_wall_is_filled_and_a_cut_across_a_room_is_not():
    along, heights = (each.ravel() for each in np.meshgrid(np.arange(0, 3, 0.02), np.arange(0, 2, 0.02)))
    assert filled(along, heights, 3.0, 2.0) == pytest.approx(1.0)
    door = (along > 1) & (along < 2) & (heights < 1.8)
    # The door's edges lie on the squares', so that a row of 10 and a column of 18 of the 600 may hold points of it.
    assert filled(along[~door], heights[~door], 3.0, 2.0) == pytest.approx(1 - 1.8 / 6, abs=0.05)
    cut = (along < 0.8) | (heights > 1.95)  # a wardrobe's side, and the ceiling's edge
    assert filled(along[cut], heights[cut], 3.0, 2.0) < 0.35
