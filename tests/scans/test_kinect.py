"""The virtual Kinect, on planes whose images are known by thought."""

from __future__ import annotations

import numpy as np
import pytest

from spherefunc_bullet.clouds.cloud import Mesh
from spherefunc_bullet.scenes.virtual_rooms.kinect import (
    NOTHING,
    Kinect,
    Surfaces,
    depth_noise,
    look_at,
    photograph,
)

IDEAL = Kinect(noise=0.0, dropouts=False)
SQUARE = np.array([[0, 1, 2], [1, 3, 2]])


def upright(distance: float, half: float = 10.0, angle_deg: float = 0.0) -> Mesh:
    """Return a square at y = distance before a camera that looks along y, turned about z."""
    x, z = np.meshgrid([-half, half], [-half, half], indexing="ij")
    turn = np.radians(angle_deg)
    corners = np.column_stack([x.ravel() * np.cos(turn), x.ravel() * np.sin(turn) + distance, z.ravel()])
    return Mesh(corners, SQUARE)


def image(kinect: Kinect, *meshes: Mesh):
    surfaces = Surfaces(list(enumerate(meshes)))
    return photograph(surfaces, look_at([0, 0, 0], [0, 1, 0]), kinect, np.random.default_rng(0))


def test_a_wall_across_has_one_depth():
    seen = image(IDEAL, upright(2.0))
    assert np.allclose(seen.depth, 2.0, atol=1e-5)  # rays are cast in float32
    points, labels = seen.points()
    assert np.allclose(points[:, 1], 2.0, atol=1e-5) and (labels == 0).all()


def test_field_of_view_and_axes():
    points, _ = image(IDEAL, upright(2.0)).points()
    edge = 2.0 * np.tan(np.radians(57 / 2))
    pixel = 2 * edge / 640
    assert points[:, 0].min() == pytest.approx(-edge + pixel / 2, abs=1e-4)
    assert points[:, 2].max() == pytest.approx(0.75 * edge - pixel / 2, abs=1e-4)  # 480 of 640
    rows = points.reshape(480, 640, 3)
    assert rows[0, 0, 0] < 0 < rows[0, 0, 2]  # the first pixel is left above


def test_what_is_too_near_or_too_far_is_not_measured():
    assert np.isnan(image(IDEAL, upright(0.4)).depth).all()
    assert np.isnan(image(IDEAL, upright(5.1)).depth).all()
    nothing = image(IDEAL, upright(-1.0))
    assert np.isnan(nothing.depth).all() and (nothing.labels == NOTHING).all()


@pytest.mark.parametrize("distance", [1.0, 3.0, 4.5])
def test_noise_grows_with_the_square_of_the_distance(distance):
    seen = image(Kinect(dropouts=False), upright(distance))
    # 300,000 samples: the deviation is known to 0.13 %; five times that.
    assert np.nanstd(seen.depth) == pytest.approx(depth_noise(distance), rel=0.007)
    assert np.nanmean(seen.depth) == pytest.approx(distance, abs=1e-3)


def test_noise_is_the_sensors_own():
    assert depth_noise(1.0) == pytest.approx(0.002, abs=2e-4)
    assert depth_noise(5.0) == pytest.approx(0.04, abs=2e-3)


def test_nothing_is_lost_on_a_wall_across():
    assert np.isfinite(image(Kinect(noise=0.0), upright(2.0)).depth).all()


def test_grazing_surfaces_are_lost():
    seen = image(Kinect(noise=0.0), upright(2.0, angle_deg=77.5))
    column = seen.depth[:, 320]  # here the angle to the normal is the turn: midway between none and all
    # 480 pixels, half of them lost: the share is known to 2.3 % (one deviation).
    assert np.isnan(column).mean() == pytest.approx(0.5, abs=0.1)


def test_a_box_casts_the_projectors_shadow_and_keeps_its_middle():
    seen = image(Kinect(noise=0.0), upright(1.0, half=0.1), upright(2.0))
    lost = np.isnan(seen.depth)
    front = seen.labels == 0
    rows, columns = np.nonzero(front)
    inner = lost[rows.min() + 2 : rows.max() - 1, columns.min() + 2 : columns.max() - 1]
    assert not inner.any()
    # The projector is on the right, so the shadow is left of the box: f * b * (1/1 - 1/2) pixels wide.
    width = Kinect().focal_length * 0.075 * (1 / 1.0 - 1 / 2.0)
    row = (rows.min() + rows.max()) // 2
    shadow = np.flatnonzero(lost[row, : columns.min()])
    assert len(shadow) == pytest.approx(width, abs=2)
    assert columns.min() - shadow.min() == pytest.approx(width, abs=2)
    assert lost[row, columns.max() + 3 :].sum() == 0


def test_the_target_is_in_the_middle_and_the_camera_level():
    T_room_camera = look_at([1.0, 2.0, 1.5], [3.0, 1.0, 0.5])
    rotation = T_room_camera[:3, :3]
    assert np.allclose(rotation.T @ rotation, np.eye(3)) and np.linalg.det(rotation) == pytest.approx(1)
    assert rotation[2, 0] == pytest.approx(0)  # the image's rows are level
    assert rotation[2, 1] < 0  # and its columns point down
    in_camera = rotation.T @ (np.array([3.0, 1.0, 0.5]) - [1.0, 2.0, 1.5])
    assert np.allclose(in_camera, [0, 0, np.sqrt(6)])


def test_same_seed_same_image():
    first, second = (image(Kinect(), upright(3.0, angle_deg=60)).depth for _ in range(2))
    assert np.array_equal(first, second, equal_nan=True)


def test_windows_share_their_noise_between_neighbours():
    seen = image(Kinect(dropouts=False, window=7), upright(1.0))
    apart = seen.depth - 1.0
    # Of independent noise neighbours have nothing in common; a window of 7 shares most of it, and 20 pixels on none.
    assert np.corrcoef(apart[:, :-1].ravel(), apart[:, 1:].ravel())[0, 1] > 0.7
    assert abs(np.corrcoef(apart[:, :-20].ravel(), apart[:, 20:].ravel())[0, 1]) < 0.1
    assert apart.std() == pytest.approx(depth_noise(1.0), rel=0.15)  # steps of 3 mm add to it


@pytest.mark.parametrize(("distance", "step"), [(1.0, 0.0028), (3.0, 0.0255)])
def test_windows_measure_in_steps_of_disparity(distance, step):
    depths = np.unique(image(Kinect(dropouts=False, window=7), upright(distance)).depth)
    # z^2 / (f b) / 8, by the Kinect's 589 pixels and 7.5 cm; noise spreads depth over a few of them.
    assert np.diff(depths).min() == pytest.approx(step, rel=0.1)
    assert len(depths) < 30


def test_windows_close_what_is_narrower_than_half_of_them():
    width = 1.0 / Kinect().focal_length  # metres of a pixel at 1 m
    left, right = (Mesh(upright(1.0).vertices + [side * (10 + 1.4 * width), 0, 0], SQUARE) for side in (-1, 1))
    sharp, smooth = (
        image(Kinect(noise=0.0, dropouts=False, window=window), left, right, upright(1.2)).depth for window in (1, 7)
    )
    assert (np.abs(sharp - 1.2) < 0.01).sum() >= 480  # the gap of about three pixels
    assert (np.abs(smooth - 1.0) < 0.01).all()


def test_blur_fills_hollows_and_spares_far_edges():
    groove, far = 0.04, 0.5  # metres behind the front: what filters even out, and what they keep apart
    width = 6.0 / Kinect().focal_length  # metres of six pixels at 1 m
    left, right = (Mesh(upright(1.0).vertices + [side * (10 + width / 2), 0, 0], SQUARE) for side in (-1, 1))
    for behind, moved in ((groove, True), (far, False)):
        sharp, smooth = (
            image(Kinect(noise=0.0, dropouts=False, blur=blur), left, right, upright(1.0 + behind)).depth
            for blur in (0.0, 3.0)
        )
        deepest = np.nanmax(sharp, axis=1)
        assert np.allclose(deepest, 1.0 + behind, atol=1e-4)
        assert (np.nanmax(smooth, axis=1) < 1.0 + 0.8 * behind).all() == moved  # 0.68 of it within one deviation
        assert np.allclose(smooth[:, 100], 1.0, atol=1e-4)  # the front, away from the groove
