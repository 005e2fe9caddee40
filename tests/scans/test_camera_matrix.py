"""A single depth image takes the camera of its folder, as the folder does."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.commands.scene import read_scan
from spherefunc_bullet.scenes.recognition.objects import scan_or_image

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


def test_colours_are_a_file_or_an_array(tmp_path):
    depth, colors = np.ones((240, 320)), np.random.default_rng(0).integers(0, 255, (240, 320, 3), np.uint8)
    Image.fromarray(colors).save(tmp_path / "color.png")
    scans = [scan_or_image(depth, "auto", K, color) for color in (colors, tmp_path / "color.png")]
    assert np.array_equal(scans[0].colors, colors.reshape(-1, 3)) and np.array_equal(scans[1].colors, scans[0].colors)


@pytest.mark.parametrize(
    ("given", "line"),
    [
        ({"units": "mm"}, "units='mm': expected with points or a mesh, got a depth image"),
        ({"color": np.zeros((240, 320))}, r"color: expected a path or \(H, W, 3\) uint8, got \(240, 320\) float64"),
        ({"color": np.zeros((24, 32, 3), np.uint8)}, "color: expected a colour image of 320 x 240 as the depth"),
    ],
)
def test_what_an_image_cannot_take_is_refused(given, line):
    whole = scan_or_image(np.ones((240, 320)), "m", K)
    assert scan_or_image(whole, "m") is whole
    with pytest.raises(InputError, match="^units='mm': expected with points or a mesh"):
        scan_or_image(whole, "mm")
    with pytest.raises(InputError, match=f"^{line}"):
        scan_or_image(np.ones((240, 320)), given.get("units", "auto"), K, given.get("color"))
