"""The coverage that sampling promises, and its regularity."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from spherefunc_bullet.clouds import thinning
from spherefunc_bullet.clouds.cloud import corners_of
from spherefunc_bullet.clouds.sampling import sample_surface
from spherefunc_bullet.clouds.thinning import one_per_cell, thin

MAX_GAP = 0.005
ROUNDING = 1e-9  # metres: coordinates of a few metres in float64, with room to spare


def random_locations(vertices, faces, count, rng):
    """Return points spread evenly over each triangle, its corners included."""
    weights = rng.dirichlet(np.ones(3), size=(len(faces), count))
    inner = np.einsum("fcw,fwx->fcx", weights, vertices[faces]).reshape(-1, 3)
    return np.concatenate([inner, vertices[np.unique(faces)]])


def largest_gap(vertices, faces, rng, count=400):
    locations = random_locations(vertices, faces, count, rng)
    distances, _ = cKDTree(sample_surface(vertices, faces)).query(locations)
    return distances.max()


def plate(width, depth, height=0.0):
    vertices = np.array([[0, 0, height], [width, 0, height], [width, depth, height], [0, depth, height]])
    return vertices, np.array([[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize("scale", [0.001, 0.01, 0.1, 0.5])
@pytest.mark.slow
def test_no_location_is_farther_than_the_gap_on_random_triangles(scale):
    rng = np.random.default_rng(1)
    for _ in range(20):
        vertices = rng.normal(scale=scale, size=(12, 3)) + rng.normal(size=3)
        faces = rng.permuted(np.tile(np.arange(12), (6, 1)), axis=1)[:, :3]
        assert largest_gap(vertices, faces, rng) <= MAX_GAP + ROUNDING


@pytest.mark.parametrize("width", [0.0, 1e-9, 4e-5, 5e-5, 0.001, 0.004])
def test_slivers_are_covered_and_get_one_or_two_rows(width):
    rng = np.random.default_rng(2)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    vertices = np.array([[0, 0, 0], [2.0, 0, 0], [0.7, width, 0]]) @ turn
    faces = np.array([[0, 1, 2]])
    assert largest_gap(vertices, faces, rng, count=20_000) <= MAX_GAP + ROUNDING
    assert len(sample_surface(vertices, faces)) <= 2.5 * 2.0 / 0.004


def test_a_mesh_of_tiny_faces_comes_out_thinned():
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=5, radius=0.05)  # 20,480 faces of 1.5 mm
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces)
    points = sample_surface(vertices, faces)
    assert len(points) < 6_000  # its 314 cm² hold 2,270 points of the regular lattice
    assert cKDTree(points).query(points, k=2)[0][:, 1].min() >= 0.54 * MAX_GAP - ROUNDING
    assert largest_gap(vertices, faces, np.random.default_rng(3), count=5) <= MAX_GAP + ROUNDING


@pytest.mark.parametrize("cells", [1, 7, 300])
def test_a_flat_panel_is_regular_however_it_is_cut(cells):
    steps = np.linspace(0.0, 0.6, cells + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(steps, steps))
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    right, up = corner + 1, corner + cells + 1
    faces = np.concatenate([np.column_stack([corner, right, up]), np.column_stack([right, up + 1, up])])
    points = sample_surface(np.column_stack([x, y, np.full(len(x), 0.43)]), faces)
    pitch = np.sqrt(3) * 0.46 * MAX_GAP
    inner = points[(np.abs(points[:, :2] - 0.3) < 0.29).all(axis=1)]
    neighbours = cKDTree(points).query(inner, k=7)[0][:, 1:]
    assert np.median(neighbours) == pytest.approx(pitch, rel=1e-6)
    assert (np.abs(neighbours - pitch) < 1e-6).mean() > 0.99
    assert (points[:, 2] == 0.43).all()  # on an axis-parallel plane exactly


def test_points_of_a_tilted_plane_lie_on_it():
    rng = np.random.default_rng(4)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    vertices, faces = plate(0.8, 0.3, 0.2)
    heights = (sample_surface(vertices @ turn, faces) @ turn.T)[:, 2]
    assert np.abs(heights - 0.2).max() < 1e-15 * 10  # ten roundings of numbers near one


def test_the_outline_keeps_corners_and_rims():
    import trimesh

    box = trimesh.creation.box((0.1, 0.2, 0.3))
    points = sample_surface(np.array(box.vertices), np.array(box.faces))
    assert cKDTree(points).query(box.vertices)[0].max() == 0
    rim = points[(np.abs(points[:, 0]) == 0.05) & (points[:, 2] == 0.15)]
    assert np.diff(np.sort(rim[:, 1])).max() <= 0.004


def test_density_of_a_panel_is_that_of_the_lattice():
    points = sample_surface(*plate(1.0, 1.0))
    cell = np.sqrt(3) / 2 * (np.sqrt(3) * 0.46 * MAX_GAP) ** 2
    assert len(points) == pytest.approx(1.0 / cell, rel=0.03)  # the border adds a row or two of 250


def test_a_row_of_which_rounding_leaves_nothing_is_skipped():
    vertices = np.array([[8.729, -52.152, 5], [13.963, -50.6, 5], [10.617, -50.799, 5]]) / 1000  # of a real mesh
    assert largest_gap(vertices, np.array([[0, 1, 2]]), np.random.default_rng(7)) <= MAX_GAP + ROUNDING


def test_repeated_vertices_doubled_sheets_and_winding_change_nothing():
    vertices, faces = plate(0.3, 0.2)
    points = sample_surface(vertices, faces)
    loose = sample_surface(vertices[faces].reshape(-1, 3), np.arange(6).reshape(2, 3))
    doubled = sample_surface(vertices, np.concatenate([faces, faces[:, ::-1]]))
    for other in (loose, doubled):
        assert len(other) == len(points)
        # the order of a triangle's corners decides the last bit only
        assert np.allclose(np.sort(other, axis=0), np.sort(points, axis=0), atol=1e-12)


@pytest.mark.parametrize("thickness", [0.0006, 0.001, 0.0025])
def test_both_sides_of_a_thin_board_are_covered_by_samples_of_their_own(thickness):
    import trimesh

    board = trimesh.creation.box((0.2, 0.2, thickness))
    points = sample_surface(np.array(board.vertices), np.array(board.faces))
    places = np.random.default_rng(7).uniform(-0.1, 0.1, size=(500, 2))
    for side in (-thickness / 2, thickness / 2):
        own = points[np.abs(points[:, 2] - side) < 1e-9]
        assert cKDTree(own[:, :2]).query(places)[0].max() <= MAX_GAP + ROUNDING


def test_the_same_mesh_gives_the_same_points():
    rng = np.random.default_rng(5)
    vertices, faces = rng.normal(scale=0.1, size=(30, 3)), rng.integers(0, 30, size=(40, 3))
    assert np.array_equal(sample_surface(vertices, faces), sample_surface(vertices.copy(), faces.copy()))


def test_thinning_is_greedy_in_order():
    points = np.random.default_rng(6).uniform(0, 0.05, size=(600, 3))
    kept = []
    for point in points:
        if all(np.linalg.norm(point - other) >= 0.004 for other in kept):
            kept.append(point)
    assert np.array_equal(thin(points, 0.004), np.array(kept))


def test_thinning_takes_scattered_points():
    points = 0.0216 * np.stack(np.meshgrid(*[np.arange(30.0)] * 3), axis=-1).reshape(-1, 3)
    assert len(thin(points, 0.0027)) == len(points)


@pytest.fixture(params=["bricks", "table"])
def way(request, monkeypatch):
    """Thin by either way of finding what is near: a grid in bricks, or a table, for sparse clouds."""
    if request.param == "table":
        monkeypatch.setattr(thinning, "MAX_CELLS", 0)


def scattered(count, size):
    """Return points on both sides of the origin, each of some of them twice, (N, 3), metres."""
    points = np.random.default_rng(7).uniform(-size, size, size=(count, 3))
    return np.concatenate([points, points[::5], points[::7] + [1e-4, 0, 0]])


@pytest.mark.slow
def test_points_that_come_backwards_are_thinned_last(way):
    points = scattered(500, 0.03)
    expected = thin(points, 0.004)
    kept = []
    for point in points:
        if all(np.linalg.norm(point - other) >= 0.004 for other in kept):
            kept.append(point)
    assert np.array_equal(expected, np.array(kept))
    assert np.array_equal(thin(points[:200], 0.004, points[200:][::-1]), expected)


def test_the_highest_point_of_each_cells_first_column_stays(way):
    points = scattered(3000, 0.04)
    cells = np.floor(points / 0.01)
    columns = np.floor(points[:, :2] / 0.005)
    order = np.lexsort([points[:, 1], points[:, 0], -points[:, 2], columns[:, 1], columns[:, 0], *cells.T])
    first = np.append(True, (np.diff(cells[order], axis=0) != 0).any(axis=1))
    found = one_per_cell(points, 0.01, corners_of(points))
    assert np.array_equal(found[np.lexsort([*np.floor(found / 0.01).T])], points[order][first])


@pytest.mark.parametrize("count", [1, 63, 64, 65, 1000])
def test_corners_hold_all_points(count):
    points = np.random.default_rng(count).normal(size=(count, 3))
    assert np.array_equal(corners_of(points), [points.min(axis=0), points.max(axis=0)])
