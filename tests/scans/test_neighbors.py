"""Points sorted into cells and looked for nearby, against what numpy and SciPy say."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull, cKDTree

from spherefunc_bullet.clouds.outline import hull_corners
from spherefunc_bullet.learning.profiles.columns import outline_of, well_within
from spherefunc_bullet.scenes.scans.cells import cells
from spherefunc_bullet.scenes.scans.neighbors import NEIGHBORS, NearPoints, crowded, nearest_others
from spherefunc_bullet.scenes.segmentation.clusters import euclidean_clusters, members_of


def scattered(count: int, seed: int = 0, thick: float = 0.02) -> np.ndarray:
    """Points (N, 3) of a slab around the origin, metres."""
    return np.random.default_rng(seed).uniform(-1, 1, (count, 3)) * [0.5, 0.5, thick]


@pytest.mark.parametrize("count", [0, 1, 2, 700, 20_000])
@pytest.mark.parametrize("side", [0.004, 0.05, 3.0])
def test_cells_are_those_of_numpy(count: int, side: float):
    points = scattered(count)
    found = cells(points, side)
    places, cell_of, counts = np.unique(
        np.floor(points / side).astype(int), axis=0, return_inverse=True, return_counts=True
    )
    assert np.array_equal(found.indices, places)
    assert np.array_equal(found.cell_of, cell_of.ravel()) and np.array_equal(found.counts, counts)
    assert np.array_equal(found.order, np.argsort(cell_of.ravel(), kind="stable"))


def test_points_far_apart_share_no_cell():
    # In cells of 1 mm over 2 km a cell and a point of it do not fit into one number.
    points = np.array([[-1000.0, 0, 0], [1000, 0, 0], [0, 1000, -1000], [0, 1000, 1000], [-1000, 0, 0]])
    found = cells(points, 0.001)
    assert found.counts.tolist() == [2, 1, 1, 1] and found.cell_of.tolist() == [0, 3, 1, 2, 0]
    assert found.order.tolist() == [0, 4, 2, 3, 1]


@pytest.mark.parametrize(("count", "others"), [(0, 5), (5, 0), (3_000, 2_000)])
def test_near_is_what_a_tree_finds(count: int, others: int):
    places, points = scattered(count, 1), scattered(others, 2)
    distances = cKDTree(points).query(places, distance_upper_bound=0.02)[0]
    assert np.array_equal(NearPoints(points, 0.02).to(places), np.isfinite(distances))


def test_crowded_is_what_a_tree_counts():
    points = scattered(4_000)
    counts = cKDTree(points).query_ball_point(points, 0.03, return_length=True) - 1
    assert 0.1 < np.mean(counts >= NEIGHBORS) < 0.9
    assert np.array_equal(crowded(points, 0.03), counts >= NEIGHBORS)


def test_nearest_others_are_those_of_a_tree():
    points, asked = scattered(4_000, thick=0.1), np.arange(0, 4_000, 3)
    expected = cKDTree(points).query(points[asked], k=NEIGHBORS + 1, distance_upper_bound=0.04)[1][:, 1:]
    assert 0 < np.mean(expected == len(points)) < 0.5
    assert np.array_equal(nearest_others(points, asked, 0.04), expected)


def test_members_of_labels_are_listed_in_order():
    labels = np.array([1, -3, 0, 1, -1, 3])
    assert [rows.tolist() for rows in members_of(labels)] == [[2], [0, 3], [], [5]]
    assert [len(rows) for rows in members_of(labels, 6)] == [1, 2, 0, 1, 0, 0] and members_of(labels[:0]) == []


def test_clusters_are_the_connected_components():
    from scipy.sparse.csgraph import connected_components

    points = scattered(3_000)
    near = cKDTree(points).sparse_distance_matrix(cKDTree(points), 0.02)
    count, component = connected_components(near, directed=False)
    found = euclidean_clusters(points, 0.02)
    assert 10 < count == found.max() + 1
    assert len(np.unique(np.column_stack([component, found]), axis=0)) == count


@pytest.mark.parametrize("count", [59, 61, 400])
@pytest.mark.parametrize("step", [1e-9, 0.05])
def test_an_outline_has_the_corners_of_the_hull(count: int, step: float):
    points = np.round(scattered(count)[:, :2] / step) * step
    outline = outline_of(points, 0.01)
    hull = ConvexHull(points)
    assert np.isclose(np.abs(np.linalg.det(outline_triangles(outline.corners))).sum() / 2, hull.volume)
    corners = {tuple(corner) for corner in outline.corners}
    assert {tuple(points[k]) for k in hull.vertices} == corners


@pytest.mark.parametrize("count", [3, 999, 1001])
def test_corners_of_many_hulls_are_qhull_s(count: int):
    for points in (scattered(count)[:, :2], np.round(scattered(count)[:, :2], 2)):
        hull = {tuple(points[k]) for k in ConvexHull(points).vertices}
        assert {tuple(corner) for corner in hull_corners(points)} == hull
    line = np.outer(np.linspace(0, 1, count), [1.0, 2.0])
    assert len(hull_corners(line)) == 2 and len(hull_corners(np.ones((count, 2)))) == 1


def outline_triangles(corners: np.ndarray) -> np.ndarray:
    """The two sides (T, 2, 2) of the triangles that a convex polygon's corners (H, 2) make with its first one."""
    spokes = corners[1:] - corners[0]
    return np.stack([spokes[:-1], spokes[1:]], axis=1)


def test_places_well_within_are_no_corners_of_the_hull():
    places = np.random.default_rng(3).normal(size=(10_000, 2))
    outer = places[~well_within(places)]
    assert len(outer) < 0.5 * len(places)
    assert set(map(tuple, outer[ConvexHull(outer).vertices])) == set(map(tuple, places[ConvexHull(places).vertices]))
    assert not well_within(np.outer(np.linspace(0, 1, 5_000), [1.0, 2.0])).any()
