"""Cached kernels are found again, and forgotten when what decides them has changed, and only then."""

from __future__ import annotations

import importlib
import os
import pickle
import subprocess
import sys
import textwrap

import pytest

from spherefunc_bullet.processes import compilation

FILES = {
    "numbers": "STEP = 3\nUNUSED = 4\n",
    "inner": """
        from numba import njit

        @njit(cache=True)
        def twice(x):
            return 2 * x
        """,
    "outer": """
        from numba import njit

        from .bystander import NOTHING
        from .inner import twice
        from .numbers import STEP

        @njit(cache=True)
        def run(x):
            return twice(x) + STEP
        """,
    "bystander": "NOTHING = 0\n",
}


@pytest.fixture
def kernels(tmp_path, monkeypatch):
    """Return a package of kernels that has been compiled, and the module with the outer one."""
    folder = tmp_path / "spherefunc_kernels"
    folder.mkdir()
    (folder / "__init__.py").touch()
    for name, text in FILES.items():
        (folder / f"{name}.py").write_text(textwrap.dedent(text))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(compilation, "ours", lambda: {name for name in sys.modules if name.startswith(folder.name)})
    outer = importlib.import_module(f"{folder.name}.outer")
    assert outer.run(1) == 5
    yield folder, outer.run
    for name in [name for name in sys.modules if name.startswith(folder.name)]:
        del sys.modules[name]


def touch(file):
    """Make a file newer than everything else."""
    later = max(path.stat().st_mtime for path in file.parent.rglob("*")) + 10
    os.utime(file, (later, later))


def test_what_decides_a_kernel_is_known(kernels):
    folder, run = kernels
    assert {file.stem for file in compilation.sources_of(run)} == {"outer", "inner", "numbers"}
    assert [called.__name__ for called in compilation.kernels_of(run)] == ["run", "twice"]


@pytest.mark.parametrize(("name", "left"), [("bystander", True), ("inner", False), ("numbers", False)])
def test_only_what_decides_it_makes_it_stale(kernels, name, left):
    folder, run = kernels
    assert any(compilation.cached_code(run))
    touch(folder / f"{name}.py")
    compilation.forget_stale(run)
    assert any(compilation.cached_code(run)) == left


def test_code_of_a_renamed_module_is_forgotten(kernels):
    _, run = kernels
    (index,) = compilation.cached_code(run)
    index.write_bytes(pickle.dumps("0.60") + b"cno_such_module\nThing\n.")
    compilation.forget_stale(run)
    assert not any(compilation.cached_code(run))


def test_kernels_are_found_again_in_their_folders():
    """Those of the package, after a run: nothing is compiled anew though nobody touched a source."""
    from spherefunc_bullet.clouds import sampling
    from spherefunc_bullet.clouds.cloud import cloud_from_mesh

    cloud_from_mesh([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0], [0, 0, 0.2]], [[0, 1, 2], [0, 1, 3]])
    compilation.forget_stale(sampling._candidates)
    assert any(compilation.cached_code(sampling._candidates))


LABEL = """
import sys
import numpy as np
from spherefunc_bullet.clouds.cloud import cloud_from_mesh
from spherefunc_bullet.settling.drops import Length
from spherefunc_bullet.settling.settling import settle

cloud = cloud_from_mesh([[0, 0, 0.1], [0.2, 0, 0.1], [0, 0.2, 0.1]], [[0, 1, 2]])
settle(cloud, "fast", [0.01, 0.03], length=Length(drops=40))
print("numba.np.arrayobj" in sys.modules)
"""


def test_kept_kernels_are_loaded_without_the_compiler():
    """The first process may compile; what it keeps is loaded by the second without numba's functions of arrays."""
    told = [subprocess.run([sys.executable, "-c", LABEL], capture_output=True, text=True, check=True) for _ in range(2)]
    assert told[1].stdout.split() == ["False"]


def test_what_was_not_kept_is_compiled(kernels):
    _, run = kernels
    compilation.prepare(run)
    assert run(1.5) == 6.0 and len(run.signatures) == 2
