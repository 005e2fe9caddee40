"""Classifiers of clouds among scikit-learn's tools: several functions or none, as that library has multilabel."""

from __future__ import annotations

import warnings
from functools import partial

import clouds
import numpy as np
import pytest
from sklearn.base import clone, is_classifier
from sklearn.ensemble import RandomForestClassifier
from sklearn.metrics import f1_score
from sklearn.model_selection import GridSearchCV, KFold, cross_val_predict, cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import MultiLabelBinarizer
from sklearn.utils import get_tags
from sklearn.utils.estimator_checks import parametrize_with_checks

import spherefunc_bullet as sf
from spherefunc_bullet.learning.profiles.trees import PlainForest

FOLDS = KFold(3, shuffle=True, random_state=0)
NO_TABLE_OF_NUMBERS = "X is a list of clouds, never a table of numbers (N, D), which this check asks for"
# Checks that hand over a table of numbers (N, D) where clouds are expected, which is refused as they ask of others.
APPLICABLE = {
    "check_estimator_cloneable",
    "check_estimator_tags_renamed",
    "check_valid_tag_types",
    "check_estimator_repr",
    "check_no_attributes_set_in_init",
    "check_parameters_default_constructible",
    "check_get_params_invariance",
    "check_set_params",
    "check_do_not_raise_errors_in_init_or_set_param",
    "check_mixin_order",
    "check_estimators_unfitted",
    "check_classifiers_one_label_sample_weights",
    "check_requires_y_none",
}


def inapplicable(estimator) -> dict[str, str]:
    """Return the checks that cannot be asked of a classifier of clouds, with the reason."""
    from sklearn.utils import estimator_checks

    names = [name for name in dir(estimator_checks) if name.startswith("check_")]
    return {name: NO_TABLE_OF_NUMBERS for name in names if name not in APPLICABLE}


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(autouse=True)
def own_cache(cache, monkeypatch):
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(cache))


@pytest.fixture(scope="module")
def objects() -> list:
    """Return six mugs and six plates."""
    mugs = [clouds.mug(0.035 + 0.001 * i) for i in range(6)]
    return mugs + [clouds.plate(0.2 + 0.02 * i) for i in range(6)]


SETS = [{"cup"}] * 6 + [{"table", "stage"}] * 5 + [set()]
FEW = PlainForest(20, random_state=0)  # trees, of the kind that is learnt by default
ESTIMATORS = [sf.FunctionClassifier(radii=(0.01,), drops=40, estimator=FEW), sf.CubeClassifier(radii=(0.01,))]


@parametrize_with_checks([sf.FunctionClassifier(), sf.CubeClassifier()], expected_failed_checks=inapplicable)
def test_scikit_learn_contract(estimator, check):
    check(estimator)


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=["profile", "cubes"])
def test_sets_in_and_sets_out(estimator, objects):
    model = clone(estimator).fit(objects, SETS)
    assert is_classifier(model) and model.classes_.tolist() == ["cup", "stage", "table"]
    result = model.predict(objects)
    assert result[:6] == [frozenset({"cup"})] * 6 and model.predict([]) == []
    right = np.mean([answer == label for answer, label in zip(result, SETS, strict=True)])
    assert model.score(objects, SETS) == pytest.approx(right)
    assert model.predict_proba([]).shape == (0, 3)


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=["profile", "cubes"])
def test_an_indicator_in_and_an_indicator_out(estimator, objects, tmp_path):
    y = MultiLabelBinarizer().fit_transform(SETS)
    model = clone(estimator).fit(objects, y)
    result = model.predict(objects)
    assert result.shape == y.shape and set(np.unique(result)) <= {0, 1} and model.classes_.tolist() == ["0", "1", "2"]
    assert result[:6].tolist() == [[1, 0, 0]] * 6 and model.predict([]).shape == (0, 3)
    by_sets = clone(estimator).fit(objects, SETS)
    assert np.array_equal(model.predict_proba(objects), by_sets.predict_proba(objects))
    assert model.score(objects, y) == by_sets.score(objects, SETS)
    assert f1_score(y, result, average="macro") > 0.8
    sf.save_model(model, tmp_path / "model.npz")
    assert np.array_equal(sf.load_model(tmp_path / "model.npz").predict(objects), result)


def test_columns_keep_their_order_and_those_of_nobody():
    y = np.zeros((4, 12), int)
    y[:2, 10], y[2:, 2] = 1, 1
    objects = [clouds.mug(), clouds.mug(0.03), clouds.plate(), clouds.plate(0.2)]
    model = sf.FunctionClassifier(radii=(0.01,), drops=40).fit(objects, y)
    assert np.array_equal(model.predict(objects), y)
    assert model.predict_proba(objects).shape == (4, 12)
    model.partial_fit([clouds.mug(0.045)], y[:1])
    assert np.array_equal(model.predict(objects), y)


def test_later_labels_name_what_was_learnt():
    objects, y = [clouds.mug(), clouds.plate()], np.array([[1, 0], [0, 1]])
    model = sf.FunctionClassifier(radii=(0.01,), drops=10)
    model.fit(objects, ["cup", "none"])
    for ask in (model.partial_fit, model.score):
        with pytest.raises(sf.InputError, match="names for each object, as they were learnt, got an indicator"):
            ask(objects, y)
    model.fit(objects, y)
    for later in (["shelf", "0"], np.eye(3, dtype=int)[1:]):
        with pytest.raises(sf.InputError, match="expected functions of the columns 0, 1, got"):
            model.partial_fit(objects, later)
    assert model.partial_fit(objects, ["0", "1"]).predict(objects).shape == (2, 2)


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=["profile", "cubes"])
@pytest.mark.parametrize("radii", [(0.02,), (0.01, 0.02)])
def test_radii_that_were_not_learnt_are_refused(estimator, radii, objects, tmp_path):
    model = clone(estimator).fit(objects[5:7], SETS[5:7])
    sf.save_model(model, tmp_path / "model.npz")
    for one in (model, sf.load_model(tmp_path / "model.npz")):
        one.set_params(radii=radii)
        for ask, *what in (
            (one.predict, objects[:1]),
            (partial(sf.classify, model=one), objects[0]),
            (one.partial_fit, objects[:1], SETS[:1]),
            (sf.save_model, one, tmp_path / "changed.npz"),
        ):
            with pytest.raises(sf.InputError, match="radii: expected 0.01 m, which were learnt, got 0.0.*; call fit"):
                ask(*what)
        assert one.set_params(radii=[0.01]).predict(objects[:1]) == [frozenset({"cup"})]


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=["profile", "cubes"])
def test_objects_without_any_function_can_be_learnt(estimator, objects):
    assert clone(estimator).fit(objects[:2], ["none", "none"]).predict(objects[:1]) == [frozenset()]


@pytest.mark.parametrize("y", [[0, 1], np.array([[0, 2], [1, 0]]), np.array([0, 1]), [{"cup"}], "cup", [1.5, {"a"}]])
def test_labels_that_are_none_are_refused(y):
    with pytest.raises(ValueError, match="expected"):
        sf.FunctionClassifier(radii=(0.01,), drops=5).fit([clouds.mug(), clouds.plate()], y)


@pytest.mark.slow
@pytest.mark.parametrize("y", [SETS, MultiLabelBinarizer().fit_transform(SETS)], ids=["sets", "indicator"])
def test_cross_validation_tells_mugs_from_plates(objects, y):
    model = ESTIMATORS[0]
    scores = cross_val_score(model, objects, y, cv=FOLDS)
    # One plate in twelve is labelled none, and nothing about it says so.
    assert scores.shape == (3,) and scores.mean() >= 0.75
    assert len(cross_val_predict(model, objects, y, cv=FOLDS)) == len(objects)


def test_scikit_learns_own_measures_are_finite(objects):
    y = MultiLabelBinarizer().fit_transform(SETS)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a fold may hold none of a function
        scores = cross_val_score(ESTIMATORS[0], objects, y, cv=FOLDS, scoring="f1_macro")
    assert np.isfinite(scores).all() and scores.mean() > 0.5


@pytest.mark.slow
def test_grid_search_chooses_and_clones(objects):
    y = MultiLabelBinarizer().fit_transform(SETS)
    grid = {"drops": [20, 40], "radii": [(0.01,), (0.005, 0.01)]}
    search = GridSearchCV(ESTIMATORS[0], grid, cv=FOLDS, n_jobs=2, error_score="raise").fit(objects, y)
    assert search.best_params_["drops"] in (20, 40) and search.best_score_ > 0.7


@pytest.mark.parametrize("features", [sf.SphereHistogram(radius=0.01), sf.RestingProfile(0.01, drops=40)])
def test_features_go_before_any_classifier(objects, features):
    pipeline = make_pipeline(features, RandomForestClassifier(10, random_state=0))
    labels = ["cup"] * 6 + ["table"] * 6
    # A mug fills and a plate holds a layer; by cubes, a mug of a size that was not learnt may go wrong.
    assert cross_val_score(pipeline, objects, labels, cv=3).mean() > 0.8


@pytest.mark.parametrize("kind", [sf.FunctionClassifier, sf.CubeClassifier])
def test_scikit_learn_knows_that_objects_have_several_functions_and_are_no_rows(kind):
    tags = get_tags(kind())
    assert tags.classifier_tags.multi_label and tags.target_tags.multi_output and not tags.input_tags.two_d_array


def test_errors_number_the_object():
    with pytest.raises(sf.InputError, match="object 1"):
        sf.load_model().predict([clouds.mug(), np.zeros((3, 3))])
    with pytest.raises(sf.InputError, match="in a list"):
        sf.load_model().predict(clouds.mug())


@pytest.mark.parametrize("kind", [sf.FunctionClassifier, sf.CubeClassifier, sf.SphereHistogram, sf.RestingProfile])
def test_backend_is_the_same_as_simulator(kind):
    named = kind(backend="bullet")
    assert named.get_params() == kind(simulator="bullet").get_params() == clone(named).get_params()
    with pytest.raises(TypeError, match=rf"{kind.__name__}\(\).*engine"):
        kind(engine="bullet")
