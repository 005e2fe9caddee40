"""What is taken for a wall: a plane that is filled, and not one that cuts across objects."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import level, sheet
from room_shapes import box, moved

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


def test_a_piece_in_a_walls_plane_is_of_the_wall_and_a_thing_before_it_is_not():
    long, piece = wall(-2.0, 2.0, 2.2), wall(1.2, 0.4, 0.5)
    chest = moved(box(0.5, 0.4, 0.5), 0.6, 1.15)
    labels = segment(np.vstack([long, piece, chest, level(4.0, 3.0, 0.0)[::4]]))
    ends = np.cumsum([len(long), len(piece), len(chest)])
    assert (labels[ends[0] : ends[1]] == WALL).mean() > 0.9
    assert (labels[ends[1] : ends[2]] == 0).mean() > 0.9


@pytest.mark.parametrize(("depth", "bottom", "is_wall"), [(0.5, 0.3, False), (0.2, 0.3, True), (0.5, 1.2, True)])
def test_a_low_thing_that_reaches_out_from_a_wall_is_furniture_and_not_hung_on_it(depth, bottom, is_wall):
    """An armchair's foot is hidden from cameras above it; a radiator is as low, and a wall cupboard reaches as far."""
    seat = moved(level(0.6, depth, bottom + 0.1), 0.0, 1.46 - depth / 2)
    front = sheet([-0.3, 1.46 - depth, bottom], [0.6, 0, 0], [0, 0, 0.1])
    item = np.vstack([seat, front])
    labels = segment(np.vstack([item, wall(-2.0, 4.0, 2.2), level(4.0, 3.0, 0.0)[::4]]))
    assert (labels[: len(item)] == WALL).mean() > 0.9 if is_wall else (labels[: len(item)] == 0).mean() > 0.9
