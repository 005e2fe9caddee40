"""Profiles under the paper's protocol: every object tested once, by what has not seen it, and points like spheres."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from sklearn.ensemble import ExtraTreesClassifier

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.compare.evaluation.protocol import Protocol, labels_of
from spherefunc_bullet.compare.evaluation.readings import ACROSS, points_as_drops, profiled
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.learning import function_classifier
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.settling.drops import Drops, drops_from_rows
from spherefunc_bullet.settling.records import VOXEL, ObjectRecord

RADII = (0.02,)
FUNCTIONS = ("table", "cup")


def dropped(centers: np.ndarray) -> Drops:
    """Return drops that settled where they fell."""
    rows = np.column_stack([centers[:, :2], centers, np.zeros(len(centers))])
    return drops_from_rows(RADII[0], rows)


def record(flat: bool, seed: int) -> ObjectRecord:
    """Return a plate with a layer of spheres, or a small block with a stack."""
    generator = np.random.default_rng(seed)
    x, y = np.mgrid[0:8, 0:8] if flat else np.mgrid[0:2, 0:2]
    layer = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]) * 0.04
    centers = layer + [0, 0, 0.7] if flat else np.concatenate([layer + [0, 0, 0.03 + 0.04 * k] for k in range(4)])
    cubes = np.argwhere(np.ones((60, 60, 1) if flat else (12, 12, 30)))
    return ObjectRecord(
        path=Path(f"{seed}.ply"),
        size=(cubes.max(axis=0) + 1) * VOXEL,
        occupied=lambda: cubes.astype(np.int16),
        settled={RADII[0]: dropped(centers * generator.uniform(0.95, 1.05))},
        seconds={RADII[0]: 0.1},
        drops={RADII[0]: 100},
    )


@pytest.fixture(scope="module")
def simulated() -> Simulated:
    objects = [
        DatasetObject(path=Path(f"{k}.ply"), functions=frozenset({FUNCTIONS[k % 2]}), group=f"source {k % 3}")
        for k in range(18)
    ]
    return Simulated("toys", tuple(objects), tuple(record(k % 2 == 0, k) for k in range(18)))


@pytest.fixture(scope="module")
def splits(simulated):
    return Protocol(train_sizes=(8,), trials=2, groups=True).splits(labels_of(simulated))


@pytest.fixture(autouse=True)
def small_forests(monkeypatch):
    """A few trees tell a plate from a block, in a hundredth of the time."""
    monkeypatch.setattr(function_classifier, "TREES", 5)


def small() -> FunctionClassifier:
    return FunctionClassifier(radii=RADII, estimator=ExtraTreesClassifier(20, random_state=0))


@pytest.mark.slow
def test_every_object_is_tested_once_and_told(simulated, splits):
    evaluation = profiled(simulated.settled, labels_of(simulated), small()).evaluation(splits)
    assert sorted(evaluation.left_out[ACROSS].rows.tolist()) == list(range(18))
    assert {name: row["f_measure"] for name, row in evaluation.left_out_quality(ACROSS).items()} == {
        "cup": 1.0,
        "table": 1.0,
    }
    assert len(evaluation.trials[8]) == 2


@pytest.mark.slow
def test_points_stand_a_diameter_apart(simulated):
    points = points_as_drops(simulated.records[0], (0.02, 0.03))
    for radius, drops in points.items():
        assert pdist(drops.rests).min() >= 2 * radius
    again = points_as_drops(simulated.records[0], (0.02, 0.03))
    assert all(np.array_equal(points[radius].rests, again[radius].rests) for radius in points)
