"""Tests that ask `bullet` are skipped where PyBullet is not installed, as on Pythons that it has no wheel for.

Files with slow tests come first, so that no process is left with a long one when the others are through.
"""

from __future__ import annotations

import os
import re
from collections import Counter

import pytest
from commands import skip_for_want_of_bullet

from spherefunc_bullet.errors import InputError

# Of the suite that ships, whose tests carry no mark of ours: shapes on which `bullet` takes more than a second.
DEAR = re.compile(r"test_conformance\.py::test_(same_seed|order_of)\w+\[bullet-(groove|chair|table|mug, small)\]")

# As on the command line, before numpy is loaded: threads that wait for each other in turns take processors.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


FEW_CANDIDATES = (  # module of `shapes`, name, and fewer of what costs time
    ("candidates", "VOXELS", (4 / 3,)),
    ("candidates", "VHACD", (8,)),
    ("compared", "SCALES", (2.0,)),
    ("spaces", "CELLS", 60),
    ("spheres", "SPHERES", 20),
    ("spheres", "STEPS", 4),
)


@pytest.fixture
def few_candidates(monkeypatch):
    """Compare few collision shapes, by few spheres in coarse cells, where how they do is not looked at."""
    for module, name, few in FEW_CANDIDATES:
        monkeypatch.setattr(f"spherefunc_bullet.shapes.{module}.{name}", few)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    try:
        return (yield)
    except InputError as error:
        skip_for_want_of_bullet(str(error))
        raise


def pytest_collection_modifyitems(items):
    """Put files first of which more is marked as slow; the Makefile has xdist hand them out in this order."""
    for item in items:
        if DEAR.search(item.nodeid):
            item.add_marker("slow")
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    every = Counter(item.path for item in items)
    items.sort(key=lambda item: (not slow[item.path], -slow[item.path] / every[item.path], -every[item.path]))
