"""The meshes of a URDF are found in its folder, in its package and where the user points, and nowhere else."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import trimesh
from test_sources import robot
from typer.testing import CliRunner

from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.sources import read_geometry

pytest.importorskip("yourdfpy", reason="yourdfpy is not installed: pip install 'spherefunc-bullet[formats]'")


def write_mesh(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    trimesh.creation.box((0.4, 0.4, 0.4)).export(path)
    return path


def write_robot(path: Path, mesh: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(robot(mesh))
    return path


def is_refused(path: Path) -> bool:
    """Return whether a URDF is refused in one line that names it, for a mesh outside its folder and its package."""
    with pytest.raises(InputError, match="in its own folder or its package") as error:
        read_geometry(path)
    return "\n" not in str(error.value) and str(error.value).startswith(path.name)


@pytest.mark.parametrize("name", ["my mug.stl", "my%20mug.stl", "100%.stl"])
def test_names_may_be_written_as_in_a_url_or_as_they_are(tmp_path, name):
    write_mesh(tmp_path / "meshes" / name)
    for written in {name, name.replace(" ", "%20")}:
        assert len(read_geometry(write_robot(tmp_path / "a.urdf", f"meshes/{written}")).faces) == 12


def test_a_package_without_a_name_is_none(tmp_path):
    mesh = write_mesh(tmp_path / "elsewhere" / "secret.stl")
    assert is_refused(write_robot(tmp_path / "robot" / "a.urdf", f"package://{mesh}"))
    assert is_refused(write_robot(tmp_path / "robot" / "a.urdf", f"package:///{mesh}"))
    for dots in (".", "..", "../.."):
        assert is_refused(write_robot(tmp_path / "robot" / "a.urdf", f"package://{dots}/elsewhere/secret.stl"))


def test_a_folder_far_above_is_no_package_for_its_name(tmp_path):
    mesh = write_mesh(tmp_path / "elsewhere" / "secret.stl")
    top, inner = mesh.parts[1], Path(*mesh.parts[2:])
    assert is_refused(write_robot(tmp_path / "robot" / "a.urdf", f"package://{top}/{inner}"))
    assert is_refused(write_robot(tmp_path / "robot" / "a.urdf", f"package://{tmp_path.name}/elsewhere/secret.stl"))


@pytest.mark.parametrize("marked", [True, False], ids=["with package.xml", "as packages are laid out"])
def test_the_package_that_a_file_is_a_part_of_is_found_above_it(tmp_path, marked):
    write_mesh(tmp_path / "arm" / "meshes" / "top.stl")
    if marked:
        (tmp_path / "arm" / "package.xml").write_text("<package/>")
    folder = tmp_path / "arm" / ("some/where" if marked else "urdf")
    path = write_robot(folder / "a.urdf", "package://arm/meshes/top.stl")
    assert len(read_geometry(path).faces) == 12


def test_a_file_may_climb_within_its_package_and_not_out_of_it(tmp_path):
    write_mesh(tmp_path / "arm" / "meshes" / "top.stl")
    (tmp_path / "arm" / "package.xml").write_text("<package/>")
    path = write_robot(tmp_path / "arm" / "urdf" / "a.urdf", "../meshes/top.stl")
    assert len(read_geometry(path).faces) == 12
    write_mesh(tmp_path / "secret.stl")
    for name in ("../../secret.stl", "package://arm/../secret.stl", str(tmp_path / "secret.stl")):
        assert is_refused(write_robot(path, name))
    (tmp_path / "arm" / "meshes" / "link.stl").symlink_to(tmp_path / "secret.stl")
    assert is_refused(write_robot(path, "package://arm/meshes/link.stl"))


@pytest.mark.parametrize(
    ("file", "mesh"),
    [("urdf/mug/a.urdf", "../../mesh/mug.stl"), ("mugs/a.urdf", "../mesh/mug.stl"), ("urdf/a.urdf", "mesh/mug.stl")],
)
def test_the_usual_folders_of_a_package_without_its_mark_are_found(tmp_path, file, mesh):
    write_mesh(tmp_path / "library" / "mesh" / "mug.stl")
    path = write_robot(tmp_path / "library" / file, mesh)
    assert len(read_geometry(path).faces) == 12
    write_mesh(tmp_path / "secret.stl")
    assert is_refused(write_robot(path, f"{'../' * len(Path(file).parts)}secret.stl"))


@pytest.mark.parametrize("pointed", ["packages", "packages/arm"], ids=["to packages", "to the package"])
def test_packages_are_found_where_the_user_points(tmp_path, monkeypatch, pointed):
    write_mesh(tmp_path / "packages" / "arm" / "meshes" / "top.stl")
    path = write_robot(tmp_path / "robot" / "a.urdf", "package://arm/meshes/top.stl")
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    assert is_refused(path)
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{tmp_path / pointed}")
    assert len(read_geometry(path).faces) == 12
    write_mesh(tmp_path / "secret.stl")
    assert is_refused(write_robot(path, "package://arm/../../secret.stl"))


def test_a_path_without_a_package_is_found_where_the_user_points(tmp_path, monkeypatch):
    """As PyBullet finds it in its search path."""
    write_mesh(tmp_path / "data" / "arm" / "top.stl")
    path = write_robot(tmp_path / "data" / "arm" / "a.urdf", "arm/top.stl")
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    assert is_refused(path)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "data"))
    assert len(read_geometry(path).faces) == 12
    assert is_refused(write_robot(path, "../arm/../../secret.stl"))


@pytest.mark.parametrize("command", ["classify", "simulate", "poses", "stand", "view"])
def test_the_command_line_points_with_an_option(tmp_path, monkeypatch, command):
    monkeypatch.setenv("ROS_PACKAGE_PATH", "")  # the option adds to it, for this test alone
    write_mesh(tmp_path / "packages" / "arm" / "top.stl")
    path = write_robot(tmp_path / "robot" / "a.urdf", "package://arm/top.stl")
    more = {"simulate": ["--radius", "5cm", "--json"], "view": ["--out", str(tmp_path / "page.html")]}
    asked = [command, str(path), "--package-path", str(tmp_path / "packages"), *more.get(command, ["--json"])]
    done = CliRunner().invoke(application(command), asked, catch_exceptions=False)
    assert done.exit_code == 0, done.stderr
    if command == "classify":
        assert "error" not in json.loads(done.stdout)[0]
