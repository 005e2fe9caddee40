"""Conformance tests for every simulator: one suite over all registered backends, or one of them.

``pytest --pyargs spherefunc_bullet.conformance --backend NAME`` runs it over a backend of another package.
"""

from __future__ import annotations

import json
import time
from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ..clouds.cloud import Cloud
from ..errors import InputError
from ..simulator import (
    DropResult,
    DropSettings,
    Outcome,
    Simulator,
    Stop,
    backend_entry_points,
    make_simulator,
    provenance_of,
)
from . import shapes

# Shapes and radii in metres: up to a thousand spheres each, so that a run takes the roller milliseconds.
SHAPES = {
    "plate": (shapes.plate, 0.015),
    "table": (shapes.table, 0.015),
    "chair": (shapes.chair, 0.02),
    "bin": (shapes.bin_, 0.01),
    "mug": (shapes.mug, 0.01),
    "mug, small": (shapes.mug, 0.005),
    "groove": (shapes.groove, 0.01),
}
# Depth of an overlap in radii. The roller places spheres by geometry and guarantees 2 %; in engines with penetrating
# contacts spheres sink in by the contact margin.
OVERLAP = {"fast": 0.02}
ENGINE_OVERLAP = 0.05
TOUCH = 0.03  # gap in radii that still counts as contact: the smallest distance that a step of any backend leaves
# A surface may be touched between its points: half a diagonal of the lattice from the nearest one, and up to one
# spacing where the lattice of a round floor ends at a wall.
BETWEEN = shapes.SPACING


def pytest_generate_tests(metafunc: pytest.Metafunc):
    """Run over the backend that ``--backend`` names, or over all that are registered."""
    if "backend" in metafunc.fixturenames:
        requested = metafunc.config.getoption("--backend", default=None)
        metafunc.parametrize("backend", [requested] if requested else sorted(backend_entry_points()), scope="module")


@pytest.fixture(scope="module")
def simulator(backend: str, request: pytest.FixtureRequest) -> Simulator:
    """Return the simulator under test; one that cannot be created is skipped, unless it was named."""
    try:
        return make_simulator(backend)
    except InputError as error:
        if request.config.getoption("--backend", default=None):
            raise
        pytest.skip(str(error))


@cache
def shape(name: str) -> Cloud:
    """Return the shape of a name."""
    return SHAPES[name][0]()


def radius_of(name: str) -> float:
    """Return the radius of the spheres for a shape, metres."""
    return SHAPES[name][1]


@cache
def dropped(simulator: str, name: str, seed: int = 0) -> DropResult:
    """Return one run, cached for the tests that only read it."""
    return make_simulator(simulator).drop(shape(name), DropSettings(radius=radius_of(name)), seed)


@cache
def dropped_so_often(simulator: str, name: str, drops: int) -> DropResult:
    """Return a run of a stated number of drops on a cloud of its own, cached likewise."""
    settings = DropSettings(radius=radius_of(name), miss_limit=90, max_drops=drops)
    return make_simulator(simulator).drop(SHAPES[name][0](), settings, 1)


def overlap(simulator: Simulator, name: str) -> float:
    """Return the largest allowed depth of an overlap, metres."""
    return OVERLAP.get(simulator.name, ENGINE_OVERLAP) * radius_of(name)


def to_cloud(result: DropResult, name: str) -> np.ndarray:
    """Return the distance of each settled centre from the cloud, (S,) metres."""
    return cKDTree(shape(name).points).query(result.centers)[0]


def touches_cloud(distances: np.ndarray, name: str) -> np.ndarray:
    """Return whether spheres with centres at distances (S,) from the nearest point can touch the surface."""
    return distances <= np.hypot((1 + TOUCH) * radius_of(name), BETWEEN)


def to_spheres(result: DropResult) -> np.ndarray:
    """Return the distance of each settled centre from the nearest other one, (S,) metres."""
    return cKDTree(result.centers).query(result.centers, k=2)[0][:, 1]


@pytest.fixture(params=sorted(SHAPES))
def name(request: pytest.FixtureRequest) -> str:
    """Run a test on every shape."""
    return request.param


def test_has_the_interface(simulator: Simulator):
    assert isinstance(simulator, Simulator)
    assert simulator.name in backend_entry_points() and simulator.version
    json.dumps(simulator.options())


def test_same_seed_gives_the_same_bits(simulator: Simulator, name: str):
    """The same cloud, settings and seed give the same result, bit for bit."""
    again = simulator.drop(shape(name), DropSettings(radius=radius_of(name)), 0)
    first = dropped(simulator.name, name)
    assert again.centers.tobytes() == first.centers.tobytes()
    assert again.on_object.tobytes() == first.on_object.tobytes()
    for count in ("drops", "rolled_off", "rejected", "timed_out"):
        assert getattr(again, count) == getattr(first, count)


def test_another_seed_gives_other_spheres(simulator: Simulator):
    first, second = dropped(simulator.name, "mug"), dropped(simulator.name, "mug", 1)
    assert first.centers.tobytes() != second.centers.tobytes()


def test_order_of_points_does_not_matter(simulator: Simulator, name: str):
    points = np.random.default_rng(0).permutation(shape(name).points)
    shuffled = simulator.drop(Cloud(points, name), DropSettings(radius=radius_of(name)), 0)
    assert np.array_equal(shuffled.centers, dropped(simulator.name, name).centers)


def test_outcomes_add_up(simulator: Simulator, name: str):
    """Every drop has one outcome."""
    result = dropped(simulator.name, name)
    counts = [result.settled, result.rolled_off, result.rejected, result.timed_out]
    assert min(counts) >= 0 and sum(counts) == result.drops and result.settled > 0
    assert result.seconds > 0


def test_centres_are_finite_rows(simulator: Simulator, name: str):
    """Centres are finite rows of three."""
    result = dropped(simulator.name, name)
    assert result.centers.dtype == np.float64 and result.centers.shape == (result.settled, 3)
    assert result.on_object.dtype == np.bool_ and result.on_object.shape == (result.settled,)
    assert np.isfinite(result.centers).all()


def test_nothing_below_the_ground(simulator: Simulator, name: str):
    # 2 % of the radius, as for every overlap.
    assert dropped(simulator.name, name).centers[:, 2].min() >= 0.98 * radius_of(name)


def test_nothing_inside_the_cloud(simulator: Simulator, name: str):
    assert to_cloud(dropped(simulator.name, name), name).min() >= radius_of(name) - overlap(simulator, name)


def test_nothing_inside_another_sphere(simulator: Simulator, name: str):
    assert to_spheres(dropped(simulator.name, name)).min() >= 2 * radius_of(name) - overlap(simulator, name)


def test_nothing_hangs_in_the_air(simulator: Simulator, name: str):
    """Every settled sphere touches the object or another sphere."""
    result = dropped(simulator.name, name)
    touches = touches_cloud(to_cloud(result, name), name) | (to_spheres(result) <= (2 + TOUCH) * radius_of(name))
    # A floor at ground level may be touched between its points.
    touches |= result.centers[:, 2] <= (1 + TOUCH) * radius_of(name)
    assert touches.all()


def test_spheres_on_spheres_stay_within_the_bounding_box(simulator: Simulator, name: str):
    """A sphere may rest without touching the object only within the object's bounding box (§III-A)."""
    result = dropped(simulator.name, name)
    low, high = shape(name).bounds
    alone = result.centers[~result.on_object]
    assert np.all((alone >= low) & (alone <= high))


def test_on_object_is_said_of_those_that_touch_it(simulator: Simulator, name: str):
    """Exactly the spheres that touch the object are marked as resting on it."""
    result = dropped(simulator.name, name)
    distances = to_cloud(result, name)
    near = touches_cloud(distances, name) | (result.centers[:, 2] <= (1 + TOUCH) * radius_of(name))
    assert np.all(near[result.on_object])
    # Not touching, but within a thousandth of the radius, would be a contradiction.
    assert np.all(distances[~result.on_object] > 0.999 * radius_of(name))


def test_run_ends_by_the_miss_limit(simulator: Simulator):
    """A run without other limits ends after this number of consecutive misses."""
    whole = dropped(simulator.name, "plate")
    early = simulator.drop(shape("plate"), DropSettings(radius=radius_of("plate"), miss_limit=1), 0)
    assert whole.stop == early.stop == Stop.MISSES
    assert early.drops - early.settled == 1 and early.drops < whole.drops
    assert np.array_equal(early.centers, whole.centers[: early.settled])


def test_run_ends_by_the_sphere_limit(simulator: Simulator):
    """It starts as the same run without the limit; the reported seconds are within those of the call."""
    started = time.perf_counter()
    result = simulator.drop(shape("plate"), DropSettings(radius=radius_of("plate"), max_spheres=7), 0)
    assert result.stop == Stop.SPHERE_LIMIT and result.settled == 7
    assert 0 < result.seconds < time.perf_counter() - started
    assert np.array_equal(result.centers, dropped(simulator.name, "plate").centers[:7])


def test_sphere_larger_than_the_object_is_refused(simulator: Simulator):
    with pytest.raises(InputError, match="mug.*radius") as caught:
        simulator.drop(shape("mug"), DropSettings(radius=0.5), 0)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("radius", [0.0, -0.01, float("nan"), float("inf")])
def test_radius_that_is_no_length_is_refused(simulator: Simulator, radius: float):
    with pytest.raises(InputError, match="radius") as caught:
        simulator.drop(shape("mug"), DropSettings(radius=radius), 0)
    assert "\n" not in str(caught.value)


def test_option_of_another_backend_is_refused(simulator: Simulator):
    with pytest.raises(InputError, match=simulator.name):
        make_simulator(simulator.name, no_such_option=1)


def test_provenance_says_what_produced_the_result(simulator: Simulator):
    settings = DropSettings(radius=radius_of("plate"), max_spheres=1)
    result, expected = simulator.drop(shape("plate"), settings, 1), provenance_of(simulator, settings, 1)
    assert expected.items() <= json.loads(json.dumps(result.provenance)).items()


def test_what_became_of_every_drop_is_reported(simulator: Simulator, name: str):
    """Columns and outcomes contain every drop, in the order in which the drops ended."""
    result = dropped(simulator.name, name)
    counts = np.bincount(result.outcomes, minlength=len(Outcome)).tolist()
    assert counts == [result.settled, result.rolled_off, result.rejected, result.timed_out]
    low, high = shape(name).bounds[:, :2]
    assert result.columns.shape == (result.drops, 2)
    assert ((result.columns >= low) & (result.columns <= high)).all()


@pytest.mark.parametrize("name", ["plate", "mug"])
def test_a_stated_number_of_drops_is_made_whatever_becomes_of_them(simulator: Simulator, name: str):
    """A run with a number of drops makes all of them, misses or not."""
    result = dropped_so_often(simulator.name, name, 90)
    assert result.drops == 90 and result.stop == Stop.DROP_LIMIT
    assert 0 < result.settled < 90


@pytest.mark.parametrize("name", ["plate", "mug"])
def test_a_shorter_run_of_drops_is_the_beginning_of_a_longer_one(simulator: Simulator, name: str):
    """A limit of drops cuts a run short and changes nothing else."""
    short, long = (dropped_so_often(simulator.name, name, drops) for drops in (30, 90))
    assert np.array_equal(short.columns, long.columns[:30])
    assert np.array_equal(short.outcomes, long.outcomes[:30])
    assert np.array_equal(short.centers, long.centers[: short.settled])


def test_columns_are_spread_evenly_if_the_settings_ask_for_it(simulator: Simulator):
    """Of 100 columns, each sixteenth of the bounding box gets about six, as by `Columns`."""
    settings = DropSettings(radius=radius_of("plate"), miss_limit=100, max_drops=100, even_columns=True)
    columns = simulator.drop(shape("plate"), settings, 1).columns
    counts = np.histogram2d(*columns.T, bins=4, range=shape("plate").bounds[:, :2].T)[0]
    assert counts.min() >= 4 and counts.max() <= 9


def test_the_first_spheres_stay_on_a_flat_plate_where_they_are_dropped(simulator: Simulator):
    """On a horizontal plate a sphere stays where it touches down."""
    settings = DropSettings(radius=radius_of("plate"), miss_limit=20, max_drops=20)
    result = simulator.drop(shape("plate"), settings, 1)
    moved = result.columns[result.outcomes == Outcome.SETTLED] - result.centers[:, :2]
    assert np.median(np.linalg.norm(moved, axis=1)) < 0.05 * radius_of("plate")


def test_cloud_is_left_as_it_was(simulator: Simulator):
    cloud, before = shapes.bin_(), shapes.bin_().points
    simulator.drop(cloud, DropSettings(radius=radius_of("bin")), 0)
    assert np.array_equal(cloud.points, before)


def test_nothing_is_printed_on_stdout(simulator: Simulator, capfd: pytest.CaptureFixture):
    """Commands print JSON there."""
    simulator.drop(shapes.plate(), DropSettings(radius=radius_of("plate"), max_drops=1), 0)
    assert not capfd.readouterr().out


def test_unknown_backend_names_those_there_are():
    with pytest.raises(InputError, match="expected one of.*fast"):
        make_simulator("no-such-backend")
