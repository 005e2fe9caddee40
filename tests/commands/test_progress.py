"""How far long work is, and what is left when it is stopped."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from batch_runs import small_objects
from sklearn.neighbors import KNeighborsClassifier

from spherefunc_bullet.compare.evaluation.protocol import Labels, Split
from spherefunc_bullet.compare.evaluation.readings import ProfileFeatures
from spherefunc_bullet.console import progress
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.profiles.quantities import NAMES


class Terminal(io.StringIO):
    """Standard error that is a terminal."""

    def isatty(self):
        return True


def on_terminal(monkeypatch) -> Terminal:
    """Make stderr a terminal; by the test itself, since pytest has its own stderr after a fixture."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys, "stderr", Terminal())
    return sys.stderr


def test_learning_shows_how_far_it_is(monkeypatch):
    terminal = on_terminal(monkeypatch)
    members = np.arange(8)[:, None] % 2 == 0
    labels = Labels(("cup",), members, np.zeros_like(members), np.full(8, ""))
    classifier = FunctionClassifier(radii=(0.01,), estimator=KNeighborsClassifier(1))
    numbers = np.random.default_rng(0).random((8, len(NAMES)))
    ProfileFeatures(profiles=numbers, labels=labels, classifier=classifier).trial(
        [Split(np.arange(6), np.arange(6, 8))]
    )
    assert "learning and testing" in terminal.getvalue()


def test_a_stage_within_a_stage_shows_no_bar_of_its_own(monkeypatch):
    terminal = on_terminal(monkeypatch)
    assert [list(progress([1, 2], 2, "inner")) for _ in progress([1, 2], 2, "outer")] == [[1, 2]] * 2
    assert "outer" in terminal.getvalue() and "inner" not in terminal.getvalue()


def test_a_pipe_is_told_nothing(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    assert list(progress([1], 1, "doing")) == [1] and sys.stderr.getvalue() == ""


SCRIPT = Path(sys.executable).with_name("spherefunc")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
def test_a_comparison_that_is_stopped_says_how_it_goes_on(tmp_path):
    """Stopped while spheres are dropped: what has been dropped stays in the cache."""
    small_objects(tmp_path / "many", 150)
    cache = tmp_path / "cache"
    process = subprocess.Popen(
        [SCRIPT, "compare", tmp_path / "many", "--backends", "fast", "--copied", "0", "--jobs", "1"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"SPHEREFUNC_CACHE": str(cache)},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a run in the background ignores it
    )
    while len(list(cache.rglob("*.npz"))) < 3 and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate()
    assert process.returncode == 130 and "Traceback" not in stderr, stderr
    assert "the same command continues" in stderr and len(list(cache.rglob("*.npz"))) >= 3
