"""``spherefunc dataset``: JSON on stdout, everything else on stderr, mistakes as InputError."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

import spherefunc_bullet.datasets.catalogue as catalogue
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.commands.dataset import app
from spherefunc_bullet.scenes.household.household import household_objects
from spherefunc_bullet.scenes.sweethome3d.library import CATALOGUE

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
ENTRIES = """
name#1=Stool
model#1=a.obj
width#1=40
depth#1=40
height#1=45
name#2=Chair
model#2=gone.obj
width#2=40
depth#2=40
height#2=45
name#3=Bowl
model#3=a.obj
width#3=20
depth#3=20
height#3=8
"""


class OneCatalogue:
    """An entry point, so that the test also runs where the package is not installed."""

    @staticmethod
    def load():
        return household_objects


@pytest.fixture
def run(monkeypatch):
    monkeypatch.setattr(catalogue, "catalogue_entry_points", lambda: {"household": OneCatalogue})
    return lambda *arguments: CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Return the folder of the built catalogue, and what building it printed."""
    folder = tmp_path_factory.mktemp("built") / "set"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(catalogue, "catalogue_entry_points", lambda: {"household": OneCatalogue})
        return folder, CliRunner().invoke(app, ["build", "household", str(folder), "--json"]).stdout


@pytest.fixture
def furniture(tmp_path):
    path = tmp_path / "some.sh3f"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(CATALOGUE, ENTRIES)
        archive.writestr("a.obj", TETRAHEDRON)
    return path


@pytest.mark.slow
def test_build_and_describe(run, built):
    folder, printed = built
    about = json.loads(printed)
    assert about["labels"] == {"cup": 30, "none": 90, "sittable": 40, "table": 40}
    described = json.loads(run("describe", folder, "--json").stdout)
    assert described["objects"] == 200 and described["labels"] == about["labels"]
    assert described["groups"] == {"household": 200}
    assert 0.6 < described["height"]["table"]["median"] < 0.8


@pytest.mark.slow
def test_seed_makes_other_objects(run, built, tmp_path):
    run("build", "household", tmp_path / "set", "--seed", 1)
    assert (tmp_path / "set" / "mug_01.ply").read_bytes() != (built[0] / "mug_01.ply").read_bytes()


def test_import_says_what_it_skipped(run, furniture, tmp_path):
    result = run("import", furniture, tmp_path / "out", "--json")
    about = json.loads(result.stdout)
    assert (about["labels"], about["ambiguous"], about["skipped"]) == ({"sittable": 1}, 1, 1)
    assert "gone.obj" in result.stderr and len(result.stderr.strip().splitlines()) == 1
    everything = json.loads(run("import", furniture, tmp_path / "all", "--all", "--json").stdout)
    assert everything["objects"] == 2


def test_without_json_standard_output_stays_empty(run, furniture, tmp_path):
    result = run("import", furniture, tmp_path / "out")
    assert result.stdout == "" and "labels: sittable 1" in result.stderr
    result = run("describe", tmp_path / "out")
    assert result.stdout == "" and "height: sittable 0.45 to 0.45 m" in result.stderr


@pytest.mark.parametrize(
    "arguments", [("build", "nothing", "out"), ("import", "gone.sh3f", "out"), ("describe", "gone")]
)
def test_mistakes_are_input_errors(run, tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    error = run(*arguments).exception
    assert isinstance(error, InputError) and "expected" in str(error) and "\n" not in str(error)


def test_folder_that_cannot_be_written_is_an_input_error(run, tmp_path):
    (tmp_path / "file").write_text("in the way")
    assert isinstance(run("build", "household", tmp_path / "file").exception, InputError)


def test_import_of_the_module_stays_light():
    code = "import sys, spherefunc_bullet.scenes.commands.dataset as _; "
    code += "sys.exit(bool({'numpy', 'trimesh'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_select_copies_the_small_objects_with_their_labels(run, tmp_path):
    rows = ["file,label,also,category,group"]
    for name, label, size in (("mug", "cup", 0.1), ("block", "none", 0.2), ("chair", "sittable", 0.9)):
        (tmp_path / f"{name}.obj").write_text(TETRAHEDRON.replace("1", f"{size}", 3))
        rows.append(f"{name}.obj,{label},,{name},here")
    (tmp_path / "manifest.csv").write_text("\n".join(rows))
    done = run("select", tmp_path, tmp_path / "small", "--up-to", "30cm", "--json")
    assert done.exit_code == 0 and json.loads(done.stdout)["objects"] == 2
    chosen = open_dataset(tmp_path / "small").objects
    assert [(sorted(item.functions), item.category, item.group) for item in chosen] == [
        (["cup"], "mug", "here"),
        ([], "block", "here"),
    ]
    assert all(item.path.is_file() for item in chosen)
    done = run("select", tmp_path, tmp_path / "large", "--from", "15cm", "--json")
    assert json.loads(done.stdout) | {"manifest": ""} == {"manifest": "", "objects": 2, "of": 3}
    assert [item.category for item in open_dataset(tmp_path / "large").objects] == ["block", "chair"]


def test_labels_of_other_files_are_not_lost(run, furniture, tmp_path):
    (tmp_path / "mug.obj").write_text(TETRAHEDRON)
    (tmp_path / "manifest.csv").write_text("file,label\nmug.obj,cup")
    for arguments in (["select", tmp_path], ["import", furniture, "--all"]):
        folder = tmp_path / arguments[0]
        first, again = (run(arguments[0], arguments[1], folder, *arguments[2:]) for _ in range(2))
        assert first.exit_code == again.exit_code == 0
        manifest = folder / "manifest.csv"
        manifest.write_text("file,label\nmine.ply,cup\n")
        kept = {path: path.read_bytes() for path in folder.iterdir()}
        refused = run(arguments[0], arguments[1], folder, *arguments[2:])
        assert isinstance(refused.exception, InputError) and "1 others, such as mine.ply" in str(refused.exception)
        assert {path: path.read_bytes() for path in folder.iterdir()} == kept


def test_select_of_nothing_is_said(run, tmp_path):
    (tmp_path / "block.obj").write_text(TETRAHEDRON)
    (tmp_path / "manifest.csv").write_text("file,label\nblock.obj,none")
    done = run("select", tmp_path, tmp_path / "small", "--up-to", "1cm")
    assert isinstance(done.exception, InputError) and "1cm" in str(done.exception)


@pytest.mark.parametrize("command", [["describe"], ["select", "DIR/some", "--up-to", "5m"]])
def test_a_file_that_cannot_be_used_costs_itself(run, tmp_path, command):
    np.save(tmp_path / "a.npy", [[0, 0, 0], [0.1, 0.2, 0.3], [0, 0, 0.4]])
    (tmp_path / "manifest.csv").write_text("file,label\nnone.ply,cup\na.npy,cup\n")
    done = run(command[0], tmp_path, *[word.replace("DIR", str(tmp_path)) for word in command[1:]], "--json")
    assert done.exit_code == 2 and done.stderr.count("\n") == 1
    assert "none.ply: expected a file, found none" in done.stderr
    about = json.loads(done.stdout)
    assert about["height"]["cup"]["max"] == 0.4 if command == ["describe"] else about["objects"] == 1


def test_objects_of_gltf_are_as_high_as_they_stand(run, tmp_path):
    (tmp_path / "cup").mkdir()
    trimesh.creation.box((0.1, 0.3, 0.2)).export(tmp_path / "cup" / "a.glb")  # y up
    assert json.loads(run("describe", tmp_path, "--json").stdout)["height"]["cup"]["max"] == 0.3


def test_select_does_not_copy_half_an_object(run, tmp_path):
    (tmp_path / "data" / "cup").mkdir(parents=True)
    box = trimesh.Scene(trimesh.creation.box((0.1, 0.3, 0.2)))
    for name, content in trimesh.exchange.gltf.export_gltf(box).items():
        (tmp_path / "data" / "cup" / name).write_bytes(content)
    box.export(tmp_path / "data" / "cup" / "whole.glb")
    done = run("select", tmp_path / "data", tmp_path / "some", "--up-to", "5m", "--json")
    assert done.exit_code == 2 and json.loads(done.stdout)["objects"] == 1
    assert "model.gltf: expected one file to copy, it names" in done.stderr and "save it as GLB" in done.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="other systems refuse such names of files")
@pytest.mark.parametrize("command", ["select", "impair"])
def test_copies_of_files_with_any_name_are_in_their_manifest(run, tmp_path, command):
    (tmp_path / "data" / "cup").mkdir(parents=True)
    mug = next(item.mesh for item in household_objects() if item.name == "mug_01")
    for name in (b"caf\xe9.ply", b"new\nline.ply"):
        (tmp_path / "data" / "cup" / os.fsdecode(name)).write_bytes(mug.export(file_type="ply"))
    options = ["--kinds", "whole"] if command == "impair" else []
    done = run(command, tmp_path / "data", tmp_path / "copies", *options, "--json")
    copies = open_dataset(tmp_path / "copies").objects
    assert done.exit_code == 0 and len(copies) == 2 and all(item.path.is_file() for item in copies)
