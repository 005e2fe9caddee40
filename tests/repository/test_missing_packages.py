"""What is optional may be missing: the tests that need it are skipped, and all others are there."""

from __future__ import annotations

import subprocess
import sys

import pytest
from checkout import TESTS

OPTIONAL = ("collada", "lxml", "yourdfpy", "laspy", "lazrs", "pybullet", "distributed", "rosbags", "mujoco")
OPTIONAL += ("mkdocs", "rerun", "viser", "pxr")
RUN = ("formats/test_reading.py", "formats/test_packages.py")
CODE = f"""
import sys
sys.modules.update(dict.fromkeys({OPTIONAL}))
import pytest

class RunSome:
    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items):
        print(*sorted({{item.path.name for item in items}}))
        chosen = [item for item in items if item.path.as_posix().endswith({RUN})]
        items[:] = [item for item in chosen if "open3d" not in item.name]  # which takes seconds to load

sys.exit(pytest.main(sys.argv[1:], plugins=[RunSome()]))
"""


@pytest.fixture(scope="module")
def without() -> subprocess.CompletedProcess:
    """Collect all tests where none of the optional packages can be imported, and run those of formats.

    Asserts are as they stand, which loads faster, and constants of our sources are not gathered for hypothesis.
    """
    quick = ["-p", "no:cacheprovider", "-p", "no:hypothesispytest", "--assert=plain"]
    command = [sys.executable, "-c", CODE, "-q", *quick, str(TESTS)]
    return subprocess.run(command, cwd=TESTS.parent, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_all_tests_are_collected_without_what_is_optional(without):
    assert without.returncode < 2 and "test_fuzz.py" in without.stdout, without.stdout[-2000:]  # 2: not collected


@pytest.mark.slow
def test_formats_without_their_packages_are_skipped_and_the_others_read(without):
    done = without
    assert done.returncode == 0 and " skipped" in done.stdout and " passed" in done.stdout, done.stdout[-2000:]
