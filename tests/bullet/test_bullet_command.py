"""The Bullet backend behind the commands, in processes as a user starts them where that is what is looked at."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import trimesh
from commands import spherefunc

from spherefunc_bullet.learning import function_classifier

pytestmark = pytest.mark.slow

COMMAND = Path(sys.executable).with_name("spherefunc")
needs_engine = pytest.mark.skipif(find_spec("pybullet") is None, reason="PyBullet is not installed")
# What a machine without PyBullet looks like to Python: no metadata and no module of that name.
WITHOUT = """
import importlib.metadata as metadata, sys
found = metadata.version
def version(name):
    if name == "pybullet":
        raise metadata.PackageNotFoundError(name)
    return found(name)
metadata.version = version
sys.modules["pybullet"] = None
"""


def run(*arguments, cwd: Path, **environment) -> subprocess.CompletedProcess:
    """Run the command with a cache of its own."""
    env = os.environ | {"SPHEREFUNC_CACHE": str(cwd / "cache")} | environment
    return subprocess.run([COMMAND, *map(str, arguments)], cwd=cwd, env=env, capture_output=True, text=True)


@pytest.fixture
def folder(tmp_path) -> Path:
    """Return a folder with a box without a lid, as a mesh and as points."""
    walls = [((0.2, 0.2, 0.01), (0, 0, 0.005))]
    walls += [((0.2, 0.01, 0.1), (0, s * 0.095, 0.05)) for s in (-1, 1)]
    walls += [((0.01, 0.2, 0.1), (s * 0.095, 0, 0.05)) for s in (-1, 1)]
    parts = [trimesh.creation.box(size, trimesh.transformations.translation_matrix(at)) for size, at in walls]
    mesh = trimesh.util.concatenate(parts)
    mesh.export(tmp_path / "tray.ply")
    np.savetxt(tmp_path / "tray.xyz", trimesh.sample.sample_surface_even(mesh, 20_000, seed=0)[0])
    return tmp_path


@needs_engine
@pytest.mark.parametrize("shape", ["voxel", "compound", "mesh"])
def test_simulate_prints_clean_json_for_every_shape(folder, shape):
    done = run("simulate", "tray.ply", "--backend", "bullet", "--shape", shape, "--radius", "1cm", "--json", cwd=folder)
    assert done.returncode == 0, done.stderr
    [row] = json.loads(done.stdout)
    assert row["backend"] == "bullet" and row["provenance"]["shape"]["kind"] == shape
    assert row["settled"] > 50
    assert row["drops"] == row["settled"] + row["rolled_off"] + row["rejected"] + row["timed_out"]


@needs_engine
def test_one_file_that_no_shape_can_be_made_of_costs_that_file(folder):
    arguments = ["--backend", "bullet", "--shape", "mesh", "--radius", "1cm", "--json", "--out", "settled"]
    done = run("simulate", "tray.xyz", "tray.ply", *arguments, cwd=folder)
    # On a new machine a line about compiling comes before.
    assert done.returncode == 2 and ["tray.xyz" in line for line in done.stderr.splitlines()].count(True) == 1
    assert "Traceback" not in done.stderr
    assert [row["file"] for row in json.loads(done.stdout)] == ["tray.ply"]
    [written] = (folder / "settled").glob("tray*.npz")
    centers = np.load(written)["centers"]
    assert centers.shape[1] == 3 and centers[:, 2].min() > 0.0095


@needs_engine
def test_evaluate_takes_the_backend(folder, monkeypatch):
    rows = ["file,label"]
    for i in range(4):
        for label, name in (("cup", "tray"), ("none", "block")):
            mesh = trimesh.load(folder / "tray.ply") if label == "cup" else trimesh.creation.box((0.2, 0.2, 0.1))
            mesh.apply_scale(1 + 0.05 * i)
            mesh.export(folder / f"{name}_{i}.ply")
            rows.append(f"{name}_{i}.ply,{label}")
    (folder / "manifest.csv").write_text("\n".join(rows))
    arguments = ["--backend", "bullet", "--radii", "2cm", "--trials", "1", "--train-sizes", "half", "--json"]
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(folder / "cache"))
    monkeypatch.setattr(function_classifier, "TREES", 8)  # what forests say is not looked at
    done = spherefunc("evaluate", folder, *arguments)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["backend"] == "bullet" and "cup" in found["results"][0]["functions"]


@needs_engine
def test_classify_has_a_model_of_this_backend(folder):
    done = run("classify", "tray.ply", "--backend", "bullet", "--json", cwd=folder)
    assert done.returncode == 0, done.stderr
    [row] = json.loads(done.stdout)
    assert set(row["functions"]) == {"cup", "sittable", "table"}
    assert all(0 <= each["score"] <= 1 for each in row["functions"].values())


@pytest.fixture
def without_engine(tmp_path) -> dict[str, str]:
    """Return an environment in which PyBullet is not to be found."""
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "sitecustomize.py").write_text(WITHOUT)
    return {"PYTHONPATH": str(tmp_path / "site")}


def test_without_pybullet_one_line_says_what_to_install(folder, without_engine):
    done = run("simulate", "tray.ply", "--backend", "bullet", cwd=folder, **without_engine)
    assert done.returncode == 2 and done.stdout == ""
    [line] = done.stderr.splitlines()
    assert "pip install" in line and "pybullet" in line and "3.11" in line


def test_without_pybullet_the_rest_works(folder, without_engine):
    done = run("simulate", "tray.ply", "--radius", "1cm", "--json", cwd=folder, **without_engine)
    assert done.returncode == 0 and json.loads(done.stdout)[0]["backend"] == "fast"
    listed = json.loads(run("backends", "--json", cwd=folder, **without_engine).stdout)
    available = {row["name"]: row["available"] for row in listed}
    assert available["fast"] and not available["bullet"]
