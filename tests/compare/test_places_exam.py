"""The exam of places says in one line which file it cannot use, and why."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from spherefunc_bullet.clouds.cloud import cloud_from_mesh
from spherefunc_bullet.compare.places.__main__ import headings_by_hand
from spherefunc_bullet.compare.places.putting import OwnWorld, StayCounts
from spherefunc_bullet.errors import InputError


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "expected a CSV file in UTF-8"),
        ("", "expected the columns file and heading_deg, separated by commas, got no columns"),
        ("file,heading\na.ply,1\n", "got file, heading"),
        ("file,heading_deg\na.ply,north\n", "expected degrees or nothing"),
    ],
)
def test_what_is_no_table_of_headings_is_named(tmp_path, text, said):
    file = tmp_path / "headings.csv"
    if text is not None:
        file.write_text(text)
    with pytest.raises(InputError, match=said) as error:
        headings_by_hand(file)
    assert str(file) in str(error.value)


def test_its_own_world_prints_nothing_that_would_break_json(capfd):
    pytest.importorskip("pybullet")
    box = trimesh.creation.box((0.2, 0.2, 0.1))
    cloud = cloud_from_mesh(box.vertices, box.faces, "box")
    world, pose = OwnWorld(cloud), np.eye(4)
    pose[2, 3] = cloud.bounds[1, 2] - cloud.bounds[0, 2] + 0.001
    assert world.stayed(cloud, [pose]) == StayCounts(asked=1, stayed=1, touched=0)
    world.close()
    assert capfd.readouterr().out == ""


def test_headings_are_read(tmp_path):
    file = tmp_path / "headings.csv"
    file.write_text("file,heading_deg\na.ply,90\nb.ply,\n")
    assert headings_by_hand(file) == {"a.ply": 90.0, "b.ply": None}
