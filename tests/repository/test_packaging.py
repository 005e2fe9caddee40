"""One package is installed and nothing beside it, whole, and files of a user's cannot get in its way."""

from __future__ import annotations

import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import clouds
import numpy as np
import pytest
import yaml
from checkout import ROOT
from packaging.requirements import Requirement

import spherefunc_bullet

pytestmark = pytest.mark.slow

FOLDERS = {
    "spherefunc_bullet": "spherefunc_bullet",
    "fast_sim": "spherefunc_bullet/fast_sim",
    "scenes": "spherefunc_bullet/scenes",
    "compare": "spherefunc_bullet/compare",
}
HOSTILE = ("compare", "scenes", "fast_sim", "commands", "formats", "errors", "simulator", "console")


def installed_names() -> set[str]:
    """Return the files of the repository that belong into site-packages, as they are called there."""
    kinds = ("*.py", "*.pyi", "*.js", "*.css", "*.html", "*.csv", "*.npz", "*.urdf", "py.typed")
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
    build = [sys.executable, "-m", "pip", "wheel", "-v", "--no-deps", "--no-build-isolation", "-w", folder, source]
    done = subprocess.run(build, check=True, capture_output=True, text=True)
    (folder / "said.txt").write_text(done.stdout + done.stderr)
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


def test_the_wheel_is_built_without_a_warning_of_ours(wheel):
    said = wheel.with_name("said.txt").read_text()
    assert "Building wheel" in said
    assert "absent from the `packages` configuration" not in said and "Package would be ignored" not in said


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
    asked = [["backends", "--json"]]
    if kind == "editable":  # of a wheel, in the fresh environment below: compiling its kernels takes half a minute
        asked.append(["simulate", "plate.xyz", "--radius", "2cm", "--json"])
    for arguments in asked:
        done = run_from(hostile, site, *arguments)
        assert done.returncode == 0 and '"fast"' in done.stdout, done.stderr


@pytest.fixture(scope="module")
def fresh(wheel, tmp_path_factory) -> Path:
    """Return the commands of a new environment with the wheel installed; what it needs is borrowed from ours."""
    home = tmp_path_factory.mktemp("fresh")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", home], check=True)
    pip = [sys.executable, "-m", "pip", "--python", home / "bin" / "python", "--disable-pip-version-check"]
    subprocess.run([*pip, "install", "-q", "--no-deps", "--no-index", wheel], check=True, capture_output=True)
    # A path file in a path file is not followed: our own editable installation stays out of it.
    site = next(home.glob("lib/python*/site-packages"))
    (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    borrow_kernels(home / "bin")
    return home / "bin"


DEAREST = ("fast_sim.dropping:drop_spheres", "fast_sim.grid:find_nearest", "settling.enclosure:met_everywhere")
WHERE = """from importlib import import_module
for kernel in {kernels}:
    module, _, name = kernel.partition(":")
    print(getattr(import_module("spherefunc_bullet." + module), name).stats.cache_path)"""


def borrow_kernels(commands: Path):
    """Copy the dearest compiled kernels of this checkout, if it has them, to an environment: compiling takes 20 s.

    What else a first answer needs is compiled there, as these would be where numba does not take the copies.
    """
    code = WHERE.format(kernels=DEAREST)
    ours, theirs = (output([python, "-c", code], Path("/")) for python in (sys.executable, commands / "python"))
    for mine, yours in zip(ours.splitlines(), theirs.splitlines(), strict=True):
        if Path(mine).is_dir():
            shutil.copytree(mine, yours, dirs_exist_ok=True)


def ended(command: list[Path | str], folder: Path) -> subprocess.CompletedProcess:
    """Run a command in a folder, where its kernels are kept beside its code."""
    environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "NUMBA_CACHE_DIR")}
    environment["SPHEREFUNC_CACHE"] = str(folder / "cache")
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done


def output(command: list[Path | str], folder: Path) -> str:
    """Return what a command prints in a folder."""
    return ended(command, folder).stdout


def test_the_wheel_works_in_a_fresh_environment(fresh, hostile):
    where = output([fresh / "python", "-c", "import spherefunc_bullet as sf; print(sf.__file__)"], Path("/"))
    assert Path(where).is_relative_to(fresh.parent)
    assert output([fresh / "spherefunc", "--version"], hostile) == f"spherefunc {spherefunc_bullet.__version__}\n"
    # The first answer after an installation compiles the kernels, says so, and leaves them for all others.
    np.savez(hostile / "first.npz", points=clouds.mug(height=0.09).points)
    np.savez(hostile / "second.npz", points=clouds.mug(height=0.10).points)
    first = ended([fresh / "spherefunc", "classify", "first.npz", "plate.xyz", "--json"], hostile)
    assert "compiling" in first.stderr and first.stdout.startswith("[") and '"plate.xyz"' in first.stdout
    assert ended([fresh / "spherefunc", "classify", "second.npz"], hostile).stderr == ""
    assert '"settled"' in output(
        [fresh / "python", "-P", "-m", "spherefunc_bullet", "simulate", "plate.xyz", "--radius", "2cm", "--json"],
        hostile,
    )


def test_the_wheel_is_typed_for_its_users(wheel, tmp_path):
    """Of what it needs mypy knows nothing here: reading numpy's own types takes it longer than all of ours."""
    home = tmp_path / "bare"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", home], check=True)
    zipfile.ZipFile(wheel).extractall(next(home.glob("lib/python*/site-packages")))
    (tmp_path / "use.py").write_text("import spherefunc_bullet as sf\nreveal_type(sf.load_cloud)\n")
    command = [sys.executable, "-m", "mypy", "--python-executable", home / "bin" / "python"]
    command += ["--follow-imports=silent", "--ignore-missing-imports", "--cache-dir", os.devnull, "use.py"]
    assert "-> spherefunc_bullet.clouds.cloud.Cloud" in output(command, tmp_path)


def test_version_is_the_same_everywhere():
    version = spherefunc_bullet.__version__
    assert importlib.metadata.version("spherefunc-bullet") == version
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text())["version"] == version


def test_pybullet_comes_by_itself_where_it_has_wheels():
    needs = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    (marker,) = [need.marker for need in map(Requirement, needs) if need.name == "pybullet"]
    linux = {"python_version": "3.11", "sys_platform": "linux", "platform_machine": "x86_64"}
    assert marker.evaluate(linux)
    assert not marker.evaluate(linux | {"python_version": "3.12"})
    assert not marker.evaluate(linux | {"sys_platform": "darwin"})
    assert not marker.evaluate(linux | {"platform_machine": "aarch64"})


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_shell_completes_commands(shell):
    spherefunc = Path(sys.executable).with_name("spherefunc")
    words = {"COMP_WORDS": "spherefunc cla", "COMP_CWORD": "1", "_TYPER_COMPLETE_ARGS": "spherefunc cla"}
    environment = (
        os.environ | words | {"_SPHEREFUNC_COMPLETE": f"complete_{shell}", "_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    )
    done = subprocess.run([spherefunc], env=environment, capture_output=True, text=True, check=False)
    assert "classify" in done.stdout and "simulate" not in done.stdout, done.stderr


def test_what_open3d_is_linked_against_is_set_up():
    """A slim system lacks libraries that a desktop has; the ones that wheels do not bring are in setup.sh."""
    open3d = Path(sysconfig.get_path("purelib")) / "open3d"
    library = next(open3d.glob("libOpen3D.so*"), None)
    if library is None or shutil.which("readelf") is None:
        pytest.skip("no shared library of Open3D, or no readelf to look into it")
    listed = subprocess.run(["readelf", "-d", library], capture_output=True, text=True, check=True).stdout
    needed = set(re.findall(r"NEEDED.*\[(.+)\]", listed)) - {file.name for file in open3d.rglob("*.so*")}
    basic = {"libstdc++.so.6", "libgcc_s.so.1", "libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2", "libpthread.so.0"}
    basic |= {"libdl.so.2", "librt.so.1"}  # the C library's, and what Python itself is linked against
    assert needed - basic <= set(re.findall(r"(lib\S+\.so\.\d+):", (ROOT / "setup.sh").read_text()))


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


def test_the_environment_says_which_python_make_takes():
    """setup.sh reads PYTHON; a value of the Makefile's own would hide it."""
    asked = ["make", "--print-data-base", "--dry-run", "setup"]
    done = subprocess.run(asked, cwd=ROOT, env=os.environ | {"PYTHON": "/else/python3"}, capture_output=True, text=True)
    assert re.search(r"^PYTHON :?= /else/python3$", done.stdout, re.MULTILINE)
