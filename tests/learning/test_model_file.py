"""Models on disk: what is read back is what was written, and what cannot be used is refused in one line."""

from __future__ import annotations

import json
import os
import pickle
import shutil

import clouds
import numpy as np
import pytest
from sklearn.pipeline import make_pipeline
from sklearn.tree import DecisionTreeClassifier
from test_classifier import collection, fitted

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.function_model import MOST_DROPS
from spherefunc_bullet.learning.cube_classifier import CubeClassifier
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.method import METHODS
from spherefunc_bullet.learning.model_file import (
    cached_model,
    inference_model,
    load_model,
    new_classifier,
    save_model,
    shipped_model,
)
from spherefunc_bullet.learning.profiles.profile_model import PROFILE, ProfileModel
from spherefunc_bullet.learning.profiles.quantities import NAMES
from spherefunc_bullet.learning.profiles.trees import PlainForest
from spherefunc_bullet.settling.cached_runs import DropConfig
from spherefunc_bullet.settling.drops import NO_DROPS


@pytest.fixture(scope="module")
def model():
    return fitted(*collection(5))


@pytest.fixture
def saved(model, tmp_path):
    save_model(model, tmp_path / "model.npz")
    return tmp_path / "model.npz"


def changed(path, **about):
    """Rewrite a model file with other statements about itself."""
    with np.load(path) as file:
        arrays = dict(file)
    arrays["about"] = np.array(json.dumps(json.loads(str(arrays["about"])) | about))
    np.savez(path, **arrays)
    return path


def check_refused(path, match, backend=None):
    with pytest.raises(InputError, match=match) as caught:
        load_model(path, backend)
    assert "\n" not in str(caught.value) and str(path) in str(caught.value)


@pytest.mark.parametrize("method", ["paper", "cubes"])
def test_round_trip_scores_the_same(tmp_path, method):
    model = fitted(*collection(5), method)
    save_model(model, tmp_path / "model")
    again = load_model(tmp_path / "model", "fast")
    asked = collection(4, 60)[0]
    assert np.array_equal(again.score_settled(asked), model.score_settled(asked))
    assert again.functions_ == model.functions_ and again.names_ == model.names_
    assert again.radius_ == model.radius_ and again.weights_ == model.weights_


def test_a_model_to_ask_answers_as_the_one_that_learns():
    learning, asked = load_model(), inference_model(None, None)
    assert isinstance(asked, ProfileModel) and isinstance(learning, FunctionClassifier)
    objects = learning.profiles_[:50] * 1.03
    assert asked.score_profiles(objects).tobytes() == learning.score_profiles(objects).tobytes()
    name = asked.functions_[-1]
    assert asked.only(name).score_profiles(objects).tobytes() == learning.only(name).score_profiles(objects).tobytes()
    assert asked.quantity_names() == learning.quantity_names() and asked.run_limit == learning.run_limit


def test_trees_are_unpacked_when_they_are_needed(tmp_path):
    with np.load(shipped_model()) as file:
        np.savez(tmp_path / "half.npz", **{name: file[name] for name in file.files if name != "threshold_1"})
    model = pickle.loads(pickle.dumps(inference_model(tmp_path / "half.npz", None)))
    assert model.early_.score_profiles(model.early_.profiles_[:1]).shape == (1, 3)
    with pytest.raises(InputError, match="half.npz: expected a model"):
        model.score_profiles(model.profiles_[:1])
    with pytest.raises(InputError, match="half.npz: expected a model"):
        load_model(tmp_path / "half.npz")


def test_the_same_drops_at_fewer_radii_are_read_anew():
    """`GridSearchCV` sets other radii on a classifier that has just been asked about the same object."""
    model = FunctionClassifier(radii=(0.02, 0.03))
    settled = {0.02: NO_DROPS, 0.03: NO_DROPS}
    assert model.profiles([settled]).shape == (1, len(model.quantity_names()))
    model.set_params(radii=(0.02,))
    assert model.profiles([settled]).shape == (1, len(model.quantity_names()))


def test_a_model_to_ask_by_cubes_is_the_classifier(saved):
    assert isinstance(inference_model(saved, "fast"), CubeClassifier)
    assert inference_model(saved, "fast") is inference_model(str(saved), "fast")
    made = load_model(saved)
    assert inference_model(made, None) is made


def test_a_model_that_was_written_since_is_read_anew(saved):
    first = inference_model(saved, None)
    save_model(fitted(*collection(3)), saved)
    os.utime(saved, ns=(10**9, 10**9))
    assert len(inference_model(saved, None).names_) == 4 * 3 != len(first.names_)
    with pytest.raises(InputError):
        inference_model(saved.with_name("no such"), None)


def test_a_model_of_a_file_goes_to_another_process_by_its_name():
    """13 MB would go with each object otherwise, and be unpacked for each."""
    model = inference_model(shipped_model("fast"), "fast")
    alone = model.only("table")
    for own in (model, alone, model.early_, alone.early_):
        sent = pickle.dumps(own)
        again = pickle.loads(sent)
        assert len(sent) < 1000 and again.functions_ == own.functions_
        assert (again.score_profiles(own.profiles_[:9]) == own.score_profiles(own.profiles_[:9])).all()
    for own in (model, model.early_):
        assert pickle.loads(pickle.dumps(own)) is own and len(own.functions_) == 3
    assert alone is not model


def test_a_model_written_while_others_ask_it_is_not_mixed_up(tmp_path):
    path = tmp_path / "model.npz"
    shutil.copy(shipped_model("fast"), path)
    sent = pickle.dumps(inference_model(path, None))
    os.utime(path, ns=(10**9, 10**9))
    cached_model.cache_clear()  # as in a process that has not read it yet
    with pytest.raises(InputError, match="written since"):
        pickle.loads(sent).drop_config()


def test_numbers_of_numpy_are_saved_and_what_cannot_be_is_named(tmp_path):
    how = {"radii": (0.02,), "estimator": PlainForest(2), "drops": np.int64(5), "seed": np.int64(2)}
    model = FunctionClassifier(**how, random_state=np.int64(3)).fit([clouds.mug(), clouds.plate()], ["cup", "table"])
    save_model(model, tmp_path / "model.npz")
    again = load_model(tmp_path / "model.npz")
    assert (again.drops, again.seed, again.random_state) == (5, 2, 3)
    with pytest.raises(InputError, match="x.npz: expected a random_state that is a number or None"):
        save_model(model.set_params(random_state=np.random.RandomState(0)), tmp_path / "x.npz")
    with pytest.raises(InputError, match="expected a FunctionClassifier or CubeClassifier, got Pipeline"):
        save_model(make_pipeline(model), tmp_path / "x.npz")


@pytest.mark.parametrize("name", METHODS)
def test_a_new_classifier_of_a_method_drops_spheres_as_said(name):
    how = DropConfig(simulator="fast", radii=METHODS[name].radii, seed=3, run_limit=METHODS[name].run_limit)
    model = new_classifier(how, name)
    assert isinstance(model, FunctionClassifier if name == PROFILE else CubeClassifier)
    assert (model.radii, model.seed, model.run_limit) == (how.radii, how.seed, how.run_limit)


def test_round_trip_of_the_file_is_the_same_model(saved, tmp_path):
    save_model(load_model(saved), tmp_path / "again.npz")
    with np.load(saved) as first, np.load(tmp_path / "again.npz") as second:
        assert sorted(first.files) == sorted(second.files)
        assert all(np.array_equal(first[name], second[name]) for name in first.files)


def test_model_read_back_learns_more(model, saved):
    more, labels, names = collection(3, 40)
    asked = collection(4, 60)[0]
    grown = load_model(saved).add_settled(more, labels, names)
    settled, first_labels, first_names = collection(5)
    whole = fitted(settled + more, first_labels + labels, first_names + names)
    assert grown.weights_ == whole.weights_
    assert np.allclose(grown.score_settled(asked), whole.score_settled(asked), rtol=1e-9)


def test_file_is_data_and_says_what_made_it(saved):
    with np.load(saved, allow_pickle=False) as file:
        about = json.loads(str(file["about"]))
        assert all(file[name].dtype != object for name in file.files)
    assert about["backend"] == "fast" and about["functions"] == ["cup", "sittable", "table"]
    assert about["radii"] == [0.01, 0.02] and {"numpy", "spherefunc-bullet"} <= set(about["versions"])


def test_other_backend_is_refused(saved):
    check_refused(saved, "backend fast.*bullet", backend="bullet")


def test_backend_that_is_not_installed_is_refused(saved):
    changed(saved, backend="gone")
    with pytest.raises(InputError, match="gone") as caught:
        load_model(saved)
    assert "\n" not in str(caught.value)


def test_other_version_of_the_backend_is_refused(saved):
    check_refused(changed(saved, backend_version="0.0"), "version 0.0.*train it again")


@pytest.mark.parametrize("early", [False, True])
@pytest.mark.parametrize("drops", [0, MOST_DROPS + 1])
def test_runs_that_are_longer_than_any_object_is_worth_are_refused(tmp_path, early, drops):
    with np.load(shipped_model()) as file:
        about = json.loads(str(file["about"]))
    (about["early"] if early else about)["method"]["drops"] = drops
    np.savez(tmp_path / "long.npz", about=np.array(json.dumps(about)))
    check_refused(tmp_path / "long.npz", f"got {drops:,}")


def test_other_version_of_the_format_is_refused(saved):
    check_refused(changed(saved, format_version=99), "format 1, got 99")


@pytest.mark.parametrize(
    "about",
    [
        {"backend": None},
        {"backend_options": None},
        {"backend_options": {"no_such": 1}},
        {"method": None},
        {"method": {"name": "x"}},
        {"functions": ["cup"]},
        {"functions": None},
        {"functions": ["cup", "cup", "table"]},
        {"functions": [1, 2, 3]},
        {"weights": {}},
        {"weights": {"cup": [[7.0, 1.0]], "sittable": [], "table": []}},
        {"radii": [0.01, 0.02, 0.03]},
        {"radii": "many"},
        {"seed": "x", "radii": None},
    ],
    ids=lambda about: ",".join(about),
)
def test_contents_that_do_not_fit_together_are_refused(saved, about):
    changed(saved, **about)
    with pytest.raises(InputError) as caught:
        load_model(saved).score_settled(collection(1)[0])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["lines", "early_lines", "familiar", "radius", "unsure", "vote_0"])
def test_numbers_that_are_nan_are_refused(tmp_path, name):
    """Every score would be NaN, or no answer unsure."""
    with np.load(shipped_model()) as file:
        arrays = dict(file)
    if name in arrays:
        arrays[name] = np.full_like(arrays[name], np.nan)
    about = json.loads(str(arrays["about"]))
    nan = {"familiar": np.nan, "radius": [np.nan] * 3, "unsure": [[0.2, np.nan]] * 3}
    arrays["about"] = np.array(json.dumps(about | {key: nan[key] for key in {name} & set(nan)}))
    np.savez(tmp_path / "nan.npz", **arrays)
    with pytest.raises(InputError, match="nan.npz: expected (a model.*damaged|trees)"):
        load_model(tmp_path / "nan.npz")


def test_examples_that_are_nan_are_refused(saved):
    with np.load(saved) as file:
        arrays = dict(file)
    np.savez(saved, **arrays | {"data_0": np.full_like(arrays["data_0"], np.nan)})
    with pytest.raises(InputError, match="damaged"):
        load_model(saved).score_settled(collection(1)[0])


def test_roots_of_trees_that_are_no_list_are_refused(tmp_path):
    with np.load(shipped_model()) as file:
        arrays = dict(file)
    np.savez(tmp_path / "roots.npz", **arrays | {"roots_0": arrays["roots_0"][:, None]})
    check_refused(tmp_path / "roots.npz", "expected trees")


def test_about_without_a_field_is_refused(saved):
    with np.load(saved) as file:
        arrays = dict(file)
    about = json.loads(str(arrays["about"]))
    for name in about:
        rest = {key: value for key, value in about.items() if key not in (name, "versions")}
        np.savez(saved, **arrays | {"about": np.array(json.dumps(rest))})
        if name != "versions":  # which are informative, not needed
            check_refused(saved, "expected")


def test_file_cut_short_is_refused_wherever_it_is_cut(saved):
    whole = saved.read_bytes()
    for length in np.linspace(0, len(whole) - 1, 60).astype(int):
        saved.write_bytes(whole[:length])
        check_refused(saved, "expected a model")


def test_damaged_bytes_are_refused_or_change_nothing(model, saved):
    whole = bytearray(saved.read_bytes())
    asked = collection(1, 60)[0]
    random = np.random.default_rng(0)
    for place in random.integers(0, len(whole), 60):
        damaged = whole.copy()
        damaged[place] ^= 0xFF
        saved.write_bytes(bytes(damaged))
        try:
            scores = load_model(saved).score_settled(asked)
        except InputError as error:
            assert "\n" not in str(error)
        else:  # a byte that nothing depends on: a date, an attribute; checksums guard the rest
            assert np.array_equal(scores, model.score_settled(asked))


@pytest.mark.parametrize("length", [0, 1, 100, 5000])
def test_random_bytes_are_refused(tmp_path, length):
    path = tmp_path / "noise.npz"
    path.write_bytes(np.random.default_rng(length).bytes(length))
    check_refused(path, "expected a model")


def test_other_npz_is_refused(tmp_path):
    np.savez(tmp_path / "cloud.npz", points=np.zeros((20, 3)))
    check_refused(tmp_path / "cloud.npz", "expected a model")
    np.savez(tmp_path / "about.npz", about=np.array(json.dumps({"format": "another"})))
    check_refused(tmp_path / "about.npz", "another NPZ")
    np.savez(tmp_path / "list.npz", about=np.array("[1, 2]"))
    check_refused(tmp_path / "list.npz", "another NPZ")
    np.save(tmp_path / "single.npy", np.zeros(3))
    check_refused(tmp_path / "single.npy", "expected a model")


class Trap:
    """What a pickle would run when it is opened."""

    def __reduce__(self):
        return (pytest.fail, ("the file's code was run",))


def test_pickled_objects_are_refused_unopened(saved, tmp_path):
    with np.load(saved) as file:
        arrays = dict(file)
    np.savez(saved, **arrays | {"names": np.array([Trap()] * len(arrays["names"]), dtype=object)})
    check_refused(saved, "expected a model")
    (tmp_path / "bare.pkl").write_bytes(pickle.dumps(Trap()))
    check_refused(tmp_path / "bare.pkl", "expected a model")


def test_missing_file_and_folder_are_refused(tmp_path):
    check_refused(tmp_path / "gone.npz", "found none")
    check_refused(tmp_path, "got a folder")


def test_what_is_no_forest_is_not_kept(tmp_path):
    model = FunctionClassifier(radii=(0.02,), estimator=DecisionTreeClassifier(), early_drops=0)
    profiles, members = np.eye(len(NAMES))[:4], np.array([True, True, False, False])[:, None]
    model.fit_profiles(profiles, members, ["cup"], [*"abcd"])._set_familiar_distance()
    with pytest.raises(InputError, match="DecisionTree"):
        save_model(model, tmp_path / "model.npz")


def test_place_that_cannot_be_written_is_an_input_error(model, tmp_path):
    for path in (tmp_path, tmp_path / "no" / "folder" / "model.npz"):
        with pytest.raises(InputError, match="expected a file that can be written"):
            save_model(model, path)
