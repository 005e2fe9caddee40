"""One object and one simulator: warmed up before it is timed, and what is odd about a file said each time."""

from __future__ import annotations

from dataclasses import replace

import clouds
import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.histogram import SphereHistogram
from spherefunc_bullet.learning.profiles.quantities import NAMES, profiles_at
from spherefunc_bullet.learning.resting_profile import RestingProfile
from spherefunc_bullet.settling import settling
from spherefunc_bullet.settling.drops import LIMITED, RunLimit
from spherefunc_bullet.settling.kept_object import KeptFile
from spherefunc_bullet.settling.records import VOXEL, Dropping, Loading, shape_of
from spherefunc_bullet.simulator import make_simulator


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    """Return an empty cache."""
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


class Watched:
    """The roller under another name, which notes what came of each run."""

    name, version = "watched", "1"

    def __init__(self):
        self.results = []

    def options(self) -> dict:
        return {"id": id(self)}

    def drop(self, cloud, settings, seed=0):
        self.results.append(make_simulator("fast").drop(cloud, settings, seed))
        return self.results[-1]


@pytest.mark.parametrize("length", [LIMITED, RunLimit(drops=20)])
def test_code_has_run_once_before_it_is_timed(length):
    simulator = Watched()
    for _ in range(2):
        settling.measured_run(clouds.mug(), simulator, 0.01, 0, length)
    first, *timed = simulator.results
    assert (first.drops, first.settled) == (1, 1) and len(timed) == 2 and min(run.drops for run in timed) >= 20


def test_the_plate_to_warm_up_with_is_where_its_surface_is():
    plate = settling.small_plate()
    corners, points = plate.mesh.vertices, plate.points
    assert np.allclose([corners.min(axis=0), corners.max(axis=0)], [points.min(axis=0), points.max(axis=0)])
    triangles = corners[plate.mesh.faces]
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert np.linalg.norm(across, axis=1).sum() / 2 == pytest.approx(0.1**2) and (across[:, 2] > 0).all()
    assert len(np.unique(points[:, :2], axis=0)) == 21**2 and np.ptp(points, axis=0) == pytest.approx([0.1, 0.1, 0])


def test_what_was_guessed_of_a_file_is_said_whether_it_is_read_again_or_not(tmp_path):
    file, dropping = tmp_path / "mug.xyz", Dropping(simulator="fast", radii=(0.01,), loading=Loading(units="auto"))
    np.savetxt(file, 1000 * clouds.mug().points)
    said = [[], []]
    for lines in said:
        KeptFile(file, dropping, lines.append)
    assert said[0] == said[1] and said[0] and all(line.startswith("mug.xyz") for line in said[0])
    assert KeptFile(file, dropping).cloud().size[2] == pytest.approx(0.1, rel=0.05)  # and to nobody if nobody asks
    silent = []
    KeptFile(file, replace(dropping, loading=Loading(units="mm")), silent.append)
    assert not silent


LEARNERS = {
    "cubes": lambda objects, cache: SphereHistogram(radius=0.02, cache=cache).fit(objects),
    "quantities": lambda objects, cache: RestingProfile(0.02, drops=10, cache=cache).transform(objects),
    "functions": lambda objects, cache: FunctionClassifier(
        radii=(0.02,), drops=10, early_drops=0, cache=cache, estimator=DecisionTreeClassifier()
    ).fit(objects, ["cup", "none"]),
}


@pytest.mark.parametrize("name", LEARNERS)
@pytest.mark.parametrize("cache", [True, False])
def test_spheres_are_kept_where_that_is_asked_for(home, name, cache):
    LEARNERS[name]([clouds.mug(), clouds.plate()], cache)
    assert len(list(home.rglob("*.npz"))) == 2 * cache


@pytest.mark.parametrize("cache", [True, False])
def test_one_call_keeps_spheres_where_that_is_asked_for(home, cache):
    sf.classify(clouds.mug(), cache=cache)
    assert any(home.rglob("*.npz")) == cache


def test_a_sphere_that_cannot_settle_takes_no_time_and_no_drop():
    roller = make_simulator("fast")
    for length in (LIMITED, RunLimit(drops=20)):
        rows, seconds, drops = settling.drop_or_nothing(clouds.mug(), roller, 0.2, 0, length)
        assert (len(rows), seconds, drops) == (0, 0.0, 0)


def test_the_transformer_reads_what_the_classifier_reads():
    objects, radii = [clouds.mug(), clouds.plate()], (0.01, 0.03)
    model = FunctionClassifier(radii=radii, drops=30, early_drops=0).fit(objects, ["cup", "none"])
    read = np.hstack([RestingProfile(radius, drops=30).transform(objects) for radius in radii])
    alone = np.tile([name not in ("gap", "middle_gap", "over_gaps") for name in NAMES], len(radii))  # of one radius
    assert np.array_equal(read[:, alone], model.profiles_[:, alone])
    drops = [settling.settle(cloud, "fast", [0.01], 0, RunLimit(drops=30))[0.01] for cloud in objects]
    assert np.array_equal(profiles_at(drops, 0.01), read[:, : read.shape[1] // 2])


def test_the_cubes_of_a_cloud_are_those_that_hold_a_point():
    points = np.random.default_rng(0).uniform([-1, -2, 0], [2, 1, 3], (500, 3))
    shape = shape_of(Cloud(np.concatenate([points, points[:50]])))
    expected = np.unique(np.floor(points / VOXEL).astype(int), axis=0)
    assert np.array_equal(shape["voxels"], expected) and shape["voxels"].dtype == np.int16
    assert np.allclose(shape["size"], np.ptp(points, axis=0))
