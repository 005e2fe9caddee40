"""One object and one simulator: warmed up before it is timed, and what is odd about a file said each time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import clouds
import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.cloud import MAX_GAP, Cloud, Mesh
from spherefunc_bullet.errors import InputError, Unexpected
from spherefunc_bullet.learning.cube_classifier import CubeClassifier
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.histogram import SphereHistogram
from spherefunc_bullet.learning.profiles.quantities import NAMES, profiles_over
from spherefunc_bullet.learning.resting_profile import RestingProfile
from spherefunc_bullet.settling import settling
from spherefunc_bullet.settling.cached_runs import CachedFile, DropConfig, LoadOptions, cloud_hash, settle_cached
from spherefunc_bullet.settling.drops import (
    LIMITED,
    NOT_SETTLED,
    TO_THE_END,
    WALL_TESTS,
    RunLimit,
    drops_from_rows,
    drops_of,
    resting_drops,
    settled_in_column,
)
from spherefunc_bullet.settling.records import VOXEL, ObjectRecord, shape_of
from spherefunc_bullet.settling.resting_places import place_radius, resting_places
from spherefunc_bullet.settling.settling import FINE, HANDHELD
from spherefunc_bullet.simulator import DropSettings, Outcome, make_simulator


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    """Return an empty cache."""
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


class Watched:
    """The roller under another name, which notes what came of each run."""

    name, version = "watched", "1"

    def __init__(self):
        self.results, self.limits = [], []

    def options(self) -> dict:
        return {"id": id(self)}

    def drop(self, cloud, settings, seed=0):
        self.limits.append(settings.max_drops)
        self.results.append(make_simulator("fast").drop(cloud, settings, seed))
        return self.results[-1]


@pytest.mark.parametrize("length", [LIMITED, RunLimit(drops=20)])
def test_code_has_run_once_before_it_is_timed(length):
    simulator = Watched()
    for _ in range(2):
        settling.measured_run(clouds.mug(), simulator, 0.01, 0, length)
    first, *timed = simulator.results
    assert simulator.limits[0] == (None if length.drops is None else 1)
    assert (first.drops, first.settled) == (1, 1) and len(timed) == 2 and min(run.drops for run in timed) >= 20


class Faulty(Watched):
    """A backend whose author has still to find an error."""

    name = "faulty"

    def drop(self, cloud, *_):
        return {}["contacts"]

    poses = stands = carry = drop


def test_an_error_in_a_backend_names_the_object_and_the_backend(tmp_path):
    """It ended commands with a traceback; now it costs one object, as in a batch."""
    from spherefunc_bullet.commands import carry, poses, simulate, stand, view

    path, simulator, run = tmp_path / "mug.npz", Faulty(), DropSettings(radius=0.01)
    np.savez(path, points=clouds.mug().points)
    words = r"^mug\S*: backend 'faulty': expected a result, got KeyError: 'contacts' \(test_settling.py, line \d+\)$"
    calls = [
        lambda: settling.measured_run(clouds.mug(), simulator, 0.01, 0),
        lambda: view.dropped(clouds.mug(), simulator, [0.01], 9, 0),
        lambda: poses.posed_file(path, simulator, None, None, 0, "m"),
        lambda: stand.stood_file(path, simulator, None, 0.01, 0, "z", "m"),
        lambda: carry.carried_file(path, simulator, None, 0, "z", "m"),
    ]
    for call in calls:
        with pytest.raises(Unexpected, match=words):
            call()
    done, error = simulate.drop_on_file(path, simulator, [run], 0, "z", "m")
    assert not done and isinstance(error, Unexpected)


def test_the_plate_to_warm_up_with_is_where_its_surface_is():
    plate = settling.small_plate()
    corners, points = plate.mesh.vertices, plate.points
    assert np.allclose([corners.min(axis=0), corners.max(axis=0)], [points.min(axis=0), points.max(axis=0)])
    triangles = corners[plate.mesh.faces]
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert np.linalg.norm(across, axis=1).sum() / 2 == pytest.approx(0.1**2) and (across[:, 2] > 0).all()
    assert triangles.mean(axis=(0, 1)) == pytest.approx([0, 0, 0.1])  # either half of it once
    assert len(np.unique(points[:, :2], axis=0)) == 21**2 and np.ptp(points, axis=0) == pytest.approx([0.1, 0.1, 0])


def test_what_was_guessed_of_a_file_is_said_whether_it_is_read_again_or_not(tmp_path):
    file, drop_config = (
        tmp_path / "mug.xyz",
        DropConfig(simulator="fast", radii=(0.01,), loading=LoadOptions(units="auto")),
    )
    np.savetxt(file, 1000 * clouds.mug().points)
    said = [[], []]
    for lines in said:
        CachedFile(file, drop_config, lines.append)
    assert said[0] == said[1] and said[0] and all(line.startswith("mug.xyz") for line in said[0])
    assert CachedFile(file, drop_config).cloud().size[2] == pytest.approx(0.1, rel=0.05)  # and to nobody if nobody asks
    silent = []
    CachedFile(file, replace(drop_config, loading=LoadOptions(units="mm")), silent.append)
    assert not silent


LEARNERS = {
    "cubes": lambda objects, **how: SphereHistogram(radius=0.02, **how).fit(objects),
    "functions by cubes": lambda objects, **how: CubeClassifier(radii=(0.02,), **how).fit(objects, ["cup", "none"]),
    "quantities": lambda objects, **how: RestingProfile(0.02, drops=10, **how).transform(objects),
    "functions": lambda objects, **how: FunctionClassifier(
        radii=(0.02,), drops=10, early_drops=0, estimator=DecisionTreeClassifier(), **how
    ).fit(objects, ["cup", "none"]),
}


@pytest.mark.parametrize("name", LEARNERS)
@pytest.mark.parametrize(("how", "kept"), [({"cache": True}, True), ({"cache": False}, False), ({}, True)])
def test_spheres_are_kept_unless_told_not_to(home, name, how, kept):
    LEARNERS[name]([clouds.mug(), clouds.plate()], **how)
    assert len(list(home.rglob("*.npz"))) == 2 * kept


@pytest.mark.parametrize("cache", [True, False])
def test_one_call_keeps_spheres_where_that_is_asked_for(home, cache):
    sf.classify(clouds.mug(), cache=cache)
    assert any(home.rglob("*.npz")) == cache


def test_a_sphere_that_cannot_settle_takes_no_time_and_no_drop():
    roller = make_simulator("fast")
    for length in (LIMITED, RunLimit(drops=20)):
        rows, seconds, drops = settling.drop_if_useful(clouds.mug(), roller, 0.2, 0, length)
        assert (len(rows), seconds, drops) == (0, 0.0, 0)


def test_the_transformer_reads_what_the_classifier_reads():
    objects, radii = [clouds.mug(), clouds.plate()], (0.01, 0.03)
    model = FunctionClassifier(radii=radii, drops=30, early_drops=0).fit(objects, ["cup", "none"])
    read = np.hstack([RestingProfile(radius, drops=30).transform(objects) for radius in radii])
    alone = np.tile([name not in ("gap", "middle_gap", "over_gaps") for name in NAMES], len(radii))  # of one radius
    assert np.array_equal(read[:, alone], model.profiles_[:, alone])
    drops = [settling.settle(cloud, "fast", [0.01], 0, RunLimit(drops=30))[0.01] for cloud in objects]
    assert np.array_equal(profiles_over([{0.01: one} for one in drops], [0.01]), read[:, : read.shape[1] // 2])


def test_the_cubes_of_a_cloud_are_those_that_hold_a_point():
    points = np.random.default_rng(0).uniform([-1, -2, 0], [2, 1, 3], (500, 3))
    shape = shape_of(Cloud(np.concatenate([points, points[:50]])))
    expected = np.unique(np.floor(points / VOXEL).astype(int), axis=0)
    assert np.array_equal(shape["voxels"], expected) and shape["voxels"].dtype == np.int16
    assert np.allclose(shape["size"], np.ptp(points, axis=0)) and VOXEL == MAX_GAP  # as sampling resolves surfaces


def test_places_are_where_spheres_touch_the_object():
    """On a level plate they are its top, as far from its edges as spheres that rest on it may be."""
    plate = clouds.plate()
    for radius in (None, 0.02):
        places = resting_places(plate, radius)
        length = place_radius(plate) if radius is None else radius
        sunk = 0.1 * length  # between its points
        assert len(places) > 20 and np.allclose(places[:, 2], plate.bounds[1, 2], atol=sunk)
        low, high = plate.bounds[:, :2] + [[-length], [length]]
        assert ((places[:, :2] >= low) & (places[:, :2] <= high)).all()
        assert not np.array_equal(places, resting_places(plate, radius, seed=1))


@pytest.mark.parametrize(("size", "radius"), [(0.1, 0.005), (0.4, 0.01), (0.8, 0.02), (3.0, 0.03)])
def test_spheres_that_find_places_are_a_fortieth_of_an_object_within_limits(size, radius):
    points = np.random.default_rng(0).uniform(0, 0.05, (200, 3))
    points[:2] = [0, 0, 0], [0, size, 0]
    assert place_radius(Cloud(points)) == pytest.approx(radius)


def test_the_axis_that_a_format_promises_counts_where_nobody_says_another():
    assert [LoadOptions().for_file(Path(name)).up for name in ("a.glb", "a.stl")] == ["y", "z"]
    assert LoadOptions(up="z").for_file(Path("a.glb")).up == "z"


def test_the_mesh_decides_what_a_cloud_is_kept_by():
    mug, (corners, faces) = clouds.mug(), (np.eye(3), np.array([[0, 1, 2]]))
    meshes = (None, Mesh(corners, faces), Mesh(2 * corners, faces), Mesh(corners, faces[:, ::-1]))
    hashes = [cloud_hash(Cloud(mug.points, name, mesh)) for name in ("one", "two") for mesh in meshes]
    assert len(set(hashes)) == 4 and hashes[:4] == hashes[4:]


def test_whatever_is_not_known_of_drops_is_not_made_up():
    """Columns are two numbers, outcomes are kept where drops were counted, and nothing falls over unless it is said."""
    rests = np.random.default_rng(0).uniform(size=(3, 3))
    shapes = [drops.places.shape for drops in (resting_drops(0.1, rests), settled_in_column(rests, rests, 0.1))]
    assert shapes == [(3, 2), (3, 2)]
    for length in (LIMITED, RunLimit(drops=20)):
        run = settling.measured_run(clouds.mug(), make_simulator("fast"), 0.01, 0, length)
        assert ("outcomes" in run) == (length.drops is not None) and "memory" in run
        nothing = settling.measured_run(clouds.mug(), make_simulator("fast"), 0.2, 0, length)
        assert "memory" not in nothing and not len(nothing["centers"]) and nothing["drops"] == 0
        assert settling.no_drops(0.2, length).losses_known == (length.drops is not None)
    assert not ObjectRecord(path=Path(), size=np.ones(3), occupied=list, settled={}, seconds={}, drops={}).falls_over


@pytest.mark.parametrize("settled", [1, 30, 49, 100, 260])
def test_about_fifty_spheres_are_tested_for_walls(settled):
    rests = np.random.default_rng(0).uniform(size=(settled, 3))
    looked = np.isfinite(settled_in_column(rests, rests, 0.01).walled_in)
    assert min(settled, WALL_TESTS) <= looked.sum() < 2 * WALL_TESTS and looked[0]


def test_a_run_without_columns_is_one_of_spheres_that_fell_straight_down():
    result = make_simulator("fast").drop(clouds.mug(), DropSettings(radius=0.01, miss_limit=20, max_drops=20))
    mug, bare = clouds.mug(), replace(result, columns=np.empty((0, 2)), outcomes=np.empty(0, np.int8))
    whole, alone = drops_of(result, mug.points, 0.01), drops_of(bare, mug.points, 0.01)
    assert len(whole) == 20 and 0 < len(alone) == result.settled < 20 and alone.settled.all()
    assert np.array_equal(alone.places, whole.rests[:, :2]) and np.array_equal(alone.rests, whole.rests)
    assert not np.array_equal(whole.places[whole.settled], alone.places)
    assert {drops.places.dtype for drops in (whole, alone)} == {np.dtype(np.float32)}


@pytest.mark.parametrize(("radius", "size", "falls"), [(FINE, 1.0, True), (0.005, HANDHELD, True), (0.005, 1.0, False)])
def test_fine_spheres_are_those_below_a_centimetre_and_large_is_what_no_hand_holds(radius, size, falls):
    cloud = Cloud(np.linspace([0, 0, 0], [size, 0.2, 0], 11))
    assert settling.too_fine(radius, cloud, RunLimit(drops=10)) != falls
    assert not settling.too_fine(radius, cloud, LIMITED)


def test_a_sphere_as_large_as_the_object_is_dropped():
    mug = clouds.mug()
    drops = settling.drop_if_useful(mug, make_simulator("fast"), float(mug.size.max()), 0, RunLimit(drops=5))[2]
    assert drops == 5


def test_another_miss_limit_is_for_runs_that_end_by_misses():
    assert LIMITED.ending(None) == LIMITED and RunLimit(drops=9).ending(None) == RunLimit(drops=9)
    assert LIMITED.ending(7) == RunLimit(miss_limit=7) and TO_THE_END.ending(7).to_the_end
    with pytest.raises(InputError):
        RunLimit(drops=9).ending(7)


def test_rows_of_older_files_are_read():
    """Of (S, 3) only rests are known; of (D, 6), a row without a rest is a drop that was lost somehow."""
    centers = np.random.default_rng(0).uniform(size=(4, 3)).astype(np.float32)
    old = drops_from_rows(0.02, centers)
    assert not old.losses_known and np.array_equal(old.rests, centers) and old.settled.all() and len(old) == 4
    rows = np.column_stack([centers[:, :2], centers, np.ones(4, np.float32)])
    rows[1, 2:] = np.nan
    drops = drops_from_rows(0.02, rows)
    assert NOT_SETTLED not in list(Outcome) and drops.outcomes[1] == NOT_SETTLED  # nobody knows how
    assert drops.losses_known and drops.settled.tolist() == [True, False, True, True]
    assert np.array_equal(drops.rests, centers[[0, 2, 3]]) and (drops.walled_in == 1).all()
    kept = drops_from_rows(0.02, rows, np.array([0, Outcome.ROLLED_OFF, 0, 0], np.int8), provenance={"by": 1})
    assert kept.provenance == {"by": 1} and kept.outcomes[1] == Outcome.ROLLED_OFF


def test_objects_are_levelled_where_few_drops_are_to_tell_and_stay_as_they_are_in_the_paper_s_runs():
    table, angle = clouds.table(), np.radians(4)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    askew, how = Cloud(table.points @ turn.T), DropConfig(simulator="fast", radii=(0.02,))
    assert how.prepared(askew) is askew and replace(how, run_limit=TO_THE_END).prepared(askew) is askew
    level = replace(how, run_limit=RunLimit(drops=20)).prepared(askew)
    assert level.size[2] == pytest.approx(table.size[2], rel=0.03) and askew.size[2] > 1.05 * table.size[2]
    both = [drop(table, "fast", [0.02]) for drop in (settling.settle, settle_cached)]
    assert np.array_equal(both[0][0.02].rests, both[1][0.02].rests)  # of the same seed, where nobody says another
