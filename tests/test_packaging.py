"""One package is installed and nothing beside it, whole, and files of a user's cannot get in its way."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import clouds
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = {
    "spherefunc_bullet": "spherefunc_bullet",
    "fast_sim": "spherefunc_bullet/fast_sim",
    "scenes": "spherefunc_bullet/scenes",
    "compare": "spherefunc_bullet/compare",
}
HOSTILE = ("compare", "scenes", "fast_sim", "commands", "formats", "errors", "simulator", "console")


def installed_names() -> set[str]:
    """Return the files of the repository that belong into site-packages, as they are called there."""
    kinds = ("*.py", "*.pyi", "*.js", "*.css", "*.csv", "*.npz", "py.typed")
    return {
        f"{place}/{file.relative_to(ROOT / folder).as_posix()}"
        for folder, place in FOLDERS.items()
        for kind in kinds
        for file in (ROOT / folder).rglob(kind)
        if "__pycache__" not in file.parts
    }


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """Return the wheel, built from a copy of what is in the repository."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode:
        pytest.skip("not a git checkout")
    for name in filter(lambda name: (ROOT / name).is_file(), listed.stdout.splitlines()):
        target = source / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes((ROOT / name).read_bytes())
    build = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", folder, source]
    subprocess.run(build, check=True, capture_output=True)
    return next(folder.glob("*.whl"))


@pytest.fixture
def hostile(tmp_path) -> Path:
    """Return a working directory with modules of a user's that are called as ours, and a cloud."""
    for name in HOSTILE:
        (tmp_path / f"{name}.py").write_text(f"raise SystemExit('the user\\'s own {name}.py was imported')")
    (tmp_path / "spherefunc").mkdir()
    np.savetxt(tmp_path / "plate.xyz", clouds.plate().points)
    return tmp_path


def run_from(folder: Path, path: Path | str, *arguments: str) -> subprocess.CompletedProcess:
    """Run the command line in a folder whose files come first where modules are looked for."""
    code = "import sys; from spherefunc_bullet.commands.command_line import main; main()"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, [str(folder), str(path)]))}
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_packages_that_are_declared_are_those_that_there_are():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    found = {Path(name).parent.as_posix().replace("/", ".") for name in installed_names() if name.endswith(".py")}
    assert set(declared) == found and len(declared) == len(set(declared))


def test_the_wheel_holds_one_package_whole(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
    assert names == installed_names()


def test_an_editable_installation_brings_one_name():
    code = "import importlib.util as u; print([n for n in ('compare', 'scenes', 'fast_sim') if u.find_spec(n)])"
    done = subprocess.run([sys.executable, "-c", code], cwd="/", capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("kind", ["editable", "wheel"])
def test_files_of_a_user_s_do_not_get_in_the_way(kind, wheel, hostile, tmp_path_factory):
    site = ""
    if kind == "wheel":
        site = tmp_path_factory.mktemp("site")
        zipfile.ZipFile(wheel).extractall(site)
    where = run_from(hostile, site, "--help")
    assert where.returncode == 0, where.stderr
    assert {"simulate", "compare", "scene", "dataset"} <= set(where.stdout.split())
    for arguments in (["backends", "--json"], ["simulate", "plate.xyz", "--radius", "2cm", "--json"]):
        done = run_from(hostile, site, *arguments)
        assert done.returncode == 0 and '"fast"' in done.stdout, done.stderr


def test_the_wheel_is_what_ran(wheel, hostile, tmp_path_factory):
    site = tmp_path_factory.mktemp("site")
    zipfile.ZipFile(wheel).extractall(site)
    code = "from spherefunc_bullet.scenes.household import household as h; print(h.__file__)"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=hostile,
        env=os.environ | {"PYTHONPATH": str(site)},
        capture_output=True,
        text=True,
    )
    assert done.stdout.startswith(str(site)), done.stderr
