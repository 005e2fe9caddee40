"""How deep spheres lie inside the true surface, as the bench measures it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from spherefunc_bullet.compare.bench import depth
from spherefunc_bullet.compare.bench.depth import Variant
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


def test_a_sphere_sinks_between_samples_as_far_as_their_lattice_lets_it(tmp_path):
    path, r = saved(tmp_path, plate=(0.2, 0.2, 0.02)) / "plate.ply", 0.005
    sparse = depth.settled_depths(path, "fast", Variant(title=""), r)
    fine = depth.settled_depths(path, "fast", Variant(title="", fine=True), r)
    # In a triangular lattice of 4 mm a place is at most 2.31 mm from the nearest point; at an edge a little farther.
    lattice = 1 - np.sqrt(1 - (0.0023 / r) ** 2)
    assert 0.5 * lattice < np.quantile(sparse, 0.9) < 1.1 * lattice
    assert fine.max() < 0.05 and np.median(fine) < np.median(sparse) / 4


def test_every_way_and_radius_has_its_row(tmp_path, capsys):
    data = saved(tmp_path, plate=(0.15, 0.15, 0.02), apple=(0.1, 0.1, 0.1))
    depth.main(str(data), "fast", "1cm,30cm", "plate,tray", 2)
    printed = capsys.readouterr().out
    assert "How deep spheres lie in 1 meshes" in printed
    for way in depth.WAYS["fast"]:
        title = re.escape(way.title)
        assert re.search(rf"^{title} +1 cm +\d+ +0\.\d+ +0\.\d+ +0\.\d+ +[01]\.\d+$", printed, re.MULTILINE)
        assert re.search(rf"^{title} +30 cm +0 ", printed, re.MULTILINE)  # larger than the plate


def test_data_without_a_mesh_of_these_kinds_is_refused(tmp_path):
    with pytest.raises(InputError, match="expected meshes of one of the categories cup, got none"):
        depth.main(str(saved(tmp_path, plate=(0.15, 0.15, 0.02))), "fast", "1cm", "cup", 2)
