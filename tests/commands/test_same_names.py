"""Libraries with a folder for each object: many files have the same name, and lines say which one is meant."""

from __future__ import annotations

import pytest
from commands import spherefunc

from spherefunc_bullet.console import with_path
from spherefunc_bullet.errors import InputError

BOX = "".join(f"v {x} {y} {z}\n" for x in (0, 0.2) for y in (0, 0.2) for z in (0, 0.1))
BOX += "".join(f"f {a} {b} {c} {d}\n" for a, b, c, d in ((1, 3, 7, 5), (2, 6, 8, 4), (1, 2, 4, 3), (5, 7, 8, 6)))


@pytest.fixture
def library(tmp_path, monkeypatch):
    """Two boxes and a damaged file of the same name, and a box of another."""
    monkeypatch.chdir(tmp_path)
    for name in ("lamp/model.obj", "stool/model.obj", "stool/box.obj"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(BOX)
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "model.obj").write_text("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    return tmp_path


@pytest.mark.parametrize("command", ["classify", "simulate", "stand", "poses", "places", "carry", "view"])
def test_lines_about_files_of_one_name_give_their_paths(library, command):
    files = ["lamp/model.obj", "stool/model.obj", "stool/box.obj", "damaged/model.obj"]
    done = spherefunc(command, *files, *(["--out", "page.html"] if command == "view" else []))
    said = done.stdout + (library / "page.html").read_text() if command == "view" else done.stdout
    assert done.returncode == 2
    assert "spherefunc: damaged/model.obj: expected finite vertices" in done.stderr
    assert "lamp/model.obj" in said and "stool/model.obj" in said
    assert "box.obj" in said and "stool/box.obj" not in said  # no other has its name


def test_json_has_the_same_error(library):
    done = spherefunc("classify", "damaged", "--json")
    assert '"error": "damaged/model.obj: expected finite vertices' in done.stdout


def test_a_batch_names_the_object_that_failed(library, tmp_path_factory):
    done = spherefunc("batch", library, "--radii", "5cm", "--jobs", 1, "--run", tmp_path_factory.mktemp("night"))
    assert done.returncode == 2
    assert "spherefunc: damaged/model.obj: expected finite vertices" in done.stderr


def test_shapes_names_the_object_that_failed(library):
    done = spherefunc("shapes", "damaged", "--json")
    assert "spherefunc: damaged/model.obj: expected finite vertices" in done.stderr
    assert '"error": "damaged/model.obj: expected finite vertices' in done.stdout


def test_an_error_about_something_else_is_unchanged():
    error = InputError("mesh.stl: expected finite vertices")
    assert with_path(error, "robots/mug.urdf") is error
    assert with_path(3, "robots/mug.urdf") == 3
