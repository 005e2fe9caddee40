"""How deep spheres lie inside the true surface, as the bench measures it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from spherefunc_bullet.compare.bench import piles
from spherefunc_bullet.compare.bench.piles import Variant
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.household.parts.solids import box


def saved(folder: Path, **sizes: tuple[float, float, float]) -> Path:
    """Write boxes of these sizes in metres as a data set whose categories are their names."""
    rows = ["file,label,category"]
    for name, size in sizes.items():
        box(*size).export(folder / f"{name}.ply")
        rows.append(f"{name}.ply,none,{name}")
    (folder / "manifest.csv").write_text("\n".join(rows))
    return folder


@pytest.mark.parametrize("backend", ["fast", "bullet"])
@pytest.mark.parametrize("drops", [None, 200])
@pytest.mark.parametrize("thickness", [0.001, 0.002, 0.02])
def test_a_sphere_touches_a_board_however_thin_it_is(tmp_path, backend, drops, thickness):
    if backend == "bullet":
        pytest.importorskip("pybullet")
    path = saved(tmp_path, plate=(0.2, 0.2, thickness)) / "plate.ply"
    way = Variant(title="", shape="voxel" if backend == "bullet" else None, drops=drops)
    depths = piles.settled_depths(path, backend, way, 0.005)
    # To the far side of a thin board it would sink by up to 0.4 radii. With `fast` it meets points only, and sinks
    # between those of the lattice, from whose 4 mm a place is at most 2.31 mm away.
    lattice = 1 - np.sqrt(1 - (0.0023 / 0.005) ** 2)
    limit = 1.05 * lattice if backend == "fast" else 0.02
    assert len(depths) >= 139 and np.quantile(depths, 0.95) < limit
    assert np.median(depths) < 0.005  # what lies beside no other is lifted to touch the board


def test_every_way_and_radius_has_its_row(tmp_path, capsys):
    data = saved(tmp_path, plate=(0.15, 0.15, 0.02), apple=(0.1, 0.1, 0.1))
    piles.measure_depths(str(data), "fast", "1cm,30cm", "plate,tray", 2)
    printed = capsys.readouterr().out
    assert "How deep spheres lie in 1 meshes" in printed
    for way in piles.WAYS["fast"]:
        title = re.escape(way.title)
        assert re.search(rf"^{title} +1 cm +\d+ +0\.\d+ +0\.\d+ +0\.\d+ +[01]\.\d+$", printed, re.MULTILINE)
        assert re.search(rf"^{title} +30 cm +0 ", printed, re.MULTILINE)  # larger than the plate


def test_data_without_a_mesh_of_these_kinds_is_refused(tmp_path):
    with pytest.raises(InputError, match="expected meshes of one of the categories cup, got none"):
        piles.measure_depths(str(saved(tmp_path, plate=(0.15, 0.15, 0.02))), "fast", "1cm", "cup", 2)
