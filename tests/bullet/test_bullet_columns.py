"""Where a sphere starts above its column, beside arithmetic that tries every point and every settled sphere."""

from __future__ import annotations

import numpy as np
import pytest

from spherefunc_bullet.bullet.columns import MAX_CELLS, ColumnIndex, in_cells


def touch_height(xy: np.ndarray, centers: np.ndarray, reach: float) -> float:
    """Return how high a sphere's centre is that comes down and is so far from the first of some places."""
    aside = ((centers[:, :2] - xy) ** 2).sum(axis=1)
    near = aside < reach**2
    return max(centers[near, 2] + np.sqrt(reach**2 - aside[near]), default=-np.inf)


def filled(count: int, spheres: int, extent: float, seed: int) -> tuple[ColumnIndex, np.ndarray, np.ndarray]:
    """Return points and settled spheres (radii) all over a footprint, and what finds them."""
    random = np.random.default_rng(seed)
    low, high = np.array([-extent, -0.6 * extent, 0]), np.array([0.8 * extent, extent, 5])
    points, settled = random.uniform(low, high, (count, 3)), random.uniform(low - 1, high + 1, (spheres, 3))
    columns = ColumnIndex(points, low[:2], high[:2])
    for center in settled:
        columns.add(center)
    return columns, points, settled


@pytest.mark.parametrize(("count", "spheres", "extent"), [(300, 0, 8), (0, 300, 8), (200, 600, 12), (3000, 600, 4000)])
def test_a_sphere_starts_on_the_highest_that_it_meets(count, spheres, extent):
    columns, points, settled = filled(count, spheres, extent, 0)
    assert columns.cell * columns.fine > 1 if extent > 1000 else (columns.cell, columns.fine) == (2, 0.5)
    random = np.random.default_rng(1)
    wide = random.uniform(-1.1 * extent - 3, 1.1 * extent + 3, (300, 2))
    places = np.concatenate([points[:100], settled[:100]])[:, :2]  # and beside what is there
    for x, y in np.concatenate([wide, places + random.uniform(-2.2, 2.2, places.shape)]):
        expected = max(touch_height([x, y], points, 1.0), touch_height([x, y], settled, 2.0))
        assert columns.height(x, y) == pytest.approx(expected)


def test_what_is_clear_has_no_point_so_near():
    columns, points, _ = filled(400, 0, 6, 2)
    random, found = np.random.default_rng(3), []
    for center in random.uniform([-8, -6, -1], [7, 8, 6], (400, 3)):
        nearest = np.linalg.norm(points - center, axis=1).min()
        found += [columns.clear(center, distance) for distance in (0.98, nearest * (1 - 1e-9), nearest * (1 + 1e-9))]
        assert found[-3:] == [nearest >= 0.98, True, False]
    assert 0.2 < np.mean(found[::3]) < 0.8


def test_cells_hold_all_points_in_their_order_and_none_other():
    points = np.random.default_rng(4).uniform(-1, 7, (500, 3))  # some outside the footprint, which count as at its edge
    dims, side = np.array([5, 3]), 1.5
    placed, starts = in_cells(points, np.zeros(2), side, dims)
    cells = np.clip(np.floor(points[:, :2] / side), 0, dims - 1) @ [3, 1]
    assert np.array_equal(placed, points[np.argsort(cells, kind="stable")])
    assert np.array_equal(np.diff(starts), np.bincount(cells.astype(int), minlength=15)) and starts[0] == 0


def test_a_huge_footprint_has_as_many_cells_as_fit_the_memory():
    columns, _, _ = filled(10, 1, 60_000, 5)
    assert max(columns.dims.prod(), columns.fine_dims.prod()) < 1.01 * MAX_CELLS


@pytest.mark.parametrize("away", [(50.0, 0.0), (0.0, 50.0), (-70.0, 30.0), (400.0, -300.0)])
def test_where_the_footprint_is_changes_nothing(away):
    random, shift = np.random.default_rng(6), np.array([*away, 0])
    points, settled = random.uniform(0, [9, 6, 3], (200, 3)), random.uniform(0, [9, 6, 5], (30, 3))
    here = ColumnIndex(points, np.zeros(2), np.array([9.0, 6]))
    there = ColumnIndex(points + shift, shift[:2], shift[:2] + [9.0, 6])
    for center in settled:
        here.add(center), there.add(center + shift)
    for x, y, z in random.uniform(-3, [12, 9, 6], (200, 3)):
        assert there.height(x + away[0], y + away[1]) == pytest.approx(here.height(x, y))
        assert there.clear(np.array([x, y, z]) + shift, 0.8) == here.clear(np.array([x, y, z]), 0.8)
