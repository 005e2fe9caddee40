"""The Bullet backend in threads: what others print meanwhile arrives, and answers are those of one thread."""

from __future__ import annotations

import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from checkout import TESTS

from spherefunc_bullet.bullet.engine import own_descriptors

pytest.importorskip("pybullet", reason="PyBullet is not installed")

THREADS = 4
SCRIPT = """
import ctypes, json, os, sys, threading
from concurrent.futures import ThreadPoolExecutor

sys.path.insert(0, {tests!r})
import clouds
import spherefunc_bullet as sf

THREADS = {threads}
libc, over = ctypes.CDLL(None), threading.Event()
printed = {{1: 0, 2: 0}}


def print_on(descriptor):
    while not over.wait(0.001):
        os.write(descriptor, b"a line\\n")
        printed[descriptor] += 1


def answer(number):
    libc.printf(b"from C %d\\n", number)
    found = sf.classify(clouds.mug(0.03 + 0.002 * number, 0.08), backend="bullet", cache=False)
    libc.printf(b"from C again %d\\n", number)
    return found.scores


before = [(os.fstat(fd).st_dev, os.fstat(fd).st_ino) for fd in (1, 2)]
printers = [threading.Thread(target=print_on, args=(fd,), daemon=True) for fd in printed]
for printer in printers:
    printer.start()
with ThreadPoolExecutor(THREADS) as pool:  # the engine is imported by whichever is first
    at_once = list(pool.map(answer, range(THREADS)))
over.set()
for printer in printers:
    printer.join()
libc.fflush(None)
after = [(os.fstat(fd).st_dev, os.fstat(fd).st_ino) for fd in (1, 2)]
one_by_one = [answer(number) for number in range(THREADS)]
libc.fflush(None)
found = {{"same": before == after, "lines": printed, "at_once": at_once, "one_by_one": one_by_one}}
with open({report!r}, "w") as file:
    json.dump(found, file)
"""


@pytest.fixture(scope="module")
def several_threads(tmp_path_factory):
    """Return what threads found that asked the engine at once, and what was read of stdout and stderr."""
    report = tmp_path_factory.mktemp("threads") / "report.json"
    code = SCRIPT.format(tests=str(TESTS / "support"), report=str(report), threads=THREADS)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(report.read_text()), done.stdout.splitlines(), done.stderr.splitlines()


@pytest.mark.slow
def test_nothing_that_others_print_is_lost(several_threads):
    found, out, error = several_threads
    assert out.count("a line") == found["lines"]["1"] > 0
    assert error.count("a line") == found["lines"]["2"] > 0
    assert sum(line.startswith("from C") for line in out) == 4 * THREADS


def test_stdout_and_stderr_stay_what_they_were(several_threads):
    found, _, _ = several_threads
    assert found["same"]


def test_the_engine_itself_says_nothing(several_threads):
    _, out, error = several_threads
    assert {line for line in out if not line.startswith("from C")} == {"a line"}
    try:
        ThreadPoolExecutor(1).submit(own_descriptors).result()
    except (OSError, AttributeError):
        pytest.skip("this system gives no thread file descriptors of its own")
    assert set(error) == {"a line"}


def test_answers_are_those_of_one_thread(several_threads):
    found, _, _ = several_threads
    assert found["at_once"] == found["one_by_one"] and len(found["at_once"]) == THREADS
