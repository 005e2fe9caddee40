"""The classifier's rule by hand, its contract by scikit-learn's own checks, and that it learns."""

from __future__ import annotations

from dataclasses import replace

import clouds
import numpy as np
import pytest
from scipy import sparse
from sklearn.utils.estimator_checks import parametrize_with_checks

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.function_model import require_bounds
from spherefunc_bullet.learning.cube_classifier import CubeClassifier
from spherefunc_bullet.learning.inverse_distance import (
    InverseDistanceClassifier,
    inverse_distance_scores,
    nearest_of_all_scores,
)
from spherefunc_bullet.learning.labels import as_sets
from spherefunc_bullet.learning.method import CUBES, METHODS, PAPER
from spherefunc_bullet.learning.validation import (
    member_scores,
    quality,
    radius_weights,
    remaining_weights,
    validated_f_measure,
    validation_splits,
)
from spherefunc_bullet.settling.drops import resting_drops

BY_CUBES = (CUBES, PAPER)
RADII = (0.01, 0.02)


@parametrize_with_checks([InverseDistanceClassifier(), InverseDistanceClassifier(n_neighbors=3)])
def test_scikit_learn_contract(estimator, check):
    check(estimator)


def test_scores_by_hand():
    distances = np.array([[1.0, 2.0, 4.0, 4.0]])
    members = np.array([True, False, False, True])
    # Nearest of either side: 1 / (1 + 1/2). Two of either: (1 + 1/4) / 2 to (1/2 + 1/4) / 2.
    assert inverse_distance_scores(distances, members, 1) == pytest.approx(1 / 1.5)
    assert inverse_distance_scores(distances, members, 2) == pytest.approx(0.625 / (0.625 + 0.375))
    # More neighbours than there are: all there are.
    assert inverse_distance_scores(distances, members, 9) == pytest.approx(0.625 / (0.625 + 0.375))


def test_scores_without_members_or_without_others():
    distances = np.array([[1.0, 2.0]])
    assert inverse_distance_scores(distances, np.array([False, False])) == 0
    assert inverse_distance_scores(distances, np.array([True, True])) == 1
    assert inverse_distance_scores(np.empty((3, 0)), np.zeros(0, bool), 2).tolist() == [0, 0, 0]


def test_scores_of_the_nearest_of_all_by_hand():
    distances, members = np.array([[4.0, 1.0, 2.0, 4.0]]), np.array([True, False, False, True])
    assert nearest_of_all_scores(distances, members, 1) == 0  # the nearest is no member
    # 1, 2 and the first of those at 4: a quarter of 1 + 1/2 + 1/4.
    assert nearest_of_all_scores(distances, members, 3) == pytest.approx(0.25 / 1.75)
    assert nearest_of_all_scores(distances, members, 9) == pytest.approx(0.5 / 2)
    assert nearest_of_all_scores(distances, members, (1, 9)) == pytest.approx(0.125)
    assert nearest_of_all_scores(distances, ~members, 3) == pytest.approx(1.5 / 1.75)  # the others' share


def test_the_same_histogram_decides():
    scores = inverse_distance_scores(np.array([[0.0, 0.5], [0.0, 0.0]]), np.array([True, False]))
    # The inverse distance is capped at 1e6, so the other's share is 2 in 1e6; two equal ones share.
    assert scores == pytest.approx([1, 0.5], abs=3e-6)


def test_scores_stay_between_zero_and_one():
    random = np.random.default_rng(0)
    distances = random.exponential(10.0 ** random.integers(-8, 8, (50, 1)), (50, 20))
    scores = inverse_distance_scores(distances, random.random(20) < 0.3, 3)
    assert np.all((scores >= 0) & (scores <= 1))


@pytest.mark.parametrize("container", [np.asarray, sparse.csr_matrix])
def test_partial_fit_in_halves_is_fit(container):
    random = np.random.default_rng(1)
    rows, labels, asked = random.random((40, 5)), random.integers(0, 3, 40), random.random((20, 5))
    whole = InverseDistanceClassifier(n_neighbors=2).fit(container(rows), labels)
    halves = InverseDistanceClassifier(n_neighbors=2)
    halves.partial_fit(container(rows[:20]), labels[:20], classes=[0, 1, 2])
    halves.partial_fit(container(rows[20:]), labels[20:])
    # The same numbers in the same order; matrix products may round them differently.
    assert np.allclose(halves.predict_proba(container(asked)), whole.predict_proba(container(asked)), rtol=1e-12)


def test_growth_brings_new_classes():
    classifier = InverseDistanceClassifier().partial_fit([[0.0]], ["cup"])
    assert classifier.predict([[5.0]]).tolist() == ["cup"]
    classifier.partial_fit([[9.0]], ["table"])
    assert classifier.predict([[5.0], [1.0]]).tolist() == ["table", "cup"]


def heap(kind: str, seed: int) -> dict:
    """Return settled centres as the paper describes them: cups fill, tables hold a layer, chairs a slope."""
    random = np.random.default_rng([seed, *map(ord, kind)])
    size = random.uniform(0.8, 1.2)
    x, y, z = random.uniform(0, 1, (3, 300))
    if kind == "cup":
        centers = np.column_stack([0.07 * (x - 0.5), 0.07 * (y - 0.5), 0.1 * z])
    elif kind == "table":
        centers = np.column_stack([1.2 * (x - 0.5), 0.8 * (y - 0.5), np.full(x.size, 0.72)])
    elif kind == "sittable":
        centers = np.column_stack([0.4 * (x - 0.5), 0.4 * (y - 0.5), 0.45 + 0.35 * y * z])
    else:
        centers = np.column_stack([0.5 * (x - 0.5), 0.3 * (y - 0.5), np.full(x.size, random.uniform(1.2, 2))])[:30]
    kept = {radius: (size * centers[:: round(radius / 0.01)]).astype(np.float32) for radius in RADII}
    return {radius: resting_drops(radius, rests) for radius, rests in kept.items()}


def collection(count: int, start: int = 0) -> tuple[list[dict], list[str], list[str]]:
    labels = [kind for kind in ("cup", "table", "sittable", "none") for _ in range(count)]
    names = [f"{label} {start + i}" for i, label in enumerate(labels)]
    return [heap(label, start + i) for i, label in enumerate(labels)], labels, names


def fitted(settled, labels, names, method="cubes") -> CubeClassifier:
    return CubeClassifier(radii=RADII, method=method).fit_settled(settled, labels, names)


def f_measures(model, settled, labels) -> np.ndarray:
    predicted = model.score_settled(settled) > 0.5
    truth = np.array([[name in each for name in model.functions_] for each in as_sets(labels)])
    return np.array([quality(*columns).f_measure for columns in zip(truth.T, predicted.T, strict=True)])


@pytest.mark.parametrize("method", [method.name for method in BY_CUBES])
def test_functions_are_learnt(method):
    model = fitted(*collection(10), method)
    settled, labels, _ = collection(10, 100)
    assert model.functions_ == ("cup", "sittable", "table")
    scores = model.score_settled(settled)
    assert np.all((scores >= 0) & (scores <= 1))
    # The four kinds lie in different cubes whatever their size, so that all but the odd object are classified.
    assert f_measures(model, settled, labels).min() > 0.9


def test_shuffled_labels_fall_to_chance():
    settled, labels, names = collection(20)
    shuffled = np.random.default_rng(3).permutation(labels).tolist()
    asked, truth, _ = collection(20, 200)
    learnt = f_measures(fitted(settled, labels, names), asked, truth)
    chance = f_measures(fitted(settled, shuffled, names), asked, truth)
    # A quarter of the objects have each function: guessing with that share finds F = 0.25. Clusters of twenty
    # shuffled labels stray from it, so what is asked for is a wide gap.
    assert learnt.min() > 0.9 and chance.mean() < 0.5


def test_several_functions_or_none():
    settled, labels, names = collection(8)
    bench = [heap("table", 500 + i) for i in range(8)]
    model = fitted(settled + bench, labels + ["table;stage"] * 8, names + ["bench"] * 8)
    assert model.functions_ == ("cup", "sittable", "stage", "table")
    held = model.score_settled([bench[0], settled[0], settled[-1]]) > 0.5
    assert held.tolist() == [[False, False, True, True], [True, False, False, False], [False] * 4]


def moved(objects: list[dict]) -> list[dict]:
    return [{radius: resting_drops(radius, one.rests + 3) for radius, one in each.items()} for each in objects]


def test_growth_is_learning_everything():
    """Also where the new objects bring a function and cubes that were not there before."""
    (settled, labels, names), (more, _, more_names) = collection(6), collection(6, 50)
    far = moved(more)
    grown = fitted(settled, labels, names).add_settled(far, ["shelf"] * len(far), more_names)
    whole = fitted(settled + far, labels + ["shelf"] * len(far), names + more_names)
    asked = collection(4, 90)[0] + moved(collection(2, 70)[0])
    assert grown.functions_ == whole.functions_ == ("cup", "shelf", "sittable", "table")
    assert grown.weights_ == whole.weights_ and grown.names_ == whole.names_
    assert np.allclose(grown.score_settled(asked), whole.score_settled(asked), rtol=1e-9)


def test_one_example_is_enough_to_begin():
    model = fitted([heap("cup", 0)], ["cup"], ["first cup"])
    assert model.functions_ == ("cup",)
    assert model.score_settled([heap("table", 1)]).tolist() == [[1.0]]  # nothing else has been met yet
    model.add_settled([heap("table", 2)], ["table"], ["first table"])
    assert (model.score_settled([heap("table", 1), heap("cup", 1)]) > 0.5).tolist() == [
        [False, True],
        [True, False],
    ]


@pytest.mark.parametrize("method", [method.name for method in BY_CUBES])
def test_neighbours_explain_the_score(method):
    model = fitted(*collection(6), method=method)
    asked = heap("sittable", 77)
    for column, name in enumerate(model.functions_):
        rows = model.neighbors(asked, name)
        score = model.score_settled([asked])[0, column]
        # Weights are printed with four digits, and there are at most two radii with six neighbours each.
        assert sum(row["weight"] for row in rows if row["member"]) == pytest.approx(score, abs=12 * 5e-5)
        assert sum(row["weight"] for row in rows) == pytest.approx(1, abs=12 * 5e-5)


def test_labels_are_counted():
    with pytest.raises(ValueError, match="2 objects, 1 labels"):
        fitted([heap("cup", 0), heap("cup", 1)], ["cup"], ["a", "b"])
    with pytest.raises(InputError, match="at least one labelled object"):
        fitted([], [], [])


def test_a_method_says_which_of_equal_radii():
    members = np.arange(10) < 4
    apart = np.where(members[:, None] == members, 1.0, 9.0)
    smallest = replace(PAPER, tied="smallest")
    assert radius_weights({0.01: apart, 0.05: apart, 0.02: apart}, members, smallest) == {0.01: 1.0}


def test_one_split_chooses_by_its_validation_set_alone():
    members = np.arange(20) < 8
    ((train, held_out),) = validation_splits(members, 1, 0)
    # At 1 cm the training objects that train lie among others, at 5 cm those that validate do.
    useful, useless = np.where(members[:, None] == members, 1.0, 9.0), np.where(members[:, None] == members, 9.0, 1.0)
    spoiled = useful.copy()
    spoiled[np.ix_(train, train)] = useless[np.ix_(train, train)]
    misled = useful.copy()
    misled[np.ix_(held_out, train)] = useless[np.ix_(held_out, train)]
    assert radius_weights({0.01: spoiled, 0.05: misled}, members, PAPER) == {0.01: 1.0}


@pytest.mark.parametrize("name", METHODS)
def test_every_method_has_radii_that_a_model_may_have(name):
    method = METHODS[name]
    assert method.name == name and list(method.radii) == sorted(set(method.radii))
    require_bounds(method.radii, method.run_limit.drops, name)


def test_the_paper_counts_three_neighbours_and_cubes_the_mean_of_one_and_of_three_on_either_side():
    alike = np.array([True, True, False, False])
    assert member_scores(np.array([[1.0, 1, 1, 1]]), alike, PAPER) == pytest.approx(2 / 3)
    members = np.arange(8) < 4
    found = member_scores(np.array([[1.0, 2, 4, 5, 2, 4, 4, 5]]), members, CUBES)
    assert found == pytest.approx(np.mean([1 / 1.5, 1.75 / (1.75 + 1)]))


def test_runs_go_to_the_end_where_the_method_says_so(monkeypatch):
    monkeypatch.setattr("spherefunc_bullet.simulator.SPHERE_LIMIT", 5)
    mug = clouds.mug()
    limited, whole = (
        CubeClassifier(radii=(0.01,), method=method).fit([mug, clouds.plate()], ["cup", "none"])
        for method in ("cubes", "paper")
    )
    assert limited.examples_[0.01].sum() == 10 < whole.examples_[0.01].sum()


def test_ties_go_to_the_larger_radius():
    settled, labels, _ = collection(6)
    members = np.array([label == "cup" for label in labels])
    apart = np.where(members[:, None] == members, 1.0, 9.0)
    for method in BY_CUBES:
        weights = radius_weights({0.01: apart, 0.05: apart, 0.02: apart}, members, method)
        assert max(weights, key=weights.get) == 0.05


def test_the_radius_that_tells_apart_is_chosen():
    members = np.arange(40) < 12
    useful = np.where(members[:, None] == members, 1.0, 9.0)
    noise = np.random.default_rng(0).uniform(1, 2, (40, 40))
    for method in BY_CUBES:
        weights = radius_weights({0.01: useful, 0.05: noise}, members, method)
        assert max(weights, key=weights.get) == 0.01 and sum(weights.values()) == pytest.approx(1)
    assert radius_weights({0.01: useful, 0.05: noise}, members, PAPER) == {0.01: 1.0}


@pytest.mark.parametrize("members", [[True], [False, False, False, False], [True, True, True], [True, False]])
def test_without_two_sides_the_cheapest_radius_serves(members):
    members = np.array(members)
    distances = np.ones((len(members),) * 2)
    assert radius_weights({0.01: distances, 0.05: distances}, members, CUBES) == {0.05: 1.0}


def test_validation_is_three_in_ten_with_both_sides():
    members = np.arange(50) < 5
    for train, held_out in validation_splits(members, 20, 0):
        assert len(held_out) == 15 and not set(train) & set(held_out)
        assert members[held_out].any() and members[train].any()


def test_three_objects_are_enough_to_choose_a_radius():
    members, far = np.array([True, True, False]), np.array([[0, 1, 5], [1, 0, 5], [5, 5, 0.0]])
    wrong = np.array([[0, 5, 1], [5, 0, 1], [1, 1, 0.0]])
    assert radius_weights({0.01: far, 0.02: wrong}, members, replace(CUBES, vote=False)) == {0.01: 1.0}
    assert radius_weights({0.01: far[:2, :2], 0.02: wrong[:2, :2]}, members[1:], CUBES) == {0.02: 1.0}  # two are not


def test_radii_that_are_left_share_all_of_the_weight():
    weights = {0.01: 0.2, 0.02: 0.3, 0.03: 0.5}
    assert remaining_weights(weights, (0.03, 0.02, 0.01, 0.5)) == weights
    assert remaining_weights(weights, (0.01, 0.02)) == pytest.approx({0.01: 0.4, 0.02: 0.6})
    assert remaining_weights(weights, (0.05,)) == {}


def test_two_members_are_on_either_side_of_every_split():
    members = np.array([True, False, False, True, False, False])
    for some in (members, ~members):
        for train, held_out in validation_splits(some, 20, 0):
            assert len(held_out) == 2 and members[train].sum() == members[held_out].sum() == 1


def test_the_f_measure_over_splits_is_one_where_all_is_right():
    distances = np.array([[0, 9, 1, 5], [9, 0, 5, 1], [1, 5, 0, 9], [5, 1, 9, 0.0]])
    members = np.array([True, False, True, False])
    every = [(np.delete(np.arange(4), k), np.array([k])) for k in range(4)]
    assert validated_f_measure(distances, members, every, CUBES) == 1.0
    assert validated_f_measure(9 - distances, members, every, CUBES) == 0.0


def test_quality_by_hand():
    """Of three members two are found, and one of the five others is claimed."""
    members, claimed = np.array([1, 1, 1, 0, 0, 0, 0, 0], bool), np.array([1, 1, 0, 1, 0, 0, 0, 0], bool)
    found = quality(members, claimed)
    assert (found.precision, found.recall, found.accuracy) == pytest.approx((2 / 3, 2 / 3, 6 / 8))
    assert found.f_measure == pytest.approx(2 / 3)
    some = quality(members, claimed, np.arange(8) < 3)
    assert (some.precision, some.recall, some.accuracy) == pytest.approx((1, 2 / 3, 2 / 3))
