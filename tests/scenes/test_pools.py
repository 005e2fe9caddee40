"""Pools: spheres on a whole scene, what they rest on, and what is cut out for them."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import level as sheet_at
from clouds import mug, sheet
from room_shapes import moved, room, square_table

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.pools.surfaces import level_pools, parted_at_necks, resting_places, upper_face
from spherefunc_bullet.scenes.pools.tops import cut_out, ground_top, objects_on, top_of_pool
from spherefunc_bullet.scenes.pools.vessels import cut_vessel, vessel_pools
from spherefunc_bullet.scenes.recognition.proposals import POOLS, Scene, kinds_of, propose
from spherefunc_bullet.scenes.scans.cells import cells
from spherefunc_bullet.scenes.settings import POOL, SCAN, SEGMENTATION

RADIUS = 0.04


def chair(x: float, y: float) -> np.ndarray:
    """Return a seat on legs with a back along its far edge."""
    seat, back = square_table(0.42, 0.42, 0.45), sheet([-0.21, 0.2, 0.45], [0.42, 0, 0], [0, 0, 0.45])
    return moved(np.vstack([seat, back]), x, y)


def pushed_chair() -> np.ndarray:
    """Return a table with a chair whose seat is half below it and whose back stands at its edge."""
    return np.vstack([square_table(1.4, 0.8, 0.74), chair(0.0, 0.42)])


def pools_of(points: np.ndarray):
    centers = resting_places(points, "fast", RADIUS)
    return level_pools(voxels_of(points), centers, RADIUS)


def voxels_of(points: np.ndarray):
    return cells(points, SEGMENTATION.leaf_size)


@pytest.mark.parametrize("backend", ["fast", "bullet"])
@pytest.mark.slow
def test_spheres_rest_on_tops_alone_and_not_on_each_other(backend):
    points = square_table(1.2, 0.8, 0.72)[::2]
    centers = resting_places(points, backend, RADIUS)
    assert len(centers) > 20
    # Of 37 on a square metre, half of those that rolled off an edge are gone; none lies higher than the top.
    assert np.abs(centers[:, 2] - RADIUS - 0.72).max() < 0.01


def test_the_same_seed_drops_the_same_spheres():
    points = square_table(0.8, 0.8, 0.5)[::4]
    one, same, other = (resting_places(points, "fast", RADIUS, seed=seed) for seed in (1, 1, 5))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_nothing_to_rest_on_is_no_error():
    assert resting_places(np.empty((0, 3)), "fast", RADIUS).shape == (0, 3)
    assert level_pools(voxels_of(np.empty((0, 3))), np.empty((0, 3)), RADIUS) == []


def test_a_table_and_a_chair_pushed_under_it_are_two_pools():
    table, seat = pools_of(pushed_chair())
    assert table.height == pytest.approx(0.74, abs=0.01)
    assert table.area == pytest.approx(1.4 * 0.8, rel=0.15)
    assert seat.height == pytest.approx(0.45, abs=0.01)
    # What lies below the table, where no sphere falls, is of the seat all the same.
    assert seat.area > 0.75 * 0.42**2


def test_a_chair_is_cut_out_with_legs_and_back_and_without_the_table():
    points = pushed_chair()
    table, seat = pools_of(points)
    own = points[cut_out(voxels_of(points), seat, POOL.back_gap)]
    assert own[:, 2].max() > 0.85
    assert own[:, 2].min() < 0.05
    assert np.ptp(own[:, 0]) < 0.6
    top = points[cut_out(voxels_of(points), table, POOL.back_gap)]
    assert top[:, 2].max() < 0.78
    assert np.ptp(top[:, 0]) == pytest.approx(1.4, abs=0.03)


def test_surfaces_that_a_neck_connects_are_pools_each_and_together():
    table, seat = sheet_at(0.9, 0.6, 0.45), moved(sheet_at(0.45, 0.45, 0.44), 0.0, 0.7)
    neck = moved(sheet_at(0.07, 0.8, 0.445), 0.1, 0.4)
    points = np.vstack([table, seat, neck])
    centers = resting_places(points, "fast", RADIUS)
    whole = level_pools(voxels_of(points), centers, RADIUS)[0]
    parts = parted_at_necks(whole, centers, RADIUS)
    assert whole.area > 0.7
    assert sorted(part.area for part in parts) == pytest.approx([0.2, 0.54], rel=0.2)
    assert sorted(part.height for part in parts) == pytest.approx([0.44, 0.45], abs=0.004)
    assert all(len(part.centers) >= 3 for part in parts)
    tongue, *_ = pools_of(np.vstack([table, neck]))
    assert not parted_at_necks(tongue, tongue.centers, RADIUS)  # it is a part of what it sticks out of


def test_a_footprint_closes_the_shadow_of_what_stands_on_a_top():
    points = sheet_at(1.0, 0.8, 0.7)
    shadow = (np.abs(points[:, :2]) < 0.05).all(axis=1)
    (pool,) = pools_of(points[~shadow])
    ground = pool.footprint
    assert ground.holds(np.array([[0.0, 0.0, 0.0]]))[0]
    assert ground.mask.sum() * SCAN.cell**2 == pytest.approx(0.8, rel=0.1)


def test_a_mug_on_a_table_is_a_thing_on_the_table_s_pool():
    points = np.vstack([square_table(1.0, 0.8, 0.5), moved(mug().points, 0.2, 0.1, 0.5)])
    (pool,) = [pool for pool in pools_of(points) if pool.area > 0.1]
    (members,) = objects_on(top_of_pool(points, pool, cells(points, SCAN.cell)))
    assert points[members, :2].mean(axis=0) == pytest.approx([0.2, 0.1], abs=0.02)
    # But its bottom, and the centimetre above the top that may be the top's.
    assert len(members) == pytest.approx((mug().points[:, 2] > SCAN.cell / 2).sum(), rel=0.02)


def test_a_mug_on_a_board_that_is_seen_from_both_sides_stands_on_its_upper_face():
    thickness = 0.024  # so that both faces lie within a slab, and their mean is more than a centimetre too low
    board = np.vstack([square_table(1.0, 0.8, 0.5), sheet_at(1.0, 0.8, 0.5 - thickness)])
    points = np.vstack([board, moved(mug().points, 0.2, 0.1, 0.5)])
    (pool,) = [pool for pool in pools_of(points) if pool.area > 0.1]
    assert pool.height == pytest.approx(0.5, abs=0.002)
    (members,) = objects_on(top_of_pool(points, pool, cells(points, SCAN.cell)))
    assert points[members, :2].mean(axis=0) == pytest.approx([0.2, 0.1], abs=0.02)


@pytest.mark.parametrize("spread", [0.002, 0.006, 0.012])
def test_noise_is_no_board_with_two_faces(spread):
    points = sheet_at(1.0, 0.8, 0.5)
    points[:, 2] += np.random.default_rng(0).normal(0, spread, len(points))
    assert upper_face(points).all()


def test_a_vessel_that_touches_a_tin_is_told_from_it_by_its_rim():
    cup = mug().points
    width = np.ptp(cup[:, 0])
    tin = moved(np.vstack([sheet_at(0.1, 0.1, 0.12), *sides(0.1, 0.12)]), 0.05 + width / 2, 0.0)
    points = np.vstack([cup, tin])
    top = ground_top(points)
    pool = vessel_pools(top, "fast")[0]
    assert pool.center[:2] == pytest.approx([0.0, 0.0], abs=0.015)
    inside = cut_vessel(points, pool)
    assert inside[: len(cup)].mean() > 0.7
    assert inside[len(cup) :].mean() < 0.25


def test_what_is_too_narrow_for_a_thing_is_no_vessel():
    """A trough 3.4 cm wide, as gaps in a pot's wall are that was seen from both sides."""
    trough = np.vstack([sheet([-0.06, y, 0], [0.12, 0, 0], [0, 0, 0.1]) for y in (-0.017, 0.017)])
    ends = np.vstack([sheet([x, -0.017, 0], [0, 0.034, 0], [0, 0, 0.1]) for x in (-0.06, 0.06)])
    box = moved(np.vstack([sheet_at(0.12, 0.12, 0.1), *sides(0.12, 0.1)]), 0.125, 0.0)
    points = np.vstack([trough, ends, box])
    assert vessel_pools(ground_top(points), "fast")
    assert {len(one.members) for one in proposed_on_table(points)} == {len(over(points))}


def proposed_on_table(points: np.ndarray):
    return propose(Scene(points=points, labels=np.zeros(len(points), int), on_table=True), "fast", [POOLS])


def over(points: np.ndarray) -> np.ndarray:
    """Return the points that lie higher than the top's own could."""
    return points[points[:, 2] > SCAN.cell / 2]


def sides(width: float, height: float) -> list[np.ndarray]:
    """Return the four walls of a box."""
    half = width / 2
    starts = [([-half, -half, 0], [width, 0, 0]), ([-half, half, 0], [width, 0, 0])]
    starts += [([-half, -half, 0], [0, width, 0]), ([half, -half, 0], [0, width, 0])]
    return [sheet(at, along, [0, 0, height]) for at, along in starts]


def test_pools_propose_what_clusters_do_not():
    points, truth = room()
    labels = np.where(truth == -1, -1, np.where(truth == -2, -2, 0))  # one cluster: all runs together
    proposed = propose(Scene(points=points, labels=labels), "fast")
    best = [
        max(
            np.count_nonzero(truth[one.members] == number)
            / (len(one.members) + np.count_nonzero(truth == number) - np.count_nonzero(truth[one.members] == number))
            for one in proposed
            if one.by == POOLS
        )
        for number in (0, 1, 3)  # table, stool, mug
    ]
    assert min(best) > 0.6


def test_spheres_fall_on_what_a_surface_covers():
    hidden = chair(0.0, 0.1)  # under the top altogether, back and all
    hidden = hidden[hidden[:, 2] < 0.7]
    boards = [sheet_at(0.8, 0.3, height) for height in (0.4, 0.8, 1.2, 1.6)]
    shelf = moved(np.vstack([*boards, sheet([-0.4, 0.15, 0], [0.8, 0, 0], [0, 0, 1.6])]), 3.0, 0.0)
    points = np.vstack([square_table(1.4, 0.8, 0.74), hidden, shelf, moved(mug().points, 3.0, 0.0, 0.4)])
    proposed = propose(Scene(points=points, labels=np.zeros(len(points), int)), "fast", [POOLS])
    heights = {round(one.pool.height, 2) for one in proposed if one.pool is not None}
    assert heights == {0.4, 0.45, 0.74, 0.8, 1.2}  # the seat, the table, and the boards within reach
    near_mug = [one for one in proposed if np.abs(points[one.members].mean(axis=0) - [3.0, 0.0, 0.45]).max() < 0.03]
    assert near_mug


@pytest.mark.parametrize("kinds", ["pool", "clusters,", "all"])
def test_unknown_kinds_of_proposals_are_refused(kinds):
    with pytest.raises(InputError, match="--proposals"):
        kinds_of(kinds)
