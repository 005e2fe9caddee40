"""A single depth image takes the camera of its folder, as the folder does."""

from __future__ import annotations

import json

import numpy as np
import pytest

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.commands.scene import read_scan

K = [[260.0, 0, 150.0], [0, 250.0, 130.0], [0, 0, 1]]


@pytest.fixture
def image(tmp_path):
    """Return an image of a slope, in metres."""
    np.save(tmp_path / "depth.npy", np.linspace(1, 2, 240)[:, None] * np.ones(320))
    return tmp_path / "depth.npy"


def test_a_matrix_is_the_same_camera_as_open3d_s_file(image, tmp_path):
    np.savetxt(tmp_path / "camera-intrinsics.txt", K)
    about = {"width": 320, "height": 240, "intrinsic_matrix": np.transpose(K).ravel().tolist()}
    (tmp_path / "camera.json").write_text(json.dumps(about))
    scans = [read_scan(image, "auto", tmp_path / name, None, None) for name in ("camera-intrinsics.txt", "camera.json")]
    assert np.array_equal(scans[0].points, scans[1].points)


def test_a_file_that_is_no_camera_is_told_both_formats(image, tmp_path):
    (tmp_path / "camera.txt").write_text("focal length 500")
    with pytest.raises(InputError, match=r"^camera.txt: expected a camera's JSON, .* 3 x 3 numbers, found 3 words"):
        read_scan(image, "auto", tmp_path / "camera.txt", None, None)
