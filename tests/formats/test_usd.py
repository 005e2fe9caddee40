"""Stages of USD: what a renderer shows of them, in metres and z up, and nothing from elsewhere."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import trimesh
from cloud_files import mesh_bytes, mug
from read_files import extent

import spherefunc_bullet as sf
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.scenes import usd
from spherefunc_bullet.formats.sources import as_source, read_geometry

pytest.importorskip("pxr", reason="usd-core is not installed")

TABLE = """#usda 1.0
(
    upAxis = "Z"
    metersPerUnit = 1
)
def Xform "Table"
{
    def Cube "Top"
    {
        double size = 1
        double3 xformOp:translate = (0, 0, 0.72)
        double3 xformOp:scale = (1.4, 0.8, 0.04)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]
    }
    def Cube "ForCollisions"
    {
        uniform token purpose = "proxy"
    }
    def Cube "Hidden"
    {
        token visibility = "invisible"
    }
%s
}
"""
LEG = """    def Xform "Leg%d" (
        instanceable = true
        prepend references = @%s@
    )
    {
        double3 xformOp:translate = (%g, %g, 0.35)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }"""
CYLINDER = """#usda 1.0
(
    defaultPrim = "Leg"
)
def Xform "Leg"
{
    def Cylinder "Shape"
    {
        double height = 0.7
        double radius = 0.03
    }
}
"""
SOLID = """#usda 1.0
(
    upAxis = "%s"
    metersPerUnit = 0.01
)
def %s "Solid"
{
    %s
}
"""
MESH = """#usda 1.0
(
    upAxis = "Z"
    metersPerUnit = 1
)
def Mesh "Mesh"
{
    int[] faceVertexCounts = [%s]
    int[] faceVertexIndices = [%s]
    point3f[] points = [%s]
    uniform token orientation = "%s"
    %s
}
"""


def box_as_usd(orientation: str = "rightHanded", more: str = "") -> str:
    """Return a box of 0.1 x 0.2 x 0.3 m, a metre from the origin along x."""
    box = trimesh.creation.box((0.1, 0.2, 0.3))
    points = ", ".join(f"({x:g}, {y:g}, {z:g})" for x, y, z in box.vertices + [1, 0, 0])
    corners = ", ".join(map(str, box.faces.ravel()))
    return MESH % (", ".join(["3"] * len(box.faces)), corners, points, orientation, more)


def write_table(folder: Path, reference: str) -> Path:
    legs = [LEG % (k, reference, x, y) for k, (x, y) in enumerate([(-0.6, -0.3), (0.6, -0.3), (-0.6, 0.3), (0.6, 0.3)])]
    (folder / "table.usda").write_text(TABLE % "\n".join(legs))
    return folder / "table.usda"


def refusal(path: Path) -> str:
    with pytest.raises(InputError) as error:
        read_geometry(path)
    message = str(error.value)
    assert "\n" not in message and message.startswith(path.name)
    return message


def volume(path: Path) -> float:
    geometry = read_geometry(path)
    return trimesh.Trimesh(geometry.vertices, geometry.faces, process=False).volume


def test_instances_are_shown_and_what_no_renderer_shows_is_left_out(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "leg.usda").write_text(CYLINDER)
    path = write_table(tmp_path, "./parts/leg.usda")
    geometry = read_geometry(path)
    assert np.allclose(
        [geometry.vertices.min(axis=0), geometry.vertices.max(axis=0)], [(-0.7, -0.4, 0), (0.7, 0.4, 0.74)]
    )
    assert volume(path) == pytest.approx(1.4 * 0.8 * 0.04 + 4 * np.pi * 0.03**2 * 0.7, rel=0.01)
    assert [part.path.name for part in as_source(path).parts()] == ["table.usda", "leg.usda"]
    assert sf.classify(path, cache=False).functions == {"table"}


def test_nothing_is_read_from_outside_the_folder_unless_it_is_named(tmp_path, monkeypatch):
    inner = tmp_path / "assets"
    inner.mkdir()
    (tmp_path / "leg.usda").write_text(CYLINDER)
    for reference in ("../leg.usda", str(tmp_path / "leg.usda")):
        assert "is elsewhere" in refusal(write_table(inner, reference))
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    assert read_geometry(write_table(inner, "../leg.usda")).vertices[:, 2].min() == pytest.approx(0)


@pytest.mark.parametrize("reference", ["./parts/leg.usda", "https://example.org/leg.usda"])
def test_a_stage_without_a_part_of_it_is_refused(tmp_path, reference):
    assert "leg.usda' is missing" in refusal(write_table(tmp_path, reference))


@pytest.mark.parametrize(
    ("kind", "sizes", "up", "extent"),
    [
        ("Cylinder", 'double height = 30\n    double radius = 5\n    token axis = "X"', "Z", (0.3, 0.1, 0.1)),
        ("Cylinder", 'double height = 30\n    double radius = 5\n    token axis = "Y"', "Y", (0.1, 0.1, 0.3)),
        ("Capsule", "double height = 30\n    double radius = 5", "Z", (0.1, 0.1, 0.4)),
        (
            "Capsule_1",
            "double height = 30\n    double radiusTop = 5\n    double radiusBottom = 5",
            "Z",
            (0.1, 0.1, 0.4),
        ),
        (
            "Cylinder_1",
            "double height = 30\n    double radiusTop = 5\n    double radiusBottom = 5",
            "Z",
            (0.1, 0.1, 0.3),
        ),
        ("Cone", "double height = 30\n    double radius = 5", "Z", (0.1, 0.1, 0.3)),
        ("Sphere", "double radius = 5", "Z", (0.1, 0.1, 0.1)),
        ("Cube", "", "Z", (0.02, 0.02, 0.02)),  # 2 units, as the standard says
    ],
)
def test_solids_come_in_metres_and_z_up(tmp_path, kind, sizes, up, extent):
    (tmp_path / "solid.usda").write_text(SOLID % (up, kind, sizes))
    vertices = read_geometry(tmp_path / "solid.usda").vertices
    assert np.ptp(vertices, axis=0) == pytest.approx(extent, rel=0.02)
    assert (vertices.min(axis=0) + vertices.max(axis=0)) / 2 == pytest.approx((0, 0, 0), abs=1e-6)


MIRRORED = 'double3 xformOp:scale = (-1, 1, 1)\n    uniform token[] xformOpOrder = ["xformOp:scale"]'


@pytest.mark.parametrize(
    ("orientation", "more", "sign"),
    [("rightHanded", "", 1), ("leftHanded", "", -1), ("rightHanded", MIRRORED, 1), ("leftHanded", MIRRORED, -1)],
)
def test_faces_are_seen_from_the_side_that_the_stage_says(tmp_path, orientation, more, sign):
    path = tmp_path / "box.usda"
    path.write_text(box_as_usd(orientation, more))
    assert volume(path) == pytest.approx(0.006 * sign, rel=1e-5)


def test_a_mesh_of_tetrahedra_is_read_as_its_surface(tmp_path):
    corners = "point3f[] points = [(0, 0, 0), (100, 0, 0), (0, 100, 0), (0, 0, 100)]"
    (tmp_path / "a.usda").write_text(SOLID % ("Z", "TetMesh", corners + "\nint4[] tetVertexIndices = [(0, 1, 2, 3)]"))
    assert volume(tmp_path / "a.usda") == pytest.approx(1 / 6)


def test_points_are_a_cloud_and_left_out_beside_a_surface(tmp_path):
    points = "point3f[] points = [" + ", ".join(f"({k}, 50, 200)" for k in range(20)) + "]"
    (tmp_path / "a.usda").write_text(SOLID % ("Y", "Points", points))
    cloud = read_geometry(tmp_path / "a.usda")
    assert not len(cloud.faces) and np.allclose(cloud.vertices, [(k / 100, -2, 0.5) for k in range(20)])
    text = (SOLID % ("Y", "Points", points)) + 'def Cube "Beside"\n{\n    double size = 10\n}\n'
    (tmp_path / "b.usda").write_text(text)
    assert np.abs(read_geometry(tmp_path / "b.usda").vertices).max() == pytest.approx(0.05)


def test_of_an_animation_the_first_moment_is_read(tmp_path):
    (tmp_path / "a.usda").write_text(SOLID % ("Z", "Sphere", "double radius.timeSamples = { 3: 5, 9: 50 }"))
    assert np.ptp(read_geometry(tmp_path / "a.usda").vertices, axis=0) == pytest.approx((0.1, 0.1, 0.1), rel=0.02)


@pytest.mark.parametrize("ending", ["usd", "usda", "usdc", "usdz"])
def test_a_part_of_a_file_is_refused_in_one_line(tmp_path, ending):
    data = mesh_bytes(ending, *mug())
    (tmp_path / f"mug.{ending}").write_bytes(data[: len(data) // 2])
    assert "could not read it" in refusal(tmp_path / f"mug.{ending}")


@pytest.mark.parametrize("reference", ["./leg.usda@</Other>#", "./leg.abc"])
def test_a_part_that_is_not_in_the_file_or_of_another_format_is_refused(tmp_path, reference):
    for name in ("leg.usda", "leg.abc"):
        (tmp_path / name).write_text(CYLINDER)
    assert "/Table/Leg" in refusal(write_table(tmp_path, reference))


def test_what_cannot_be_read_is_refused_in_words(tmp_path):
    path = tmp_path / "a.usda"
    path.write_text(SOLID % ("Z", "PointInstancer", ""))
    assert "PointInstancer" in refusal(path)
    for kind in ("Xform", "Plane"):
        path.write_text(SOLID % ("Z", kind, ""))
        assert "is it empty?" in refusal(path)
    path.write_text(SOLID % ("Z", "Cylinder_1", "double radiusTop = 5\n    double radiusBottom = 4"))
    assert "a Cylinder_1 of two radii, /" in refusal(path)
    path.write_text(SOLID % ("Z", "NurbsPatch", ""))
    assert "a NurbsPatch, /" in refusal(path)
    path.write_text(box_as_usd().replace("faceVertexIndices = [", "faceVertexIndices = [99, "))
    assert "faces of other points" in refusal(path)


def test_a_program_that_has_ended_is_started_again_and_one_serves_all(tmp_path):
    (tmp_path / "box.usda").write_text(box_as_usd())
    before = extent(tmp_path / "box.usda")
    reader = usd._reader(os.getpid())
    reader.kill()
    reader.wait()
    with ThreadPoolExecutor(3) as threads:
        assert list(threads.map(extent, [tmp_path / "box.usda"] * 6)) == [before] * 6
    assert usd._reader(os.getpid()) is not reader and usd._reader.cache_info().misses == 1
