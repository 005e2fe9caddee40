"""Segmentation of a room whose objects are known."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import level, sheet
from room_shapes import NAMES, box, room, room_parts, square_table

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.segmentation.clusters import euclidean_clusters
from spherefunc_bullet.scenes.segmentation.segmentation import FLOOR, LEFT_OVER, WALL, Segmentation, segment


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


STANDING = NAMES[:-1]  # the mug is one cluster with its table; pools part them (test_pools)


@pytest.mark.parametrize("number", range(len(STANDING)), ids=STANDING)
def test_objects_are_found(segmented, number):
    labels, truth = segmented
    # Legs lose the 2 cm that count as floor.
    assert overlaps(labels, truth, len(NAMES))[number] > 0.6


def test_nothing_else_is_found(segmented):
    labels, _ = segmented
    assert labels.max() + 1 == len(STANDING)


def test_floor_and_walls_are_named(segmented):
    labels, truth = segmented
    assert (labels[truth == -1] == FLOOR).mean() > 0.95  # where the walls meet it, it may be theirs
    assert (labels[truth == -2] == WALL).mean() > 0.95


def test_the_order_of_points_does_not_matter():
    points, _ = room()
    order = np.random.default_rng(1).permutation(len(points))
    assert np.array_equal(segment(points[order]), segment(points)[order])


def test_the_back_of_a_chair_stays_with_its_seat():
    chair = np.vstack([square_table(0.44, 0.44, 0.45), sheet([-0.22, 0.22, 0.45], [0.44, 0, 0], [0, 0, 0.45])])
    labels = segment(np.vstack([chair, level(2.0, 2.0, 0.0)]))
    assert labels.max() == 0


def test_a_bin_under_a_table_is_no_part_of_it():
    table, bin_ = square_table(1.2, 0.8, 0.72), box(0.25, 0.25, 0.3)
    labels = segment(np.vstack([table, bin_, level(3.0, 3.0, 0.0)[::4]]))
    truth = np.repeat([0, 1, -1], [len(table), len(bin_), len(labels) - len(table) - len(bin_)])
    assert min(overlaps(labels, truth, 2)) > 0.8


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
    "wrong",
    [
        {"leaf_size": 0},
        {"leaf_size": "1cm"},
        {"cluster_tolerance": -1},
        {"min_cluster_size": 0},
        {"min_cluster_size": 2.5},
        {"max_cluster_size": 3},
    ],
)
def test_impossible_settings_are_refused(wrong):
    with pytest.raises(InputError):
        Segmentation(**wrong)


def test_a_box_has_one_top_and_keeps_it():
    points = np.vstack([box(0.6, 0.4, 0.7), level(2.0, 2.0, 0.0)])
    assert segment(points).max() == 0
