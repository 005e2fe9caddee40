"""The installed backends keep the contract, and backends of other packages can be held to it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import clouds
import numpy as np
import pytest
from checkout import ROOT

from spherefunc_bullet.conformance.test_simulator import *  # noqa: F403
from spherefunc_bullet.conformance.test_simulator import SHAPES
from spherefunc_bullet.simulator import DropResult, Stop

PAGE = (ROOT / "docs" / "backends.md").read_text(encoding="utf-8")


def install(folder: Path, project: str, module: str, code: str):
    """Put a package of one module into a folder, with the entry points of its pyproject.toml."""
    declared = tomllib.loads(project)["project"]
    about = folder / f"{module}-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {declared['name']}\nVersion: 1\n")
    points = declared["entry-points"]["spherefunc.backends"]
    (about / "entry_points.txt").write_text(
        "\n".join(["[spherefunc.backends]", *(f"{name} = {point}" for name, point in points.items())])
    )
    (folder / f"{module}.py").write_text(code)


@pytest.fixture
def sticky(tmp_path) -> Path:
    """Return a folder with the page's backend."""
    code, project = re.findall(r"```(?:python|toml)\n(.*?)```", PAGE, re.DOTALL)
    install(tmp_path, project, "spherefunc_sticky", code)
    return tmp_path


def suite(backend: str, folder: Path, *arguments: str, as_installed: bool = False) -> str:
    """Return what the suite prints, run over one backend in a folder as another package would.

    As it is installed, pytest finds our option by itself, and loads what else there is on the machine, but for a plugin
    that comes with Open3D and takes seconds.
    """
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:dash"]
    environment = os.environ | {"PYTHONPATH": str(folder)}
    if not as_installed:
        command += ["-p", "spherefunc_bullet.conformance.option"]
        environment["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    command += ["--pyargs", "spherefunc_bullet.conformance", "--backend", backend, *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False).stdout


@pytest.mark.slow
def test_the_page_s_backend_keeps_the_contract(sticky):
    # Without the optional parts, which it lacks, and the two largest shapes, which are as a plate to it.
    required = "not mechanics and not chair and not table"
    printed = suite("sticky", sticky, "-k", required, as_installed=True)
    assert "failed" not in printed and "skipped" not in printed, printed
    assert int(re.search(r"(\d+) passed", printed)[1]) > 10 * (len(SHAPES) - 2)  # ten truths of each shape, and others


@pytest.mark.slow
def test_a_backend_that_breaks_the_contract_is_told(sticky):
    source = sticky / "spherefunc_sticky.py"
    right = source.read_text()
    source.write_text(right.replace("settings, seed), None", "settings, time.time_ns()), None"))
    assert "FAILED" in suite("sticky", sticky, "-k", "same_seed and plate")
    source.write_text(right.replace("source.draw(1)[0]", "source.generator.uniform(low[:2], high[:2])"))
    assert "FAILED" in suite("sticky", sticky, "-k", "spread_evenly")


def test_a_backend_asked_for_by_name_is_not_skipped_when_it_is_missing(tmp_path):
    assert "expected one of" in suite("nobody-s", tmp_path, "-k", "interface")


def test_the_page_s_backend_is_taken_by_the_commands(sticky):
    np.savetxt(sticky / "plate.xyz", clouds.plate().points)
    command = [sys.executable, "-m", "spherefunc_bullet", "simulate", "plate.xyz", "--backend", "sticky"]
    command += ["--radius", "2cm", "--json"]
    environment = os.environ | {"PYTHONPATH": str(sticky)}
    done = subprocess.run(command, cwd=sticky, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and '"backend": "sticky"' in done.stdout, done.stderr


def test_a_result_without_provenance_is_refused_where_it_is_made():
    nothing = {"centers": np.empty((0, 3)), "on_object": np.empty(0, bool), "stop": Stop.MISSES, "seconds": 0.0}
    nothing |= {"rolled_off": 50, "rejected": 0, "timed_out": 0}
    with pytest.raises(TypeError, match="provenance"):
        DropResult(**nothing)
    with pytest.raises(ValueError, match="provenance.*version.*provenance_of"):
        DropResult(**nothing, provenance={"backend": "x", "seed": 0, "settings": {}})


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"centers": np.full((1, 3), np.nan)}, "centers.*finite"),
        ({"centers": np.zeros((1, 2))}, r"centers.*floats \(S, 3\), got float64 \(1, 2\)"),
        ({"centers": [[0.0, 0.0, 1.0]]}, "centers.*array of floats.*list"),
        ({"centers": np.zeros((2, 3))}, "outcomes: expected.* 2 settled.*1 of them settled"),
        ({"columns": np.zeros((3, 2))}, "outcomes: expected a column for each.*3 columns, 1 outcomes"),
    ],
)
def test_a_result_that_contradicts_itself_is_refused_where_it_is_made(wrong, words):
    """Caches and ledgers would keep it."""
    right = {"centers": np.zeros((1, 3)), "columns": np.zeros((1, 2)), "outcomes": np.zeros(1, np.int8)}
    about = {"on_object": np.ones(1, bool), "rolled_off": 0, "rejected": 0, "timed_out": 0, "stop": Stop.MISSES}
    about |= {"seconds": 0.0, "provenance": {"backend": "x", "version": "1", "seed": 0, "settings": {}}}
    assert DropResult(**right, **about).settled == 1
    with pytest.raises(ValueError, match=words):
        DropResult(**(right | wrong), **about)


def test_backends_that_cannot_be_made_are_a_line_each_and_hide_no_other(tmp_path):
    code = "class Unlicensed:\n    def __init__(self):\n        raise RuntimeError('no licence')\n"
    code += "class Unversioned:\n    name = 'unversioned'\n"
    points = "".join(f'{name.lower()} = "half:{name}"\n' for name in ("Absent", "Unlicensed", "Unversioned"))
    install(tmp_path, f'[project]\nname = "half"\n[project.entry-points."spherefunc.backends"]\n{points}', "half", code)
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    command = [sys.executable, "-m", "spherefunc_bullet"]
    done = subprocess.run([*command, "backends"], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "fast" in done.stdout, done.stderr
    for words in ("no attribute 'Absent'", "'unlicensed': no licence", "'unversioned': expected name, version"):
        assert words in done.stderr
    carry = [*command, "carry", "x.ply", "--backend", "fast"]
    done = subprocess.run(carry, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr


@pytest.mark.slow
def test_mujoco_keeps_the_contract(tmp_path):
    """The example of a backend elsewhere, on the shape that takes it seconds; docs/backends.md says how on all."""
    pytest.importorskip("mujoco")
    example = ROOT / "examples" / "mujoco_backend"
    module = (example / "spherefunc_mujoco.py").read_text()
    install(tmp_path, (example / "pyproject.toml").read_text(), "spherefunc_mujoco", module)
    printed = suite("mujoco", tmp_path, "-k", "(plate or interface or provenance or larger) and not mechanics")
    assert "passed" in printed and "failed" not in printed and "skipped" not in printed, printed
