"""A large object's drops strip by strip: the same bits on any number of cores, and the pile of the paper's order."""

from __future__ import annotations

import os
from functools import cache

import clouds
import numpy as np
import pytest
from scipy.spatial import cKDTree

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.fast_sim.drop_run import CHUNK, FEW, DropRun
from spherefunc_bullet.fast_sim.strips import EVERYWHERE, LARGE, strip_cuts
from spherefunc_bullet.settling.drops import LIMITED, TO_THE_END
from spherefunc_bullet.settling.settling import drop_if_useful
from spherefunc_bullet.simulator import DropSettings, Stop, make_simulator, one_by_one

RADIUS = 0.0045  # of spheres for which the chair has more than LARGE columns
needs_two = pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="this machine has one core")


@cache
def dropped(seed: int, cores: int = 1, as_drawn: bool = False, **limits):
    simulator = make_simulator("fast", cores=cores, as_drawn=as_drawn)
    return simulator.drop(clouds.chair(), DropSettings(radius=RADIUS, **limits), seed)


@cache
def whole_run(seed: int = 0) -> DropRun:
    settings = DropSettings(radius=RADIUS)
    run = DropRun(clouds.chair(), settings, make_simulator("fast"), seed)
    run.continue_run(settings)
    return run


def centers_of(run: DropRun) -> np.ndarray:
    return run.spheres.centers[: run.settled]


@needs_two
@pytest.mark.parametrize(
    "limits", [{}, {"max_spheres": 5000}, {"max_drops": 6000}, {"miss_limit": 12}], ids=["none", *"SDM"]
)
def test_the_bits_do_not_depend_on_the_cores(limits):
    one, two = dropped(4, **limits), dropped(4, cores=2, **limits)
    for name in ("centers", "on_object", "columns", "outcomes"):
        assert np.array_equal(getattr(one, name), getattr(two, name))
    assert one.stop == two.stop and one.provenance == two.provenance
    assert one.settled == limits.get("max_spheres", one.settled) and one.drops <= limits.get("max_drops", one.drops)


@pytest.mark.slow
def test_a_large_object_is_filled_in_strips():
    run = whole_run()
    assert run.spheres.nx * run.spheres.ny >= LARGE and [len(cuts) for _, cuts in run.strips.rounds] == [1, 1, 0]
    counts = [len(columns) for columns in run.columns]
    assert counts[0] == CHUNK // 4 and sum(FEW <= count < CHUNK // 4 for count in counts) > 5
    assert np.array_equal(dropped(0).centers, centers_of(run))


def test_each_settled_sphere_is_in_one_block():
    """Blocks that one sphere did not need serve others, whoever ended in which strip."""
    run = whole_run()
    full = run.spheres.blocks[: run.spheres.used[0]]
    spared = run.strips.spares[run.strips.spares > 0]
    kept = np.delete(full, spared, axis=0)[:, 1:].transpose(0, 2, 1).reshape(-1, 3)
    kept = kept[np.isfinite(kept).all(axis=1)]
    assert np.array_equal(np.sort(kept, axis=0), np.sort(centers_of(run), axis=0))


@pytest.mark.parametrize("together", [3000, 300], ids=["many are spared", "few are"])
def test_there_is_room_for_all_blocks(together):
    """Also where a long stretch one by one follows strips, whose spare blocks are kept."""
    settings = DropSettings(radius=RADIUS)
    run = DropRun(clouds.chair(), settings, make_simulator("fast"), 3)
    strips, drawn = (run.drop_in_strips, together), (run.drop_in_order, 500)
    for drop, count in [strips, *[drawn] * 30, strips]:
        drop(run.draw_columns(count))
        assert run.spheres.used[0] <= len(run.spheres.blocks) and run.settled <= len(run.on_object)
    assert run.settled > CHUNK


def test_misses_in_a_row_go_on_from_strips_to_strips():
    """On a slope that holds nothing a run ends after as many drops as may miss, however many fall together."""
    settings = DropSettings(radius=RADIUS, miss_limit=100)
    run = DropRun(clouds.incline(30, length=0.5), settings, make_simulator("fast"), 0)
    assert [run.drop_in_strips(run.draw_columns(count)) for count in (30, 40, 29, 1)] == [False, False, False, True]
    assert run.settled == 0 and run.drops == 100 and run.stop() == Stop.MISSES


def test_what_settles_ends_a_row_of_misses():
    run = DropRun(clouds.chair(), DropSettings(radius=RADIUS), make_simulator("fast"), 0)
    for _ in range(200):
        assert not run.drop_in_strips(run.draw_columns(2))
        outcomes = np.concatenate(run.outcomes)
        assert run.state[4] == len(outcomes) - 1 - np.flatnonzero(outcomes == 0)[-1]
    assert 0 < run.settled < run.drops


def test_spheres_overlap_nothing_and_none_hangs_in_the_air():
    result, cloud = dropped(0), clouds.chair()
    distances = cKDTree(result.centers).query(result.centers, k=2)[0][:, 1]
    assert distances.min() >= 0.98 * 2 * RADIUS
    to_cloud = cKDTree(cloud.points).query(result.centers)[0]
    assert to_cloud.min() >= 0.98 * RADIUS
    held = (to_cloud < 1.1 * RADIUS) | (distances < 1.02 * 2 * RADIUS) | (result.centers[:, 2] <= 1.01 * RADIUS)
    assert held.all()


@pytest.mark.slow
def test_the_pile_is_the_one_that_the_papers_order_gives():
    """Within three times what seeds differ by: how many settle, how high, how many on the object."""
    answer = []
    for options in ({}, {"as_drawn": True}):
        results = [dropped(seed, **options) for seed in range(5)]
        heights = [result.centers[:, 2] for result in results]
        on_object = [result.on_object.mean() for result in results]
        answer.append([[len(z), z.mean(), z.std(), share] for z, share in zip(heights, on_object, strict=True)])
    strips, drawn = np.array(answer)
    spread = np.sqrt((strips.var(axis=0, ddof=1) + drawn.var(axis=0, ddof=1)) / 5)
    assert (abs(strips.mean(axis=0) - drawn.mean(axis=0)) < 3 * spread).all()
    assert not np.array_equal(dropped(0).centers, dropped(0, as_drawn=True).centers)


def test_drops_are_told_in_the_order_of_their_columns():
    result = dropped(0)
    drawn = np.random.default_rng(0).uniform(*(bound[:2] for bound in clouds.chair().bounds), size=(result.drops, 2))
    assert np.array_equal(result.columns, drawn)
    settled = result.outcomes == 0
    assert settled.sum() == result.settled and result.stop == Stop.MISSES
    # Straight down for many: the order of centres is that of the drops which settled.
    assert np.median(np.hypot(*(result.centers[:, :2] - result.columns[settled]).T)) < 3 * RADIUS


@pytest.mark.parametrize("length", [LIMITED, TO_THE_END], ids=["limited", "to the end"])
def test_features_are_of_spheres_that_are_dropped_one_by_one(length):
    simulator, cloud = make_simulator("fast"), clouds.table()
    drops, _, _ = drop_if_useful(cloud, simulator, RADIUS, 0, length)
    expected = make_simulator("fast", as_drawn=True).drop(cloud, DropSettings(radius=RADIUS), 0).centers
    assert np.array_equal(drops.rests, expected.astype(np.float32))
    assert one_by_one(simulator).as_drawn and not simulator.as_drawn
    assert one_by_one(object) is object  # what knows no other way


@pytest.mark.parametrize(("count", "strips"), [(25, 1), (26, 2), (199, 2), (200, 2), (420, 4)])
def test_cuts(count, strips):
    cuts = strip_cuts(-1.0, 0.5, count)
    assert len(cuts) == strips - 1
    assert np.allclose(np.diff([-1.0, *cuts, -1.0 + 0.5 * count]), 0.5 * count / strips)


def test_a_sphere_outside_its_strip_is_dropped_in_a_later_round():
    run = whole_run()
    strips = run.strips
    column = np.array([[strips.rounds[0][1][0], strips.rounds[1][1][0]]])  # on both cuts
    ends = strips.drop(run.points, run.spheres, column, RADIUS, run.shape, *run.inside)
    assert ends.outcomes[0] in (0, 1, 2) and tuple(strips.nearbies[0].strip) == EVERYWHERE


@pytest.mark.parametrize("cores", [0, 10_000])
def test_cores_that_there_are_not(cores):
    with pytest.raises(InputError, match="cores: expected at least 1 and at most"):
        make_simulator("fast", cores=cores)
