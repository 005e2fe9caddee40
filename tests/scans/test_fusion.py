"""Depth images over time: the map lies on the surfaces, objects keep their ids, and what cannot be used is said."""

from __future__ import annotations

import json
import pickle
import sys
from collections import deque
from itertools import count

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.cloud import Mesh
from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.model_file import inference_model, shipped_model
from spherefunc_bullet.scenes.fusion.changes import changed_region
from spherefunc_bullet.scenes.fusion.frames import open_frames
from spherefunc_bullet.scenes.fusion.point_map import (
    FREE,
    HIDDEN,
    NEW,
    PRESENT,
    UNKNOWN,
    FusionSettings,
    PointMap,
    smoothed_depth,
    view_of,
)
from spherefunc_bullet.scenes.fusion.tracking import OdometryLost, Tracker, assigned, motion
from spherefunc_bullet.scenes.household.parts.solids import box, join, shift
from spherefunc_bullet.scenes.recognition.recognition import RoomFrame
from spherefunc_bullet.scenes.scans.levelling import Levelling
from spherefunc_bullet.scenes.segmentation.segmentation import FLOOR, LEFT_OVER, WALL, Shell, Wall
from spherefunc_bullet.scenes.virtual_rooms.kinect import Kinect, Surfaces, look_at, photograph

KINECT = Kinect(width=320, height=240)
CAMERA = KINECT.camera
EYES = ([2.4, 0.3, 1.6], [1.6, -1.8, 1.6], [-0.6, -2.4, 1.7])
GROUND = shift(box(14, 6, 0.02), z=-0.02)
TABLE = join(
    shift(box(1.2, 0.8, 0.03), z=0.7),
    *(shift(box(0.05, 0.05, 0.7), x=x, y=y) for x in (-0.55, 0.55) for y in (-0.35, 0.35)),
)
CRATE = box(0.4, 0.4, 0.4)
MODEL = inference_model(shipped_model("fast", scans=True), None)


def surfaces_of(*solids) -> Surfaces:
    return Surfaces((k, Mesh(np.array(one.vertices), np.array(one.faces))) for k, one in enumerate(solids))


def images_of(*solids, noise: float = 1.0, x: float = 0.0) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return what the camera sees of solids from each of the eyes, so far along x, with its poses."""
    surfaces, rng = surfaces_of(GROUND, *solids), np.random.default_rng(0)
    poses = [look_at(eye + np.array([x, 0, 0]), [x + 0.3, 0, 0.3]) for eye in EYES]
    return [(photograph(surfaces, pose, KINECT.noisy(noise), rng).depth, pose) for pose in poses]


def fused(images, fusion: sf.SceneFusion | None = None) -> sf.SceneFusion:
    fusion = fusion or sf.SceneFusion()
    for depth, pose in images:
        fusion.add(depth, CAMERA, pose)
    return fusion


@pytest.fixture(scope="module")
def images():
    return images_of(TABLE, shift(CRATE, x=1.3))


def write_png(path, depth, scale=1000):
    Image.fromarray(np.nan_to_num(np.round(depth * scale)).astype(np.uint16)).save(path)


@pytest.fixture
def folder(images, tmp_path):
    """Return a folder as 3DMatch has it."""
    for number, (depth, pose) in enumerate(images):
        write_png(tmp_path / f"frame-{number:06d}.depth.png", depth)
        np.savetxt(tmp_path / f"frame-{number:06d}.pose.txt", pose)
    np.savetxt(tmp_path / "camera-intrinsics.txt", [[CAMERA.fx, 0, CAMERA.cx], [0, CAMERA.fy, CAMERA.cy], [0, 0, 1]])
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("noise, most", [(0.0, 0.002), (1.0, 0.004)])  # a fifth of a voxel; two deviations at 1 m
def test_the_map_lies_on_the_surfaces(noise, most):
    solids = (TABLE, shift(CRATE, x=1.3))
    room = PointMap(FusionSettings())
    for depth, pose in images_of(*solids, noise=noise):
        depth = smoothed_depth(depth, 9 if noise else 1)
        room.add(depth, view_of(depth, CAMERA, pose))
    distance = surfaces_of(GROUND, *solids).clearance(room.points)
    assert len(distance) > 10_000 and np.median(distance) < most


def test_a_wall_thinner_than_a_voxel_is_kept_from_both_sides():
    plate, room = shift(box(0.5, 0.003, 0.5), z=0.5), PointMap(FusionSettings())
    for y in (-1.0, 1.0):
        pose = look_at([0, y, 0.75], [0, 0, 0.75])
        depth = photograph(surfaces_of(plate), pose, KINECT.noisy(0.0), np.random.default_rng(0)).depth
        room.add(depth, view_of(depth, CAMERA, pose))
    inside = room.points[np.abs(room.points[:, [0, 2]] - [0, 0.75]).max(axis=1) < 0.2]
    columns = np.unique(np.floor((inside[:, [0, 2]] - [0, 0.75]) / 0.02), axis=0)
    assert len(columns) == 20 * 20 and np.abs(inside[:, 1]).max() < 0.005


def test_what_more_images_look_through_than_show_is_forgotten():
    near, far, room = np.full((240, 320), 1.0), np.full((240, 320), 2.0), PointMap(FusionSettings())
    shown = []
    for depth in (near, near, far, far, far):
        room.add(depth, view_of(depth, CAMERA, np.eye(4)))
        shown.append(bool((room.points[:, 2] < 1.5).any()))
    assert shown == [True, True, True, True, False] and len(room.points) > 1000


def test_a_view_knows_what_is_free_present_and_hidden():
    view = view_of(np.full((240, 320), 2.0), CAMERA, np.eye(4))
    points = np.array([[0, 0, 1.0], [0, 0, 2.01], [0, 0, 3.0], [5.0, 0, 2.0], [0, 0, -1.0]])
    assert view.verdicts(points).tolist() == [FREE, PRESENT, HIDDEN, UNKNOWN, UNKNOWN]


@pytest.mark.slow
def test_objects_keep_their_ids_as_the_map_grows(images):
    fusion = fused(images[:2])
    before = {item.id: item for item in fusion.objects()}
    after = {item.id: item for item in fused(images[2:], fusion).objects()}
    table = next(item for item in before.values() if "table" in item.functions)
    assert "table" in after[table.id].functions
    for item in after.values():
        seen = fusion.room.objects[item.label]
        doubts = fusion.room.doubts(seen)
        assert (item.unsure, item.reasons) == (bool(doubts), (*fusion.room.reasons(seen), *doubts))
    assert np.linalg.norm(after[table.id].box.center - table.box.center) < 0.05  # a few voxels
    assert after[table.id].seen == 3 and after[table.id].moved is None


@pytest.mark.slow
def test_what_moved_keeps_its_id_and_what_is_taken_away_is_gone():
    fusion = fused(images_of(TABLE, shift(CRATE, x=1.3), noise=0.0))
    crate = min(fusion.objects(), key=lambda item: np.linalg.norm(item.box.center - [1.3, 0, 0.2]))
    fused(images_of(TABLE, shift(CRATE, x=1.3, y=0.9), noise=0.0), fusion)
    moved = next(item for item in fusion.objects() if item.id == crate.id)
    assert moved.moved == pytest.approx([0, 0.9, 0], abs=0.05) and not fusion.gone
    fused(images_of(TABLE, noise=0.0), fusion)
    assert crate.id not in {item.id for item in fusion.objects()}
    assert [known.id for known in fusion.gone] == [crate.id]


@pytest.mark.slow
def test_what_changes_is_recognised_anew_and_what_is_far_from_it_stays():
    near, far = TABLE, shift(TABLE, x=4.5)
    fusion = fused(images_of(near, far, noise=0.0) + images_of(near, far, noise=0.0, x=4.5))
    before = {item.id: fusion.room.objects[item.label] for item in fusion.objects()}
    tables = sorted((item.box.center[0], number) for number, item in before.items() if "table" in item.members)
    (_, first), (_, second) = tables
    everything = fusion.looked_at
    full = images_of(near, far, shift(CRATE, x=5.8), noise=0.0, x=4.5)
    after = {item.id: item for item in fused(full, fusion).objects()}
    assert fusion.looked_at == everything  # not all of the map was looked at
    assert fusion.room.objects[after[first].label].points is before[first].points and after[first].seen == 3
    crate = min(after.values(), key=lambda item: np.linalg.norm(item.box.center - [5.8, 0, 0.2]))
    assert crate.id not in before and np.linalg.norm(crate.box.center - [5.8, 0, 0.2]) < 0.1
    assert "table" in after[second].functions and set(after) == {*before, crate.id}
    labels = [fusion.room.labels[np.isclose(fusion.scan.points, point).all(axis=1)] for point in crate.points[::100]]
    assert all((found == crate.label).all() for found in labels) and fusion.room.labels.min() >= LEFT_OVER
    whole = {item.id: item for item in fusion.objects(whole=True)}
    assert {number: item.functions for number, item in whole.items()} == {
        k: item.functions for k, item in after.items()
    }
    assert all(np.linalg.norm(whole[k].box.center - item.box.center) < 0.05 for k, item in after.items())


def map_of(points: np.ndarray, labels: np.ndarray | int) -> PointMap:
    """Return a map of points (N, 3), metres, and their labels."""
    room = PointMap(FusionSettings())
    room.points, room.labels = np.asarray(points, float), np.broadcast_to(labels, len(points)).astype(np.int32)
    room.weights = room.present = room.free = np.ones(len(points))
    return room


def block(x: float, z: float, size: float = 0.15) -> np.ndarray:
    """Return the points of a cube, one in each voxel of 2 cm, that begins at x and z."""
    steps = np.arange(0.01, size, 0.02)
    return np.stack(np.meshgrid(steps + x, steps, steps + z), axis=-1).reshape(-1, 3)


FRAME = RoomFrame(
    levelling=Levelling(T_level_scan=np.eye(4), source="floor", floor_seen=True, noise=0.005),
    shell=Shell(walls=[Wall(normal=np.array([1.0, 0]), offset=-1.0, span=(-5, 5), thickness=0.05)], ceiling=np.inf),
)


@pytest.mark.parametrize(
    "seen, label",
    [(block(-1.2, 0.5), WALL), (block(3.0, 0.0) * [1, 1, 0.05], FLOOR), (block(3.0, 0.5, 0.06), NEW)],
    ids=["wall", "floor", "a few voxels"],
)
def test_walls_floor_and_a_few_voxels_are_no_change(seen, label):
    room = map_of(np.vstack([block(0.0, 0.5), seen]), np.repeat([0, NEW], [len(block(0.0, 0.5)), len(seen)]))
    region = changed_region(room, FRAME)
    assert not region.core.any() and not region.around.any()
    assert (room.labels[-len(seen) :] == label).all()


def test_an_image_from_far_away_by_a_wrong_pose_costs_no_memory(images):
    fusion = fused(images)
    before = {item.id for item in fusion.objects()}
    depth = np.full_like(images[0][0], np.nan)
    depth[:20, :20] = 1.0
    away = look_at([61.0, 0.0, 1.5], [62.0, 0.0, 1.5])
    assert before <= {item.id for item in fusion.add(depth, CAMERA, away).objects()}
    assert changed_region(fusion.map, fusion.frame) is None and fusion.scan.dropped > 0


def test_a_wrong_pose_far_away_costs_no_later_update(images):
    fusion, away = fused(images[:1]), look_at([300.0, 0.0, 1.5], [301.0, 0.0, 1.5])
    with pytest.raises(InputError, match="image 1: expected a camera within 60 m of the map's first, got one 298 m"):
        fusion.add(images[1][0], CAMERA, away, "image 1")
    assert fused(images[1:2], fusion).objects() and fusion.count == 2


def test_a_cup_on_a_table_is_a_change():
    top = np.stack(np.meshgrid(np.arange(0.005, 1, 0.01), np.arange(0.005, 1, 0.01), [0.725]), axis=-1).reshape(-1, 3)
    angles, heights = (each.ravel() for each in np.meshgrid(np.linspace(0, np.pi, 13), np.arange(0.735, 0.83, 0.01)))
    cup = np.column_stack([0.5 + 0.04 * np.cos(angles), 0.5 + 0.04 * np.sin(angles), heights])  # seen from one side
    room = map_of(np.vstack([top, cup]), np.repeat([0, NEW], [len(top), len(cup)]))
    region = changed_region(room, FRAME)
    assert region.in_core[len(top) :].any() and region.in_core[: len(top)].mean() < 0.1


@pytest.mark.parametrize("change", ["new", "gone", "lost"])
def test_what_is_new_gone_or_lost_is_a_change_with_its_surroundings(change):
    parts = [block(x, 0.5) for x in (0.0, 0.42, 2.0)]
    sizes = [len(part) for part in parts]
    room = map_of(np.vstack(parts), np.repeat([0 if change != "new" else NEW, 1, 2], sizes))
    if change == "gone":
        room.keep(np.arange(sum(sizes)) % 2 + (np.arange(sum(sizes)) >= sizes[0]) > 0)
        sizes[0] = len(room.points) - sizes[1] - sizes[2]
    region = changed_region(room, FRAME, [0] if change == "lost" else [])
    assert region.in_core.tolist() == np.repeat([True, False, False], sizes).tolist()
    assert region.around.tolist() == np.repeat([True, True, False], sizes).tolist()


def test_a_pickled_fusion_goes_on_where_it_was(images):
    fusion = fused(images[:1])
    fusion.objects()
    other = pickle.loads(pickle.dumps(fusion))
    answers = [
        [(item.id, item.scores, item.seen) for item in fused(images[1:2], each).objects()] for each in (fusion, other)
    ]
    assert answers[0] == answers[1] != []


def interrupted(doing, where, line: int | None = None) -> bool:
    """Do something, and press Ctrl-C at the call, or the line from 0 on, of a function; return whether it got there."""
    lines = count()

    def trace(frame, event, _):
        if frame.f_code is where.__code__ and (event == "call") == (line is None) and line in (None, next(lines)):
            raise KeyboardInterrupt
        return trace if frame.f_code is where.__code__ else None

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        doing()
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(before)
    return False


def test_ctrl_c_leaves_a_map_that_takes_the_next_image():
    camera, pose = sf.Intrinsics(width=32, height=24, fx=30, fy=30, cx=15.5, cy=11.5), np.diag([1.0, -1, -1, 1])
    for where in (PointMap.add, PointMap.keep):
        for line in count():
            fusion = sf.SceneFusion(MODEL).add(np.full((24, 32), 1.0), camera, pose)
            stopped = interrupted(lambda: fusion.add(np.full((24, 32), 2.0), camera, pose), where, line)  # noqa: B023
            fusion.add(np.full((24, 32), 2.0), camera, pose)
            rows = {len(getattr(fusion.map, name)) for name in ("points", "weights", "present", "free", "labels")}
            assert len(rows) == 1, line
            if not stopped:
                break
        assert line > 2


def test_objects_have_places_as_those_of_a_single_scan_have(images):
    fusion = fused(images)
    objects = fusion.objects()
    fusion.add(images[0][0], CAMERA, look_at(EYES[1], [0.3, 0, 0.3]))  # places are those of the update before
    (table,) = (item for item in pickle.loads(pickle.dumps(objects)) if "table" in item.functions)
    place = table.places[0]
    assert (place.kind, place.function) == ("put", "table") and np.abs(place.position[:2]).max() < 0.6
    assert abs(place.position[2] - 0.73) < 0.01 and isinstance(table, sf.FoundObject)  # the top; noise of depth


def test_an_update_ended_by_ctrl_c_is_made_up_for(images):
    fusion = fused(images[:1])
    fusion.objects()
    fused(images[1:2], fusion)
    other = pickle.loads(pickle.dumps(fusion))
    assert interrupted(fusion.objects, Tracker.update)
    answers = [[(item.id, item.seen, *item.box.center) for item in each.objects()] for each in (fusion, other)]
    assert answers[0] == answers[1] != []


def test_odometry_tells_the_motion_of_a_camera_or_fails():
    surfaces, rng = surfaces_of(GROUND, TABLE, shift(CRATE, x=1.3)), np.random.default_rng(0)
    poses = [look_at(eye, [0.3, 0, 0.3]) for eye in ([2.0, -1.6, 1.5], [1.94, -1.66, 1.5], [-2.0, 1.6, 1.5])]
    depths = [photograph(surfaces, pose, KINECT, rng).depth for pose in poses]
    true = np.linalg.inv(poses[0]) @ poses[1]
    assert np.linalg.norm((motion(depths[1], depths[0], CAMERA, "b") - true)[:3, 3]) < 0.02  # of 8 cm
    with pytest.raises(OdometryLost):
        motion(depths[2], depths[0], CAMERA, "c")


def test_lost_odometry_costs_no_image_before_it(folder):
    for path in folder.glob("*.pose.txt"):
        path.unlink()
    (folder / "frame-000001.depth.png").write_bytes((folder / "frame-000000.depth.png").read_bytes())
    result = CliRunner().invoke(application(), ["scene", "--frames", str(folder), "--json"])
    assert result.exit_code == 2
    assert sum("odometry is lost" in line for line in result.stderr.splitlines()) == 1
    answer = json.loads(result.stdout)
    assert answer["frames"] == {"fused": 2, "left_out": 1} and answer["poses"] == "odometry"
    assert any(item["functions"]["table"]["member"] for item in answer["objects"])


def test_tum_and_redwood_give_the_same_poses(images, tmp_path):
    times = [1305031102.16 + number / 30 for number in range(len(images))]
    tum, log = [], []
    for time, (depth, pose) in zip(times, images, strict=True):
        write_png(tmp_path / f"{time:.6f}.png", depth, 5000)
        tum.append(" ".join(map(str, [time, *pose[:3, 3], *Rotation.from_matrix(pose[:3, :3]).as_quat()])))
        log.append("0 0 0\n" + "\n".join(" ".join(map(str, row)) for row in pose))
    (tmp_path / "poses.txt").write_text("\n".join(["# times", *tum]))
    (tmp_path / "poses.log").write_text("\n".join(log))
    for name in ("poses.txt", "poses.log"):
        frames = open_frames(tmp_path, poses=tmp_path / name).frames
        assert np.allclose([frame.T_world_camera() for frame in frames], [pose for _, pose in images])
        assert np.nanmax(np.abs(frames[0].depth() - images[0][0])) < 2e-4  # a step of TUM's


@pytest.mark.parametrize(
    "wrong", [{"fx": 0}, {"fy": -3}, {"cx": np.nan}, {"cy": np.inf}, {"width": 0}, {"height": 2.5}]
)
def test_a_camera_that_is_none_is_refused(wrong):
    good = {name: getattr(CAMERA, name) for name in ("width", "height", "fx", "fy", "cx", "cy")}
    with pytest.raises(InputError, match=f"{next(iter(wrong))}: expected"):
        sf.Intrinsics(**good | wrong)


def test_ids_are_assigned_by_the_largest_sum():
    assert assigned(np.array([[0.9, 0.8], [0.85, 0.1], [0.2, 0.2]]), 0.3) == [(0, 1), (1, 0)]
    assert assigned(np.zeros((0, 3)), 0.3) == []


MOVED = look_at(EYES[0], [0.3, 0, 0.3])
FAR = MOVED + np.pad(
    [[5e6]], ((0, 3), (3, 0))
)  # as in a map of a country: the map's numbers would be half a metre apart


@pytest.mark.parametrize(
    "pose", [np.full((4, 4), np.nan), np.eye(3), 2 * np.eye(4), MOVED.T, "pose", MOVED * [1, -1, 1, 1], FAR]
)
def test_a_pose_that_is_none_is_refused(images, pose):
    fusion = sf.SceneFusion()
    with pytest.raises(InputError):
        fusion.add(images[0][0], CAMERA, pose)
    assert not fusion.views


@pytest.mark.slow
def test_a_bad_image_costs_only_itself(folder):
    np.savetxt(folder / "frame-000003.pose.txt", np.full((4, 4), np.nan))
    good = (folder / "frame-000000.depth.png").read_bytes()
    for number in (3, 4):
        (folder / f"frame-{number:06d}.depth.png").write_bytes(good)  # 4 has no pose
    (folder / "frame-000005.depth.png").write_bytes(b"no PNG")
    write_png(folder / "frame-000006.depth.png", np.ones((50, 60)))
    for number in (5, 6):
        np.savetxt(folder / f"frame-{number:06d}.pose.txt", np.eye(4))
    out = folder / "out"
    result = CliRunner().invoke(application(), ["scene", "--frames", str(folder), "--json", "--out", str(out)])
    assert result.exit_code == 2
    for number in (3, 4, 5, 6):
        assert sum(f"frame-{number:06d}" in line for line in result.stderr.splitlines()) == 1
    answer = json.loads(result.stdout)
    assert json.loads((out / f"{folder.name}.json").read_text()) == answer
    assert answer["frames"] == {"fused": 3, "left_out": 4}
    assert any(item["functions"]["table"]["member"] and item["seen"] == 3 for item in answer["objects"])


@pytest.mark.parametrize("options", [["--frames", "."], ["--frames", "none"], ["--poses", "p.txt"], []])
def test_what_cannot_be_fused_is_one_line(options, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(application(), ["scene", *options])
    assert isinstance(result.exception, InputError) and len(str(result.exception).splitlines()) == 1


def test_a_folder_of_images_is_told_its_option(folder):
    error = CliRunner().invoke(application(), ["scene", str(folder)]).exception
    assert "got a folder without metadata.yaml; --frames reads depth images from one" in str(error)


def test_depth_in_millimetres_is_refused_and_changes_nothing(images):
    (depth, pose), *_ = images
    fusion = sf.SceneFusion()
    with pytest.raises(InputError, match=r"kinect: expected surfaces within 5 m, found none; is it in metres\?"):
        fusion.add(depth * 1000, CAMERA, pose, name="kinect")
    assert not fusion.views


def test_integers_are_millimetres_and_cameras_may_be_of_open3d_or_ros(images):
    import open3d as o3d

    depth, pose = images[0]
    steps = np.round(np.nan_to_num(depth) * 1000)
    K = np.array([[CAMERA.fx, 0, CAMERA.cx], [0, CAMERA.fy, CAMERA.cy], [0, 0, 1]])
    other = o3d.camera.PinholeCameraIntrinsic(320, 240, K)
    wanted = sf.SceneFusion(MODEL).add(steps / 1000, CAMERA, pose).map.points
    for camera in (CAMERA, other, K.ravel()):
        assert np.array_equal(sf.SceneFusion(MODEL).add(steps.astype(np.uint16), camera, pose).map.points, wanted)
    with pytest.raises(InputError, match="expected a camera of 320 x 240 as the depth, got a camera of 640 x 480"):
        sf.SceneFusion(MODEL).add(depth, o3d.camera.PinholeCameraIntrinsic(640, 480, K), pose)
    with pytest.raises(InputError, match=r"is it in millimetres\?"):
        sf.SceneFusion(MODEL).add((steps * 1000).astype(np.uint32), CAMERA, pose)


@pytest.mark.parametrize("how", [{"completion": ("foo",)}, {"proposals": "pools"}, {"settings": 3}])
def test_unknown_steps_and_settings_of_recognition_are_refused(how):
    with pytest.raises(InputError, match=f"{next(iter(how))}.*expected"):
        sf.SceneFusion(**how)


def test_a_log_of_more_poses_than_images_is_refused(images, tmp_path):
    write_png(tmp_path / "0.png", images[0][0])
    one = "0 0 0\n" + "\n".join(" ".join(map(str, row)) for row in images[0][1]) + "\n"
    (tmp_path / "trajectory.log").write_text(one * 2)
    with pytest.raises(InputError, match=r"trajectory.log: expected a pose for each of the 1 images, got 2"):
        open_frames(tmp_path, poses=tmp_path / "trajectory.log")


def log_of(numbers) -> str:
    """Return a Redwood log of poses whose x is the number of the image, with three numbers before each."""
    return "".join(f"{k - 1} {k - 1} {k}\n1 0 0 {k}\n0 1 0 0\n0 0 1 0\n0 0 0 1\n" for k in numbers)


def test_images_are_in_the_order_of_their_numbers(tmp_path):
    for number in range(1, 13):
        write_png(tmp_path / f"{number}.png", np.full((4, 4), number / 10))
    write_png(tmp_path / "._1.png", np.ones((4, 4)))  # as another system leaves it; it would shift all poses
    (tmp_path / "trajectory.log").write_text(log_of(range(1, 13)))
    frames = open_frames(tmp_path, poses=tmp_path / "trajectory.log").frames
    found = [(frame.depth()[0, 0] * 10, frame.T_world_camera()[0, 3]) for frame in frames]
    assert np.allclose(found, [(k, k) for k in range(1, 13)])


@pytest.mark.parametrize(("numbers", "known"), [([1, 3, 4], [1, None, 3, 4]), ([7, 9, 12], [7, 9, 12, None])])
def test_a_log_says_which_images_its_poses_are_of(numbers, known, tmp_path):
    for number in range(4):
        write_png(tmp_path / f"{number:06d}.png", np.ones((4, 4)))
    (tmp_path / "trajectory.log").write_text(log_of(numbers))
    poses = [frame.pose for frame in open_frames(tmp_path, poses=tmp_path / "trajectory.log").frames]
    assert [None if pose is None else pose[0, 3] for pose in poses] == known


@pytest.mark.parametrize("row", ["1.5,1,2,3,0,0,0,1", "1.5, 1, 2, 3, 0, 0, 0, 1", "\ufeff1.5 1 2 3 0 0 0 1  # first"])
def test_poses_as_other_programs_write_them(row, tmp_path):
    write_png(tmp_path / "1.500000.png", np.ones((4, 4)))
    (tmp_path / "groundtruth.txt").write_text(row + "\r\n", encoding="utf-8", newline="")
    (frame,) = open_frames(tmp_path).frames
    assert frame.T_world_camera()[:3].tolist() == [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3]]


def test_a_line_that_is_no_pose_is_shown(tmp_path):
    write_png(tmp_path / "1.500000.png", np.ones((4, 4)))
    (tmp_path / "groundtruth.txt").write_text("timestamp,tx,ty,tz,qx,qy,qz,qw\n")
    with pytest.raises(InputError, match="of timestamp tx ty tz qx qy qz qw, found timestamp tx ty tz qx qy qz qw$"):
        open_frames(tmp_path)


def test_a_camera_in_another_format_is_told_which_there_are(tmp_path):
    write_png(tmp_path / "0.png", np.ones((4, 4)))
    (tmp_path / "camera.yaml").write_text("image_width: 4\n")
    with pytest.raises(InputError, match="camera.yaml: expected a camera's JSON.* or its matrix of 3 x 3 numbers"):
        open_frames(tmp_path, intrinsics=tmp_path / "camera.yaml")


def test_long_sequences_do_not_fill_the_memory():
    camera, pose = sf.Intrinsics(width=32, height=24, fx=30, fy=30, cx=15.5, cy=11.5), np.diag([1.0, -1, -1, 1])
    fusion = sf.SceneFusion()
    assert fusion.views.maxlen == 1000
    fusion.views = deque(maxlen=3)
    for _ in range(5):
        fusion.add(np.full((24, 32), 1.003), camera, pose)
    item, *_ = fusion.objects()
    assert (len(fusion.views), fusion.count, item.seen) == (3, 5, 3)
    fusion.add(np.full((24, 32), 1.003), camera, pose)
    assert [one.seen for one in fusion.objects() if one.id == item.id] == [4]


def test_poses_of_another_clock_are_refused(images, tmp_path):
    depth, pose = images[0]
    write_png(tmp_path / "1305031102.160000.png", depth, 5000)
    row = [12.5, *pose[:3, 3], *Rotation.from_matrix(pose[:3, :3]).as_quat()]
    (tmp_path / "groundtruth.txt").write_text(" ".join(map(str, row)))
    with pytest.raises(InputError, match=r"groundtruth.txt: expected poses within 0.02 s .* another clock"):
        open_frames(tmp_path)


def test_an_update_that_sees_too_little_costs_no_later_image(folder):
    speck = np.full((240, 320), np.nan)
    speck[116:124, 156:164] = 1.0
    write_png(folder / "frame-000000.depth.png", speck)
    result = CliRunner().invoke(application(), ["scene", "--frames", str(folder), "--json", "--every", "1"])
    assert result.exit_code == 0 and json.loads(result.stdout)["frames"] == {"fused": 3, "left_out": 0}


def test_the_table_says_which_threshold_a_score_exceeds(folder):
    result = CliRunner().invoke(application(), ["scene", "--frames", str(folder), "--every", "0", "--places"])
    assert "3 depth images: " in result.stdout and "1.00 (0.50)" in result.stdout
    assert "fused: where it can be used" in result.stdout


def test_fused_images_say_where_an_object_can_be_put(folder):
    np.savetxt(folder / "mug.xyz", np.random.default_rng(0).uniform(-0.04, 0.04, (500, 3)))
    options = ["--every", "0", "--put", str(folder / "mug.xyz"), "--json"]
    result = CliRunner().invoke(application(), ["scene", "--frames", str(folder), *options])
    (table,) = (item for item in json.loads(result.stdout)["objects"] if item["functions"]["table"]["member"])
    assert len(table["places"][0]["poses"]) > 3


@pytest.mark.filterwarnings("error")
def test_numbers_that_are_no_depth_are_unseen(images):
    (depth, pose), noise = images[0], images[0][0].copy()
    depth = depth.copy()
    noise[:5], depth[:5] = np.array([1e-45, 1e-38, 1e-30, 1e-6, 5e-4])[:, None], np.nan
    known, same = (sf.SceneFusion(MODEL).add(each, CAMERA, pose).map.points for each in (depth, noise))
    assert np.array_equal(known, same)


@pytest.mark.parametrize("size", [1, 2])
def test_images_need_no_smoothing(size, images):
    assert smoothed_depth(images[0][0], size) is images[0][0]


def test_masked_depth_is_unseen(images):
    depth, pose = images[0]
    masked = np.ma.masked_array(np.nan_to_num(depth, nan=0.5), np.isnan(depth))
    plain, other = sf.SceneFusion().add(depth, CAMERA, pose), sf.SceneFusion().add(masked, CAMERA, pose)
    known, same = (np.unique(fusion.map.points, axis=0) for fusion in (plain, other))
    assert np.array_equal(known, same)


@pytest.mark.slow
def test_the_command_aligns_poses_unless_they_are_exact(folder):
    off = np.eye(4)
    off[:3, 3] = [0.06, -0.06, 0.06]
    np.savetxt(path := folder / "frame-000001.pose.txt", np.loadtxt(path) @ off)
    command = ["scene", "--frames", str(folder), "--json", "--pose-error"]
    exact, aligned = (
        json.loads(CliRunner().invoke(application(), [*command, error]).stdout) for error in ("none", "6cm")
    )
    assert exact["agreement"] < aligned["agreement"]
