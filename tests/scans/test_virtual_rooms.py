"""Virtual rooms: objects keep their distance, stand on what carries them, and every point knows its owner."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest
import trimesh
from objects_to_scan import THINGS, slab_on_posts, write_objects
from scipy.spatial import cKDTree
from typer.testing import CliRunner

from spherefunc_bullet.datasets.catalogue import COLUMNS, write_manifest
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.sources import read_geometry
from spherefunc_bullet.scenes.commands.dataset import app
from spherefunc_bullet.scenes.virtual_rooms.furnishing import FLOOR, GAP, WALL, furnish
from spherefunc_bullet.scenes.virtual_rooms.grounds import CELL, floor_of, footprint, top_of
from spherefunc_bullet.scenes.virtual_rooms.kinect import Kinect
from spherefunc_bullet.scenes.virtual_rooms.scans import partial_views, seen_scan, whole_scan


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return write_objects(tmp_path_factory.mktemp("objects"))


@pytest.fixture(scope="module")
def rooms(data):
    return list(furnish(open_dataset(data), 2, seed=1, failed=pytest.fail))


def plan(placed) -> np.ndarray:
    """Return an object seen from above, (N, 2), to the centimetre."""
    centimetres = np.round(100 * placed.points[:, :2]).astype(int)
    keys = np.unique(centimetres[:, 0] * 1000 + centimetres[:, 1])  # all are between 0 and 5 m
    return np.column_stack(np.divmod(keys, 1000)) / 100


@pytest.mark.slow
def test_no_object_is_nearer_than_the_gap(rooms):
    for room in rooms:
        on_floor = [placed for placed in room.objects if placed.support == FLOOR]
        plans = [plan(placed) for placed in on_floor]
        for i, one in enumerate(on_floor):
            low, high = one.points.min(axis=0), one.points.max(axis=0)
            # A footprint is drawn on cells: a diagonal of one may be lost.
            assert (low[:2] > GAP - 1.5 * CELL).all()
            assert (high[:2] < room.size[:2] - GAP + 1.5 * CELL).all()
            tree = cKDTree(plans[i])
            for other in plans[:i]:
                assert tree.query(other)[0].min() > GAP - 1.5 * CELL


def test_small_things_stand_on_tops(rooms):
    tops = {"desk": 0.74, "stand": 0.6}
    small = [(room, placed) for room in rooms for placed in room.objects if placed.item.path.stem in ("mug", "tin")]
    assert len(small) == 12  # six a room
    carried = [(room, placed) for room, placed in small if placed.support != FLOOR]
    assert len(carried) > 8
    for room, placed in carried:
        table = room.objects[placed.support]
        # The first sample of a top's height is half a level's width off at most.
        assert placed.points[:, 2].min() == pytest.approx(tops[table.item.path.stem], abs=0.005)
        low, high = table.points.min(axis=0), table.points.max(axis=0)
        assert (placed.points[:, :2] > low[:2] - CELL).all() and (placed.points[:, :2] < high[:2] + CELL).all()


def test_what_is_too_low_or_too_large_is_left_out(rooms):
    names = {placed.item.path.stem for room in rooms for placed in room.objects}
    assert names == set(THINGS) - {"pen", "bus"}


def test_same_seed_same_rooms(data, rooms):
    again = list(furnish(open_dataset(data), 2, seed=1, failed=pytest.fail))
    for one, other in zip(rooms, again, strict=True):
        assert np.array_equal(whole_scan(one).points, whole_scan(other).points)


def test_a_table_top_is_found_above_its_feet():
    points = trimesh.sample.sample_surface(slab_on_posts(1.2, 0.7, 0.74), 60_000, seed=0)[0]
    top = top_of(points)
    assert top.height == pytest.approx(0.74, abs=1e-6)
    assert (~top.blocked).mean() > 0.9


def test_a_full_floor_takes_nothing_more():
    floor, rng = floor_of(1.0, 1.0), np.random.default_rng(0)
    block = np.stack(np.meshgrid(*[np.linspace(-0.2, 0.2, 41)] * 2), axis=-1).reshape(-1, 2)
    points = np.column_stack([block, np.zeros(len(block))])
    places = [floor.place(points, 0.05, rng) for _ in range(9)]
    assert sum(place is not None for place in places) in (1, 2, 3, 4)  # four fit, placed by thought
    assert places[-1] is None
    assert footprint(block).shape == (21, 21)


def test_whole_scans_hold_every_point_of_every_object(rooms):
    scan = whole_scan(rooms[0])
    for number, placed in enumerate(rooms[0].objects):
        assert (scan.labels == number).sum() == len(placed.cloud.points)
    floor = scan.points[scan.labels == FLOOR]
    assert np.allclose(floor[:, 2], 0) and np.allclose(np.ptp(floor[:, :2], axis=0), rooms[0].size[:2])
    assert (scan.points[scan.labels == WALL] >= -1e-9).all()
    assert list(scan.seen()) == list(range(len(rooms[0].objects)))


def test_ideal_views_lie_on_the_surfaces_they_are_labelled_with(rooms):
    ideal = Kinect(noise=0.0, dropouts=False, width=160, height=120)
    scan = seen_scan(rooms[0], 3, ideal, np.random.default_rng(0))
    for number in scan.seen():
        distances, _ = cKDTree(rooms[0].objects[number].points).query(scan.points[scan.labels == number])
        assert distances.max() < 0.006  # the samples' own largest gap, and float32 rays
    assert np.abs(scan.points[scan.labels == FLOOR][:, 2]).max() < 1e-4


def test_more_views_show_more(rooms):
    counts = []
    for views in (1, 4):
        scan = seen_scan(rooms[0], views, Kinect(width=160, height=120), np.random.default_rng(0))
        counts.append(len(scan.points))
        assert len(scan.poses) == views
    assert counts[1] > 2 * counts[0]


def test_cameras_stand_clear_of_objects(rooms):
    for room in rooms:
        scan = seen_scan(room, 3, Kinect(width=64, height=48), np.random.default_rng(0))
        eyes = np.array([pose[:3, 3] for pose in scan.poses])
        assert ((eyes > 0) & (eyes < room.size)).all()
        for placed in room.objects:
            assert cKDTree(placed.points).query(eyes)[0].min() > 0.25  # 30 cm, to the surface between the points


def test_partial_views_stand_on_the_ground(rooms):
    ideal = Kinect(noise=0.0, dropouts=False, width=320, height=240)
    scan = seen_scan(rooms[0], 3, ideal, np.random.default_rng(0))
    clouds = dict(partial_views(scan))
    assert list(clouds) == list(scan.seen())
    for number, cloud in clouds.items():
        height = THINGS[rooms[0].objects[number].item.path.stem][0][2]
        assert cloud.points[:, 2].max() == pytest.approx(height, abs=0.02)


@pytest.fixture
def run():
    return lambda *arguments: CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.mark.slow
def test_rooms_are_written_with_their_truth(run, data, tmp_path):
    about = json.loads(run("rooms", data, tmp_path / "out", "--rooms", 1, "--views", 2, "--json").stdout)
    assert about["scans"] == ["room_01.ply"]
    with open(tmp_path / "out" / "room_01_instances.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    seen = [row for row in rows if row["seen"] == "1"]
    objects = open_dataset(tmp_path / "out" / "objects").objects
    assert len(objects) == len(seen) == about["objects"]
    assert len(read_geometry(tmp_path / "out" / "room_01.ply").vertices) > 100_000
    labels = {next(iter(item.functions), "none") for item in objects}
    assert labels <= {label for _, label in THINGS.values()}


def test_clouds_cannot_be_seen(run, tmp_path):
    folder = tmp_path / "clouds"
    folder.mkdir()
    np.savetxt(folder / "cloud.xyz", np.random.default_rng(0).random((50, 3)))
    write_manifest(folder, COLUMNS, [("cloud.xyz", "cup", "", "", "")])
    done = run("rooms", folder, tmp_path / "out")
    assert isinstance(done.exception, InputError) and "expected objects" in str(done.exception)


@pytest.mark.parametrize("views", ["0", "-1", "many"])
def test_views_are_numbers(run, data, tmp_path, views):
    done = run("rooms", data, tmp_path / "out", f"--views={views}")
    assert isinstance(done.exception, InputError) and "--views" in str(done.exception)
