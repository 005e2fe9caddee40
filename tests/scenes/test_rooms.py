"""From scans to labelled boxes: reading, completion, boxes, recognition, and `spherefunc scene`."""

from __future__ import annotations

import json

import numpy as np
import pytest
from clouds import level, mug, sheet
from commands import spherefunc
from PIL import Image
from room_shapes import NAMES, as_camera_sees, in_view, moved, room, square_table

import spherefunc_bullet as sf
from spherefunc_bullet.compare.rooms.truth import box_overlap
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.ply import ply_bytes
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.scenes.recognition.completion import DEFAULT, complete, steps_of
from spherefunc_bullet.scenes.recognition.judging import object_cloud
from spherefunc_bullet.scenes.recognition.recognition import recognise
from spherefunc_bullet.scenes.scans.depth_image import is_image_file, kinect_like, load_depth_image
from spherefunc_bullet.scenes.scans.scan import load_scan, require_surfaces, scan_from_points
from spherefunc_bullet.scenes.segmentation.clusters import Box, bounding_box
from spherefunc_bullet.scenes.settings import POOL


@pytest.fixture(scope="module")
def recognised():
    points, _ = room()
    return recognise(scan_from_points(points, "room"), load_model(shipped_model("fast", scans=True)))


# Scans


def test_what_a_sensor_did_not_see_is_dropped_and_counted():
    points = np.vstack([level(0.5, 0.5, 0.0), np.full((7, 3), np.nan)])
    scan = scan_from_points(points)
    assert scan.dropped == 7
    assert len(scan) == len(points) - 7


@pytest.mark.parametrize("away", [1e3, 1e7, 1e30])
@pytest.mark.parametrize("metre", [1, 1000])
def test_a_stray_point_far_away_is_dropped_and_counted(away, metre):
    """One at 100 km took the precision of all others: seats were lost, and cups appeared."""
    points = room()[0][::20]
    scan = scan_from_points(np.vstack([points, [[away, 0, 0]]]) * metre, units="auto")
    assert scan.dropped == 1 and np.allclose(scan.points, points)


def test_coordinates_too_coarse_for_their_shape_are_said(tmp_path):
    far, said = [room()[0][::20] + [500_000, 5_400_000, 300]], []
    far.append(far[0].astype(np.float32))
    scan, _ = (scan_from_points(points, report=said.append) for points in far)
    assert said == ["scan: 32-bit coordinates this far from the origin are 0.5 m apart; subtract an offset first"]
    (tmp_path / "far.ply").write_bytes(ply_bytes(scan.points, "as a room's labels are written"))
    assert np.array_equal(load_scan(tmp_path / "far.ply").points, far[0])


def test_millimetres_are_taken_for_such_and_said():
    said = []
    scan = scan_from_points(room()[0] * 1000, units="auto", report=said.append)
    assert np.ptp(scan.points[:, 0]) == pytest.approx(4.0)
    assert "millimetres" in said[0]


def test_points_that_fill_space_are_one_line():
    """They made surfaces everywhere; it took minutes and ten gigabytes."""
    points = np.random.default_rng(0).uniform(0, [3, 3, 2], (50_000, 3))
    with pytest.raises(InputError, match="scan: expected points on surfaces, got some everywhere: "):
        sf.find_objects(points)
    require_surfaces(points * [1, 1, 0.04], "a layer as thick as a cell")


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((5, 3)), "at least 100 points, got 5"),
        (np.full((500, 3), np.nan), "at least 100 points, got 0"),
        (np.zeros((500, 2)), "shape"),
        (np.zeros((500, 3)), "between 5 cm and 60 m"),
    ],
)
def test_what_is_no_scan_is_refused(points, message):
    with pytest.raises(InputError, match=message):
        scan_from_points(points)


def test_colours_of_ply_and_pcd(tmp_path):
    open3d = pytest.importorskip("open3d")
    points, colours = level(0.5, 0.5, 0.3), np.random.default_rng(0).integers(0, 256, (2, 3))
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    wanted = colours[np.arange(len(points)) % 2]
    cloud.colors = open3d.utility.Vector3dVector(wanted / 255)
    for name in ("scan.ply", "scan.pcd"):
        open3d.io.write_point_cloud(str(tmp_path / name), cloud)
        assert np.abs(load_scan(tmp_path / name).colors.astype(int) - wanted).max() <= 1  # rounded on the way


def depth_of_wall(width: int, height: int, metres: float) -> np.ndarray:
    return np.full((height, width), metres)


@pytest.mark.parametrize("kind", ["png", "npy", "tiff"])
def test_depth_images_of_every_kind_agree(tmp_path, kind):
    depth = depth_of_wall(64, 48, 2.0)
    depth[:5] = 0  # not seen
    path = tmp_path / f"depth.{kind}"
    if kind == "npy":
        np.save(path, depth)
    else:
        whole = (depth * 1000).astype(np.uint16) if kind == "png" else depth.astype(np.float32)
        Image.fromarray(whole).save(path)
    scan = load_depth_image(path)
    assert len(scan) == 64 * 43
    assert scan.dropped == 64 * 5
    assert np.allclose(scan.points[:, 2], 2.0)
    # 525 pixels of focal length to 640 of width, seen from two metres.
    assert np.ptp(scan.points[:, 0]) == pytest.approx(2.0 * 63 / (525 / 640 * 64))


def test_an_npy_of_points_is_a_cloud(tmp_path):
    np.save(tmp_path / "room.npy", room()[0][::20])
    np.save(tmp_path / "depth.npy", depth_of_wall(64, 48, 2.0))
    assert not is_image_file(tmp_path / "room.npy") and is_image_file(tmp_path / "depth.npy")
    result = spherefunc("scene", tmp_path / "room.npy", "--json")
    assert json.loads(result.stdout)["points"] == len(room()[0][::20])


def test_open3d_backprojects_the_same(tmp_path):
    open3d = pytest.importorskip("open3d")
    camera = open3d.camera.PinholeCameraIntrinsic(64, 48, 50.0, 51.0, 30.0, 25.0)
    open3d.io.write_pinhole_camera_intrinsic(str(tmp_path / "camera.json"), camera)
    depth = np.random.default_rng(0).integers(500, 4000, (48, 64)).astype(np.uint16)
    Image.fromarray(depth).save(tmp_path / "depth.png")
    expected = open3d.geometry.PointCloud.create_from_depth_image(open3d.geometry.Image(depth), camera)
    scan = load_depth_image(tmp_path / "depth.png", intrinsics=tmp_path / "camera.json")
    assert np.allclose(scan.points, np.asarray(expected.points), atol=1e-5)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("camera.json", "{}", "intrinsic_matrix"),
        ("camera.json", "not json", "intrinsic_matrix"),
        ("camera.json", '{"width": 3, "height": 2, "intrinsic_matrix": [9,0,0,0,9,0,1,1,1]}', "64 x 48"),
    ],
)
def test_a_wrong_camera_is_refused(tmp_path, name, content, message):
    np.save(tmp_path / "depth.npy", depth_of_wall(64, 48, 2.0))
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=message):
        load_depth_image(tmp_path / "depth.npy", intrinsics=tmp_path / name)


@pytest.mark.parametrize("depth", [np.full((48, 64), 1500.0), np.zeros((48, 64), np.uint16)])
def test_depth_in_another_unit_or_none_is_told(depth):
    with pytest.raises(InputError, match=r"depth: expected surfaces within 60 m, found none; is it in metres\?"):
        load_depth_image(depth)


def test_a_colour_image_is_no_depth_image(tmp_path):
    Image.fromarray(np.zeros((48, 64, 3), np.uint8)).save(tmp_path / "color.png")
    with pytest.raises(InputError, match="is it the colour image"):
        load_depth_image(tmp_path / "color.png")


def test_kinect_of_the_first_generation():
    assert kinect_like(640, 480).fx == 525


# Boxes


def test_the_box_of_a_turned_box_is_that_box():
    box = Box(center=np.array([1.0, 2.0, 0.5]), size=np.array([1.2, 0.6, 0.8]), yaw=0.4)
    around = bounding_box(box.corners)
    assert np.allclose(around.center, box.center)
    assert np.allclose(around.size, box.size)
    assert around.yaw == pytest.approx(box.yaw)
    assert box_overlap(box, around) == pytest.approx(1.0)


def test_boxes_apart_do_not_overlap():
    a = Box(center=np.zeros(3), size=np.ones(3), yaw=0.0)
    assert box_overlap(a, Box(center=np.array([1.5, 0, 0]), size=np.ones(3), yaw=0.7)) == 0


# Completion


def test_the_bottom_of_a_cup_is_closed_and_that_of_a_table_is_not():
    ring = mug().points[mug().points[:, 2] > 0.01]
    closed = complete(ring, ("bottom",))
    added = closed[len(ring) :]
    assert np.hypot(added[:, 0], added[:, 1]).max() < 0.04 + 1e-9
    sheet_points = added[np.hypot(added[:, 0], added[:, 1]) < 0.035]
    assert np.allclose(sheet_points[:, 2], 0.0)
    assert len(sheet_points) * POOL.spacing**2 == pytest.approx(np.pi * 0.035**2, rel=0.1)
    assert len(complete(table := square_table(0.8, 0.6, 0.7), ("bottom",))) == len(table)


def test_sides_reach_the_support():
    board = level(0.6, 0.4, 0.5)
    longer = complete(board, ("sides",), support=0.1)
    assert longer[:, 2].min() == pytest.approx(0.1)
    inside = (np.abs(longer[:, 0]) < 0.25) & (np.abs(longer[:, 1]) < 0.15) & (longer[:, 2] < 0.5)
    assert not inside.any()


def test_a_mirror_image_adds_the_far_side():
    seen = np.vstack([level(0.6, 0.4, 0.5), sheet([-0.3, -0.2, 0], [0.6, 0, 0], [0, 0, 0.5])])
    whole = complete(seen, ("mirror",))
    assert (whole[len(seen) :, 1] > 0.19).any()
    assert np.allclose(bounding_box(whole).size, bounding_box(seen).size, atol=1e-6)


def test_only_small_things_are_smoothed_and_only_large_ones_mirrored():
    cup, side = mug().points, sheet([0, 0, 0], [0.9, 0, 0], [0, 0, 0.5])
    assert np.array_equal(complete(cup, ("mirror",)), cup)
    assert np.array_equal(complete(side, ("smooth",)), side)
    assert not np.array_equal(complete(cup, ("smooth",))[: len(cup)], cup)


def test_a_large_object_is_thinned_and_a_small_one_is_not():
    cup, table = mug().points, square_table(1.2, 0.8, 0.72)
    assert len(object_cloud(cup, (), 0.0)[0].points) == len(cup)
    cloud, box = object_cloud(np.vstack([table, table + 0.001]), (), 0.0)
    assert len(cloud.points) < 0.7 * len(table)  # which lie 5 mm apart
    assert np.allclose(box.size, [1.201, 0.801, 0.721], atol=2e-3)


def test_steps_are_read():
    assert steps_of("none") == ()
    assert steps_of(None) == DEFAULT
    with pytest.raises(InputError, match="expected some of smooth, top, bottom, sides, mirror"):
        steps_of("bottom,magic")


# Recognition


def test_every_object_of_the_room_has_its_function(recognised):
    wanted = {"table": {"table"}, "mug": {"cup"}}
    for number, name in enumerate(NAMES):
        centre = {"table": (0, 0), "stool": (1.2, 0.3), "box": (-1.2, 0.5), "mug": (0.2, 0.1)}[name]
        near = [item for item in recognised.objects if np.hypot(*(item.box.center[:2] - centre)) < 0.08]
        item = min(near, key=lambda item: abs(item.box.size[0] - (0.08 if name == "mug" else 1.2)))
        if name in wanted:
            assert item.members == wanted[name], number


def test_the_mug_stands_on_the_table(recognised):
    mug = min(recognised.objects, key=lambda item: item.box.size.max())
    assert mug.support == pytest.approx(0.72, abs=0.015)


@pytest.mark.slow
def test_turning_the_room_turns_the_boxes(recognised):
    points, _ = room()
    seen = recognise(scan_from_points(in_view(as_camera_sees(points))), load_model(shipped_model("fast", scans=True)))
    assert len(seen.objects) == len(recognised.objects)
    largest = seen.levelling.to_scan(seen.objects[0].box.center[None])
    expected = as_camera_sees(recognised.objects[0].box.center[None])
    assert np.allclose(largest, expected, atol=0.03)


@pytest.mark.slow
def test_bullet_recognises_too():
    pytest.importorskip("pybullet")
    points, truth = room(walls=False)
    scene = scan_from_points(points[(truth == 0) | (truth == -1)][::2], "table")
    recognised = recognise(scene, load_model(shipped_model("bullet", scans=True)))
    assert recognised.objects[0].members == {"table"}


# The command


@pytest.fixture(scope="module")
def scan_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("scan") / "room.xyz"
    np.savetxt(path, in_view(as_camera_sees(room()[0][::3])), fmt="%.5f")
    return path


@pytest.mark.slow
def test_the_command_writes_all_it_promises(scan_file, tmp_path):
    done = spherefunc("scene", scan_file, "--out", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    about = json.loads(done.stdout)
    assert {"floor", "up", "objects", "stages"} <= set(about)
    assert {"id", "points", "box", "functions"} <= set(about["objects"][0])
    assert {path.name for path in tmp_path.iterdir()} == {
        "room.json", "room_labelled.ply", "room.png", "room.html"
    }  # fmt: skip
    labelled = load_scan(tmp_path / "room_labelled.ply")
    assert len(labelled) == about["points"]
    assert Image.open(tmp_path / "room.png").size == (1000, 750)
    page = (tmp_path / "room.html").read_text()
    assert "http://" not in page and "https://" not in page


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--up", "sideways"], "--up"),
        (["--complete", "magic"], "completion"),
        (["--cluster-tolerance", "5m"], "--cluster-tolerance: expected"),
        (["--color", "room.png"], "--color"),
        (["--model", "missing.npz"], "missing.npz"),
    ],
)
def test_mistakes_are_one_line_and_code_2(scan_file, options, message):
    done = spherefunc("scene", scan_file, *options)
    assert done.returncode == 2
    assert message in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_a_single_plane_has_no_objects_and_is_no_error(tmp_path):
    np.savetxt(tmp_path / "plane.xyz", moved(level(3.0, 3.0, 0.0)[::9], 5, 5), fmt="%.4f")
    done = spherefunc("scene", tmp_path / "plane.xyz", "--json", "--places", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["objects"] == []
    assert json.loads((tmp_path / "plane.json").read_text())["places"] == []
    assert "no objects" in done.stderr


def test_a_mesh_of_no_possible_size_is_no_scan(tmp_path):
    (tmp_path / "huge.obj").write_text("v 0 0 0\nv 1e300 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\n")
    with pytest.raises(InputError, match=r"huge.obj: expected a scan of at most 60 m, got 1e\+300"):
        load_scan(tmp_path / "huge.obj")
