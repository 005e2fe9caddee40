"""Imports point inward, and what is heavy waits until it is used."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import clouds
import pytest
from checkout import ROOT

HEAVY = ("numba", "open3d", "sklearn", "scipy", "scipy.stats", "matplotlib", "trimesh", "pybullet")


def loaded_by(code: str) -> set[str]:
    """Return which of the heavy modules a new interpreter has loaded after running code."""
    code += f"\nimport sys; print(*({HEAVY!r} & sys.modules.keys()), file=sys.stderr)"
    code = code.replace(repr(HEAVY), repr(set(HEAVY)))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    return set(done.stderr.splitlines()[-1].split())


def test_imports_run_one_way(tmp_path):
    """The contracts of pyproject.toml hold, over the folders as they are installed."""
    linter = Path(sys.executable).with_name("lint-imports")
    if not linter.is_file():
        pytest.skip("import-linter is not installed")
    for folder in ("spherefunc_bullet", "fast_sim", "scenes", "compare"):
        place = tmp_path if folder == "spherefunc_bullet" else tmp_path / "spherefunc_bullet"
        shutil.copytree(ROOT / folder, place / folder)
    command = [linter, "--config", ROOT / "pyproject.toml", "--no-cache"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
def test_heavy_modules_are_seen():
    assert loaded_by("import sklearn") == {"sklearn", "scipy", "scipy.stats"}


def test_importing_the_package_is_light():
    assert loaded_by("import spherefunc_bullet") == set()


def test_help_is_light():
    code = "import sys\nfrom spherefunc_bullet.commands.command_line import main\nsys.argv = ['spherefunc', '--help']\n"
    assert loaded_by(code + "try:\n    main()\nexcept SystemExit:\n    pass") == set()


def test_a_command_is_read_alone():
    from spherefunc_bullet.commands.command_line import application

    assert [command.name for command in application("classify").registered_commands] == ["classify"]
    every = {command.name for command in application().registered_commands}
    assert {"classify", "simulate", "train"} < every
    assert {command.name for command in application("clasify").registered_commands} == every


@pytest.mark.parametrize(
    "asking",
    [
        pytest.param(
            "import sys\nfrom spherefunc_bullet.commands.command_line import main\n"
            "sys.argv = ['spherefunc', 'classify', '--explain', {path!r}]\n"
            "try:\n    main()\nexcept SystemExit as left:\n    assert not left.code",
            id="command",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "import spherefunc_bullet as sf\nassert sf.classify({path!r}, cache=True).functions == {{'cup'}}",
            id="call",
        ),
    ],
)
@pytest.mark.slow
def test_asking_loads_nothing_that_only_learning_needs(asking, tmp_path, monkeypatch):
    """The first time kernels are loaded, and numba asks SciPy for its linear algebra; what is kept needs neither."""
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))
    mug = clouds.mug().points
    header = f"ply\nformat ascii 1.0\nelement vertex {len(mug)}\n" + "".join(f"property float {k}\n" for k in "xyz")
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in mug)
    (tmp_path / "mug.ply").write_text(f"{header}end_header\n{rows}")
    code = asking.format(path=str(tmp_path / "mug.ply"))
    assert loaded_by(code) <= {"numba", "scipy"}
    assert loaded_by(code) == set()


def test_finding_objects_in_scans_loads_nothing_that_only_learning_needs():
    modules = "recognition.recognition", "recognition.objects", "report.files", "fusion.scene_fusion"
    imports = ", ".join(f"spherefunc_bullet.scenes.{module}" for module in modules)
    assert loaded_by(f"import {imports}").isdisjoint({"sklearn", "scipy.stats", "open3d", "matplotlib", "pybullet"})


def test_every_public_name_is_there():
    import spherefunc_bullet

    for name in dir(spherefunc_bullet):
        assert getattr(spherefunc_bullet, name) is not None
    with pytest.raises(AttributeError, match="no_such_name"):
        spherefunc_bullet.no_such_name  # noqa: B018
