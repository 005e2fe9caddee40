"""A cloud turned: its points and its surface go together, and both stand on the ground."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import mug

from spherefunc_bullet.clouds.cloud import Cloud, Mesh
from spherefunc_bullet.clouds.preparation import rotated_cloud

UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0])
ASIDE = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])


@pytest.mark.parametrize("rotation", [np.eye(3), UPSIDE_DOWN, ASIDE])
def test_points_and_surface_are_turned_alike(rotation):
    points = mug().points
    surface = Mesh(points[:90] * [1.5, 1, 1], np.arange(90).reshape(-1, 3))
    turned, alone = rotated_cloud(Cloud(points, "it", surface), rotation), rotated_cloud(Cloud(points, "it"), rotation)
    assert alone.mesh is None and np.array_equal(alone.points, turned.points)
    assert turned.bounds[0, 2] == pytest.approx(0) and turned.bounds[:, :2].sum(axis=0) == pytest.approx([0, 0])
    moved = turned.points - points @ rotation.T  # all by the same way
    assert np.ptp(moved, axis=0) == pytest.approx([0, 0, 0])
    assert np.allclose(turned.mesh.vertices, surface.vertices @ rotation.T + moved[0])
    assert np.array_equal(turned.mesh.faces, surface.faces)
