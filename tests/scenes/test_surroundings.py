"""What surrounds a part of a scene: over it, under it, behind it and beyond its edge."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import level, mug, sheet
from room_shapes import box, moved, square_table

from spherefunc_bullet.scenes.recognition.surroundings import NAMES, ScanSurroundings, surroundings_alone
from spherefunc_bullet.scenes.segmentation.clusters import bounding_box

STOOL = square_table(0.4, 0.4, 0.45)
BACK = sheet([-0.2, 0.2, 0.45], [0.4, 0, 0], [0, 0, 0.45])
FLOOR = level(3.0, 3.0, 0.0)
NO_WALL = np.empty((0, 3))


def described(
    own: np.ndarray, *others: np.ndarray, wall: np.ndarray = NO_WALL, support: float = 0.0
) -> dict[str, float]:
    """Return what surrounds some points where others are, by name."""
    points = np.vstack([own, *others, wall])
    is_wall = np.arange(len(points)) >= len(points) - len(wall)
    scene = ScanSurroundings(points=points, is_wall=is_wall)
    return dict(zip(NAMES, scene.of(own, bounding_box(own).size, support).tolist(), strict=True))


def test_a_stool_alone_has_a_level_on_legs_and_nothing_around_it():
    stool = described(STOOL)
    assert stool["level"] == pytest.approx(0.45, abs=0.01)
    assert stool["level_area"] == pytest.approx(0.16, rel=0.15)  # a square of 2 cm along each edge, more or less
    assert stool["hollow_below"] > 0.8  # but for the legs
    assert stool["backed"] == 0 and stool["unseen_near"] == 1 and stool["from_wall"] == 1
    assert not any(stool[name] for name in ("carries", "covered", "goes_on", "beside", "walled_far", "ground_near"))
    assert list(stool.values()) == surroundings_alone(STOOL, bounding_box(STOOL).size).tolist()


def test_a_carton_is_closed_below_and_a_stool_is_not():
    carton = described(box(0.4, 0.4, 0.45))
    assert carton["closed_below"] > 0.9 and carton["hollow_below"] < 0.9
    assert described(STOOL)["closed_below"] < 0.4


def test_a_back_rises_on_one_side():
    chair = described(np.vstack([STOOL, BACK]))
    assert 0.15 < chair["backed"] < 0.5 and chair["backed_aside"] > 0.8
    assert chair["over_level"] == pytest.approx(0.45, abs=0.03)


def test_what_stands_on_a_table_is_carried_and_what_it_covers_is_covered():
    table = square_table(1.2, 0.8, 0.72)
    assert described(table, moved(mug().points, 0.2, 0.1, 0.72))["carries"] > 0
    assert described(table, FLOOR)["carries"] == 0
    assert described(STOOL, table)["covered"] > 0.9


def test_a_piece_of_a_shelf_goes_on_and_a_whole_one_does_not():
    piece, rest = level(0.4, 0.3, 0.5), moved(level(0.8, 0.3, 0.5), 0.6, 0.0)
    assert described(piece, rest)["goes_on"] > 0.1
    assert described(piece, FLOOR)["goes_on"] == 0


def test_a_wall_behind_and_the_ground_in_front_are_seen():
    wall = sheet([-1.5, 0.3, 0.0], [3, 0, 0], [0, 0, 2.0])
    stool = described(STOOL, FLOOR[FLOOR[:, 1] < -0.25], wall=wall)
    assert 0.1 < stool["walled_near"] < 0.5 and stool["walled_near"] <= stool["walled_far"]
    assert stool["from_wall"] == pytest.approx(0.1, abs=0.05)
    assert 0.1 < stool["ground_near"] < 0.8 and stool["unseen_near"] < 0.9
    assert stool["highest_far"] > 1.0


def test_turning_and_moving_a_scene_changes_little():
    chair, wall = np.vstack([STOOL, BACK]), sheet([-1.5, 0.35, 0.0], [3, 0, 0], [0, 0, 2.0])
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    here = described(chair, FLOOR, wall=wall)
    there = described(
        chair @ turn.T + [1.3, -0.7, 0], FLOOR @ turn.T + [1.3, -0.7, 0], wall=wall @ turn.T + [1.3, -0.7, 0]
    )
    for name, value in here.items():
        assert there[name] == pytest.approx(value, abs=0.09, rel=0.1), name  # two directions of 24, or a square's width


def test_a_lower_ground_raises_the_level():
    assert described(STOOL, support=-0.2)["level"] == pytest.approx(0.65, abs=0.01)
