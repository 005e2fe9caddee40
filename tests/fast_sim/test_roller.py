"""The roller: where spheres must come to rest by thought alone, and its kernels against independent arithmetic."""

from __future__ import annotations

import clouds
import numpy as np
import pytest
import trimesh
from scipy.optimize import nnls
from scipy.spatial import cKDTree

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.fast_sim.contact import (
    MAX_CONTACTS,
    is_allowed,
    nearest_point,
    plane_normal,
    steepest_descent,
)
from spherefunc_bullet.fast_sim.drop_run import empty_neighborhood
from spherefunc_bullet.fast_sim.falling import GRAZE_POINT, TIGHT_POINT, fall, fall_nearby, fall_on_nearby
from spherefunc_bullet.fast_sim.grid import find_nearest, insert, point_grid, sphere_grid
from spherefunc_bullet.fast_sim.nearby import DEPTH, covers_fall, fill_neighbourhood
from spherefunc_bullet.fast_sim.rolling import free_path
from spherefunc_bullet.simulator import DropSettings, make_simulator

OVERLAP = 0.02  # of the radius, promised of every contact


def drop(cloud: Cloud, radius: float, seed: int = 0):
    return make_simulator("fast").drop(cloud, DropSettings(radius=radius), seed)


def enter(spheres, centers):
    """Enter settled spheres into a grid."""
    for center in centers:
        spheres.used[0] += insert(spheres, *center, spheres.used[0])


def lowest_between_points(radius: float) -> float:
    """Return how high above a lattice a sphere rests at least: in the middle of four points, half a diagonal aside."""
    return np.sqrt(((1 - OVERLAP) * radius) ** 2 - clouds.SPACING**2 / 2)


@pytest.mark.parametrize("radius", [0.005, 0.01, 0.02])
def test_sphere_on_a_plate_rests_one_radius_above_it(radius):
    plate = clouds.plate()
    result = drop(plate, radius)
    x, y, z = (result.centers - [0, 0, 0.4]).T
    over = np.maximum(abs(x), abs(y)) <= 0.15  # at the edge a sphere may also hang over by less than the spacing
    assert result.settled > 40 and over.mean() > 0.9
    # Never higher; lower by what it sinks between the points: 17 % of 5 mm, 4 % of 1 cm, 1 % of 2 cm, and overlap.
    assert z.max() <= radius * (1 + 1e-9)
    assert z[over].min() >= lowest_between_points(radius)


def test_a_sphere_comes_down_its_own_column():
    for seed in range(5):
        settings = DropSettings(radius=0.01, max_drops=1)
        result = make_simulator("fast").drop(clouds.plate(), settings, seed)  # whose margin of one radius is free
        assert result.settled == 1 and result.centers[0, :2] == pytest.approx(result.columns[0])


@pytest.mark.parametrize("radius", [0.005, 0.01, 0.02])
def test_table_gets_one_flat_layer(radius):
    result = drop(clouds.table(), radius)
    assert result.on_object.all()
    assert np.ptp(result.centers[:, 2]) < 0.3 * radius  # a second layer would lie at least 1.4 radii higher
    # Random places leave holes. Discs that cannot move jam at 0.547 of the area; a roller does no worse than
    # 0.45 after fifty misses in a row, and no layer can pass the hexagonal 0.907.
    share = result.settled * np.pi * radius**2 / (0.6 * 0.4)
    assert 0.45 < share < 0.907


@pytest.mark.parametrize("floor", [0.004, 0.0], ids=["floor above the ground", "floor on the ground"])
@pytest.mark.parametrize("seed", range(3))
def test_mug_fills_to_the_rim(floor, seed):
    radius, wall, height = 0.005, 0.04, 0.1
    centers = drop(clouds.mug(wall, height, floor), radius, seed).centers
    aside, z = np.hypot(*centers[:, :2].T), centers[:, 2]
    # The twenty highest, of the fifty that a cross-section holds, reach the rim, and no heap stands above it.
    highest = np.sort(z)[-20:]
    assert highest[0] > height - radius and highest[-1] < height + 2 * radius
    # Away from walls, floor and top by two radii, piles of spheres fill between 0.45 (as loose as cohesionless
    # spheres get, with a margin: 0.52 is a cubic lattice) and 0.64 (random close packing).
    core = (aside < wall - 2 * radius) & (z > 0.02) & (z < 0.085)
    volume = np.pi * (wall - 2 * radius) ** 2 * 0.065
    assert 0.45 < core.sum() * 4 / 3 * np.pi * radius**3 / volume < 0.64


@pytest.mark.parametrize("radius", [0.005, 0.01])
def test_nothing_leaks_from_a_mug(radius):
    centers = drop(clouds.mug(), radius).centers
    below_rim = centers[centers[:, 2] < 0.1 - radius]
    # Between points of the wall 4 mm apart a sphere sinks as it does on a plate.
    assert np.hypot(*below_rim[:, :2].T).max() <= 0.04 - lowest_between_points(radius)
    assert below_rim[:, 2].min() >= 0.004 + lowest_between_points(radius)


@pytest.mark.parametrize("seed", range(3))
def test_pile_on_a_chair_slopes_up_to_the_back(seed):
    radius = 0.01
    x, y, z = drop(clouds.chair(), radius, seed).centers.T
    columns = np.floor(np.column_stack([x, y]) / (2 * radius)).astype(int)
    _, column = np.unique(columns, axis=0, return_inverse=True)
    top = [np.flatnonzero(column == k)[np.argmax(z[column == k])] for k in range(column.max() + 1)]
    quarters = np.clip(((y[top] + 0.2) / 0.1).astype(int), 0, 3)
    heights = [z[top][quarters == k].mean() for k in range(4)]
    assert np.all(np.diff(heights) > 0)
    # By more than a layer: spheres on spheres lie at least 1.4 radii higher.
    assert heights[-1] - heights[0] > 5 * radius and heights[0] > 0.4


@pytest.mark.parametrize("radius", [0.005, 0.01, 0.02])
def test_steep_incline_is_left_by_all(radius):
    result = drop(clouds.incline(30), radius)
    assert result.settled == 0 and result.rolled_off == 50


@pytest.mark.parametrize("thickness", [0.001, 0.002, 0.02])
@pytest.mark.parametrize("radius", [0.01, 0.02])
def test_spheres_roll_off_a_board_however_thin_it_is(radius, thickness):
    board, post = trimesh.creation.box((0.2, 0.3, thickness)), trimesh.creation.box((0.02, 0.02, 0.3))
    board.apply_transform(trimesh.transformations.rotation_matrix(np.radians(25), [1, 0, 0]))
    post.apply_translation([0, 0, -0.16 - thickness])
    both = trimesh.util.concatenate([board, post])
    # On both sides of a thin board samples lie nearer to each other than along it. On its upper edge one may balance.
    assert drop(cloud_from_mesh(both.vertices, both.faces), radius).settled < 5


@pytest.mark.parametrize("radius", [0.005, 0.01, 0.02])
def test_nearly_flat_incline_holds_a_layer(radius):
    result = drop(clouds.incline(1), radius)
    slope = np.radians(1)
    normal = np.array([0, -np.sin(slope), np.cos(slope)])
    above = (result.centers - [0, 0, 0.3 + 0.15 * np.sin(slope)]) @ normal
    level = drop(clouds.plate(), radius).settled
    assert result.on_object.all() and above.max() <= radius * (1 + 1e-6)
    # As many as on a level plate; how many fit at random varies by some five per cent of fifty.
    assert result.settled == pytest.approx(level, rel=0.15)


def test_flatness_is_an_option():
    strict, lax = (make_simulator("fast", flat_angle_deg=angle) for angle in (2.0, 8.0))
    settings = DropSettings(radius=0.01)
    assert strict.drop(clouds.incline(5), settings).settled == 0
    assert lax.drop(clouds.incline(5), settings).settled > 50


def test_what_counts_as_flat_is_a_plane():
    """A sphere that meets a wire up to 5 degrees beside its top is on no surface, and rolls off it."""
    radius = 0.01
    wires = [np.column_stack([clouds.steps(0.3), np.full(76, y), np.full(76, 0.3)]) for y in (0.0, 0.06)]
    cloud = clouds.cloud(*wires, name="two wires")
    for seed in range(4):
        result = make_simulator("fast").drop(cloud, DropSettings(radius=radius, miss_limit=100), seed)
        # A third of the drops meet a wire, and of these one in six so near its top; what balances on it to a
        # thousandth of the radius, one drop in 1,500, may stay.
        assert result.settled <= 1


def test_what_is_as_usual_is_not_named():
    """Results are kept under the options, so that those of earlier versions are still found."""
    assert make_simulator("fast").options() == {"flat_angle_deg": 5.0}
    assert make_simulator("fast", as_drawn=True).options() == {"flat_angle_deg": 5.0, "as_drawn": True}


def test_groove_holds_a_row_along_its_bottom():
    radius = 0.02
    result = drop(clouds.groove(), radius)
    lowest = result.centers[:, 2] < 0.2 + radius * np.sqrt(2) * 1.05
    # A sphere between two planes at right angles has its centre sqrt(2) radii above their edge, or lower by what
    # it sinks between the points on either side.
    assert result.centers[:, 2].min() >= 0.2 + lowest_between_points(radius) * np.sqrt(2) - 1e-9
    assert lowest.sum() >= 4 and abs(result.centers[lowest][:, 1]).max() < 0.1 * radius


@pytest.mark.parametrize("radius", [0.01, 0.02])
def test_spheres_on_the_ground_beside_legs_are_not_counted(radius):
    feet = [(x, y) for x in (-0.15, 0.15) for y in (-0.1, 0.1)]
    posts = clouds.cloud(*(clouds.post(x, y, 0.4) for x, y in feet), name="four posts")
    for seed in range(4):
        result = drop(posts, radius, seed)
        # What settles, if anything, sits on a post's rim.
        assert result.rolled_off >= 50 and np.all(result.centers[:, 2] > 0.4)


def test_floor_on_the_ground_holds_spheres():
    result = drop(clouds.bin_(), 0.01)
    on_floor = result.centers[:, 2] <= 0.0102
    assert on_floor.sum() > 20 and result.settled > 100
    assert np.all(np.abs(result.centers[:, :2]) < [0.08, 0.06])


def test_shifted_cloud_gives_a_like_pile():
    mug = clouds.mug()
    first, second = drop(mug, 0.01), drop(Cloud(mug.points + [0.5, -0.25, 0], "mug"), 0.01)
    # Rounding differs, and one contact that turns out otherwise changes all after it: what must agree is how many
    # settle and where their middle is, as between seeds.
    assert second.settled == pytest.approx(first.settled, rel=0.2)
    assert abs(second.centers.mean(axis=0) - first.centers.mean(axis=0) - [0.5, -0.25, 0]).max() < 0.01


# Kernels: the Python original beside the compiled form, and both beside arithmetic of another kind.

BOTH = pytest.mark.parametrize("form", ["compiled", "python"])


def kernel(function, form: str):
    return function if form == "compiled" else function.py_func


def contacts(rows) -> tuple[np.ndarray, int]:
    """Return normals in a kernel's scratch, and their number."""
    scratch = np.full((MAX_CONTACTS + 1, 3), np.nan)
    scratch[: len(rows)] = np.reshape(rows, (-1, 3))
    return scratch, len(rows)


def unit_vectors(random, count: int) -> np.ndarray:
    rows = random.normal(size=(count, 3))
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def projected_gravity(normals: np.ndarray) -> np.ndarray:
    """Return gravity projected onto {v : n v >= 0}: by Moreau, what non-negative normals cannot balance of it."""
    gravity = np.array([0.0, 0.0, -1.0])
    forces, _ = nnls(normals.T, -gravity)
    return gravity + normals.T @ forces


@BOTH
@pytest.mark.parametrize("count", [1, 2, 3, 4, 6, 12])
def test_steepest_descent_is_the_projection_of_gravity(form, count):
    random = np.random.default_rng(count)
    for _ in range(300):
        normals = unit_vectors(random, count)
        normals[: count // 2, 2] = abs(normals[: count // 2, 2])  # mostly from below, as contacts are
        v = kernel(steepest_descent, form)(*contacts(normals))
        # Both solve in double precision; normals nearly parallel cost half of the digits.
        assert np.allclose(v, projected_gravity(normals), atol=1e-7)


@BOTH
@pytest.mark.parametrize("angle_deg", [0, 1, 30, 60, 90])
def test_steepest_descent_on_one_slope(form, angle_deg):
    angle = np.radians(angle_deg)
    v = kernel(steepest_descent, form)(*contacts([[np.sin(angle), 0, np.cos(angle)]]))
    assert np.allclose(v, np.sin(angle) * np.array([np.cos(angle), 0, -np.sin(angle)]), atol=1e-12)


@BOTH
def test_steepest_descent_without_contacts_or_when_blocked(form):
    descend = kernel(steepest_descent, form)
    assert descend(*contacts([])) == (0, 0, -1)
    corner = np.array([[1, 1, 1], [-1, 1, 1], [0, -1, 1]]) / np.sqrt([[3], [3], [2]])
    assert descend(*contacts(corner)) == (0, 0, 0)
    assert descend(*contacts([[0, 0, -1.0]])) == (0, 0, -1)  # a ceiling holds nothing up


@BOTH
def test_motions_into_a_contact_are_not_allowed(form):
    may = kernel(is_allowed, form)
    floor = contacts([[0, 0, 1.0]])
    assert may(*floor, 1.0, 0.0, 0.0) and may(*floor, 0.0, 0.0, 1.0) and not may(*floor, 0.0, 0.0, -1.0)


@BOTH
def test_plane_through_points_of_a_plane(form):
    random = np.random.default_rng(0)
    for normal in unit_vectors(random, 50):
        across = np.linalg.svd(normal[None])[2][1:]
        points = random.uniform(-1, 1, (40, 2)) @ across * 0.01 + random.uniform(-1, 1, 3)
        x, y, z = points.mean(axis=0)
        found = kernel(plane_normal, form)(by_axis(points), 40, x, y, z, 0.05)
        # Points in a plane up to rounding: coordinates of one metre, offsets of a centimetre, squared.
        assert abs(np.dot(found, normal)) == pytest.approx(1, abs=1e-9)
        assert np.linalg.norm(found) == pytest.approx(1)


@BOTH
def test_plane_is_the_least_squares_one_of_noisy_points(form):
    points = np.random.default_rng(1).normal(size=(200, 3)) * [0.01, 0.008, 0.0002] + 0.5
    found = kernel(plane_normal, form)(by_axis(points), 200, 0.5, 0.5, 0.5, 1.0)
    best = np.linalg.svd(points - points.mean(axis=0))[2][2]
    # The minors weigh errors a little differently from the eigenvector: to second order in noise over extent.
    assert np.degrees(np.arccos(min(1, abs(np.dot(found, best))))) < 0.05


@BOTH
def test_edges_and_single_points_are_no_planes(form):
    plane = kernel(plane_normal, form)
    line = np.outer(np.linspace(-1, 1, 20), [1.0, 2.0, 0.5])
    assert plane(by_axis(line), 20, 0.0, 0.0, 0.0, 9.0) == (0, 0, 0)
    assert plane(np.eye(3), 2, 0.0, 0.0, 0.0, 9.0) == (0, 0, 0)
    assert plane(np.eye(3), 3, 50.0, 0.0, 0.0, 9.0) == (0, 0, 0)  # all out of reach


@BOTH
def test_nearest_point(form):
    random = np.random.default_rng(2)
    points = random.uniform(-1, 1, (100, 3))
    for place in random.uniform(-1, 1, (50, 3)):
        row, distance = kernel(nearest_point, form)(by_axis(points), 100, *place, 0.3)
        expected, i = cKDTree(points).query(place)
        if expected < 0.3:
            assert (row, distance) == (i, pytest.approx(expected))
        else:
            assert row == -1


@BOTH
def test_free_path_ends_at_the_first_touch(form):
    path = kernel(free_path, form)
    obstacle = by_axis([[3.0, 0.6, 0.0]])
    # Touching at distance 1, passing 0.6 aside: 0.8 before it.
    assert path(obstacle, 1, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 9.0) == pytest.approx(3 - 0.8)
    assert path(obstacle, 1, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 9.0) == 9  # behind
    assert path(obstacle, 1, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 9.0) == 9  # aside
    assert path(obstacle, 0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 9.0) == 9  # nothing found
    assert path(obstacle, 1, 2.0, 0.6, 0.0, 0.0, 0.0, 1.0, 1.0, 9.0) == 9  # along it, touching


def by_axis(points) -> np.ndarray:
    """Return points (N, 3) as kernels of what is nearby take them, (3, N)."""
    return np.ascontiguousarray(np.transpose(points))


def contact_height(points: np.ndarray, x: float, y: float, touch: float, start: float) -> float:
    """Return where a fall ends, by trying every point."""
    aside = np.hypot(points[:, 0] - x, points[:, 1] - y)
    near = aside < GRAZE_POINT * touch
    return max(start, *(points[near, 2] + np.sqrt(touch**2 - aside[near] ** 2)), start)


@BOTH
def test_fall_ends_on_the_highest_contact(form):
    random = np.random.default_rng(3)
    for _ in range(50):
        points = random.uniform([-1, -1, 0], [1, 1, 1], (12, 3))
        fall_on = kernel(fall_on_nearby, form)
        height, clear = fall_on(by_axis(points), 12, 0.0, 0.0, 5.0, 0.5, GRAZE_POINT, TIGHT_POINT, 0.1)
        assert clear and height == pytest.approx(contact_height(points, 0, 0, 0.5, 0.1))


@BOTH
def test_fall_that_begins_inside_is_not_clear(form):
    point = by_axis([[0.1, 0.0, 1.0]])
    inside = 1 + 0.5 * np.sqrt(TIGHT_POINT**2 - 0.2**2) - 0.01
    assert not kernel(fall_on_nearby, form)(point, 1, 0.0, 0.0, inside, 0.5, GRAZE_POINT, TIGHT_POINT, 0.1)[1]
    assert kernel(fall_on_nearby, form)(point, 1, 0.0, 0.0, inside + 0.02, 0.5, GRAZE_POINT, TIGHT_POINT, 0.1)[1]


@pytest.mark.slow
def test_fall_through_the_grids_is_the_fall_past_every_point_and_sphere():
    random = np.random.default_rng(4)
    radius = 0.03
    cloud = random.uniform([-0.4, -0.3, 0], [0.4, 0.3, 0.5], (300, 3))
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    points = point_grid(cloud, low, high, radius)
    spheres = sphere_grid(points, low, high, radius, 4 * radius, 64)
    centers = random.uniform([-0.4, -0.3, 0.1], [0.4, 0.3, 0.7], (40, 3))
    enter(spheres, centers)
    for x, y in random.uniform([-0.45, -0.35], [0.45, 0.35], (300, 2)):
        height, clear = fall(points, spheres, x, y, 1.0, radius)
        aside = np.hypot(centers[:, 0] - x, centers[:, 1] - y)
        if np.any(abs(aside / (2 * radius) - 0.9975) < 0.0026):
            continue  # grazes a sphere: whether it stops is a matter of the grazing limit, not of the grid
        on_spheres = centers[aside < 2 * radius]
        on_spheres = on_spheres[:, 2] + np.sqrt(4 * radius**2 - aside[aside < 2 * radius] ** 2)
        expected = max([contact_height(cloud, x, y, radius, radius), *on_spheres])
        assert clear and height == pytest.approx(expected)


@pytest.mark.parametrize("reach", [4.0, None], ids=["it is known where points are", "it is not"])
def test_fall_past_what_is_nearby_is_the_fall_through_the_grids(reach):
    """To the last bit, however long: a fall that the surroundings do not decide is looked up."""
    random, radius = np.random.default_rng(6), 0.03
    cloud = random.uniform([-0.3, -0.3, 0], [0.3, 0.3, 0.2], (400, 3))
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    points = point_grid(cloud, low, high, radius)
    spheres = sphere_grid(points, low, high, radius, reach and reach * radius, 512)
    enter(spheres, random.uniform([-0.3, -0.3, 0.1], [0.3, 0.3, 0.5], (400, 3)))
    nearby = empty_neighborhood(len(cloud))
    decided = []
    for x, y, z in random.uniform([-0.3, -0.3, 0.1], [0.3, 0.3, 0.7], (600, 3)):
        fill_neighbourhood(points, spheres, nearby, x, y, z, radius)
        x, y, z = np.array([x, y, z]) + 0.6 * radius * unit_vectors(random, 1)[0]
        height, clear = fall_nearby(points, spheres, nearby, x, y, z, radius)
        expected, expected_clear = fall(points, spheres, x, y, z, radius)
        assert clear == expected_clear and (height == expected or not clear)
        decided += [covers_fall(nearby, x, y, z, height, radius)] if clear and z - height > DEPTH * radius else []
    assert 0.1 < np.mean(decided) < 0.9 and len(decided) > 30  # both ways are taken


def test_neighbour_distances_through_the_grid():
    cloud = np.random.default_rng(5).uniform(0, 0.2, (2000, 3))
    points = point_grid(cloud, cloud.min(axis=0), cloud.max(axis=0), 0.02)
    ordered = points.xyz
    truth = cKDTree(ordered).query(ordered, k=2)[0][:, 1]
    nearest = np.empty(2000)
    find_nearest(points, np.arange(2000), nearest)
    assert np.allclose(nearest, np.minimum(truth, points.cell))  # farther than a cell's side is not looked


@pytest.mark.parametrize("radius", [0.004, 0.05])  # few points to a cell, and hundreds
def test_a_grid_does_not_depend_on_the_order_of_points(radius):
    random = np.random.default_rng(6)
    cloud = random.uniform(0, 0.2, (3000, 3))
    cloud = np.concatenate([cloud, cloud[:50]])  # some at the same place
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    grid, mixed = (point_grid(points, low, high, radius) for points in (cloud, random.permutation(cloud)))
    assert np.array_equal(grid.xyz, mixed.xyz) and np.array_equal(grid.start, mixed.start)
    cells = np.floor((cloud[:, :2] - low[:2]) * grid.per_metre).astype(int)
    columns = np.bincount(cells[:, 0] * grid.ny + cells[:, 1], minlength=grid.nx * grid.ny)
    assert np.array_equal(np.diff(grid.start[:: grid.nz].astype(int)), columns)
