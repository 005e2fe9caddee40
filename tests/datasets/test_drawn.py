"""The sets of drawn objects and of `variety`, which `make model` learns besides the catalogue."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from spherefunc_bullet.clouds.orientation import standing_margin
from spherefunc_bullet.datasets.dataset import open_dataset, sources_of
from spherefunc_bullet.formats.sources import read_geometry
from spherefunc_bullet.scenes.impairment.specimen import NONE

SETS = sorted((Path(__file__).parents[2] / "scenes" / "drawn").glob("*.zip"))
EVERY = 15  # of the objects are read


@pytest.mark.parametrize(
    "packed", [pytest.param(one, id=one.stem, marks=[pytest.mark.slow] * (one != SETS[0])) for one in SETS]
)
def test_a_set_has_objects_of_every_function_that_stand(packed, tmp_path):
    zipfile.ZipFile(packed).extractall(tmp_path)
    objects = open_dataset(tmp_path).objects
    assert {name for item in objects for name in item.functions or {NONE}} == {"cup", "sittable", "table", NONE}
    assert {item.path.name for item in objects} == {path.name for path in tmp_path.glob("*.ply")}
    by_others = "variety" not in packed.stem  # whose licence is stated: a source that `across_sources` leaves out
    assert set(sources_of(objects)) == {packed.stem if by_others else ""}
    for item in objects[::EVERY]:
        mesh = read_geometry(item.path)
        assert abs(mesh.vertices[:, 2].min()) < 1e-4, item.path.name
        assert 0.03 < np.ptp(mesh.vertices, axis=0).max() < 4, item.path.name
        assert standing_margin(mesh.vertices, mesh.faces) > 0 or not item.functions, item.path.name
