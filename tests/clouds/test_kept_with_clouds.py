"""What is kept with a cloud: made once, left behind by copies, gone with the cloud; and runs that go on."""

from __future__ import annotations

import copy
import gc
import pickle
import weakref
from dataclasses import replace

import clouds
import numpy as np
import pytest

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.clouds.preparation import headed, prepare
from spherefunc_bullet.fast_sim import drop_run
from spherefunc_bullet.simulator import DropSettings, make_simulator

SHORT, LONG = (DropSettings(radius=0.008, miss_limit=count, max_drops=count) for count in (40, 200))


class Derived:
    """Something that can be watched."""


def test_what_is_derived_is_made_once_and_goes_with_the_cloud():
    cloud = clouds.mug()
    item = cloud.cached("object", Derived)
    assert cloud.cached("object", Derived) is item and cloud.cached("other object", Derived) is not item
    watched = weakref.ref(item)
    del item, cloud
    gc.collect()
    assert watched() is None


def test_a_classified_cloud_goes_with_its_last_use_before_garbage_is_looked_for():
    cloud = clouds.mug()
    assert prepare(cloud) is cloud  # it stands level and has no gaps
    headed(cloud)
    make_simulator("fast").drop(cloud, SHORT, 0)
    watched = weakref.ref(cloud)
    gc.disable()
    try:
        del cloud
        assert watched() is None
    finally:
        gc.enable()


@pytest.mark.parametrize(
    "copied",
    [copy.copy, copy.deepcopy, lambda cloud: pickle.loads(pickle.dumps(cloud)), lambda cloud: replace(cloud, name="x")],
    ids=["copy", "deepcopy", "pickle", "replace"],
)
def test_copies_leave_behind_what_was_derived(copied):
    cloud = clouds.mug()
    size = len(pickle.dumps(cloud))
    make_simulator("fast").drop(cloud, SHORT, 0)
    assert len(pickle.dumps(cloud)) == size  # nothing of it is sent to other processes
    other = copied(cloud)
    assert not other._derived and cloud._derived
    assert np.array_equal(other.points, cloud.points) and np.array_equal(other.bounds, cloud.bounds)


def same(one, other) -> bool:
    """Return whether two results are the same but for the time they took."""
    arrays = all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in ("centers", "on_object", "columns", "outcomes")
    )
    return arrays and replace(one, seconds=0.0).provenance == other.provenance and one.stop == other.stop


@pytest.fixture
def begun(monkeypatch) -> list[int]:
    """Return a list that grows whenever a run of `fast` begins anew."""
    runs, begin = [], drop_run.DropRun.__init__

    def counted(run, *arguments):
        runs.append(len(runs))
        begin(run, *arguments)

    monkeypatch.setattr(drop_run.DropRun, "__init__", counted)
    return runs


@pytest.mark.parametrize("shape", [clouds.chair, clouds.mug, clouds.plate])
@pytest.mark.parametrize("options", [{}, {"flat_angle_deg": 2.0}], ids=str)
def test_a_longer_run_goes_on_with_a_short_one(begun, shape, options):
    simulator, cloud = make_simulator("fast", **options), shape()
    short, long = simulator.drop(cloud, SHORT, 3), simulator.drop(cloud, LONG, 3)
    assert len(begun) == 1
    assert same(long, simulator.drop(shape(), LONG, 3)) and same(short, simulator.drop(shape(), SHORT, 3))
    assert long.seconds > short.seconds  # of all its drops


@pytest.mark.parametrize(
    ("settings", "seed", "options"),
    [
        (SHORT, 3, {}),  # no more than there are: a lap of a bench is a whole one
        (replace(LONG, miss_limit=10), 3, {}),
        (replace(LONG, max_spheres=5), 3, {}),
        (replace(LONG, radius=0.01), 3, {}),
        (replace(LONG, max_drops=None), 3, {}),
        (LONG, 4, {}),
        (LONG, 3, {"flat_angle_deg": 2.0}),
    ],
    ids=["as many drops", "fewer misses", "fewer spheres", "radius", "to the end", "seed", "option"],
)
@pytest.mark.slow
def test_another_run_begins_anew(begun, settings, seed, options):
    cloud = clouds.chair()
    make_simulator("fast").drop(cloud, SHORT, 3)
    again = make_simulator("fast", **options).drop(cloud, settings, seed)
    assert len(begun) == 2
    assert same(again, make_simulator("fast", **options).drop(clouds.chair(), settings, seed))


def test_a_run_goes_on_whatever_ended_it():
    """A run that ended for misses, or for spheres, is the beginning of one with higher limits too."""
    for first in (replace(SHORT, miss_limit=3), replace(SHORT, max_spheres=7)):
        cloud = clouds.mug()
        make_simulator("fast").drop(cloud, first, 1)
        assert same(make_simulator("fast").drop(cloud, LONG, 1), make_simulator("fast").drop(clouds.mug(), LONG, 1))


def test_long_runs_are_not_kept():
    """Of a set of clouds that is learnt from, nobody asks for more."""
    cloud = Cloud(clouds.mug().points)
    make_simulator("fast").drop(cloud, LONG, 0)
    make_simulator("fast").drop(cloud, SHORT, 0)
    make_simulator("fast").drop(cloud, LONG, 0)
    kept = [value for value in cloud._derived.values() if isinstance(value, dict)]
    assert kept == [{}]
