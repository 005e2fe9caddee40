"""Sparse scans: what is added between neighbours, and that nothing else is."""

from __future__ import annotations

import numpy as np
from clouds import level as sheet_at
from room_shapes import moved, room, square_table

from spherefunc_bullet.scenes.scans.cells import cells
from spherefunc_bullet.scenes.scans.depth_image import filled
from spherefunc_bullet.scenes.segmentation.segmentation import segment

LEAF = 0.01


def sparse(points: np.ndarray, side: float) -> np.ndarray:
    """Return one point in each cube of a side in metres, as fused scans have it."""
    return points[np.unique(cells(points, side).cell_of, return_index=True)[1]]


def test_a_dense_scan_gains_hardly_a_point():
    points = room()[0]
    dense = filled(points, LEAF)
    assert np.array_equal(dense[: len(points)], points) and len(dense) < 1.001 * len(points)


def test_a_sparse_surface_is_filled_and_does_not_grow():
    surface = sheet_at(0.6, 0.4, 0.7)
    points = sparse(surface, 0.03)
    dense = filled(points, LEAF)
    assert np.array_equal(dense[: len(points)], points)
    voxels = len(cells(dense, LEAF).keys)
    assert voxels > 4 * len(points)
    assert (dense.min(axis=0) >= points.min(axis=0) - 1e-9).all()
    assert (dense.max(axis=0) <= points.max(axis=0) + 1e-9).all()


def test_what_stands_apart_stays_apart():
    points = sparse(np.vstack([sheet_at(0.4, 0.4, 0.7), moved(sheet_at(0.4, 0.4, 0.7), 0.55, 0.0)]), 0.025)
    gap = filled(points, LEAF)[:, 0]
    assert not ((gap > 0.21) & (gap < 0.34)).any()


def test_the_order_of_points_does_not_matter():
    points = sparse(square_table(0.8, 0.6, 0.7), 0.03)
    shuffled = points[np.random.default_rng(0).permutation(len(points))]
    one, other = (cells(filled(some, LEAF), 0.005).keys for some in (points, shuffled))
    assert np.array_equal(one, other)


def test_a_sparse_room_falls_into_the_same_furniture():
    points, truth = room()
    kept = np.unique(cells(points, 0.03).cell_of, return_index=True)[1]
    points, truth = points[kept], truth[kept]
    assert segment(points).max() < 0 or not found(segment(points), truth)
    labels = segment(filled(points, LEAF))[: len(points)]
    assert found(labels, truth)


def found(labels: np.ndarray, truth: np.ndarray) -> bool:
    """Return whether table and stool are parts of their own."""
    parts = [np.bincount(labels[(truth == number) & (labels >= 0)], minlength=1) for number in (0, 1)]
    return all(len(part) and part.max() > 0.6 * np.count_nonzero(truth == n) for n, part in enumerate(parts))
