"""How points spread in cells, against what numpy says."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from spherefunc_bullet.scenes.pools.tops import fit_plane
from spherefunc_bullet.scenes.scans.spread import cell_moments, spread_of

ROOM = np.random.default_rng(5).uniform(-1, 1, (5_000, 3)) * [0.4, 0.4, 0.03]


def in_pairs(covariances: np.ndarray) -> np.ndarray:
    """Covariances (C, 3, 3) as `CellMoments` has them, (C, 6)."""
    return covariances[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]


def test_moments_are_those_of_each_cell_s_points():
    moments = cell_moments(ROOM, 0.12)
    cell = np.floor(ROOM / 0.12).astype(int)
    for corner, count, mean, covariance in zip(
        moments.corners, moments.counts, moments.means, moments.covariances, strict=True
    ):
        inside = ROOM[(cell == np.rint(corner / 0.12)).all(axis=1)]
        assert len(inside) == count
        assert mean == pytest.approx(inside.mean(axis=0), abs=1e-4)
        assert covariance == pytest.approx(in_pairs(np.cov(inside.T, bias=True)[None])[0], abs=1e-5)


def test_merged_moments_are_those_of_larger_cells():
    merged, large = cell_moments(ROOM, 0.04).merged(0.36), cell_moments(ROOM, 0.36)
    assert np.array_equal(merged.counts, large.counts) and np.allclose(merged.corners, large.corners)
    assert np.allclose(merged.means, large.means, atol=2e-5)
    assert np.allclose(merged.covariances, large.covariances, atol=2e-5)


@pytest.mark.parametrize("deviations", [(0.02, 0.01, 0.001), (1.0, 1e-3, 1e-4), (0.03, 0.03, 0.0)])
def test_the_least_axis_and_the_spread_are_lapack_s(deviations: tuple[float, float, float]):
    turns = Rotation.random(200, random_state=1).as_matrix()
    covariances = turns @ np.diag(np.square(deviations)) @ turns.transpose(0, 2, 1)
    values, axes = spread_of(in_pairs(covariances))
    expected, vectors = np.linalg.eigh(covariances)
    assert np.allclose(values, expected, rtol=0, atol=1e-8 * max(deviations) ** 2)
    assert np.abs((axes * vectors[:, :, 0]).sum(axis=1)) == pytest.approx(1.0, abs=1e-8)


def test_equal_spread_on_all_sides_has_an_axis():
    values, axes = spread_of(np.array([[0.0] * 6, [2.0, 0, 0, 2, 0, 2]]))
    assert np.array_equal(axes, [[0, 0, 1]] * 2) and np.array_equal(values, [[0] * 3, [2] * 3])


def test_a_plane_is_fitted_to_the_points_near_it_in_least_squares():
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(2, 3, (500, 2)), np.zeros(500)])
    points[:, 2] = 0.7 + 0.02 * points[:, 0] - 0.01 * points[:, 1] + rng.normal(0, 0.002, 500)
    far = points + [0, 0, 0.2]
    plane = np.array([0.0, 0.0, 0.73])
    assert fit_plane(np.vstack([points, far]), 0.05, 60, plane)
    rows = np.column_stack([points[:, :2], np.ones(500)])
    assert plane == pytest.approx(np.linalg.lstsq(rows, points[:, 2], rcond=None)[0], abs=1e-9)


def test_points_on_a_line_keep_the_slope_and_few_points_the_plane():
    line, plane = np.column_stack([np.linspace(0, 1, 100), np.zeros(100), np.full(100, 0.71)]), np.array([0, 0, 0.7])
    assert not fit_plane(line, 0.02, 101, plane) and plane.tolist() == [0, 0, 0.7]
    assert fit_plane(line, 0.02, 60, plane) and plane == pytest.approx([0, 0, 0.71])
