"""Gravity and floor of scans whose tilt is known."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import level as sheet_at
from clouds import sheet
from room_shapes import as_camera_sees, box, in_view, moved, room
from scipy.spatial.transform import Rotation

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.scans.gravity import axis_up
from spherefunc_bullet.scenes.scans.levelling import level


@pytest.fixture(scope="module")
def points() -> np.ndarray:
    return room()[0][::3]


def angle_deg(a, b) -> float:
    return float(np.degrees(np.arccos(np.clip(np.dot(a, b), -1, 1))))


def test_a_level_room_stays_as_it_is(points):
    levelling = level(points)
    assert levelling.source == "floor"
    assert angle_deg(levelling.up, [0, 0, 1]) < 0.2
    assert abs(levelling.height) < 0.005


@pytest.mark.parametrize("tilt_deg", [0, 20, 35, 50])
def test_a_tilted_camera_is_levelled(points, tilt_deg):
    seen = in_view(as_camera_sees(points, tilt_deg=tilt_deg))
    levelling = level(seen)
    assert angle_deg(levelling.up, as_camera_sees(np.array([[0.0, -3.2, 2.6]]), tilt_deg=tilt_deg)[0]) < 1.0
    # The camera is 1.6 m above the floor, and is the origin.
    assert levelling.height == pytest.approx(-1.6, abs=0.02)


def test_to_level_and_back(points):
    turned = Rotation.from_euler("xyz", [12, -8, 40], degrees=True).apply(points) + [1, 2, 3]
    levelling = level(turned)
    assert np.allclose(levelling.to_scan(levelling.to_level(turned)), turned)
    floor = room()[1][::3] == -1
    assert np.abs(levelling.to_level(turned)[floor, 2]).max() < 0.02


def test_a_scan_far_from_the_origin_is_levelled_as_near_it(points):
    """As in a map of a country, in metres from the equator."""
    turned = Rotation.from_euler("xyz", [12, -8, 40], degrees=True).apply(points)
    far = np.array([4e5, 5e6, 30.0])
    near, levelling = level(turned - np.median(turned, axis=0)), level(turned + far)
    assert np.allclose(levelling.T_level_scan[:3, :3], near.T_level_scan[:3, :3], atol=1e-6)
    assert np.ptp(levelling.to_level(turned + far), axis=0) == pytest.approx(np.ptp(near.to_level(turned), axis=0))
    assert levelling.to_level(turned + far)[room()[1][::3] == -1, 2] == pytest.approx(0, abs=0.02)
    assert np.allclose(levelling.to_scan(levelling.to_level(turned + far)), turned + far)


def test_the_floor_is_the_lowest_large_plane_not_the_largest():
    small_floor, large_top = sheet_at(1.2, 1.2, 0.0)[::2], moved(sheet_at(2.4, 1.2, 0.72), 0.9, 0.0)
    levelling = level(np.vstack([small_floor, large_top]))
    assert abs(levelling.height) < 0.01


def test_a_table_top_without_floor_serves_and_is_called_so():
    scene = np.vstack([sheet_at(0.9, 0.7, 0.0), moved(box(0.1, 0.1, 0.12), 0.1, 0.0)])
    assert level(scene).source == "table top"


def test_a_wall_alone_gives_no_floor():
    levelling = level(sheet([-1, 2, 0], [2, 0, 0], [0, 0, 2.0]))
    assert levelling.source == "assumed"
    assert not levelling.floor_seen
    assert angle_deg(levelling.up, [0, 0, 1]) < 1e-6


def test_given_up_is_kept(points):
    up = np.array([0.0, 0.1, 1.0]) / np.hypot(0.1, 1.0)
    assert np.allclose(level(points, "0,0.1,1").up, up) and np.allclose(level(points, [0, 0.1, 1]).up, up)
    assert np.allclose(level(points @ Rotation.from_euler("x", 90, degrees=True).as_matrix().T, "-y").up, [0, -1, 0])


@pytest.mark.parametrize("up", ["w", "0,0,0", "1,2", "nan,0,1", "", "--z", 3, None, [1, 2]])
def test_no_direction_is_refused(up):
    with pytest.raises(InputError, match="up="):
        axis_up(up)


def test_the_order_of_points_does_not_matter(points):
    shuffled = points[np.random.default_rng(0).permutation(len(points))]
    # The plane is fitted to means of cells, whose sums are exact; only their last bits may differ.
    assert np.allclose(level(points).T_level_scan, level(shuffled).T_level_scan, atol=1e-9)


def test_a_floor_that_curls_is_levelled_by_the_walls_too():
    # A sensor's far floor rises: 6 degrees over the strip that is seen, beside walls that are upright.
    strip = sheet([-0.6, 2.0, 0.0], [1.2, 0, 0], [0, 1.0, np.tan(np.radians(6.0))])
    walls = np.vstack([sheet([-2, 4, 0], [4, 0, 0], [0, 0, 2.2]), sheet([-2, 0.5, 0], [0, 3.5, 0], [0, 0, 2.2])])
    top = moved(sheet_at(1.4, 0.8, 0.72), 1.0, 2.6)
    # The plane through the strip alone is 6 degrees off.
    assert angle_deg(level(np.vstack([strip, walls, top])).up, [0, 0, 1]) < 1.5


def test_an_origin_on_the_floor_is_no_camera(points):
    ahead = points - [points[:, 0].mean(), points[:, 1].min() - 4.0, 0.0]
    assert level(ahead).source == "floor"
