"""Compiled kernels are found again, and made anew when what decides them has changed, and only then."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from checkout import ROOT
from clouds import mug
from numba.core.dispatcher import Dispatcher
from room_shapes import room

import spherefunc_bullet as sf
import spherefunc_bullet.scenes.recognition.recognition  # noqa: F401 (for its kernels)

REPOSITORY = ROOT
OWN_FILE_ALONE = {"lzf.py"}  # kernels that take nothing from other files
FILES = {
    "__init__": "",
    "numbers": "STEP = 3\nSIDES = (1, 2)\n",
    "inner": """
from spherefunc_bullet.processes.compilation import njit

@njit(cache=True)
def twice(x):
    return 2 * x
""",
    "outer": """
from spherefunc_bullet.processes.compilation import njit
from .bystander import nothing
from .inner import twice
from .numbers import SIDES, STEP

@njit(cache=True)
def run(x):
    return twice(x) + STEP * SIDES[0]
""",
    "bystander": "def nothing():\n    return 0\n",
}
RUN = "from kernels.outer import run; print(run(1), *run.stats.cache_hits.values())"
# Reads what to run, with which variables of the environment, a line each, and runs it in a copy of itself that has
# loaded numba and none of the kernels: a new process, but for the second that numba takes.
NEW_PROCESSES = """
import json, os, sys
from numba.core import config
from spherefunc_bullet.processes.compilation import njit

njit(lambda x: x + 1)(1)  # as one that has compiled something
for line in sys.stdin:
    code, variables = json.loads(line)
    copy = os.fork()
    if not copy:
        os.environ.update(variables)
        config.reload_config()
        exec(code, {})
        sys.stdout.flush()
        os._exit(0)
    os.waitpid(copy, 0)
    print(flush=True)
"""


@pytest.fixture
def kernels(tmp_path):
    """Return a function that runs a package of kernels in a new process, after changes of its files.

    It returns what the kernel returns, and whether its code was there.
    """
    folder = tmp_path / "kernels"
    folder.mkdir()
    for name, text in FILES.items():
        (folder / f"{name}.py").write_text(text)
    path = os.pathsep.join([str(tmp_path), str(REPOSITORY)])
    processes = subprocess.Popen(
        [sys.executable, "-B", "-c", NEW_PROCESSES],
        env=os.environ | {"PYTHONPATH": path},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )

    def run(name="__init__", old="", new="", code=RUN, **variables) -> tuple[float | bool, ...]:
        file = folder / f"{name}.py"
        file.write_text(file.read_text().replace(old, new) if old else file.read_text())
        print(json.dumps([code, variables]), file=processes.stdin, flush=True)
        value, *hits = processes.stdout.readline().split()  # nothing where it failed, and stderr says why
        processes.stdout.readline()
        return float(value), bool(hits)

    with processes:
        yield run
        processes.stdin.close()


CHANGES = (  # one after the other, with the value that they make together and whether the code is found
    ("__init__", "", "", 5, True),
    ("numbers", "STEP = 3", "STEP = 4", 6, False),
    ("numbers", "(1, 2)", "(2, 2)", 10, False),
    ("inner", "2 * x", "3 * x", 11, False),
    ("outer", "STEP *", "1 + STEP *", 12, False),
    ("bystander", "return 0", "return 1", 12, True),
)


@pytest.mark.slow
def test_only_what_decides_it_makes_code_anew_and_older_code_is_removed(kernels, tmp_path):
    assert kernels() == (5, False)
    for file, old, new, value, found in CHANGES:
        before = set(tmp_path.glob("kernels/__pycache__/kernels-outer-*"))
        assert kernels(file, old, new) == (value, found)
        after = set(tmp_path.glob("kernels/__pycache__/kernels-outer-*"))
        assert len(after) == 1 and (after == before) == found


@pytest.mark.slow
def test_code_of_these_sources_stays_where_it_is_while_others_keep_theirs_elsewhere(kernels, tmp_path):
    kernels()
    assert kernels(NUMBA_CACHE_DIR=str(tmp_path / "elsewhere")) == (5, False)
    assert kernels() == (5, True)


def test_code_is_compiled_each_time_where_no_folder_for_it_can_be_written(kernels, tmp_path):
    nowhere = "from numba.core.caching import CompileResultCacheImpl as kept; kept._locator_classes = []; "
    assert [kernels(code=nowhere + RUN) for _ in range(2)] == [(5, False)] * 2
    assert not any(tmp_path.glob("kernels/__pycache__/*"))


def test_code_is_compiled_each_time_where_the_disk_is_full(kernels):
    full = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0)); "  # no file may get any content
    assert [kernels(code=full + RUN) for _ in range(2)] == [(5, False)] * 2


def turned_by(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])


def test_kernels_let_other_threads_run_meanwhile():
    loaded = [vars(module) for name, module in sys.modules.items() if name.startswith("spherefunc_bullet.")]
    kernels = {id(value): value for names in loaded for value in names.values() if isinstance(value, Dispatcher)}
    assert len(kernels) > 30
    assert all(kernel.targetoptions["nogil"] for kernel in kernels.values())


def test_answers_in_threads_are_those_of_one_thread():
    def answer(height: float) -> dict[str, float]:
        return sf.classify(mug(0.03, height), cache=False).scores

    heights = np.linspace(0.06, 0.12, 6)
    with ThreadPoolExecutor(3) as threads:
        at_once = list(threads.map(answer, heights))
    assert at_once == [answer(height) for height in heights]


@pytest.mark.slow
def test_scans_in_threads_are_recognised_as_in_one():
    def answer(turn: float) -> list[dict[str, float]]:
        return [found.scores for found in sf.find_objects(room()[0] @ turned_by(turn).T)]

    turns = [0.0, 0.3, 0.6]
    with ThreadPoolExecutor(3) as threads:
        at_once = list(threads.map(answer, turns))
    assert at_once == [answer(turn) for turn in turns] and all(at_once)


def test_every_file_with_kernels_has_them_kept_so():
    for folder in ("fast_sim", "scenes", "compare", "spherefunc_bullet"):
        for file in (REPOSITORY / folder).rglob("*.py"):
            assert "from numba import njit" not in file.read_text() or file.name in OWN_FILE_ALONE, file


LABEL = """
import sys
import numpy as np
from spherefunc_bullet.clouds.cloud import cloud_from_mesh
from spherefunc_bullet.settling.drops import RunLimit
from spherefunc_bullet.settling.settling import settle

cloud = cloud_from_mesh([[0, 0, 0.1], [0.2, 0, 0.1], [0, 0.2, 0.1]], [[0, 1, 2]])
settle(cloud, "fast", [0.01, 0.03], run_limit=RunLimit(drops=40))
print("numba.np.arrayobj" in sys.modules)
"""


@pytest.mark.slow
def test_kept_kernels_are_loaded_without_the_compiler():
    """The first process may compile; what it keeps is loaded by the second without numba's functions of arrays."""
    said = [subprocess.run([sys.executable, "-c", LABEL], capture_output=True, text=True, check=True) for _ in range(2)]
    assert said[1].stdout.split() == ["False"]


@pytest.mark.slow
def test_what_was_not_kept_is_compiled(kernels):
    """For numbers of another kind, though code for the first kind was loaded."""
    kernels()
    asking = "from kernels.outer import run; print(run(1) + run(1.5), *[1] * (len(run.signatures) == 2))"
    assert kernels(code=asking) == (11, True)
