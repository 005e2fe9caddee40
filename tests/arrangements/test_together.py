"""Several objects together: who carries what, and what one takes from another, against areas that are known."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from objects_to_scan import slab_on_posts
from PIL import Image

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, load_cloud
from spherefunc_bullet.commands.command_line import main
from spherefunc_bullet.datasets.catalogue import built_catalogue
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.arrangements.falls import NO_OWNER, drops_over, falls_on, united
from spherefunc_bullet.scenes.arrangements.levels import crossing, level_of
from spherefunc_bullet.scenes.arrangements.placing import Placement, parse_placed
from spherefunc_bullet.scenes.arrangements.supports import GROUND, require_carried, tips_by
from spherefunc_bullet.scenes.arrangements.together import TogetherSettings, notes_on, put_down
from spherefunc_bullet.simulator import DropSettings, make_simulator
from spherefunc_bullet.viewer.pictures import CameraView

HEIGHT = 0.75  # of the table, metres
TOP = (1.2, 0.8)
BOX = (0.3, 0.4, 0.2)


@pytest.fixture(scope="module", params=["fast", "bullet"])
def simulator(request):
    try:
        return make_simulator(request.param)
    except InputError as error:
        pytest.skip(str(error))


def cloud_of(mesh: trimesh.Trimesh, name: str) -> Cloud:
    return cloud_from_mesh(mesh.vertices, mesh.faces, name)


def table() -> Cloud:
    return cloud_of(slab_on_posts(*TOP, HEIGHT), "table")


def box(*extents: float) -> Cloud:
    return cloud_of(trimesh.creation.box(extents), "box")


def box_on_table(**place: float):
    return put_down([table(), box(*BOX)], [Placement(), Placement(**{"x": 0.2, "y": 0.1, **place})])


def drops_on_all(objects: list, simulator, settings: DropSettings, seed: int):
    clouds = [item.cloud for item in objects]
    return falls_on(clouds, united(clouds, "both"), simulator, settings, seed)[1]


def household(name: str) -> Path:
    return built_catalogue("household").parent / f"{name}.ply"


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("mug.ply", Placement()),
        ("mug.ply@0.1,-0.2", Placement(x=0.1, y=-0.2)),
        ("a@b.ply@1,2,0.72", Placement(x=1, y=2, z=0.72)),
        ("mug.ply@1,2,,45", Placement(x=1, y=2, heading_deg=45)),
    ],
)
def test_a_placement_is_read(text, place):
    assert parse_placed(text)[1] == place
    assert str(parse_placed(text)[0]).endswith(".ply")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("mug.ply@0,0,0,east", "got 'east' for a number"),
        ("mug.ply@0.1", "got 1 numbers"),
        ("mug.ply@0,0,0,0,0", "got 5 numbers"),
        ("mug.ply@0,0,nan", "z: expected at least 0 and at most .*, got nan"),
        ("mug.ply@0,0,-0.1", "z: expected at least 0"),
    ],
)
def test_a_placement_that_is_none_is_said(text, said):
    with pytest.raises(InputError, match=said) as caught:
        parse_placed(text)
    assert str(caught.value).startswith(text) and "\n" not in str(caught.value)


@pytest.mark.parametrize("heading", [0.0, 30.0, 90.0])
def test_a_box_is_set_down_on_the_table_below_it_and_beside_it_on_the_ground(heading):
    placed = put_down(
        [table(), box(*BOX), box(*BOX)],
        [Placement(), Placement(heading_deg=heading), Placement(x=1.5, heading_deg=heading)],
    )
    assert [item.height for item in placed] == pytest.approx([0, HEIGHT, 0], abs=1e-6)
    feet = [require_carried(item, [other for other in placed if other is not item]) for item in placed]
    assert feet[1].carriers(["table", "other"]) == ("table",) and feet[2].carriers(["table", "other"]) == (GROUND,)


def test_things_are_stacked_in_the_order_in_which_they_come():
    placed = put_down([table(), box(*BOX), box(0.1, 0.1, 0.1)], [Placement()] * 3)
    assert placed[2].height == pytest.approx(HEIGHT + BOX[2], abs=1e-6)
    assert [item.name for item in placed] == ["table", "box (1)", "box (2)"]


def test_what_nothing_carries_is_said():
    placed = box_on_table(z=1.0)
    with pytest.raises(InputError, match="got nothing for 25 cm below it; leave its height out"):
        require_carried(placed[1], placed[:1])


@pytest.mark.parametrize(("x", "beyond"), [(0.0, -0.15), (0.55, -0.05), (0.65, 0.05)])
def test_what_stands_over_the_edge_tips(x, beyond):
    placed = box_on_table(x=x, y=0.0)
    feet = require_carried(placed[1], placed[:1])
    assert tips_by(placed[1], feet) == pytest.approx(beyond, abs=0.006)  # samples of the surface are 5 mm apart


def test_what_stands_on_an_object_may_tip_it():
    """A plank whose own weight is above its support, with a box at its end that is not."""
    plank = cloud_of(trimesh.creation.box((0.4, 0.1, 0.02)), "plank")
    placed = put_down(
        [box(0.2, 0.2, 0.2), plank, box(0.1, 0.1, 0.1)], [Placement(), Placement(x=0.08), Placement(x=0.24)]
    )
    feet = [require_carried(item, [other for other in placed if other is not item]) for item in placed]
    areas = np.array([2 * (0.4 * 0.1 + 0.4 * 0.02 + 0.1 * 0.02), 6 * 0.1**2])
    beyond = areas @ [0.08, 0.24] / areas.sum() - 0.1
    assert tips_by(placed[1], feet[1]) < 0 and tips_by(placed[1], feet[1], [placed[2]]) == pytest.approx(
        beyond, abs=0.006
    )
    (note,) = notes_on(placed, feet)
    assert note.startswith("plank would tip under box (2): their weight acts ")


@pytest.mark.parametrize(
    ("place", "crosses"),
    [
        ({"z": HEIGHT}, False),  # touches
        ({"z": HEIGHT - 0.1}, True),
        ({"z": HEIGHT - 0.005}, True),
        ({"x": 1.5, "z": 0.0}, False),  # beside
        ({"x": 0.0, "y": 0.0, "z": 0.0}, False),  # wholly below the top, between the legs
        ({"x": 0.55, "y": 0.35, "z": 0.0}, True),  # through a leg
    ],
)
def test_things_that_interpenetrate_are_told_from_those_that_touch(place, crosses):
    below, above = box_on_table(**place)
    assert (crossing(below, above) is not None) == (crossing(above, below) is not None) == crosses


def test_a_sphere_belongs_to_what_is_under_it_and_not_to_what_it_leans_on(simulator):
    placed, radius = put_down([box(0.5, 0.6, HEIGHT), box(*BOX)], [Placement(), Placement(heading_deg=90.0)]), 0.02
    run = DropSettings(radius=radius, miss_limit=300, max_drops=300)
    falls = [drops_on_all(placed, simulator, run, seed) for seed in range(3)]
    centers, owners = (np.concatenate([getattr(part, name) for part in falls]) for name in ("centers", "owners"))
    height = centers[:, 2] - radius
    on_table, on_box = np.abs(height - HEIGHT) < 0.003, np.abs(height - HEIGHT - BOX[2]) < 0.003
    aside = np.abs(centers[:, :2] - placed[1].shift[:2]) - np.array(BOX[1::-1]) / 2
    leaning = on_table & (aside.max(axis=1) < 1.1 * radius)
    assert on_table.sum() > 100 and on_box.sum() > 100 and leaning.sum() > 5
    assert (owners[on_table] == 0).all() and (owners[on_box] == 1).all()
    assert (owners[~np.isnan(centers[:, 0])] != NO_OWNER).all()


def test_a_sphere_on_spheres_belongs_to_who_carries_those(simulator):
    """A tray with a rim, on a table: what lies above its floor is the tray's, however deep."""
    walls = [((0.3, 0.01, 0.08), (0, 0.145)), ((0.3, 0.01, 0.08), (0, -0.145))]
    walls += [((0.01, 0.3, 0.08), (0.145, 0)), ((0.01, 0.3, 0.08), (-0.145, 0))]
    parts = [trimesh.creation.box((0.3, 0.3, 0.01))]
    for extents, (x, y) in walls:
        parts.append(trimesh.creation.box(extents))
        parts[-1].apply_translation([x, y, 0.035])
    placed = put_down([table(), cloud_of(trimesh.util.concatenate(parts), "tray")], [Placement(), Placement()])
    settings = DropSettings(radius=0.015, miss_limit=400, max_drops=400)
    falls = drops_over(placed, 1, simulator, settings, [0])
    inside = (np.abs(falls.centers[:, :2]) < 0.14).all(axis=1)
    assert falls.upon[inside].sum() > 20
    assert (falls.owners[inside] == 1).all()
    assert np.median(falls.bases[inside]) == pytest.approx(HEIGHT + 0.01, abs=0.002)


@pytest.mark.slow
def test_a_box_takes_its_footprint_from_the_table(simulator):
    placed, drops = box_on_table(heading_deg=30.0), 1000
    level, top, foot = level_of(placed, 0, simulator, None, drops, 0), math.prod(TOP), math.prod(BOX[:2])
    spread = 3 * math.sqrt(foot / top * (1 - foot / top) / drops)  # three standard deviations of the share
    assert level.height == pytest.approx(HEIGHT, abs=0.002)
    assert level.taken["box"] / top == pytest.approx(foot / top, abs=spread)
    assert level.left == pytest.approx(1 - foot / top, abs=2 * spread)  # both of its areas are counted
    # The roller lets go of spheres within some 2 cm of the edge, where samples end.
    assert 0.92 * top < level.alone < 1.01 * top


@pytest.mark.slow
def test_points_alone_do_as_well_as_meshes():
    placed = [replace(item, own=Cloud(item.own.points, item.name)) for item in box_on_table()]
    assert require_carried(placed[1], placed[:1]).carriers(["table"]) == ("table",)
    level = level_of(placed, 0, make_simulator("fast"), None, 500, 0)
    assert level.left == pytest.approx(1 - math.prod(BOX[:2]) / math.prod(TOP), abs=0.08)  # as above, of 500 drops


def test_what_stands_on_top_keeps_its_own_level(simulator):
    level = level_of(box_on_table(), 1, simulator, None, 500, 0)
    assert level.height == pytest.approx(HEIGHT + BOX[2], abs=0.002)
    assert level.left == pytest.approx(1, abs=0.06)  # three standard deviations of 500 drops


@pytest.mark.slow
def test_a_chair_under_a_table_is_no_seat_until_it_is_pulled_out():
    chair, top = load_cloud(household("dining_chair_01")), table()
    settings = TogetherSettings(drops=300)

    def seat(y: float, z: float | None = 0.0):
        placement = Placement(x=0.0, y=y, z=z, heading_deg=180.0)
        return sf.together([(top, Placement()), (chair, placement)], settings=settings).objects

    (_, under), (table_, beside) = seat(-0.2), seat(-1.2)
    assert beside.lost == () and beside.together["sittable"].member and beside.level.left > 0.9
    assert under.lost == ("sittable",) and under.level.left < 0.2
    assert under.level.taken["table"] > 0.5 * under.level.alone
    assert table_.together == table_.alone  # nothing is near the table: the same bits


@pytest.mark.slow
def test_a_mug_on_a_table_stays_a_mug_and_the_table_a_table():
    found = sf.together(
        [(household("dining_table_02"), Placement()), (household("mug_01"), Placement(x=0.1, y=0.2))],
        settings=TogetherSettings(drops=300),
    )
    table_, mug = found.objects
    assert mug.stands_on == ("dining_table_02.ply",) and table_.stands_on == (GROUND,)
    assert mug.together["cup"].member and table_.together["table"].member and found.notes == ()


@pytest.mark.slow
def test_no_heading_takes_a_table_its_function():
    """Nor does the frame in which its file has it: spheres fall on its top, not on a box around its corners."""
    own = cloud_of(slab_on_posts(*TOP, HEIGHT).apply_transform(rotation_about_z(45.0)), "table")
    for placement in (Placement(), Placement(heading_deg=-28.0)):
        found = sf.together([(own, placement), (household("mug_01"), Placement(x=0.1, y=0.2))])
        assert found.objects[0].lost == () and found.objects[0].alone["table"].member
        assert 0.92 * math.prod(TOP) < found.objects[0].level.alone < 1.01 * math.prod(TOP)


def rotation_about_z(angle_deg: float) -> np.ndarray:
    return trimesh.transformations.rotation_matrix(math.radians(angle_deg), [0, 0, 1])


@pytest.mark.slow
def test_the_same_seed_gives_the_same_bits(simulator):
    placed = box_on_table()
    first, again = (level_of(placed, 0, simulator, 0.03, 100, 0) for _ in range(2))
    other = level_of(placed, 0, simulator, 0.03, 100, 1)
    assert first == again and first != other


def test_moving_all_things_changes_no_owner():
    there = box_on_table()
    moved = [replace(item, placement=replace(item.placement, x=item.placement.x + 2.0)) for item in there]
    settings, fast = DropSettings(radius=0.02, miss_limit=300, max_drops=300), make_simulator("fast")
    owners = [np.bincount(drops_on_all(objects, fast, settings, 0).owners + 1) for objects in (there, moved)]
    # The same columns, but for the last digits of where they are, on which a sphere at an edge may depend.
    assert np.abs(owners[0] - owners[1]).max() <= 3


def test_one_thing_alone_is_no_company():
    with pytest.raises(InputError, match="at least two objects"):
        sf.together([(table(), Placement())])


@pytest.fixture
def run(monkeypatch, capsys):
    def call(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["spherefunc", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capsys.readouterr()
        return ended.value.code or 0, out, err

    return call


@pytest.mark.parametrize("backend", ["fast", pytest.param("bullet", marks=pytest.mark.slow)])
def test_the_command_prints_json(backend, run):
    if backend == "bullet":
        pytest.importorskip("pybullet", reason="PyBullet is not installed")
    table_file, mug = household("cafe_table_01"), household("mug_02")
    code, out, _ = run("together", table_file, f"{mug}@0.1,0", "--drops", 100, "--backend", backend, "--json")
    found = json.loads(out)
    assert code == 0 and found["notes"] == []
    assert [one["file"] for one in found["objects"]] == [str(table_file), str(mug)]
    assert found["objects"][1]["stands_on"] == ["cafe_table_01.ply"]
    assert found["objects"][1]["place"][2] == pytest.approx(load_cloud(table_file).size[2], abs=0.005)
    assert found["objects"][0]["functions"]["table"]["together"]["member"]
    assert 0 < found["objects"][0]["level"]["together"] <= 1.1 * found["objects"][0]["level"]["alone"]
    assert found["drop"]["drops"] == found["drop"]["settled"] + found["drop"]["rolled_off"]


@pytest.mark.parametrize(
    ("places", "said"),
    [
        ([""], "at least two files"),
        (["", "@0,0,3"], "got nothing for"),
        (["", "@0,0,0,north"], "'north'"),
    ],
)
def test_the_command_says_what_is_wrong_in_one_line(places, said, run):
    files = [f"{household('cafe_table_01')}{place}" for place in places]
    code, _, err = run("together", *files, "--drops", 100)
    lines = [line for line in err.splitlines() if line.startswith("spherefunc:")]
    assert code == 2 and len(lines) == 1 and said in lines[0]


@pytest.mark.slow
def test_the_command_draws_and_says_that_things_interpenetrate(run, tmp_path, monkeypatch):
    monkeypatch.setattr("spherefunc_bullet.scenes.arrangements.picture.VIEW", CameraView(size=(180, 135)))
    file, picture, page = household("cafe_table_01"), tmp_path / "both.png", tmp_path / "both.html"
    drawn = ("--picture", picture, "--page", page)
    code, _, err = run("together", file, f"{file}@0.1,0,0", "--drops", 50, *drawn)
    assert code == 0 and "cafe_table_01.ply (2) and cafe_table_01.ply (1) interpenetrate" in err
    assert Image.open(picture).size[0] > 170 and "cafe_table_01.ply" in page.read_text()


@pytest.mark.parametrize(
    "objects", [None, ["mug.obj", "table.obj"], [("mug.obj", Placement()), ("table.obj", None)], 3]
)
def test_what_stands_nowhere_is_refused(objects):
    with pytest.raises(InputError, match="expected a (list of pairs|Placement)"):
        sf.together(objects)
