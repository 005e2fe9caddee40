"""Segmentation of a room whose objects are known."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import level, post, sheet
from room_shapes import NAMES, box, moved, room, room_parts, square_table

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.scans.cells import cells
from spherefunc_bullet.scenes.segmentation.clusters import euclidean_clusters
from spherefunc_bullet.scenes.segmentation.segmentation import FLOOR, LEFT_OVER, WALL, Segmentation, segment
from spherefunc_bullet.scenes.segmentation.supports import tops


def overlaps(labels: np.ndarray, truth: np.ndarray, count: int) -> list[float]:
    """Return the intersection over union of each true object with what was found of it best."""
    out = []
    for number in range(count):
        own = truth == number
        shared = [(own & (labels == k)).sum() / (own | (labels == k)).sum() for k in range(labels.max() + 1)]
        out.append(max(shared, default=0.0))
    return out


@pytest.fixture(scope="module")
def segmented() -> tuple[np.ndarray, np.ndarray]:
    points, truth = room()
    return segment(points), truth


@pytest.mark.parametrize("number", range(len(NAMES)), ids=NAMES)
def test_objects_are_found(segmented, number):
    labels, truth = segmented
    # Legs and mug lose the 2 cm that count as floor, or as table top.
    assert overlaps(labels, truth, len(NAMES))[number] > 0.6


def test_nothing_else_is_found(segmented):
    labels, _ = segmented
    assert labels.max() + 1 == len(NAMES)


def test_floor_and_walls_are_named(segmented):
    labels, truth = segmented
    assert (labels[truth == -1] == FLOOR).mean() > 0.95  # where the walls meet it, it may be theirs
    assert (labels[truth == -2] == WALL).mean() > 0.95


def test_the_order_of_points_does_not_matter():
    points, _ = room()
    order = np.random.default_rng(1).permutation(len(points))
    assert np.array_equal(segment(points[order]), segment(points)[order])


def test_a_mug_stays_with_the_table_unless_parted():
    points, truth = room(walls=False)
    above = points[:, 2] > 0.03
    clusters = euclidean_clusters(points[above], Segmentation.cluster_tolerance)  # by distance alone
    assert clusters.max() + 1 == len(NAMES) - 1
    assert len(np.unique(clusters[(truth[above] == 0) & (points[above, 2] > 0.1)])) == 1
    assert segment(points).max() + 1 == len(NAMES)


def test_the_back_of_a_chair_stays_with_its_seat():
    chair = np.vstack([square_table(0.44, 0.44, 0.45), sheet([-0.22, 0.22, 0.45], [0.44, 0, 0], [0, 0, 0.45])])
    labels = segment(np.vstack([chair, level(2.0, 2.0, 0.0)]))
    assert labels.max() == 0


def test_a_chair_pushed_against_a_table_is_parted_from_it():
    back = sheet([-0.2, 0.61, 0.0], [0.4, 0, 0], [0, 0, 0.95])
    table = square_table(1.6, 1.2, 0.72)
    points = np.vstack([table, back, level(4.0, 4.0, 0.0)[::3]])
    labels = segment(points)
    truth = np.repeat([0, 1, -1], [len(table), len(back), len(points) - len(table) - len(back)])
    assert min(overlaps(labels, truth, 2)) > 0.8


def test_both_sides_of_a_cup_are_one_object():
    angles = np.linspace(0, 2 * np.pi, 300)
    arcs = angles[(np.abs(np.sin(angles)) > 0.3)]
    wall = np.vstack([np.column_stack([0.08 * np.cos(arcs), 0.08 * np.sin(arcs), np.full(arcs.size, z)])
                      for z in np.arange(0.0, 0.09, 0.004)])  # fmt: skip
    table = level(0.8, 0.6, 0.0)
    seen = table[np.hypot(table[:, 0], table[:, 1]) > 0.09]  # nobody sees the table within the cup
    labels = segment(np.vstack([wall, seen]), Segmentation(min_cluster_size=10), noise=0.001)
    assert labels.max() == 0
    assert segment(np.vstack([wall, table]), Segmentation(min_cluster_size=10), noise=0.001).max() == 1


@pytest.mark.parametrize(("height", "expected"), [(0.3, 2), (1.0, 1)])
def test_a_gap_parts_small_things_and_tears_no_large_one(height, expected):
    halves = [sheet([0, y, 0], [0, 0.2, 0], [0, 0, height]) for y in (0.0, 0.235)]
    labels = segment(np.vstack([*halves, level(1.5, 1.5, 0.0)]))
    assert labels.max() + 1 == expected
    narrow = segment(np.vstack([*halves, level(1.5, 1.5, 0.0)]), Segmentation(large_tolerance=0.01))
    assert narrow.max() + 1 == 2


def test_a_leg_that_stands_alone_is_its_tables():
    top = moved(box(0.9, 0.6, 0.1), 0, 0, 0.62)
    near, far = post(-0.35, 0.2, 0.62), post(0.35, 0.2, 0.45)
    points = np.vstack([top, near, far, level(3.0, 3.0, 0.0)[::4]])
    labels = segment(points)
    above = points[:, 2] > 0.03
    assert set(labels[above]) - {LEFT_OVER} == {0}
    assert euclidean_clusters(points[above], Segmentation.cluster_tolerance).max() > 0  # by distance alone


def test_a_bin_under_a_table_is_no_part_of_it():
    table, bin_ = square_table(1.2, 0.8, 0.72), box(0.25, 0.25, 0.3)
    labels = segment(np.vstack([table, bin_, level(3.0, 3.0, 0.0)[::4]]))
    truth = np.repeat([0, 1, -1], [len(table), len(bin_), len(labels) - len(table) - len(bin_)])
    assert min(overlaps(labels, truth, 2)) > 0.8


def test_what_scatters_over_a_table_makes_it_no_higher():
    table = square_table(1.2, 0.8, 0.72)
    stray = np.random.default_rng(0).uniform([-0.5, -0.3, 0.76], [0.5, 0.3, 0.95], (300, 3))
    points = np.vstack([table, stray, level(3.0, 3.0, 0.0)[::4]])
    labels = segment(points)
    assert points[labels == 0, 2].max() < 0.76


def test_two_tables_of_one_height_have_two_tops():
    tables = [moved(square_table(0.8, 0.6, 0.72), x, 0.0) for x in (-0.5, 0.5)]
    boards = tops(cells(np.vstack(tables), 0.01).means)
    assert sorted(round(float(top.box.center[0]), 1) for top in boards) == [-0.5, 0.5]
    assert all(np.allclose(top.box.size[:2], [0.8, 0.6], atol=0.03) for top in boards)


def test_what_crosses_a_top_is_no_part_of_it():
    table, back = level(1.2, 0.8, 0.72), moved(box(0.4, 0.12, 0.5), 0.0, 0.46, 0.45)
    (top,) = tops(cells(np.vstack([table, back]), 0.01).means)
    assert top.box.size[1] == pytest.approx(0.8, abs=0.06)
    assert top.outside(np.array([[0.0, 0.5, 0.72]]))[0] > 0.05


def test_a_glass_on_a_stem_is_one():
    def ring(radius: float, low: float, high: float) -> np.ndarray:
        angles, heights = np.meshgrid(np.linspace(0, 2 * np.pi, 120), np.arange(low, high, 0.004))
        return np.column_stack([radius * np.cos(angles.ravel()), radius * np.sin(angles.ravel()), heights.ravel()])

    disk = level(0.08, 0.08, 0.004)
    foot = disk[np.hypot(disk[:, 0], disk[:, 1]) < 0.035]
    bowl = [moved(foot, 0, 0, 0.076), ring(0.035, 0.08, 0.15)]
    glass = moved(np.vstack([foot, ring(0.006, 0.004, 0.08), *bowl]), 0.1, 0.05, 0.72)
    table = square_table(1.2, 0.8, 0.72)
    points = np.vstack([table, glass, level(3.0, 3.0, 0.0)[::4]])
    labels = segment(points)
    upper = labels[len(table) : len(table) + len(glass)][glass[:, 2] > 0.76]
    assert len(set(upper)) == 1 and upper[0] not in (labels[0], LEFT_OVER)


def test_clusters_are_those_of_a_tree():
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    points = np.random.default_rng(2).uniform(0, 0.5, (3000, 3))
    pairs = cKDTree(points).query_pairs(0.025, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(points),) * 2)
    expected = connected_components(graph, directed=False)[1]
    clusters = euclidean_clusters(points, 0.025)
    assert clusters.max() + 1 > 100  # neither all nor nothing is connected
    pairs = np.unique(np.stack([clusters, expected]), axis=1).T
    assert len(np.unique(clusters)) == len(np.unique(expected)) == len(pairs)


def test_the_tolerance_follows_the_steps_of_a_camera():
    slices = np.vstack([moved(sheet([0, 0, 0], [0.2, 0, 0], [0, 0, 0.2]), 0, y) for y in (0.0, 0.035, 0.07)])
    assert euclidean_clusters(slices, 0.02).max() == 2
    assert euclidean_clusters(slices, 0.02, np.full(len(slices), 3.5)).max() == 0


def test_sizes_are_kept_to():
    points, _ = room(walls=False)
    largest = [np.unique(np.floor(part / 0.01), axis=0).shape[0] for part in room_parts()]
    labels = segment(points, Segmentation(min_cluster_size=max(largest) // 2))
    assert labels.max() + 1 < len(NAMES)
    assert (labels == LEFT_OVER).any()
    assert segment(points, Segmentation(max_cluster_size=100, min_cluster_size=60)).max() < len(NAMES) - 1


def test_an_empty_room_has_no_objects():
    points = np.vstack([level(4, 3, 0.0)[::4], sheet([-2, 1.5, 0], [4, 0, 0], [0, 0, 2.2])[::4]])
    assert segment(points).max() < 0


@pytest.mark.parametrize(
    "wrong", [{"leaf_size": 0}, {"cluster_tolerance": -1}, {"min_cluster_size": 0}, {"max_cluster_size": 3}]
)
def test_impossible_settings_are_refused(wrong):
    with pytest.raises(InputError):
        Segmentation(**wrong)


def test_a_box_has_one_top_and_keeps_it():
    points = np.vstack([box(0.6, 0.4, 0.7), level(2.0, 2.0, 0.0)])
    assert segment(points).max() == 0
