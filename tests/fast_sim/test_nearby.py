"""What the roller finds around a sphere, beside a look at every point and every settled sphere."""

from __future__ import annotations

import numpy as np
import pytest

from spherefunc_bullet.fast_sim.drop_run import empty_neighborhood, roll_shape
from spherefunc_bullet.fast_sim.falling import stands_on_floor
from spherefunc_bullet.fast_sim.grid import insert, may_touch_points, point_grid, sphere_grid
from spherefunc_bullet.fast_sim.nearby import (
    POINT_REACH,
    SPHERE_REACH,
    fill_neighbourhood,
    is_in_strip,
    still_valid,
    touches_points,
)

RADIUS = 0.03
LOW, HIGH = np.array([-0.3, -0.2, 0.0]), np.array([0.2, 0.3, 0.25])


def surroundings(points: int, spheres: int, reach: float | None, seed: int = 0):
    """Return a cloud and settled spheres all over a box, and the grids that hold them."""
    random = np.random.default_rng(seed)
    cloud, centers = random.uniform(LOW, HIGH, (points, 3)), random.uniform(LOW, HIGH + [0, 0, 0.1], (spheres, 3))
    grid = point_grid(cloud, LOW, HIGH, RADIUS)
    settled = sphere_grid(grid, LOW, HIGH, RADIUS, reach, spheres)
    for center in centers:
        settled.used[0] += insert(settled, *center, settled.used[0])
    return cloud, centers, grid, settled


def places(count: int, seed: int = 1) -> np.ndarray:
    """Return places in the box, beside it, above it and below."""
    return np.random.default_rng(seed).uniform(LOW - 0.1, HIGH + 0.15, (count, 3))


def within(points: np.ndarray, place: np.ndarray, reach: float) -> np.ndarray:
    """Return the points that are nearer than so far, sorted."""
    return np.sort(points[np.linalg.norm(points - place, axis=1) < reach], axis=0)


@pytest.mark.parametrize("points", [200, 6000])  # few to a look, and more than fit the bits of a number
@pytest.mark.parametrize("known", [True, False])
def test_all_that_is_near_is_found_and_nothing_else(points, known):
    reach = POINT_REACH * RADIUS
    cloud, centers, grid, settled = surroundings(points, 150, reach if known else None)
    nearby = empty_neighborhood(points)
    for place in places(150):
        fill_neighbourhood(grid, settled, nearby, *place, RADIUS)
        found, spheres = nearby.points[:, : nearby.counts[0]].T, nearby.spheres[:, : nearby.counts[1]].T
        assert np.array_equal(np.sort(found, axis=0), within(cloud, place, reach))
        assert np.array_equal(np.sort(spheres, axis=0), within(centers, place, SPHERE_REACH * RADIUS))


def test_what_touches_a_point_is_near_one():
    cloud, _, grid, _ = surroundings(800, 0, None)
    said = [touches_points(grid, *place, RADIUS) for place in places(400)]
    assert said == [len(within(cloud, place, RADIUS)) > 0 for place in places(400)]
    assert 0.1 < np.mean(said) < 0.9


def test_a_floor_is_points_near_the_ground_under_the_sphere():
    """Within a tenth of its radius above the ground, and 0.8 of it aside."""
    cloud, _, grid, _ = surroundings(4000, 0, None)
    low = cloud[cloud[:, 2] <= 0.1 * RADIUS]
    said = [stands_on_floor(grid, x, y, RADIUS) for x, y, _ in places(400)]
    aside = np.array([np.linalg.norm(low[:, :2] - place[:2], axis=1).min() for place in places(400)])
    assert said == (aside < 0.8 * RADIUS).tolist() and 0.1 < np.mean(said) < 0.9


def test_where_no_point_is_said_to_be_near_there_is_none():
    """Nor is more of the space said to be near points than a cell's diagonal explains."""
    reach = 1.5 * RADIUS
    cloud, _, grid, settled = surroundings(12, 0, reach)
    nearest = np.array([np.linalg.norm(cloud - place, axis=1).min() for place in places(2000)])
    said = np.array([may_touch_points(settled, *place) for place in places(2000)])
    margin = 2 * RADIUS + settled.cell
    outside = ((places(2000) < LOW - margin) | (places(2000) > HIGH + margin)).any(axis=1)
    assert said[nearest < reach].all() and said[outside].all()  # outside the grid nothing is known
    far = nearest > np.sqrt(3) * (reach + settled.cell)
    assert not said[far & ((places(2000) > LOW) & (places(2000) < HIGH)).all(axis=1)].any() and 0.1 < said.mean() < 0.9


def test_a_strip_ends_at_its_edges_and_surroundings_serve_for_a_fifth_of_a_radius():
    nearby = empty_neighborhood(1)
    assert is_in_strip(nearby, -1e9, 1e9)
    nearby.strip[:] = -0.1, 0.2, -0.3, 0.4
    for x, y in [(-0.1, 0), (0.2, 0), (0, -0.3), (0, 0.4)]:
        assert is_in_strip(nearby, x, y) and not is_in_strip(nearby, 1.01 * x, 1.01 * y)
    nearby.place[:] = 1, 2, 3
    for axis in range(3):
        for side in (-1, 1):
            near, far = np.array([[1.0, 2.0, 3.0]] * 2)
            near[axis] += side * 0.199 * RADIUS
            far[axis] += side * 0.201 * RADIUS
            assert still_valid(nearby, *near, RADIUS) and not still_valid(nearby, *far, RADIUS)


@pytest.mark.parametrize("spacing", [0.001, 0.004, 0.01])
@pytest.mark.parametrize("radius", [0.005, 0.02])
def test_a_sphere_climbs_out_of_where_it_sinks_between_points(radius, spacing):
    """It sinks deepest in the middle of four; and three points at least make the plane around its contact."""
    shape = roll_shape(radius, spacing, 30.0)
    aside = min(spacing / np.sqrt(2), 0.6 * radius)
    sink = radius - np.sqrt(radius**2 - aside**2)
    assert sink <= shape.bump < max(1.6 * sink, 0.02 * radius)
    assert aside < shape.gap < 1.25 * aside and shape.gap < radius
    assert shape.patch >= max(spacing, 0.5 * radius) and shape.patch < max(1.5 * spacing, 0.51 * radius)
    assert shape.flat == pytest.approx(0.5)
