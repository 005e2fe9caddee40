"""Impaired copies: each change does what its name says, the same seed gives the same bits, and nothing is faked."""

from __future__ import annotations

import csv
import json
import pickle
import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import trimesh
from catalogues import household
from checkout import DATA
from objects_to_scan import slab_on_posts, write_objects
from typer.testing import CliRunner

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, cloud_from_points, load_cloud
from spherefunc_bullet.commands.command_line import main
from spherefunc_bullet.compare.evaluation import features, impaired, readings
from spherefunc_bullet.datasets.catalogue import COLUMNS, write_manifest
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning import function_classifier
from spherefunc_bullet.scenes.commands.dataset import app
from spherefunc_bullet.scenes.impairment.folder import COLUMNS as COPY_COLUMNS
from spherefunc_bullet.scenes.impairment.folder import copy_ply, impair_dataset, read_copies
from spherefunc_bullet.scenes.impairment.impairments import COPIES, IMPAIRMENTS, chosen_kinds
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.scenes.impairment.surfaces import ObjectSurface, halved

MODELS = DATA / "models"
FEATURES = {"spheres", "spheres, held up", "bounding_box", "occupancy", "occupancy_sqrt", "height_map"}
FEATURES |= {"points", "spheres, copies learnt", "points, copies learnt", "rules", "examiner"}
FEATURES |= {"spheres, copies learnt, this kind left out", "points, copies learnt, this kind left out"}
LOOKED_AT = [each for each in IMPAIRMENTS if each.kind in ("whole", "missing", "triangulation")]
RADIUS, HEIGHT, WALL, FLOOR = 0.04, 0.10, 0.004, 0.008  # of a plain cup, metres


def plain_cup() -> trimesh.Trimesh:
    """Return a cup turned on a lathe, its axis the z axis."""
    profile = [(0, 0), (RADIUS, 0), (RADIUS, HEIGHT), (RADIUS - WALL, HEIGHT), (RADIUS - WALL, FLOOR), (0, FLOOR)]
    return trimesh.creation.revolve(np.array(profile), sections=48)


def mug() -> trimesh.Trimesh:
    """Return the same cup with a handle to +x."""
    handle = trimesh.creation.torus(0.025, 0.005)
    handle.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    handle.apply_translation([RADIUS + 0.018, 0, 0.05])
    return trimesh.util.concatenate([plain_cup(), handle])


def armchair(arms: bool = True) -> trimesh.Trimesh:
    """Return a chair: a seat 45 cm high on posts, a back to +y, and two arms or none."""
    boxes = [((0.5, 0.05, 0.5), (0, 0.225, 0.7))]
    boxes += [((0.05, 0.3, 0.2), (x, -0.05, 0.55)) for x in (-0.225, 0.225)] if arms else []
    parts = [trimesh.creation.box(size) for size, _ in boxes]
    for part, (_, place) in zip(parts, boxes, strict=True):
        part.apply_translation(place)
    return trimesh.util.concatenate([slab_on_posts(0.5, 0.5, 0.45), *parts])


def specimen(mesh: trimesh.Trimesh, function: str) -> Specimen:
    return Specimen(cloud_from_mesh(mesh.vertices, mesh.faces), function)


def changed(target: Specimen, kind: str, seed: int = 0) -> ObjectSurface | None:
    """Return an impaired copy of one kind."""
    each = next(each for each in IMPAIRMENTS if each.kind == kind and target.function in each.functions)
    return each.applied(target, "object", seed)


def heights_on(surface: ObjectSurface, x: float, y: float) -> list[float]:
    """Return the heights at which a vertical line meets a surface, ascending."""
    corners = surface.triangles - [x, y, 0]
    ahead = np.roll(corners, -1, axis=1)
    side = corners[..., 0] * ahead[..., 1] - corners[..., 1] * ahead[..., 0]
    met = (side > 0).all(axis=1) | (side < 0).all(axis=1)
    weights = np.roll(side[met], -1, axis=1)  # of each corner: the area across from it
    return sorted(((weights * corners[met, :, 2]).sum(axis=1) / weights.sum(axis=1)).tolist())


AXIS = (0.0003, 0.0002)  # beside the axis by less than a millimetre, so that no edge is met


def test_a_line_meets_what_it_should():
    surface = specimen(plain_cup(), "cup").surface
    assert heights_on(surface, *AXIS) == pytest.approx([0, FLOOR])
    assert heights_on(surface, RADIUS - WALL / 2, 0.0003) == pytest.approx([0, HEIGHT])


def test_halves_cover_the_triangle_and_are_small():
    triangle = np.array([[[0, 0, 0], [1, 0, 0], [0.2, 0.01, 0.3]]], float)
    pieces, owners = halved(triangle, 0.05)
    area = np.linalg.norm(np.cross(pieces[:, 1] - pieces[:, 0], pieces[:, 2] - pieces[:, 0]), axis=1).sum()
    assert area == pytest.approx(np.linalg.norm(np.cross(triangle[0, 1], triangle[0, 2])))
    assert np.linalg.norm(pieces - np.roll(pieces, 1, axis=1), axis=2).max() <= 0.05 and not owners.any()


def test_the_cavity_of_a_cup_is_known():
    cavity = specimen(plain_cup(), "cup").cavity
    cell = cavity.grid.cell
    assert cavity.axis == pytest.approx([0, 0], abs=cell)
    assert cavity.floor == pytest.approx(FLOOR, abs=1e-6)
    assert cavity.brim == pytest.approx(HEIGHT, abs=HEIGHT / 40)
    assert cavity.radii == pytest.approx(RADIUS - WALL, abs=cell)  # the wall takes part of a ring of cells


@pytest.mark.slow
def test_a_hole_leaves_nothing_under_the_cavity():
    holed = changed(specimen(plain_cup(), "cup"), "hole")
    assert heights_on(holed, *AXIS) == []
    assert holed.bounds == pytest.approx(specimen(plain_cup(), "cup").surface.bounds)


def test_a_lid_is_met_first():
    lidded = changed(specimen(plain_cup(), "cup"), "lid")
    for x in (0, 0.02, RADIUS - 1.5 * WALL):
        assert heights_on(lidded, x + AXIS[0], AXIS[1])[-1] > HEIGHT


@pytest.mark.slow
def test_a_filling_reaches_the_brim_and_not_farther():
    filled = changed(specimen(plain_cup(), "cup"), "filled")
    assert heights_on(filled, *AXIS)[-1] == pytest.approx(HEIGHT, abs=HEIGHT / 40)
    assert filled.size == pytest.approx(specimen(plain_cup(), "cup").surface.size)


def test_a_slit_opens_the_wall_away_from_the_handle():
    slit = changed(specimen(mug(), "cup"), "slit")
    walls = slit.centres[np.abs(slit.centres[:, 2] - HEIGHT / 2) < 0.03]
    walls = walls[:, :2] - [slit.bounds[0, 0] + RADIUS, 0]  # from the cup's axis, which the handle has moved
    angles = np.sort(np.arctan2(walls[:, 1], walls[:, 0]))
    gaps = np.diff(np.append(angles, angles[0] + 2 * np.pi))
    middle = (angles + gaps / 2)[gaps.argmax()]
    assert gaps.max() > 0.3 and np.cos(middle) < np.cos(np.radians(20))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["upside_down", "on_side"])
def test_a_cup_that_is_turned_holds_nothing(kind):
    target = specimen(plain_cup(), "cup")
    assert Specimen(as_cloud(changed(target, kind)), "cup").cavity is None
    assert changed(target, kind).bounds[0, 2] == pytest.approx(0)


def as_cloud(surface: ObjectSurface) -> Cloud:
    return cloud_from_points(surface.points) if surface.is_cloud else cloud_from_mesh(*surface.mesh())


def test_a_handle_comes_off_and_the_cup_stays():
    bare = changed(specimen(mug(), "cup"), "no_handle")
    assert bare.size[:2] == pytest.approx([2 * RADIUS] * 2, rel=0.12)  # what is nearer than that is body
    assert Specimen(as_cloud(bare), "cup").cavity is not None


def test_what_is_not_there_is_not_taken_off():
    assert changed(specimen(plain_cup(), "cup"), "no_handle") is None
    assert changed(specimen(slab_on_posts(0.5, 0.5, 0.45), "sittable"), "no_arms") is None


def test_a_solid_block_is_no_cup():
    block = specimen(trimesh.creation.box((0.08, 0.08, 0.1)), "cup")
    assert block.cavity is None
    made = {each.kind for each in IMPAIRMENTS if "cup" in each.functions and each.applied(block, "block", 0)}
    assert made == {"whole", "smaller", "larger", "turned", "sensor", "triangulation"}


TABLE = (0.9, 0.6, 0.74)


def test_the_top_of_a_table_is_known():
    level = specimen(slab_on_posts(*TABLE), "table").level
    assert level.height == pytest.approx(TABLE[2]) and level.area == pytest.approx(0.54, rel=0.12)  # and a cell around


def test_a_table_without_its_top_is_legs():
    bare = changed(specimen(slab_on_posts(*TABLE), "table"), "missing")
    assert heights_on(bare, 0.013, 0.017) == [] and bare.size[:2] == pytest.approx([0.85, 0.55])
    assert bare.size[2] > 0.5 * TABLE[2]


def test_half_a_top_is_gone():
    target = specimen(slab_on_posts(*TABLE), "table")
    half = changed(target, "half")
    covered = [bool(heights_on(half, half.bounds[0, 0] + x, 0.013)) for x in (0.2, 0.6)]
    assert Specimen(as_cloud(half), "table").level.area == pytest.approx(target.level.area / 2, rel=0.15)
    assert sum(covered) == 1


def test_a_tilted_top_slopes():
    tilted = changed(specimen(slab_on_posts(*TABLE), "table"), "tilted")
    low, high = (max(heights_on(tilted, 0.013, y)) for y in (-0.1513, 0.1487))
    assert abs(high - low) / 0.3 == pytest.approx(np.tan(np.radians(35)), abs=1e-3)


def test_spikes_leave_no_level_place():
    spiky = changed(specimen(slab_on_posts(*TABLE), "table"), "spikes")
    tops = [max(heights_on(spiky, x, y)) for x in np.linspace(-0.3, 0.3, 40) for y in (0.0113, 0.0513)]
    assert min(tops) >= TABLE[2] - 0.011 and np.std(tops) > 0.02 and max(tops) > TABLE[2] + 0.08


def test_a_chair_of_the_catalogue_loses_its_seat():
    item = next(item for item in household() if item.category == "dining_chair")
    chair = specimen(item.mesh, "sittable")
    bare = changed(chair, "missing")
    middle = chair.level.box.mean(axis=0) + 0.003
    assert heights_on(chair.surface, *middle)[-1] == pytest.approx(chair.level.height, abs=0.06)
    assert not [height for height in heights_on(bare, *middle) if height > 0.35 * chair.level.height]


@pytest.mark.slow
@pytest.mark.parametrize("depth", [0.4, 1.2])
def test_gaps_are_wide_and_bars_stay(depth):
    bench = specimen(slab_on_posts(1.4, depth, 0.45), "sittable")
    gaps = changed(bench, "gaps")
    met = np.array([bool(heights_on(gaps, x, 0.013)) for x in np.linspace(-0.69, 0.69, 691)])
    edges = np.flatnonzero(np.diff(np.concatenate([[1], met, [1]])))
    assert (np.diff(edges)[::2] * 0.002 > 0.22).all() and len(edges) == 6 and met[[0, -1]].all()


def test_a_box_stands_on_the_seat():
    occupied = changed(specimen(armchair(), "sittable"), "occupied")
    assert heights_on(occupied, 0.013, 0.017)[-1] > 0.8


def test_arms_come_off_and_the_back_stays():
    chair = specimen(armchair(), "sittable")
    assert chair.back == pytest.approx([0, 1])
    bare = changed(chair, "no_arms")
    assert heights_on(bare, 0.22, -0.05)[-1] < 0.53 and heights_on(chair.surface, 0.22, -0.05)[-1] > 0.64
    assert bare.size == pytest.approx(chair.surface.size)


def test_a_chair_is_laid_on_its_back():
    chair = specimen(armchair(arms=False), "sittable")
    laid = changed(chair, "on_back")
    assert laid.size[[0, 2, 1]] == pytest.approx(chair.surface.size)
    back = laid.centres[:, 2] < 0.01
    assert np.ptp(laid.centres[back, 0]) > 0.4 and np.ptp(laid.centres[back, 1]) > 0.4


def test_a_cube_is_a_seat_any_way_round_so_it_is_left_out():
    pouf = specimen(trimesh.creation.box((0.45, 0.45, 0.45)), "sittable")
    assert changed(pouf, "upside_down") is None and changed(pouf, "on_back") is None
    assert changed(pouf, "missing") is not None


@pytest.mark.parametrize("seed", range(3))
def test_other_legs_keep_the_top(seed):
    target = specimen(slab_on_posts(*TABLE), "table")
    other = changed(target, "other_legs", seed)
    level = Specimen(as_cloud(other), "table").level
    assert level.height == pytest.approx(TABLE[2]) and level.area == pytest.approx(target.level.area, rel=0.02)
    assert not np.array_equal(other.bounds[0], target.surface.bounds[0]) or len(other.triangles) != 60


def test_below_a_round_top_no_legs_stand_at_corners():
    top, post = trimesh.creation.cylinder(0.5, 0.04), trimesh.creation.cylinder(0.04, 0.7)
    top.apply_translation([0, 0, 0.72])
    post.apply_translation([0, 0, 0.35])
    target = specimen(trimesh.util.concatenate([top, post]), "table")
    for seed in range(3):
        assert np.linalg.norm(changed(target, "other_legs", seed).vertices[:, :2], axis=1).max() < 0.501


def test_harmless_changes_keep_the_size_that_they_say():
    target = specimen(armchair(), "sittable")
    size = target.surface.size
    assert changed(target, "smaller").size == pytest.approx(0.9 * size)
    assert changed(target, "larger").size == pytest.approx(1.1 * size)
    assert changed(target, "triangulation").size == pytest.approx(size)
    assert changed(target, "turned").size[2] == pytest.approx(size[2])
    assert changed(target, "turned").size[:2].prod() != pytest.approx(size[:2].prod(), rel=0.01)
    seen = changed(target, "sensor")
    # 1.5 mm of noise: five deviations on either side hold all of some thousand points.
    assert seen.is_cloud and seen.size == pytest.approx(size, abs=0.015)


def test_another_triangulation_is_the_same_surface():
    target = specimen(slab_on_posts(*TABLE), "table")
    again = changed(target, "triangulation")
    assert len(again.triangles) == 3 * len(target.surface.triangles)
    assert heights_on(again, 0.013, 0.017) == pytest.approx(heights_on(target.surface, 0.013, 0.017))


def test_a_cloud_has_what_points_can_show():
    cloud = cloud_from_mesh(plain_cup().vertices, plain_cup().faces, max_gap=0.002)
    points = Specimen(cloud_from_points(cloud.points), "cup")
    kinds = {
        each.kind for each in IMPAIRMENTS if "cup" in each.functions and each.applied(points, "cup", 0) is not None
    }
    assert {"hole", "upside_down", "on_side", "turned", "smaller", "larger", "sensor"} <= kinds
    assert not {"lid", "filled", "triangulation"} & kinds


@pytest.mark.parametrize(
    "category", ["coffee_table", *(pytest.param(name, marks=pytest.mark.slow) for name in ("mug", "dining_chair"))]
)
@pytest.mark.slow
def test_every_kind_is_made_or_left_out_and_repeats_bit_for_bit(category):
    """Whatever was made of the object before: the second time they are made in the opposite order."""
    item = next(item for item in household() if item.category == category)
    kinds = [each for each in IMPAIRMENTS if item.label in each.functions]
    made = []
    for order in (kinds, kinds[::-1]):
        target = specimen(item.mesh, item.label)
        made.append({each.kind: each.applied(target, item.name, 3) for each in order})
    for each in kinds:
        first, again = (copies[each.kind] for copies in made)
        assert (first is None) == (again is None)
        if first is not None:
            assert copy_ply(first) == copy_ply(again)
            assert first.bounds[0, 2] == pytest.approx(0, abs=1e-9) and np.isfinite(first.vertices).all()


def test_another_seed_makes_another_copy():
    target = specimen(plain_cup(), "cup")
    assert not np.array_equal(changed(target, "turned", 0).triangles, changed(target, "turned", 1).triangles)


@pytest.fixture
def targets(tmp_path) -> Path:
    folder = tmp_path / "objects"
    folder.mkdir()
    return write_objects(folder, ("desk", "stand", "chest", "tin"))


@pytest.mark.slow
def test_the_folder_is_a_data_set_that_knows_its_originals(targets, tmp_path):
    copies = impair_dataset(open_dataset(targets), tmp_path / "copies", failed=pytest.fail)
    with copies.manifest.open() as stream:
        rows = list(csv.DictReader(stream))
    assert tuple(rows[0]) == COPY_COLUMNS and tuple(rows[0])[:5] == ("file", "label", "of", "kind", "works")
    assert {row["of"] for row in rows} == {"desk.ply", "stand.ply"}
    assert {row["of"] for row in rows if row["kind"] == "whole"} == {"desk.ply", "stand.ply"}
    assert all(row["label"] == ("table" if row["works"] == "1" else "none") for row in rows)
    assert all(row["group"] == "test" for row in rows)
    dataset = open_dataset(tmp_path / "copies")
    assert len(dataset) == len(rows) == sum(copies.made.values()) and dataset.functions == ("table",)
    for item in dataset.objects:
        assert load_cloud(item.path).bounds[0, 2] == pytest.approx(0)
    assert [copy.kind for copy in read_copies(tmp_path / "copies")] == [row["kind"] for row in rows]


@pytest.mark.slow
def test_same_seed_same_files_however_many_processes_make_them(targets, tmp_path):
    for folder, jobs in (("a", 1), ("b", 2)):
        impair_dataset(open_dataset(targets), tmp_path / folder, seed=5, jobs=jobs, failed=pytest.fail)
    files = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert files == sorted(path.name for path in (tmp_path / "b").iterdir())
    assert all((tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes() for name in files)


def test_every_kind_can_be_sent_to_another_process():
    assert [one.kind for one in pickle.loads(pickle.dumps(COPIES))] == [one.kind for one in COPIES]


@pytest.mark.slow
def test_bad_files_are_said_and_the_others_are_made(targets, tmp_path):
    (targets / "desk.ply").write_bytes(b"ply\nnot at all")
    result = CliRunner().invoke(app, ["impair", str(targets), str(tmp_path / "out"), "--kinds", "missing", "--json"])
    assert result.exit_code == 2 and len(result.stderr.strip().splitlines()) == 1 and "desk.ply" in result.stderr
    assert json.loads(result.stdout)["made"] == {"table whole": 1, "table missing": 1}


def test_a_kind_that_is_none_is_refused():
    with pytest.raises(InputError, match="expected some of whole, hole"):
        chosen_kinds(["holes"])


def test_nothing_to_impair_is_refused(tmp_path):
    dataset = open_dataset(write_objects(tmp_path, ("chest", "tin")))
    with pytest.raises(InputError, match="expected objects labelled cup, sittable, table"):
        impair_dataset(dataset, tmp_path / "out", failed=pytest.fail)


def test_a_folder_of_other_things_is_no_folder_of_copies(targets):
    with pytest.raises(InputError, match="columns of, kind and works"):
        read_copies(targets)


@pytest.fixture
def sources(tmp_path) -> Path:
    """Return a data set of two sources, each with two tables and two chests."""
    rows = []
    for source in ("here", "there"):
        for number, width in enumerate((0.8, 1.0)):
            grown = width + 0.05 * (source == "there")
            slab_on_posts(grown, 0.6, 0.74).export(tmp_path / f"{source}_table{number}.ply")
            trimesh.creation.box((grown / 2, 0.4, 0.3)).export(tmp_path / f"{source}_chest{number}.ply")
            rows.append((f"{source}_table{number}.ply", "table", "", "table", source))
            rows.append((f"{source}_chest{number}.ply", "none", "", "chest", source))
    write_manifest(tmp_path, COLUMNS, rows)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("grouped", [True, False])
def test_evaluate_impaired_prints_the_contract(sources, tmp_path, monkeypatch, capsys, grouped):
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(readings, "WORTH_CORES", 10**6)  # other processes take longer to start
    monkeypatch.setattr(features, "MANY", 10**6)
    if grouped:  # of all objects, the kinds of which the answers are looked at
        monkeypatch.setattr(impaired, "impair_dataset", partial(impair_dataset, impairments=LOOKED_AT))
    else:  # all kinds, of half of the objects: what forests say is not looked at
        monkeypatch.setattr(function_classifier, "TREES", 8)
        head, *rows = (sources / "manifest.csv").read_text().splitlines()
        (sources / "manifest.csv").write_text("\n".join([head, *(row for row in rows if row.endswith(",here"))]))
    command = ["evaluate", str(sources), "--impaired", "--radii", "5cm", "--train-sizes", "half", "--jobs", "1"]
    command += ["--trials", "1" if grouped else "2"]
    picture = tmp_path / "picture.png"
    command += [] if grouped else ["--copied", "1"]
    about = run_json(command + ([] if grouped else ["--picture", str(picture)]), monkeypatch, capsys)
    kinds = about["impaired"]["table"]
    assert list(about["impaired"]) == ["table"] and about["results"]
    assert picture.is_file() != grouped
    expected = LOOKED_AT if grouped else IMPAIRMENTS
    assert set(kinds) == {each.kind for each in expected if "table" in each.functions}
    for row in kinds.values():
        assert isinstance(row["works"], bool) and row["copies"] == (4 if grouped else 1)
        assert set(row["share"]) == FEATURES
        assert all(0 <= share <= 1 for share in row["share"].values())
    assert kinds["whole"]["share"]["rules"] == 1 and kinds["missing"]["share"]["rules"] == 0
    if grouped:
        # A sphere that balances on a post makes it a table to what has learnt two tables and two chests only.
        assert kinds["whole"]["share"]["spheres"] == kinds["whole"]["share"]["spheres, copies learnt"] == 1
        assert kinds["missing"]["share"]["spheres, copies learnt"] == 0
        assert kinds["triangulation"]["share"]["spheres"] == 1
    else:
        made = list((tmp_path / "cache" / "impaired").iterdir())
        assert run_json(command, monkeypatch, capsys)["impaired"] == about["impaired"]
        assert list((tmp_path / "cache" / "impaired").iterdir()) == made and len(made) == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--picture", "a.png"], "expected with --impaired"),
        (["--impaired", "--picture", "a.pdf"], "ends in .png or .svg"),
    ],
)
def test_a_picture_that_cannot_be_is_refused_at_once(sources, monkeypatch, capsys, options, words):
    monkeypatch.setattr("sys.argv", ["spherefunc", "evaluate", str(sources), *options])
    with pytest.raises(SystemExit) as stop:
        main()
    said = capsys.readouterr().err
    assert stop.value.code == 2 and words in said and len(said.strip().splitlines()) == 1


def run_json(command: list[str], monkeypatch, capsys) -> dict:
    """Return what a command prints as JSON."""
    monkeypatch.setattr("sys.argv", ["spherefunc", *command, "--json"])
    with pytest.raises(SystemExit) as stop:
        main()
    assert not stop.value.code
    return json.loads(capsys.readouterr().out)


def test_the_table_has_a_row_for_each_kind_and_the_means(capsys):
    from spherefunc_bullet.compare.evaluation.impaired import print_shares

    row = {"works": True, "copies": 2, "share": {"spheres": 0.5, "bounding_box": 1.0}}
    bad = replace_row(row, works=False, share={"spheres": 0.0, "bounding_box": 1.0})
    worse = replace_row(bad, share={"spheres": 0.5, "bounding_box": 0.0})
    print_shares({"cup": {"whole": row, "hole": bad, "lid": worse, "turned": row}})
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["cup,", "useless,", "mean", "no", "4", "0.25", "0.50"] in lines
    assert ["cup,", "harmless,", "mean", "yes", "2", "0.50", "1.00"] in lines


def replace_row(row: dict, **values) -> dict:
    return row | values


@pytest.mark.slow
@pytest.mark.skipif(not (MODELS / "manifest.csv").is_file(), reason="the models are not beside the repository")
def test_seats_and_tops_are_where_the_catalogue_says_things_come_to_rest():
    """Which is known of 57 objects, of which half are asked, and never an input.

    ``pytest -s`` prints how far off the finder is.
    """
    errors = []
    with (MODELS / "manifest.csv").open(newline="", encoding="utf-8") as file:
        furniture = [row for row in csv.DictReader(file) if row["label"] in ("sittable", "table")]
    stated = [(row, re.search(r"dropOnTopElevation ([\d.]+) cm", row["notes"])) for row in furniture]
    for row, known in [(row, known) for row, known in stated if known][::2]:
        cloud = load_cloud(MODELS / row["file"], max_gap=0.02)  # of which the mesh alone is looked at
        level = Specimen(cloud, row["label"]).level
        errors.append(np.inf if level is None else abs(level.height - float(known[1]) / 100))
    near = sum(error < 0.05 for error in errors)
    print(f"{near} of {len(errors)} within 5 cm, the median within {1000 * np.median(errors):.0f} mm")
    assert len(errors) > 25 and near / len(errors) > 0.9 and np.median(errors) < 0.01
