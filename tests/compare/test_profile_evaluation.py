"""Profiles under the paper's protocol: every object tested once, by what has not seen it, and points like spheres."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import clouds
import numpy as np
import pytest
from scipy.spatial.distance import pdist
from sklearn.ensemble import ExtraTreesClassifier

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.compare.evaluation import profiles, stopping
from spherefunc_bullet.compare.evaluation.protocol import Labels, Protocol, labels_of
from spherefunc_bullet.compare.evaluation.readings import ACROSS, fused, points_as_drops, profiled, reliability
from spherefunc_bullet.compare.figures import budget
from spherefunc_bullet.compare.pages.plates import write_plate
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
        voxels=cubes.astype(np.int16),
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
    monkeypatch.setattr(profiles, "TREES", 2)


def small() -> FunctionClassifier:
    return FunctionClassifier(radii=RADII, estimator=ExtraTreesClassifier(20, random_state=0))


def test_every_object_is_tested_once_and_told(simulated, splits):
    evaluation = profiled(simulated.settled, labels_of(simulated), small()).evaluation(splits)
    assert sorted(evaluation.left_out[ACROSS].rows.tolist()) == list(range(18))
    assert {name: row["f_measure"] for name, row in evaluation.left_out_quality(ACROSS).items()} == {
        "cup": 1.0,
        "table": 1.0,
    }
    assert len(evaluation.trials[8]) == 2


def test_points_stand_a_diameter_apart(simulated):
    points = points_as_drops(simulated.records[0], (0.02, 0.03))
    for radius, drops in points.items():
        assert pdist(drops.rests).min() >= 2 * radius
    again = points_as_drops(simulated.records[0], (0.02, 0.03))
    assert all(np.array_equal(points[radius].rests, again[radius].rests) for radius in points)


def test_results_hold_the_baselines_and_few_drops(simulated, splits, capsys):
    read = profiles.all_readings(simulated, RADII, None, RADII)
    evaluated = {name: reading.evaluation(splits) for name, reading in read.items()}
    results = profiles.results_of(evaluated)
    sure = reliability(evaluated[profiles.SPHERES].left_out[ACROSS], labels_of(simulated))
    assert sum(row["scores"] for row in sure) == 18 * len(FUNCTIONS)
    assert all(row["from"] <= row["said"] <= row["to"] for row in sure)
    assert {profiles.POINTS, profiles.FUSED, "bounding_box", "rules", "examiner"} <= set(
        results[0]["baselines"]
    )
    few = profiles.few_drops(simulated, RADII, [4, 16], splits)
    profiles.print_all(results, few, sure, 1.0, json=False)
    assert "points" in capsys.readouterr().out


def test_fused_quantities_stand_side_by_side(simulated, splits):
    labels, points = labels_of(simulated), [points_as_drops(record, RADII) for record in simulated.records]
    spheres, own = (profiled(objects, labels, small()) for objects in (simulated.settled, points))
    both = fused([spheres, own])
    assert np.array_equal(both.profiles, np.hstack([spheres.profiles, own.profiles]))
    assert {row["f_measure"] for row in both.evaluation(splits).left_out_quality(ACROSS).values()} == {1.0}


def test_ranking_names_every_quantity(simulated, splits, capsys):
    profiles.print_ranking(simulated, RADII, splits, json=False)
    out = capsys.readouterr().out
    assert all(name in out for name in profiles.NAMES)


def test_log_loss_of_a_sure_truth_is_nothing(simulated, splits):
    evaluation = profiled(simulated.settled, labels_of(simulated), small()).evaluation(splits)
    trial, labels = evaluation.left_out[ACROSS], labels_of(simulated)
    sure = replace(trial, scores=labels.members[trial.rows].astype(float))
    assert profiles.log_loss(sure, labels) == pytest.approx(-np.log(1 - profiles.SURE), abs=1e-5)


def test_seeds_are_listed_with_their_mean_and_spread(capsys):
    profiles.print_seeds([{"cup": 0.9, "table": 1.0}, {"cup": 0.7, "table": 1.0}], "two seeds", json=False)
    out = capsys.readouterr().out
    assert "0.800 ± 0.100" in out and "1.000 ± 0.000" in out


def test_budget_draws_and_prints_what_drops_give_and_cost(simulated, tmp_path, capsys):
    timed = [clouds.mug(), clouds.plate(0.2, 0.2, 0.2)]
    rows = budget.budgets(simulated, timed, "fast", [4, 16])
    assert {(row.drops, row.function) for row in rows} == {(n, name) for n in (4, 16) for name in FUNCTIONS}
    assert all(row.milliseconds > 0 and 0 <= row.f_measure <= 1 for row in rows)
    written = write_plate(budget.budget_plate(rows, "objects"), tmp_path)
    assert [path.name for path in written] == ["budget.png", "budget.svg", "budget.csv"]
    words = (tmp_path / "budget.svg").read_text()
    assert all(f"{name}, fast" in words for name in FUNCTIONS) and "drops at each radius" in words
    budget.print_rows(rows)
    assert "fast" in capsys.readouterr().out


def test_stopping_counts_what_is_sure_and_what_is_wrong():
    members = np.array([[True, False], [False, True], [False, False]])
    labels = Labels(functions=FUNCTIONS, members=members, also=~members & False, groups=np.array(["a", "b", "c"]))
    early = np.array([[0.99, 0.01], [0.01, 0.6], [0.99, 0.01]])  # the second is unsure, the third surely wrong
    late = np.array([[0.9, 0.1], [0.1, 0.4], [0.1, 0.1]])
    asked = stopping.Asked(rows=np.arange(3), early=early, late=late, doubtful=np.zeros(3, bool))
    row = stopping.stopped_at("whole", asked, labels, 40, 0.05)
    assert (row.stopped, row.wrong, row.wrong_to_the_end) == (0.667, 1, 0)
    assert row.f_measures == {"table": pytest.approx(2 / 3, abs=1e-4), "cup": 0}
    doubtful = replace(asked, doubtful=np.array([False, False, True]))
    assert (
        stopping.stopped_at("whole", doubtful, labels, 40, 0.05).wrong == 0
    )  # it goes on, and is classified correctly


def test_toys_are_sure_after_a_few_drops(simulated):
    rows = stopping.stoppings(simulated, None, FunctionClassifier(radii=RADII, early_drops=8))
    assert [row.error for row in rows] == list(stopping.ERRORS) and all(row.drops == 8 for row in rows)
    assert rows[-1].stopped > 0.9 and set(rows[-1].f_measures.values()) == {1.0}
