"""One object's drops on several cores: the same bits as on one, and the arithmetic of who came near whom."""

from __future__ import annotations

import os

import clouds
import numpy as np
import pytest

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.fast_sim.cores import came_near
from spherefunc_bullet.fast_sim.nearby import MAX_LOOKS
from spherefunc_bullet.simulator import DropSettings, make_simulator

needs_two = pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="this machine has one core")


@needs_two
@pytest.mark.parametrize(
    "settings",
    [
        DropSettings(radius=0.008),
        DropSettings(radius=0.008, max_spheres=150),
        DropSettings(radius=0.008, max_drops=130),
        DropSettings(radius=0.008, miss_limit=5),
    ],
    ids=["to the end", "spheres", "drops", "misses"],
)
@pytest.mark.parametrize("shape", ["chair", "mug", "plate"])
def test_the_bits_do_not_depend_on_the_cores(shape, settings):
    cloud = {"chair": clouds.chair, "mug": clouds.mug, "plate": clouds.plate}[shape]()
    one, two = (make_simulator("fast", cores=cores).drop(cloud, settings, 4) for cores in (1, 2))
    for name in ("centers", "on_object", "columns", "outcomes"):
        assert np.array_equal(getattr(one, name), getattr(two, name))
    assert one.stop == two.stop and one.provenance == two.provenance


def near(center, looks, count=None, radius=1.0):
    return came_near(np.array([center], float), 0, 1, np.array(looks, float), count or len(looks), radius)


def test_who_came_near_whom():
    way = [[0, 0, 10, 0], [3, 0, 8, 0], [6, 0, 6, 0]]
    assert near([6, 0, 4], way)  # under its end
    assert near([0, 1, 0], way)  # in the column that it came down
    assert not near([6, 1, 0], way) and near([6, 1, 0], [*way[:2], [6, 0, 6, 1]])  # only where it fell far
    assert not near([6, 5, 6], way) and not near([-5, 0, 10], way)
    assert near([500, 0, 0], [way[0]] * MAX_LOOKS, MAX_LOOKS + 1)  # nobody remembers all of its way
    assert not came_near(np.zeros((1, 3)), 0, 0, np.array(way, float), 3, 1.0)


@pytest.mark.parametrize("cores", [0, 10_000])
def test_cores_that_there_are_not(cores):
    with pytest.raises(InputError, match="cores: expected 1 to"):
        make_simulator("fast", cores=cores)
