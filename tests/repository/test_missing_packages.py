"""What is optional may be missing: the tests that need it are skipped, and all others are there."""

from __future__ import annotations

import subprocess
import sys

import pytest
from checkout import TESTS

OPTIONAL = ("collada", "lxml", "yourdfpy", "laspy", "lazrs", "pybullet", "distributed", "rosbags", "mujoco")
OPTIONAL += ("nbclient", "nbformat", "mkdocs", "rerun", "viser")
CODE = f"""
import sys
sys.modules.update(dict.fromkeys({OPTIONAL}))
import pytest
sys.exit(pytest.main(sys.argv[1:]))
"""


def pytest_without(*arguments: str) -> subprocess.CompletedProcess:
    """Run pytest where none of the optional packages can be imported; asserts are as they stand, which loads faster."""
    command = [sys.executable, "-c", CODE, "-q", "-p", "no:cacheprovider", "--assert=plain", *arguments]
    return subprocess.run(command, cwd=TESTS.parent, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_all_tests_are_collected_without_what_is_optional():
    done = pytest_without("--collect-only", str(TESTS))
    assert done.returncode == 0 and "test_fuzz.py::" in done.stdout, done.stdout[-2000:]


def test_formats_without_their_packages_are_skipped_and_the_others_read():
    done = pytest_without(str(TESTS / "formats/test_reading.py"), str(TESTS / "formats/test_packages.py"))
    assert done.returncode == 0 and " skipped" in done.stdout and " passed" in done.stdout, done.stdout[-2000:]
