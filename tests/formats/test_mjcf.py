"""MJCF is read as MuJoCo compiles it: what is seen, with what the file includes, of the files that are hashed."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import trimesh
from read_files import extent, refused

from spherefunc_bullet.formats.scenes.mjcf import bodies
from spherefunc_bullet.formats.sources import as_source, read_geometry

mujoco = pytest.importorskip("mujoco", reason="mujoco is not installed: pip install 'spherefunc-bullet[formats]'")


def write(path, world: str, more: str = ""):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"<mujoco>{more}<worldbody>{world}</worldbody></mujoco>")
    return path


SEEN = '<geom type="box" size="0.3 0.4 0.5" contype="0" conaffinity="0" group="{0}"/>'
MET = '<geom type="box" size="0.5 0.5 0.5" group="{0}"/>'


@pytest.mark.parametrize(
    ("geoms", "seen"),
    [
        (SEEN.format(1) + MET.format(0), [0.6, 0.8, 1.0]),  # as robosuite writes its objects
        (SEEN.format(2) + MET.format(3), [0.6, 0.8, 1.0]),  # as MuJoCo's own collection of robots
        (SEEN.format(0) + MET.format(0), [1.0, 1.0, 1.0]),  # a mark on what is seen and met
        (SEEN.format(1).replace("0.5", "0.01") + MET.format(0), [0.6, 0.8, 0.02]),
        (SEEN.format(1).replace("0.3 0.4 0.5", "0.1 0.1 0.01") + MET.format(0), [1.0, 1.0, 1.0]),  # a mark
        (MET.format(0) + '<geom type="box" size="1 1 1" rgba="1 0 0 0"/>', [1.0, 1.0, 1.0]),
        (MET.format(0) + '<geom type="plane" size="9 9 1"/>', [1.0, 1.0, 1.0]),
    ],
)
def test_what_is_seen_of_a_body_is_not_what_collides(tmp_path, geoms, seen):
    path = write(tmp_path / "a.xml", f"<body name='a'>{geoms}</body>")
    assert extent(path) == seen
    assert "a" in dict(bodies(as_source(path), collision=True))


def test_geoms_of_a_transparent_material_are_hidden(tmp_path):
    material = "<asset><material name='air' rgba='1 1 1 0'/></asset>"
    path = write(tmp_path / "a.xml", MET.format(0) + "<geom type='box' size='2 2 2' material='air'/>", material)
    assert extent(path) == [1.0, 1.0, 1.0]


def test_geoms_are_where_mujoco_puts_them(tmp_path):
    """Joints at their references, nested bodies, frames, copies, angles in radians and meshes that it moves."""
    trimesh.creation.cone(0.2, 0.5).apply_translation((1, 2, 3)).export(tmp_path / "cone.stl")
    world = """<body pos="1 0 0" euler="0.3 0 0"><joint type="hinge" ref="0.5"/><geom type="mesh" mesh="cone"/>
      <body pos="0 1 0"><geom type="capsule" fromto="0 0 0 1 1 1" size="0.1"/></body></body>
      <frame pos="0 0 2"><geom type="ellipsoid" size="0.1 0.2 0.3" quat="1 1 0 0"/></frame>
      <replicate count="3" offset="0 0 1"><geom type="cylinder" size="0.1 0.2"/></replicate>"""
    compiler = "<compiler angle='radian'/><asset><mesh file='cone.stl' scale='1 -2 1'/></asset>"
    path = write(tmp_path / "a.xml", world, compiler)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    ours = list(bodies(as_source(path), collision=False))
    assert len(ours) == model.ngeom == 6
    for geom, (_, (vertices, faces)) in enumerate(ours):
        own = (vertices - data.geom_xpos[geom]) @ data.geom_xmat[geom].reshape(3, 3)
        middle, half = model.geom_aabb[geom].reshape(2, 3)
        assert np.allclose(own.min(axis=0), middle - half, atol=3e-3)
        assert np.allclose(own.max(axis=0), middle + half, atol=3e-3)
        assert trimesh.Trimesh(vertices, faces, process=False).volume > 0


def test_a_file_includes_others_of_the_folder_of_assets(tmp_path):
    for name in ("stls", "common"):
        (tmp_path / "assets" / name).mkdir(parents=True)
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "assets" / "stls" / "box.stl")
    part = "<mujocoinclude><compiler meshdir='../stls'/><asset><mesh file='box.stl'/></asset></mujocoinclude>"
    (tmp_path / "assets" / "common" / "meshes.xml").write_text(part)
    (tmp_path / "assets" / "common" / "geom.xml").write_text(
        "<mujocoinclude><geom type='mesh' mesh='box'/></mujocoinclude>"
    )
    inner = "<body><include file='..\\common\\geom.xml'/></body>"
    path = write(tmp_path / "assets" / "objects" / "a.xml", inner, "<include file='../common/meshes.xml'/>")
    assert extent(path) == [0.1, 0.2, 0.3]
    assert {part.path.name for part in as_source(path).parts()} == {"a.xml", "meshes.xml", "geom.xml", "box.stl"}


def test_what_an_included_file_names_may_lie_beside_it(tmp_path):
    """As in MuJoCo, what lies in the folder of the model comes first."""
    (tmp_path / "parts" / "stls").mkdir(parents=True)
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "parts" / "stls" / "box.stl")
    more = "<mujoco><asset><mesh file='box.stl'/></asset></mujoco>"
    (tmp_path / "parts" / "all.xml").write_text("<mujoco><include file='stls/assets.xml'/></mujoco>")
    (tmp_path / "parts" / "stls" / "assets.xml").write_text(more)
    path = write(tmp_path / "a.xml", "<geom type='mesh' mesh='box'/>", "<include file='parts/all.xml'/>")
    for expected in ([0.1, 0.2, 0.3], [0.4, 0.5, 0.6]):
        assert extent(path) == expected
        assert mujoco.MjModel.from_xml_path(str(path)).geom_aabb[0][3:].max() == pytest.approx(expected[2] / 2)
        trimesh.creation.box((0.4, 0.5, 0.6)).export(tmp_path / "box.stl")


def test_names_without_folders_are_stripped_as_mujoco_strips_them(tmp_path):
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "box.stl")
    more = "<compiler strippath='true' meshdir='elsewhere'/><asset><mesh file='/home/me/box.stl'/></asset>"
    assert extent(write(tmp_path / "a.xml", "<geom type='mesh' mesh='box'/>", more)) == [0.1, 0.2, 0.3]


def test_what_is_painted_or_driven_need_not_be_there(tmp_path):
    more = """<option integrator="nothing"/><size njmax="500"/><actuator><motor joint="none"/></actuator>
      <asset><texture name="wood" type="2d" file="wood.png"/><material name="wood" texture="wood"/></asset>"""
    geom = "<geom type='box' size='0.5 0.5 0.5' material='{}'/>"
    world = (
        f"{geom.format('wood')}{geom.format('of the file that includes it')}<body><freejoint/><site/><light/></body>"
    )
    assert extent(write(tmp_path / "a.xml", world, more)) == [1.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("world", "more", "words"),
    [
        ("<composite type='cable' count='9 1 1'/>", "", "expected bodies of rigid geoms, got 'composite'"),
        ("<geom type='box'/>", "", "expected an MJCF that MuJoCo compiles; Error: size 0"),
        ("<geom type='plane' size='1 1 1'/>", "", "expected visible geoms beside planes, found none"),
        (MET.format(3), "", "has it collision geometry alone?"),
        (3 * "<replicate count='100'>" + MET.format(0) + 3 * "</replicate>", "", "at most 10,000 copies of a body"),
        (f"<replicate count='5001'>{2 * MET.format(0)}</replicate>", "", "at most 10,000 geoms"),
        ("<replicate count='x'/>", "", "expected a whole number of copies, got 'x'"),
        (MET.format(0), "<deformable><flex name='a'/></deformable>", "got 'flex', which is not read"),
        ("", "<include/>", "expected the name of a file, got '.'"),
        ("", "<include file='b.stl'/>", "b.stl: expected a STL file, could not read it (ParseError"),
        ("", "<include file='a.xml'/>", "expected each file to be included once, got 'a.xml' again"),
        ("", "<include file='/etc/passwd'/>", "expected what it names in its own folder or its package"),
        ("<geom mesh='b' type='mesh'/>", "<asset><mesh file='../b.stl'/></asset>", "in its own folder"),
        ("<geom type='box' size='1 1 nan'/>", "", "expected an MJCF that MuJoCo compiles"),
    ],
)
def test_what_is_not_read_is_refused_in_one_line(tmp_path, monkeypatch, capfd, world, more, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").mkdir()
    for place in (tmp_path, tmp_path / "in"):
        (place / "b.stl").write_bytes(trimesh.creation.box().export(file_type="stl"))
    assert words in refused(write(tmp_path / "in" / "a.xml", world, more))
    assert capfd.readouterr() == ("", "") and {each.name for each in tmp_path.iterdir()} == {"in", "b.stl"}


def test_another_kind_of_xml_is_called_what_it_is(tmp_path):
    (tmp_path / "package.xml").write_text("<package format='3'/>")
    assert "expected an MJCF, whose root is 'mujoco', got 'package'" in refused(tmp_path / "package.xml")


def test_threads_leave_the_warnings_of_mujoco_as_they_were(tmp_path):
    path = write(tmp_path / "a.xml", MET.format(0))
    with ThreadPoolExecutor(4) as threads:
        assert set(threads.map(lambda _: len(read_geometry(path).faces), range(100))) == {12}
    assert mujoco.get_mju_user_warning() is None
