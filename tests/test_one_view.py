"""A cloud that is one view of an object: completed, and told by the model for scans, as in a scene."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from clouds import mug
from room_shapes import box, square_table

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.learning.reasons.one_view import COMPLETED, NOTHING, looks_like_one_view, nothing_settled


@pytest.fixture(scope="module")
def seen_mug() -> np.ndarray:
    """A mug's wall as a camera in front of it and above sees it: outside nearer, inside farther, no bottom."""
    points = mug().points
    wall = points[points[:, 2] > 0.012]
    radius = np.linalg.norm(wall[:, :2], axis=1)
    return wall[(radius > 0.9 * radius.max()) & ((wall[:, 1] < 0) | (wall[:, 2] > 0.03))]


def test_a_mug_s_view_is_told_as_in_a_scene_and_unsure(seen_mug):
    answer = sf.classify(seen_mug)
    assert answer.functions == {"cup"}
    assert answer.unsure
    assert answer.reasons[-1] == COMPLETED


def test_hardly_a_sphere_is_as_good_as_none():
    lost, held = np.full((200, 6), np.nan, np.float32), np.zeros((200, 6), np.float32)
    few = np.vstack([lost[:197], held[:3]])
    assert nothing_settled({0.01: lost, 0.03: few})
    assert not nothing_settled({0.01: lost, 0.03: held})


def test_whole_objects_are_told_as_before():
    for points in (mug().points, box(0.3, 0.3, 0.3), square_table(1.2, 0.8, 0.72)[::4]):
        reasons = sf.classify(points).reasons
        assert COMPLETED not in reasons and NOTHING not in reasons


def test_what_has_an_underside_is_no_view(seen_mug):
    assert looks_like_one_view(Cloud(seen_mug))
    assert not looks_like_one_view(Cloud(mug().points))


def test_the_command_says_the_same(seen_mug, tmp_path):
    np.savetxt(tmp_path / "view.xyz", seen_mug)
    call = [Path(sys.executable).with_name("spherefunc"), "classify", tmp_path / "view.xyz", "--json"]
    (row,) = json.loads(subprocess.run(call, capture_output=True, text=True, check=True).stdout)
    assert row["functions"]["cup"]["member"]
    assert row["unsure"]
    assert row["reasons"][-1] == COMPLETED
