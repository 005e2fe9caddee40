"""How deep spheres lie inside the true surface."""

from __future__ import annotations

import numpy as np
import pytest

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.compare.bench.peers import mesh_distances
from spherefunc_bullet.scenes.household.parts.solids import box
from spherefunc_bullet.simulator import DropSettings, make_simulator

RADIUS = 0.005


@pytest.mark.parametrize("backend", ["fast", "bullet"])
@pytest.mark.parametrize("drops", [None, 200])
@pytest.mark.parametrize("thickness", [0.001, 0.002, 0.02])
@pytest.mark.slow
def test_a_sphere_touches_a_board_however_thin_it_is(tmp_path, backend, drops, thickness):
    if backend == "bullet":
        pytest.importorskip("pybullet")
    box(0.2, 0.2, thickness).export(tmp_path / "plate.ply")
    cloud = load_cloud(tmp_path / "plate.ply")
    few = {} if drops is None else {"max_drops": drops, "miss_limit": drops}
    simulator = make_simulator(backend, **({"shape": "voxel"} if backend == "bullet" else {}))
    result = simulator.drop(cloud, DropSettings(radius=RADIUS, max_spheres=300, **few), 0)
    depths = 1 - mesh_distances(cloud.mesh, result.centers[result.on_object]) / RADIUS
    # To the far side of a thin board it would sink by up to 0.4 radii. With `fast` it meets points only, and sinks
    # between those of the lattice, from whose 4 mm a place is at most 2.31 mm away.
    lattice = 1 - np.sqrt(1 - (0.0023 / RADIUS) ** 2)
    limit = 1.05 * lattice if backend == "fast" else 0.02
    assert len(depths) >= 139 and np.quantile(depths, 0.95) < limit
    assert np.median(depths) < 0.005  # what lies beside no other is lifted to touch the board
