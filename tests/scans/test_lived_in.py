"""Rooms as people leave them: chairs under tables, stacks, shelves and the rest touch and never cross, by options."""

from __future__ import annotations

import csv
from dataclasses import fields

import numpy as np
import pytest
import trimesh
from objects_to_scan import slab_on_posts, write_objects
from scipy.spatial import cKDTree
from typer.testing import CliRunner

from spherefunc_bullet.datasets.catalogue import COLUMNS, write_manifest
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.commands.dataset import app
from spherefunc_bullet.scenes.virtual_rooms.chairs_at_tables import front_of
from spherefunc_bullet.scenes.virtual_rooms.furnishing import FLOOR, WALL, furnish
from spherefunc_bullet.scenes.virtual_rooms.grounds import boards_of
from spherefunc_bullet.scenes.virtual_rooms.lived_in import LivedIn, furnish_lived_in, parse_lived_in
from spherefunc_bullet.scenes.virtual_rooms.occupancy import SIDE, Occupancy
from spherefunc_bullet.scenes.virtual_rooms.scans import Resolution, scan_room, whole_scan
from spherefunc_bullet.scenes.virtual_rooms.surroundings import BED, CARTON, CLUTTER, PILE, SHELF, SILL

pytestmark = pytest.mark.slow

KINDS = [kind.name for kind in fields(LivedIn)]
ALONE = {"chairs": 2, "stacks": 2, "sills": 1, "clutter": 1, "all": 1}  # rooms


def chair() -> trimesh.Trimesh:
    """Return a seat of 45 cm on four legs, with a back to +y."""
    back = trimesh.creation.box((0.42, 0.03, 0.45))
    back.apply_translation([0, 0.2, 0.67])
    return trimesh.util.concatenate([slab_on_posts(0.42, 0.42, 0.45), back])


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    folder = write_objects(tmp_path_factory.mktemp("home"), ("desk", "chest", "mug", "tin"))
    labels = {"desk": "table", "chest": "none", "mug": "cup", "tin": "none", "chair": "sittable"}
    chair().export(folder / "chair.ply")
    write_manifest(folder, COLUMNS, [(f"{name}.ply", label, "", name, "test") for name, label in labels.items()])
    return open_dataset(folder)


@pytest.fixture(scope="module")
def rooms(data):
    """Return rooms with some kinds alone, and one with all."""
    return {kind: lived_in(data, kind, count) for kind, count in ALONE.items()}


@pytest.fixture(scope="module")
def bare(data):
    """Return the first rooms of the same seed without any disorder."""
    return list(furnish(data, 2, seed=3, failed=pytest.fail))


def lived_in(data, text: str, count: int) -> list:
    return list(furnish_lived_in(data, count, seed=3, failed=pytest.fail, lived_in=parse_lived_in(text)))


def places(room) -> list:
    return [placed.T_room_object.tolist() for placed in room.objects]


def added(room, before) -> list:
    return list(room.objects[len(before.objects) :])


def test_without_options_rooms_are_what_they_were(data, bare):
    for one, other in zip(lived_in(data, "", 2), bare, strict=True):
        assert np.array_equal(whole_scan(one).points, whole_scan(other).points)
    assert np.array_equal(scan_room(one, 1, 1.0, 3).points, scan_room(other, 1, 1.0, 3, Resolution()).points)


def test_a_share_of_rooms_is_lived_in_and_the_others_are_as_before(data, bare):
    pairs = list(zip(lived_in(data, "chairs=0.5", 2), bare, strict=True))
    assert sum([places(one) == places(other) for one, other in pairs]) == 1


def test_same_seed_same_disorder(data, rooms):
    again = lived_in(data, "all", 1)
    for one, other in zip(rooms["all"], again, strict=True):
        assert np.array_equal(whole_scan(one).points, whole_scan(other).points)


@pytest.mark.parametrize("kind", ["chairs", "stacks", "all"])
def test_nothing_crosses_anything(rooms, kind):
    for room in rooms[kind]:
        everything = Occupancy.of(room.size, (placed.points for placed in room.objects))
        for number, placed in enumerate(room.objects):
            near = [k for k, other in enumerate(room.objects) if other.support == number] + [number, placed.support]
            own = [room.objects[k].points for k in near if k >= 0]
            for points in own:
                everything.clear(points)
            cubes = np.floor(placed.points / SIDE).astype(int)
            cubes = cubes[((cubes >= 0) & (cubes < everything.counts.shape)).all(axis=1)]
            own_cubes = np.unique(np.ravel_multi_index(tuple(cubes.T), everything.counts.shape))
            # Objects that touch share the cubes in which they do: a face of one at most, never what is behind it.
            assert (everything.counts.ravel()[own_cubes] > 0).mean() < 0.25, (kind, placed.item.category)
            for points in own:
                everything.fill(points)


@pytest.mark.parametrize("kind", ALONE)
def test_all_stays_in_the_room(rooms, kind):
    for room in rooms[kind]:
        for placed in room.objects:
            low, high = placed.points.min(axis=0), placed.points.max(axis=0)
            assert (low > -1e-6).all() and (high < room.size + 1e-6).all()


def test_chairs_stand_under_tables(rooms):
    under = 0
    for room in rooms["chairs"]:
        tables = [placed for placed in room.objects if placed.item.category == "desk"]
        for placed in (placed for placed in room.objects if placed.item.category == "chair"):
            for table in tables:
                # A desk's own frame has its middle at the origin; its top reaches 45 cm along x and 30 along y.
                own = (placed.points - table.T_room_object[:3, 3]) @ table.T_room_object[:3, :3]
                under += bool(((np.abs(own[:, :2]) < [0.43, 0.28]).all(axis=1) & (own[:, 2] < 0.7)).any())
    assert under >= 3


def test_a_chair_faces_away_from_its_back():
    points = trimesh.sample.sample_surface(chair(), 20_000, seed=0)[0]
    assert front_of(points, np.random.default_rng(0)) @ [0, -1] > 0.99


def test_small_things_are_stacked_or_touch(rooms):
    stacked = touching = 0
    for room in rooms["stacks"]:
        small = [(k, p) for k, p in enumerate(room.objects) if p.item.category in ("mug", "tin") and p.support != FLOOR]
        for k, placed in small:
            carrier = room.objects[placed.support]
            if carrier.item.category in ("mug", "tin"):
                stacked += 1
                assert placed.points[:, 2].min() == pytest.approx(carrier.points[:, 2].max(), abs=0.006)
            others = [other.points for n, other in small if n != k and other.support == placed.support]
            # Sampled surfaces that touch are nearer than a sample is to the next: 5 mm.
            touching += bool(others and cKDTree(np.vstack(others)).query(placed.points)[0].min() < 0.006)
    assert stacked >= 1 and touching >= 2


def test_what_rooms_have_besides(rooms, bare):
    (everything,), (sills,), bare = rooms["all"], rooms["sills"], bare[0]
    assert {BED, SHELF, SILL, CARTON, PILE} <= {placed.item.category for placed in added(everything, bare)}
    assert everything.size[0] > bare.size[0] and np.array_equal(sills.size, bare.size)
    assert SILL in {placed.item.category for placed in added(sills, bare)}


def test_shelves_and_sills_carry_things_and_sills_hang(rooms):
    carried = {SHELF: 0, SILL: 0}
    for room in (*rooms["all"], *rooms["sills"]):
        for placed in room.objects:
            if placed.support >= 0 and (category := room.objects[placed.support].item.category) in carried:
                carried[category] += 1
            if placed.item.category == SILL:
                assert placed.support == WALL and placed.points[:, 2].min() > 0.6
    assert min(carried.values()) >= 1


def test_clutter_lies_on_seats(rooms):
    lying = [
        (placed, room.objects[placed.support])
        for room in rooms["clutter"]
        for placed in room.objects
        if placed.item.category == CLUTTER
    ]
    assert lying and all("sittable" in seat.item.functions for _, seat in lying)
    for placed, _ in lying:
        assert placed.points[:, 2].min() == pytest.approx(0.45, abs=0.01)  # the chair's seat


def test_every_point_knows_its_owner(rooms):
    scan = whole_scan(rooms["all"][0])
    for number, placed in enumerate(scan.room.objects):
        assert (scan.labels == number).sum() == len(placed.cloud.points)


def test_boards_are_found_at_their_upper_faces():
    boards = [trimesh.creation.box((0.8, 0.3, 0.02)) for _ in range(3)]
    for board, z in zip(boards, (0.05, 0.45, 0.85), strict=True):
        board.apply_translation([0.4, 0.15, z])
    points = trimesh.sample.sample_surface(trimesh.util.concatenate(boards), 60_000, seed=0)[0]
    assert [round(board.height, 3) for board in boards_of(points)] == [0.06, 0.46, 0.86]


def test_kinds_are_read():
    assert parse_lived_in(None) == LivedIn()
    assert parse_lived_in("all") == LivedIn(**dict.fromkeys(KINDS, 1.0))
    assert parse_lived_in("all=0.5, beds=0").beds == 0


@pytest.mark.parametrize("text", ["dogs", "chairs=many", "chairs=2", "beds=-1"])
def test_wrong_kinds_are_one_line(text):
    with pytest.raises(InputError, match="--lived-in") as caught:
        parse_lived_in(text)
    assert "expected" in str(caught.value) and "\n" not in str(caught.value)


# Resolution


def test_a_fused_scan_has_one_point_a_cell_and_the_owner_of_most(rooms):
    room = rooms["chairs"][0]
    seen, fused = (scan_room(room, 2, 1.0, 0, Resolution(leaf=leaf)) for leaf in (None, 0.03))
    # A mean is rounded, and may come to lie beyond its cell's edge.
    assert len(np.unique(np.floor(fused.points / 0.03), axis=0)) == pytest.approx(len(fused.points), rel=1e-3)
    inside = (np.floor(seen.points / 0.03) == np.floor(fused.points[100] / 0.03)).all(axis=1)
    values, counts = np.unique(seen.labels[inside], return_counts=True)
    assert np.allclose(seen.points[inside].mean(axis=0), fused.points[100], atol=1e-4)
    assert counts[values == fused.labels[100]] == counts.max()


def test_a_sparse_scan_has_so_many_points_of_the_whole(bare):
    room = bare[0]
    whole, sparse = (scan_room(room, 1, 1.0, 0, Resolution(points=points)) for points in (None, 4_000))
    assert len(sparse.points) == len(sparse.labels) == 4_000
    assert cKDTree(whole.points).query(sparse.points)[0].max() == 0


@pytest.mark.parametrize("wrong", [{"leaf": 0.0}, {"leaf": 1.0}, {"points": 3}])
def test_wrong_resolutions_are_refused(wrong):
    with pytest.raises(InputError, match="expected"):
        Resolution(**wrong)


def test_the_command_writes_lived_in_rooms(tmp_path):
    data = write_objects(tmp_path, ("desk", "seat", "mug", "tin"))
    kinds = "sills,stacks,clutter"
    words = ["rooms", data, tmp_path / "out", "--rooms", 1, "--views", 1, "--lived-in", kinds, "--points", 40_000]
    done = CliRunner().invoke(app, [str(word) for word in words])
    assert done.exit_code == 0, done.output
    with open(tmp_path / "out" / "room_01_instances.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["standing_on"] for row in rows if row["category"] == "window_sill"} == {"wall"}
