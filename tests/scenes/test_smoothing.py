"""Smoothing takes a sensor's scatter off thin walls and leaves their shape."""

from __future__ import annotations

import numpy as np
import pytest

from spherefunc_bullet.scenes.recognition.completion import smoothed


def noisy_cylinder(radius: float, scatter: float) -> np.ndarray:
    rng = np.random.default_rng(3)
    angles, heights = rng.uniform(0, 2 * np.pi, 12000), rng.uniform(0, 0.12, 12000)
    radii = radius + rng.normal(0, scatter, angles.size)
    return np.column_stack([radii * np.cos(angles), radii * np.sin(angles), heights])


def test_a_cups_wall_becomes_thin_where_it_is():
    before = noisy_cylinder(0.04, 0.004)
    after = smoothed(before)
    inner = np.abs(after[:, 2] - 0.06) < 0.04  # off the rim, where a neighbourhood is one-sided
    radii = np.hypot(after[inner, 0], after[inner, 1])
    assert radii.std() < 0.5 * 0.004
    assert radii.mean() == pytest.approx(0.04, abs=0.002)
    assert np.allclose(after[:, 2].min(), 0, atol=0.01) and np.allclose(after[:, 2].max(), 0.12, atol=0.01)


def test_a_plane_stays_where_it_is():
    x, y = np.meshgrid(np.arange(0, 0.2, 0.004), np.arange(0, 0.2, 0.004))
    plane = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    assert np.abs(smoothed(plane)[:, 2]).max() < 1e-9


def test_the_order_of_points_does_not_matter():
    points = noisy_cylinder(0.04, 0.002)
    order = np.random.default_rng(1).permutation(len(points))
    one, other = (moved[np.lexsort(np.round(moved, 7).T)] for moved in (smoothed(points), smoothed(points[order])))
    assert np.allclose(one, other, atol=1e-7)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_few_points_come_back(count):
    points = np.arange(3.0 * count).reshape(count, 3)
    assert len(smoothed(points)) == count
