"""Shapes: what a collision shape keeps, by truths that follow from geometry."""

import json
import os
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from objects_to_scan import slab_on_posts
from typer.testing import CliRunner

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.shapes import library, spaces, spheres
from spherefunc_bullet.shapes.candidates import of_hull, of_mesh
from spherefunc_bullet.shapes.compared import candidate_rows
from spherefunc_bullet.shapes.comparison import KeepCriteria, Subject, row_of
from spherefunc_bullet.shapes.loaded import FileFrame, load_solids
from spherefunc_bullet.shapes.solid import of_pieces, surface

RADIUS, HEIGHT, WALL, BOTTOM, STAVES = 0.04, 0.09, 0.003, 0.004, 32


def cup() -> trimesh.Trimesh:
    """A cup that holds 0.04² π 0.086 m3, of 32 sides."""
    profile = [
        [0, 0],
        [RADIUS + WALL, 0],
        [RADIUS + WALL, HEIGHT],
        [RADIUS, HEIGHT],
        [RADIUS, BOTTOM],
        [0, BOTTOM],
    ]
    return trimesh.creation.revolve(np.array(profile), sections=STAVES)


def staves() -> list[np.ndarray]:
    """The same cup cut into convex pieces: its bottom, and a stave for each side."""
    angles = np.arange(STAVES) * 2 * np.pi / STAVES
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    bottom = np.vstack([np.column_stack([(RADIUS + WALL) * ring, np.full(STAVES, z)]) for z in (0, BOTTOM)])
    sides = []
    for n in range(STAVES):
        ends = ring[[n, (n + 1) % STAVES]]
        corners = [np.column_stack([r * ends, np.full(2, z)]) for r in (RADIUS, RADIUS + WALL) for z in (0, HEIGHT)]
        sides.append(np.vstack(corners))
    return [bottom, *sides]


@pytest.fixture(scope="module", autouse=True)
def fewer_timed_steps():
    """How long a step takes is not looked at here."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(spheres, "STEPS", 8)
        yield


@pytest.fixture(scope="module")
def subject() -> Subject:
    mesh = cup()
    return Subject(cloud_from_mesh(mesh.vertices, mesh.faces, "cup"))


def held_by(polygon_radius: float) -> float:
    """Millilitres of a prism of 32 sides as high as the cup is deep."""
    return 1e6 * STAVES / 2 * np.sin(2 * np.pi / STAVES) * polygon_radius**2 * (HEIGHT - BOTTOM)


def test_a_cup_holds_what_its_geometry_says(subject):
    assert 1e6 * subject.capacity == pytest.approx(held_by(RADIUS), rel=0.04)  # cells of 0.8 mm at the brim


@pytest.mark.slow
def test_its_hull_is_solid(subject):
    row = row_of(subject, of_pieces("hull", [subject.mesh.vertices]), KeepCriteria())
    assert row.capacity_kept == 0 and not row.keeps and row.settled_kept < 0.5
    assert row.filled and "solid for the engine" in row.verdict


@pytest.mark.slow
def test_a_cup_with_a_slit_in_its_floor_runs_out_and_is_not_solid(subject):
    """Its floor is two halves, 6 mm apart, through which the spheres of the test do not go."""
    bottom, *sides = staves()
    halves = [np.column_stack([np.maximum(side * bottom[:, 0], 0.003) * side, bottom[:, 1:]]) for side in (1, -1)]
    row = row_of(subject, of_pieces("slit", [*halves, *sides]), KeepCriteria())
    assert row.capacity_kept < 0.02 and not row.filled
    assert "it runs out through gaps" in row.verdict and "solid" not in row.verdict


@pytest.mark.slow
def test_a_shape_of_voxels_is_still_a_cup(subject):
    """Water finds a way between its faces; the spheres that it is made for do not."""
    from spherefunc_bullet.shapes.candidates import of_cloud

    row = row_of(subject, of_cloud(subject.cloud, subject.radius, "voxel", 0.001), KeepCriteria())
    assert row.functions["cup"][0] and row.capacity_kept > 0.95, row.verdict
    assert row.capacity_ml == pytest.approx(held_by(RADIUS), rel=0.05)  # not the room inside its walls of voxels


@pytest.mark.slow
def test_a_wall_with_gaps_for_thin_water_alone_is_not_extrapolated_below_zero(subject):
    """Gaps of 2 mm between the sides: walls two cells thick leak, walls four cells thick hold."""
    bottom, *sides = staves()
    apart = [side.mean(axis=0) + (side - side.mean(axis=0)) * [0.72, 0.72, 1.0] for side in sides]
    space = subject.space.grid.free_space(of_pieces("gaps", [bottom, *apart]))
    thick = space.standing_of(2 * spaces.WALL)
    assert 2 * space.standing.sum() < thick.sum() and 0 <= space.capacity < 0.1 * subject.capacity


@pytest.mark.slow
def test_the_best_is_written_where_its_file_has_it(tmp_path):
    mesh = slab_on_posts(0.4, 0.4, 0.45).apply_translation([1.0, -2.0, 0.5])
    mesh.export(tmp_path / "stool.obj")
    shapes = sf.compare_shapes(tmp_path / "stool.obj", shapes=False)
    path = shapes.best.write(tmp_path / "out" / "stool.urdf")
    assert shapes.best.row.keeps and shapes.best.solid.count > 4  # a seat and its legs, not a hull
    solid = next(load_solids(path, FileFrame(up="z", units="m", shift=np.zeros(3))))
    assert np.allclose(solid.vertices.min(axis=0), mesh.bounds[0], atol=1e-3)
    assert np.allclose(solid.vertices.max(axis=0), mesh.bounds[1], atol=1e-3)
    assert np.allclose(trimesh.load(tmp_path / "out" / "stool_meshes" / "visual.obj").bounds, mesh.bounds, atol=1e-6)
    center = [float(number) for number in ElementTree.parse(path).find("link/inertial/origin").get("xyz").split()]
    assert np.allclose(center[:2], [1.0, -2.0], atol=1e-3) and 0.5 < center[2] < 0.95


def test_the_best_is_never_written_among_the_files_that_are_asked_about(tmp_path):
    from spherefunc_bullet.commands.shapes import folder_kept_below, require_apart
    from spherefunc_bullet.shapes.library import LibraryOptions

    def places(files, out):
        options = LibraryOptions(best="urdf", out=out, root=folder_kept_below(files))
        require_apart(files, options)
        return [options.best_file(file) for file in files]

    files, out = [tmp_path / "mugs" / "mug.obj", tmp_path / "cups" / "cup.obj"], tmp_path / "out"
    assert places(files, out) == [out / "mug.urdf", out / "cup.urdf"]
    alike = [*files, tmp_path / "cups" / "mug.obj"]  # as in libraries of folders with a model.obj each
    assert places(alike, out) == [out / "mugs" / "mug.urdf", out / "cups" / "cup.urdf", out / "cups" / "mug.urdf"]
    for some, refused in ((files, tmp_path / "mugs"), (files, out / ".." / "cups"), (alike, tmp_path)):
        with pytest.raises(InputError, match="expected --out of another folder"):
            places(some, refused)
    with pytest.raises(InputError, match="files of different names"):
        places([*files, tmp_path / "mugs" / "mug.stl"], out)


@pytest.mark.parametrize("option", [["--out", "x"], ["--format", "sdf"], ["--static"]])
def test_what_is_said_of_the_best_is_refused_without_it(option):
    done = CliRunner().invoke(application("shapes"), ["shapes", "mug.obj", *option])
    assert str(done.exception) == f"{option[0]}: expected with --best"


def test_a_missing_coacd_is_said_before_anything_is_measured(subject, monkeypatch):
    from spherefunc_bullet.shapes import candidates

    monkeypatch.setattr(candidates, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="shape 'coacd' needs its package"):
        candidates.candidates(subject.cloud, 0.005, coacd=(0.05,))
    assert not any(name.startswith("coacd") for name in candidates.candidates(subject.cloud, 0.005))


@pytest.mark.parametrize("threshold", [0.0, -0.1, 1.5, np.nan, "0.1"])
def test_a_threshold_that_ends_coacd_or_never_ends_it_is_refused(subject, monkeypatch, threshold):
    from spherefunc_bullet.shapes import candidates

    monkeypatch.setattr(candidates, "find_spec", lambda name: name)
    with pytest.raises(InputError, match="coacd: expected .*at least 0.01 and at most 1, got"):
        candidates.candidates(subject.cloud, 0.005, coacd=threshold)


def test_pieces_of_coacd_have_few_corners():
    """Those of a ball have 160 of its 162 otherwise."""
    from spherefunc_bullet.shapes.candidates import of_coacd

    pytest.importorskip("coacd")
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.1)
    solid = of_coacd(cloud_from_mesh(ball.vertices, ball.faces, "ball"), 0.5)
    assert [len(piece) for piece in solid.pieces] == [64]
    assert np.allclose(np.ptp(solid.vertices, axis=0), 0.2, atol=0.01)


def test_coacd_is_refused_where_no_shapes_are_made():
    done = CliRunner().invoke(application("shapes"), ["shapes", "mug.obj", "--only-collision", "--coacd", "0.1"])
    assert str(done.exception) == "--coacd: expected without --only-collision"


def pid(file, options) -> dict:
    """Return the process in which an object is compared, in place of the result."""
    return {"file": str(file), "process": os.getpid()}


def test_coacd_does_not_run_in_the_process_that_ctrl_c_ends(monkeypatch):
    monkeypatch.setattr(library, "library_result", pid)
    for coacd, here in (((), True), ((0.05,), False)):
        [result] = library.library_results([Path("mug.obj")], library.LibraryOptions(coacd=coacd))
        assert (result["process"] == os.getpid()) is here


@pytest.mark.slow
def test_a_candidate_that_no_engine_takes_costs_itself(subject):
    points = Cloud(subject.mesh.vertices, "points")
    said, makes = [], {"points": partial(of_mesh, points), "hull": partial(of_hull, subject.cloud)}
    rows = [row for _, row in candidate_rows(subject, makes, KeepCriteria(), said.append)]
    assert [row.name for row in rows] == ["hull"]
    assert said == ["points: expected a mesh to make shapes of, got points; it is not compared"]


def test_links_much_smaller_than_the_object_are_named_in_one_line(subject, monkeypatch):
    """As a robot's are; it is no sign of a wrong unit."""
    from spherefunc_bullet.shapes import compared

    monkeypatch.setattr(compared, "row_of", lambda subject, link, criteria: link.name)
    whole = subject.cloud.mesh.vertices
    links, said = [of_pieces(name, [whole * size]) for name, size in [("a", 1), ("b", 0.3), ("c", 0.1)]], []
    rows = [row for _, row in compared.rows_of_links(subject, links, KeepCriteria(), said.append)]
    assert rows == ["all links", "a"]
    assert said == [f"{subject.cloud.name}: links much smaller than the object have no row: b, c"]


def test_without_vhacd_everything_else_is_compared(subject, monkeypatch):
    from spherefunc_bullet.shapes import candidates

    monkeypatch.setattr(candidates, "has_vhacd", lambda: False)
    names = set(candidates.candidates(subject.cloud, 0.005))
    monkeypatch.undo()
    assert {"mesh", "compound", "hull"} < names and not any(name.startswith("vhacd") for name in names)
    assert {name.split()[0] for name in candidates.candidates(subject.cloud, 0.005)} >= {"vhacd"}  # it is installed


@pytest.mark.slow
def test_no_shape_of_the_table_that_keeps_everything_is_cheaper_than_the_best(subject, monkeypatch):
    """Of shapes that were found by a search; here by one that finds staves at once."""
    from dataclasses import replace

    from spherefunc_bullet.shapes import compared
    from spherefunc_bullet.shapes.compared import STRICT, best_shape

    found = [[("staves", lambda: of_pieces("staves", staves()))]]
    monkeypatch.setattr(compared, "kinds", lambda *_: found)
    solid, row = best_shape(subject, STRICT)
    monkeypatch.setattr(compared, "row_of", lambda *_, **__: row)  # measured once: the staves are the same each time
    other = replace(solid, name="vhacd 32")
    cheap, dear = (replace(row, name="vhacd 32", step_us=row.step_us * times) for times in (0.5, 2.0))
    assert best_shape(subject, STRICT, compared=[(other, cheap)])[0] is other
    assert best_shape(subject, STRICT, compared=[(other, dear)])[0] is not other
    assert best_shape(subject, STRICT, compared=[(other, replace(cheap, level_kept=0.5))])[0] is not other
    own = replace(solid, name="base_link")  # the collision shape of the object's own file
    assert best_shape(subject, STRICT, compared=[(own, cheap)])[0] is own
    compound = replace(solid, name="compound")
    assert best_shape(subject, STRICT, compared=[(compound, cheap)])[0].name == "staves"
    lossy = replace(row, level_kept=0.5, keeps=False)
    with monkeypatch.context() as patched:
        patched.setattr(compared, "row_of", lambda *_, **__: lossy)
        assert best_shape(subject, STRICT, compared=[(compound, cheap)])[0] is compound
    untimed = replace(row, step_us=np.nan)  # as of a ball, on which no spheres rest
    assert (
        compared.costs((solid, row))
        < compared.costs((solid, untimed))
        < compared.costs((replace(solid, vertices=np.zeros((999, 3))), untimed))
    )


def test_a_hull_that_is_written_has_few_corners():
    from spherefunc_bullet.shapes.compared import kinds

    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.1)
    hulls = next(kinds(Subject(cloud_from_mesh(ball.vertices, ball.faces, "ball")), bool, still=False))
    assert [(name, len(make().vertices)) for name, make in hulls] == [("hull", 64), ("hull", 162)]  # all if they must


@pytest.mark.slow
def test_exact_pieces_keep_everything(subject):
    row = row_of(subject, of_pieces("staves", staves()), KeepCriteria())
    assert row.keeps, row.verdict
    assert row.capacity_kept == pytest.approx(1, abs=0.01) and row.moved_mm < 0.2 and row.pieces == STAVES + 1


def test_the_mesh_keeps_everything(subject):
    row = row_of(subject, subject.mesh, KeepCriteria())
    assert row.keeps and row.capacity_kept == 1 and row.level_kept == 1 and row.openings_closed == 0


def test_a_closed_box_holds_nothing():
    box = trimesh.creation.box([0.1, 0.1, 0.1])
    assert Subject(cloud_from_mesh(box.vertices, box.faces, "box")).capacity == 0


@pytest.mark.slow
def test_a_lowered_top_is_lost():
    top = trimesh.creation.box([1.0, 0.7, 0.03])
    top.apply_translation([0, 0, 0.7])
    feet = [(x, y) for x in (-0.45, 0.45) for y in (-0.3, 0.3)]
    legs = [trimesh.creation.box([0.05, 0.05, 0.7]).apply_translation([x, y, 0.35]) for x, y in feet]
    table = trimesh.util.concatenate([top, *legs])
    subject = Subject(cloud_from_mesh(table.vertices, table.faces, "table"))
    moved = [top.vertices - [0, 0, 0.02], *(leg.vertices - [0, 0, 0.02] for leg in legs)]
    pieces = [piece + subject.mesh.vertices.min(axis=0) - table.vertices.min(axis=0) for piece in moved]
    row = row_of(subject, of_pieces("lower", pieces), KeepCriteria())
    assert not row.keeps and row.level_higher_mm == pytest.approx(-20, abs=1)
    filled = row_of(subject, of_pieces("hull", [subject.mesh.vertices]), KeepCriteria())
    assert filled.openings_closed and not filled.keeps


def test_another_unit_is_said(subject):
    with pytest.raises(InputError, match=" 1,000 times as large"):
        row_of(subject, surface("mm", 1000 * subject.mesh.vertices, subject.mesh.faces), KeepCriteria())


def test_groups_are_loaded_as_hulls(tmp_path: Path):
    lines, first = [], 1
    for number, piece in enumerate(staves()):
        lines += [f"o {number}", *(f"v {x} {y} {z}" for x, y, z in piece)]
        lines += [f"f {first} {first + k} {first + k + 1}" for k in range(1, len(piece) - 1)]
        first += len(piece)
    path = tmp_path / "cup.obj"
    path.write_text("\n".join(lines))
    solid = next(load_solids(path, FileFrame(up="z", units="m", shift=np.zeros(3))))
    assert solid.count == STAVES + 1
    cup().export(tmp_path / "whole.obj")
    assert next(load_solids(tmp_path / "whole.obj", FileFrame(up="z", units="m", shift=np.zeros(3)))).count == 1


def test_points_are_refused():
    points = np.random.default_rng(0).random((500, 3))
    with pytest.raises(InputError, match="expected a mesh"):
        sf.compare_shapes(points)


@pytest.mark.parametrize("suffix", [".urdf", ".sdf", ".xml"])
def test_what_is_written_is_what_engines_load(subject, tmp_path, suffix):
    from spherefunc_bullet.shapes.files import write_shape
    from spherefunc_bullet.simulator.mechanics import Material
    from spherefunc_bullet.simulator.statics.body import body_of

    body = body_of(subject.cloud, Material(mass=0.3))
    path = write_shape(tmp_path / f"cup{suffix}", subject.mesh, of_pieces("staves", staves()), body)
    if suffix == ".urdf":
        pybullet = pytest.importorskip("pybullet")
        client = pybullet.connect(pybullet.DIRECT)
        number = pybullet.loadURDF(str(path), physicsClientId=client)
        assert len(pybullet.getCollisionShapeData(number, -1, physicsClientId=client)) == STAVES + 1
        assert pybullet.getDynamicsInfo(number, -1, physicsClientId=client)[0] == pytest.approx(0.3)
        hit = pybullet.rayTest([0, 0, 1], [0, 0, -1], physicsClientId=client)[0]
        pybullet.disconnect(client)
        assert hit[3][2] == pytest.approx(BOTTOM, abs=0.002)  # the engine's margin
    elif suffix == ".xml":
        mujoco = pytest.importorskip("mujoco")
        model = mujoco.MjModel.from_xml_path(str(path))
        assert model.ngeom == STAVES + 2 and model.body_mass[1] == pytest.approx(0.3)
    solid = next(load_solids(path, FileFrame(up="z", units="m", shift=np.zeros(3))))
    assert solid.count == STAVES + 1
    assert np.allclose(solid.vertices.max(axis=0), subject.high, atol=1e-6)


def test_what_stands_still_may_be_written_concave(subject, tmp_path):
    from spherefunc_bullet.shapes.files import write_shape
    from spherefunc_bullet.simulator.mechanics import Material
    from spherefunc_bullet.simulator.statics.body import body_of

    body = body_of(subject.cloud, Material())
    path = write_shape(tmp_path / "cup.urdf", subject.mesh, subject.mesh, body)
    assert next(load_solids(path, FileFrame(up="z", units="m", shift=np.zeros(3)))).pieces is None
    with pytest.raises(InputError, match="MuJoCo"):
        write_shape(tmp_path / "cup.xml", subject.mesh, subject.mesh, body)


@pytest.mark.slow
def test_the_command_prints_its_contract(tmp_path, few_candidates):
    file = str(tmp_path / "cup.obj")
    cup().export(file)
    options = ["--collision", file, "--only-collision", "--json", "--csv", str(tmp_path / "shapes.csv")]
    done = CliRunner().invoke(application("shapes"), ["shapes", str(tmp_path), *options])
    assert len((tmp_path / "shapes.csv").read_text().splitlines()) == 2
    answer = json.loads(done.stdout)[0]
    row = answer["shapes"][0]
    expected = {"name", "pieces", "faces", "build_seconds", "step_us", "settled_kept", "capacity_kept", "level_kept"}
    assert expected | {"moved_mm", "functions", "keeps", "verdict"} <= row.keys()
    assert answer["functions"]["cup"]["member"] and row["keeps"] is False


@pytest.mark.slow
def test_free_space_is_not_bridged_by_thin_pieces(subject):
    from spherefunc_bullet.shapes.exposure import Fitting

    row = row_of(subject, Fitting(subject).pieces(1.2), KeepCriteria())
    assert row.level_kept > 0.95 and row.openings_closed == 0, row.verdict


def test_a_part_of_one_point_is_not_cut():
    from spherefunc_bullet.shapes.fitting import ExposedSurface, best_cut, part_of

    one = np.ones(1)
    exposed = ExposedSurface(places=np.zeros((1, 3)), outward=np.zeros((1, 3)), tolerance=one, reach=one, clear=0 * one)
    assert best_cut(part_of(np.zeros((2, 3, 3)), exposed), exposed) is None


def test_fewer_corners_stay_within_the_hull():
    from spherefunc_bullet.shapes.solid import MOST_CORNERS, capped, hull_of

    points = trimesh.creation.icosphere(subdivisions=3).vertices
    corners = capped(points)
    assert len(corners) <= MOST_CORNERS
    hull, faces = hull_of(corners)
    assert trimesh.Trimesh(hull, faces).volume > 0.75 * 4 / 3 * np.pi  # 32 corners of a sphere hold 0.8 of it


SDF = """<sdf version="1.6"><model name="m"><link name="a"><pose>0 0 1 0 0 0</pose><collision name="c">
<pose>1 0 0 0 0 1.5707963</pose><geometry><box><size>0.4 0.2 0.1</size></box></geometry></collision></link>
<link name="b"><collision name="c"><geometry><cylinder><radius>0.1</radius><length>0.5</length></cylinder></geometry>
</collision></link></model></sdf>"""
MJCF = """<mujoco><worldbody><body name="a" pos="1 0 1" euler="0 0 90"><geom type="box" size="0.2 0.1 0.05"/></body>
<body name="b"><geom type="cylinder" size="0.1 0.25"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize("name, text", [("m.sdf", SDF), ("m.xml", MJCF)])
def test_primitives_of_other_peoples_files_are_placed(tmp_path, name, text):
    if name.endswith("xml"):
        pytest.importorskip("mujoco")
    (tmp_path / name).write_text(text)
    first, second = load_solids(tmp_path / name, FileFrame(up="z", units="m", shift=np.zeros(3)))
    assert (first.name, second.name) == ("a", "b")
    assert np.allclose(first.vertices.min(axis=0), [0.9, -0.2, 0.95], atol=1e-6)
    assert second.vertices[:, 2].max() == pytest.approx(0.25)


@pytest.mark.parametrize(
    "pose",
    [
        "<pose>1 0 0 0 0 1.5707963</pose>",
        "<pose degrees='true'>1 0 0 0 0 90</pose>",
        "<pose rotation_format='quat_xyzw'>1 0 0 0 0 0.70710678 0.70710678</pose>",
        "<pose relative_to='a'>1 0 0 0 0 1.5707963</pose>",
    ],
)
def test_a_pose_of_an_sdf_is_read_as_it_is_written(tmp_path, pose):
    (tmp_path / "m.sdf").write_text(SDF.replace("<pose>1 0 0 0 0 1.5707963</pose>", pose))
    first, _ = load_solids(tmp_path / "m.sdf", FileFrame(up="z", units="m", shift=np.zeros(3)))
    assert np.allclose(first.vertices.min(axis=0), [0.9, -0.2, 0.95], atol=1e-6)


@pytest.mark.parametrize(
    "text, other, words",
    [
        ("<pose>1 0 0", "<pose relative_to='b'>1 0 0", "got one relative to 'b'"),
        ("<box><size>0.4 0.2 0.1</size></box>", "<cone><radius>1</radius></cone>", "got cone"),
        ("<box><size>0.4 0.2 0.1</size></box>", "<mesh><uri>a</uri><submesh/></mesh>", "got submesh"),
        ("</model>", "<model name='lid'><pose>0 0 1 0 0 0</pose></model></model>", "expected one model, got 1 more"),
        ("</model>", "</model><model name='other'/><include/>", "expected one model, got 2 more"),
    ],
)
def test_what_an_sdf_says_and_is_not_read_is_refused(tmp_path, text, other, words):
    (tmp_path / "m.sdf").write_text(SDF.replace(text, other))
    with pytest.raises(InputError, match=words):
        list(load_solids(tmp_path / "m.sdf", FileFrame(up="z", units="m", shift=np.zeros(3))))


@pytest.mark.parametrize(
    "form", ["<capsule><radius>0.1</radius><length>0.4</length>", "<ellipsoid><radii>0.1 0.2 0.3</radii>"]
)
def test_capsules_and_ellipsoids_of_an_sdf_collide(tmp_path, form):
    solid = f"{form}</{form[1:].partition('>')[0]}>"
    (tmp_path / "m.sdf").write_text(SDF.replace("<box><size>0.4 0.2 0.1</size></box>", solid))
    first, _ = load_solids(tmp_path / "m.sdf", FileFrame(up="z", units="m", shift=np.zeros(3)))
    assert first.vertices[:, 2].max() == pytest.approx(1.3)


def urdf_of(geometry: str) -> str:
    """A URDF of one link with a name that XPath has to quote."""
    return f"<robot name='r'><link name=\"bob's\"><collision><geometry>{geometry}</geometry></collision></link></robot>"


def test_a_link_of_a_urdf_may_have_an_apostrophe(tmp_path):
    (tmp_path / "m.urdf").write_text(urdf_of("<box size='0.4 0.2 0.1'/>"))
    (solid,) = load_solids(tmp_path / "m.urdf", FileFrame(up="z", units="m", shift=np.zeros(3)))
    assert solid.name == "bob's" and np.allclose(np.ptp(solid.vertices, axis=0), [0.4, 0.2, 0.1])


def test_a_material_within_a_geometry_of_a_urdf_is_passed_over(tmp_path):
    """As PyBullet's own racecar has it."""
    (tmp_path / "m.urdf").write_text(urdf_of("<box size='0.4 0.2 0.1'/><material name='blue'/>"))
    (solid,) = load_solids(tmp_path / "m.urdf", FileFrame(up="z", units="m", shift=np.zeros(3)))
    assert np.allclose(np.ptp(solid.vertices, axis=0), [0.4, 0.2, 0.1])


def test_a_capsule_of_a_urdf_is_refused_by_its_name(tmp_path):
    (tmp_path / "m.urdf").write_text(urdf_of("<capsule radius='0.1' length='0.4'/>"))
    with pytest.raises(InputError, match="expected meshes, boxes, cylinders and spheres, got a capsule$"):
        list(load_solids(tmp_path / "m.urdf", FileFrame(up="z", units="m", shift=np.zeros(3))))


@pytest.mark.parametrize("folder", ["cup", "cup-1.2"])
def test_meshes_of_a_gazebo_model_are_in_its_folder(tmp_path, folder):
    (tmp_path / folder / "meshes").mkdir(parents=True)
    trimesh.creation.box((0.4, 0.2, 0.1)).export(tmp_path / folder / "meshes" / "b.stl")
    mesh = "<mesh><uri>\n  model://cup/meshes/b.stl\n</uri></mesh>"
    text = SDF.replace("<box><size>0.4 0.2 0.1</size></box>", mesh)
    (tmp_path / folder / "model.sdf").write_text(text)
    first, _ = load_solids(tmp_path / folder / "model.sdf", FileFrame(up="z", units="m", shift=np.zeros(3)))
    assert sorted(np.ptp(first.vertices, axis=0).round(6)) == [0.1, 0.2, 0.4]


@pytest.mark.parametrize("solid", ["sphere", "ellipsoid", "capsule", "cylinder", "box"])
def test_every_solid_of_an_mjcf_collides(tmp_path, solid):
    pytest.importorskip("mujoco")
    text = f"<mujoco><worldbody><geom type='{solid}' size='0.1 0.2 0.3'/></worldbody></mujoco>"
    (tmp_path / "m.xml").write_text(text)
    (link,) = load_solids(tmp_path / "m.xml", FileFrame(up="z", units="m", shift=np.zeros(3)))
    half = {"sphere": 0.1, "capsule": 0.3, "cylinder": 0.2}.get(solid, 0.3)
    assert link.vertices[:, 2].max() == pytest.approx(half, abs=1e-3) and link.vertices[:, 0].max() > 0.097


@pytest.mark.parametrize(
    "collision, words", [(cup, "expected the path of a file"), ("nope", "expected a file, found none")]
)
def test_collision_geometry_is_a_file(collision, words):
    with pytest.raises(InputError, match=words):
        sf.compare_shapes(cup(), collision=collision)


def test_bodies_of_an_mjcf_without_names_are_links_of_their_own(tmp_path):
    pytest.importorskip("mujoco")
    (tmp_path / "m.xml").write_text(MJCF.replace(' name="a"', "").replace(' name="b"', ""))
    links = load_solids(tmp_path / "m.xml", FileFrame(up="z", units="m", shift=np.zeros(3)))
    assert [link.name for link in links] == ["body 1", "body 2"]


@pytest.mark.slow
def test_a_library_is_done_once_and_a_bad_file_costs_itself(tmp_path, few_candidates):
    (tmp_path / "in" / "deeper").mkdir(parents=True)
    cup().export(tmp_path / "in" / "deeper" / "cup.obj")
    (tmp_path / "in" / "bad.obj").write_text("v 0 0")
    line = ["shapes", str(tmp_path / "in"), "--only-collision", "--report", str(tmp_path / "out"), "--json"]
    first, again = (CliRunner().invoke(application("shapes"), line) for _ in range(2))
    assert first.exit_code == again.exit_code == 2 and first.stdout == again.stdout  # times among it: it was kept
    bad, good = json.loads(first.stdout)
    assert "error" in bad and good["shapes"][0]["capacity_kept"] == 0
    page = (tmp_path / "out" / "report.html").read_text()
    assert "<b>0 of 1</b> vessels still hold something" in page and "data:image/webp" in page
    assert len((tmp_path / "out" / "shapes.csv").read_text().splitlines()) == 3


URDF = """<robot name="cup"><link name="cup"><visual><geometry><mesh filename="seen.obj"/></geometry></visual>
<collision><geometry><mesh filename="met.obj"/></geometry></collision></link></robot>"""


@pytest.mark.parametrize("collision", ["cup.urdf", "met.obj", "met.sdf"])
def test_a_kept_result_is_that_of_all_files_that_were_read(tmp_path, monkeypatch, collision):
    calls = iter(range(9))
    options = library.LibraryOptions(collision=tmp_path / collision, best="urdf")

    def measured(file, _):
        (tmp_path / "best.urdf").touch()
        return {"file": str(file), "call": next(calls), "best": {"file": str(tmp_path / "best.urdf")}}

    def result(file=tmp_path / "cup.urdf"):
        return library.kept_result(file, options, tmp_path / "kept")

    monkeypatch.setattr(library, "library_result", measured)
    (tmp_path / "cup.urdf").write_text(URDF)
    mesh = "<mesh><uri>met.obj</uri></mesh>"
    (tmp_path / "met.sdf").write_text(SDF.replace("<box><size>0.4 0.2 0.1</size></box>", mesh))
    for name in ("seen.obj", "met.obj"):
        cup().export(tmp_path / name)
    assert result()["call"] == result()["call"] == 0
    monkeypatch.chdir(tmp_path)
    assert result(Path("cup.urdf")) == result() | {"file": "cup.urdf"}
    trimesh.creation.box().export(tmp_path / "met.obj")
    assert result()["call"] == result()["call"] == 1
    (tmp_path / "best.urdf").unlink()
    assert result()["call"] == 2
    for damage in ("", '{"file":', "[]"):
        for kept in (tmp_path / "kept").iterdir():
            kept.write_text(damage)
        assert result()["call"] == result()["call"]
    monkeypatch.setattr(library, "__version__", "another")  # it may measure otherwise
    assert result()["call"] == 6


def test_a_folder_is_its_manifest_or_its_urdfs_or_its_meshes(tmp_path):
    from spherefunc_bullet.commands.shapes import objects_in

    for name in ("cup.obj", "chair.ply", "README.txt", "scores.csv"):
        (tmp_path / name).write_text("")
    assert [path.name for path in objects_in([tmp_path])] == ["chair.ply", "cup.obj"]
    (tmp_path / "mug.urdf").write_text("")
    assert [path.name for path in objects_in([tmp_path])] == ["mug.urdf"]
    (tmp_path / "manifest.csv").write_text("file,label\ncup.obj,cup\nchair.ply,sittable\n")
    assert [path.name for path in objects_in([tmp_path])] == ["cup.obj", "chair.ply"]


def test_what_is_done_to_a_seat_and_a_table_is_known():
    """Each is met as it is, moved by less than a millimetre, and with something added or lowered."""
    from shape_pairs import pairs

    mesh = slab_on_posts(0.4, 0.4, 0.45)
    stool = Subject(cloud_from_mesh(mesh.vertices, mesh.faces, "stool"))
    made = {label: list(pairs(stool, label, np.random.default_rng(0))) for label in ("table", "sittable")}
    lost = {label: {kind for kind, is_lost, _ in found if is_lost} for label, found in made.items()}
    assert lost == {"table": {"legs joined", "lowered"}, "sittable": {"legs joined", "lowered", "seat filled"}}
    tops = {kind: solid.vertices[:, 2].max() for kind, _, solid in made["sittable"]}
    assert tops["lowered"] == pytest.approx(0.43) and tops["seat filled"] > 0.5
    assert tops["copy"] == pytest.approx(0.45, abs=0.001) and tops["legs joined"] == pytest.approx(0.45, abs=1e-6)


def test_a_handle_is_found_where_a_loop_is_open(subject):
    from shape_pairs import handle_pairs

    upright = trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0])
    loop = trimesh.creation.torus(0.02, 0.004).apply_transform(upright)
    mug = trimesh.util.concatenate([cup(), loop.apply_translation([RADIUS + 0.02, 0, HEIGHT / 2])])
    found = list(handle_pairs(Subject(cloud_from_mesh(mug.vertices, mug.faces, "mug"))))
    assert [kind for kind, *_ in found] == ["handle filled", "handle closed"] and not list(handle_pairs(subject))


def test_a_page_counts_what_is_lost_and_not_what_there_is_none_of():
    """A seat whose level is a little higher, and which is still one, is not lost; a table is, by its level."""
    from spherefunc_bullet.shapes.library import counts_kept, summary

    def result(name, seat, level_kept):
        functions = {name: {"member": True}}
        row = {"capacity_kept": None, "level_kept": level_kept, "keeps": False, "functions": {name: {"member": seat}}}
        return {"capacity_ml": 0.0, "keep": 0.9, "functions": functions, "shapes": [row]}

    results = [result("sittable", True, 0.5), result("sittable", False, 1.0), result("table", True, 0.5)]
    counts = summary(results)
    assert counts["seats that are no longer classified as seats"] == 1 and counts["seats"] == 2
    assert counts["tables that do not carry at their level"] == 1 and "vessels" not in counts
    assert counts_kept(results) == [
        (1, 2, "seats are still classified as seats"),
        (0, 1, "tables still carry at their level"),
    ]


@pytest.mark.parametrize("ending, remarked", [("obj", True), ("glb", False)])
def test_a_collision_shape_of_another_axis_than_its_object_is_remarked_on(tmp_path, ending, remarked):
    """glTF is y up by its standard and OBJ is taken as z up, though pieces of a glTF are often written as they are."""
    for name in ("seen.glb", f"pieces.{ending}"):
        cup().apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0])).export(tmp_path / name)
    lines = []
    sf.compare_shapes(tmp_path / "seen.glb", tmp_path / f"pieces.{ending}", shapes=False, report=lines.append)
    assert any("pieces.obj: taken as z up, and seen.glb as y up" in line for line in lines) == remarked
