"""The paper's own way with a scene: floor by RANSAC, clusters as they are, whole models."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from clouds import level as sheet_at
from clouds import mug
from room_shapes import box, moved, room, square_table
from scipy.spatial.transform import Rotation

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.cube_classifier import CubeClassifier
from spherefunc_bullet.scenes.commands.scene import require_method
from spherefunc_bullet.scenes.recognition.examples import recognise_as_paper
from spherefunc_bullet.scenes.scans.levelling import level_by_ransac
from spherefunc_bullet.scenes.scans.scan import scan_from_points


@pytest.fixture(scope="module")
def model() -> CubeClassifier:
    """A classifier by the paper's method that knows a few mugs, tables and boxes."""
    clouds = [Cloud(mug().points * scale, "mug") for scale in (0.9, 1.0, 1.1)]
    clouds += [Cloud(square_table(width, 0.7, 0.72)[::6], "table") for width in (0.9, 1.1, 1.3)]
    clouds += [Cloud(box(0.3, depth, 0.4)[::6], "box") for depth in (0.3, 0.4, 0.5)]
    labels = [{"cup"}] * 3 + [{"table"}] * 3 + [set()] * 3
    return CubeClassifier("fast", method="paper", radii=(0.01, 0.03), cache=False).fit(clouds, labels)


def test_the_plane_of_most_points_is_the_floor_in_any_frame():
    points = np.vstack([sheet_at(3.0, 3.0, 0.0)[::4], moved(square_table(1.0, 0.8, 0.7), 0.3, 0.2)[::4]])
    turn = Rotation.from_euler("xyz", [14, -9, 30], degrees=True)
    seen = turn.apply(points) + [0.5, 1.0, -0.3]
    levelling = level_by_ransac(seen)
    assert np.degrees(np.arccos(levelling.up @ turn.apply([0, 0, 1]))) < 0.5
    assert np.percentile(levelling.to_level(seen)[:, 2], 5) == pytest.approx(0, abs=0.01)


def test_ransac_takes_a_wall_for_the_floor_where_it_is_larger():
    # As the paper's way does; the default does not (test_levelling).
    wall = np.column_stack([sheet_at(3.0, 3.0, 0.0)[::4][:, [0, 2, 1]]])
    levelling = level_by_ransac(np.vstack([wall, sheet_at(1.0, 1.0, 0.0)[::4]]))
    assert abs(levelling.up[2]) < 0.1


@pytest.mark.slow
def test_clusters_stand_on_their_own_lowest_point_and_walls_are_clusters(model):
    found = recognise_as_paper(scan_from_points(room()[0][::2], "room"), model)
    assert {item.proposed_by for item in found.objects} == {"clusters"}
    assert all(item.support == pytest.approx(item.points[:, 2].min()) for item in found.objects)
    # The walls touch one another, and table and mug: nothing parts them.
    assert max(len(item.points) for item in found.objects) > 0.1 * len(room()[0][::2])
    assert set(found.stages) >= {"floor", "clusters", "spheres"}


def test_a_table_alone_on_a_floor_is_told_by_whole_models(model):
    points = np.vstack([sheet_at(3.0, 3.0, 0.0)[::4], square_table(1.1, 0.7, 0.72)[::2]])
    found = recognise_as_paper(scan_from_points(points, "table"), model)
    assert [item.members for item in found.objects] == [{"table"}]


@pytest.mark.parametrize("method", ["paper", "papers"])
def test_the_command_wants_a_model_of_the_method(method):
    with pytest.raises(InputError, match="--method"):
        require_method(method, None, {})


def test_the_paper_completes_and_proposes_nothing():
    with pytest.raises(InputError, match="--complete: expected without --method paper"):
        require_method("paper", Path("paper.npz"), {"--complete": "none", "--proposals": None})
