"""What models learnt: cubes that speak for a function, one function alone, what surrounds an object, how sure to be."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import clouds
import numpy as np
import pytest
from sklearn.ensemble import ExtraTreesClassifier
from sklearn.tree import DecisionTreeClassifier
from test_classifier import collection, fitted, heap
from test_doubts import dropped as shelves
from test_resting_profile import RADIUS, layer

from spherefunc_bullet.clouds.preparation import prepare, rotated_cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats import FormatError
from spherefunc_bullet.learning import function_classifier, validation
from spherefunc_bullet.learning.cube_classifier import CubeClassifier, rebuilt_method
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.histogram import CubeHistogram, SphereHistogram, counts_matrix, cube_keys, quarter_turns
from spherefunc_bullet.learning.method import CUBES, METHODS, PAPER, find_cube_method
from spherefunc_bullet.learning.model_file import (
    inference_model,
    load_model,
    model_for_views,
    save_model,
    shipped_model,
)
from spherefunc_bullet.learning.profiles.calibration import (
    DEFAULT_UNSURE_RANGE,
    group_copies,
)
from spherefunc_bullet.learning.profiles.columns import columns_of
from spherefunc_bullet.learning.profiles.forest import LEAF, Forest, forest_arrays, forest_from_sklearn, rebuilt_forests
from spherefunc_bullet.learning.profiles.quantities import NAMES, profiles_over
from spherefunc_bullet.learning.profiles.trees import PlainForest
from spherefunc_bullet.learning.reasons.cubes import cube_evidence, side_weights, strongest_cubes
from spherefunc_bullet.learning.resting_profile import RestingProfile
from spherefunc_bullet.learning.validation import member_scores, radius_weights
from spherefunc_bullet.settling.cached_runs import settle_cached
from spherefunc_bullet.settling.drops import RunLimit, drops_from_rows, resting_drops
from spherefunc_bullet.settling.settling import settle

RANDOM = np.random.default_rng


@pytest.mark.parametrize("method", ["cubes", "paper"])
def test_cubes_speak_by_how_much_nearer_they_bring_an_object(method):
    """Over all cubes it is the difference of the mean squared distances; none without a sphere is among them."""
    model, asked = fitted(*collection(6), method), heap("sittable", 77)
    name, radius = "sittable", model.radius_["sittable"]
    cubes = cube_evidence(model, asked, name, radius)
    distances = model.distances([asked], radius)[0]
    weights = model.neighbor_weights(distances, name)
    members = model.members_[:, model.functions_.index(name)]
    sides = [(distances**2, side_weights(weights, side, distances)) for side in (~members, members)]
    far, near = (np.average(squared, weights=own) for squared, own in sides)
    spoken = cubes.speaks_for.sum()
    unknown = model.histograms_[radius].transform([asked[radius].rests]).toarray()[0, -1]
    assert spoken == pytest.approx(far - near) and spoken > 0 and unknown >= 0
    assert ((cubes.counts > 0) | (cubes.members > 0) | (cubes.others > 0)).all() and cubes.counts.sum() == len(
        asked[radius].rests
    )
    inside = cubes.corners[cubes.counts > 0]
    held = (asked[radius].rests[:, None] >= inside) & (asked[radius].rests[:, None] < inside + cubes.side)
    assert (held.all(axis=2).sum(axis=0) == cubes.counts[cubes.counts > 0]).all()
    rows = strongest_cubes(model, asked, name, 3)
    shares = [row["share"] for row in rows]
    pro, contra = [share for share in shares if share > 0], [-share for share in shares if share < 0]
    assert 0 < len(pro) <= 3 and len(contra) <= 3 and pro + contra == [abs(share) for share in shares]
    assert pro == sorted(pro, reverse=True) and contra == sorted(contra, reverse=True)
    assert rows[0]["share"] == pytest.approx(cubes.speaks_for.max() / np.abs(cubes.speaks_for).sum(), abs=1e-4)
    order = np.argsort(-cubes.speaks_for, kind="stable")
    named = [*order[cubes.speaks_for[order] > 0], *order[::-1][cubes.speaks_for[order[::-1]] < 0]]
    every = strongest_cubes(model, asked, name, len(order))
    for key, means in {"spheres": cubes.counts, "members": cubes.members, "others": cubes.others}.items():
        assert [row[key] for row in every] == [round(means[i], 2) for i in named]  # to hundredths


def test_spheres_where_nobody_had_any_speak_neither_way():
    model = fitted(*collection(3))
    asked = {radius: resting_drops(radius, one.rests + 4) for radius, one in heap("cup", 5).items()}
    cubes = cube_evidence(model, asked, "cup", model.radius_["cup"])
    new = cubes.counts > 0
    assert new.any() and not (cubes.speaks_for[new].any() or cubes.members[new].any() or cubes.others[new].any())
    shares = [row["share"] for row in strongest_cubes(model, asked, "cup", len(new))]
    assert len(shares) == np.count_nonzero(cubes.speaks_for) < len(new)


def test_who_is_held_out_is_held_out_with_a_classifier_by_cubes():
    settled, labels, names = collection(5)
    model = fitted(settled + [heap("stage", 1)], [*labels, "stage"], [*names, "one"])
    found = model.held_out_f_measures()
    assert found.pop("stage") is None and set(found) == {"cup", "sittable", "table"}
    assert min(found.values()) > 0.9
    shuffled = RANDOM(0).permutation(labels).tolist()
    assert np.mean([value for value in fitted(settled, shuffled, names).held_out_f_measures().values()]) < 0.6


def test_an_object_that_may_face_any_way_is_as_near_as_its_nearest_quarter_turn():
    settled, labels, names = collection(4)
    model = fitted(settled, labels, names)
    lying = {radius: resting_drops(radius, one.rests * [2, 0.5, 1]) for radius, one in heap("table", 9).items()}
    for turns in range(4):
        turned = {radius: resting_drops(radius, quarter_turns(one.rests, turns)) for radius, one in lying.items()}
        each = [
            model.distances([{0.01: resting_drops(0.01, quarter_turns(lying[0.01].rests, k))}], 0.01) for k in range(4)
        ]
        assert np.allclose(model.distances([turned], 0.01, any_heading=True), np.min(each, axis=0))
        anyhow = model.score_settled([turned], any_heading=True)
        assert np.allclose(anyhow, model.score_settled([lying], any_heading=True))
    assert model.score_settled([]).shape == (0, 3)


def test_one_function_alone_is_asked_as_among_all():
    model, asked = fitted(*collection(4)), [heap("table", 40), heap("cup", 41)]
    for column, name in enumerate(model.functions_):
        alone = model.only(name)
        assert alone.functions_ == (name,) and model.functions_ != alone.functions_
        assert np.array_equal(alone.score_settled(asked)[:, 0], model.score_settled(asked)[:, column])
        assert alone.chosen_radii() == sorted(model.weights_[name])


def test_objects_that_had_other_radii_are_asked_by_those_they_had():
    model, both = fitted(*collection(6)), heap("cup", 50)
    for radius in (0.01, 0.02):
        one = {radius: both[radius]}
        assert model.score_settled([both, one])[0] == pytest.approx(model.score_settled([both])[0])
        assert model.score_settled([both, one])[1] == pytest.approx(model.score_settled([one])[0])


def test_no_cubes_are_known_where_nothing_was_learnt():
    cubes = cube_keys(RANDOM(0).uniform(-0.2, 0.2, (9, 3)), 1.0)[:1]
    matrix = counts_matrix([(cubes, np.array([3.0]))], np.empty(0, np.int64))
    assert matrix.toarray().tolist() == [[3.0]] and counts_matrix([], cubes).shape == (0, 2)


def test_files_of_earlier_versions_are_read_where_they_say_the_same():
    about = {"name": "default", "neighbors": [1, 3], "vote": True, "anchor": "centre", "counts": "raw"}
    assert rebuilt_method(about) == CUBES and rebuilt_method({"name": "x", "neighbors": [2]}).neighbors == (2,)
    with pytest.raises(ValueError):
        rebuilt_method(about | {"heading": "front"})
    assert find_cube_method("paper") is PAPER and find_cube_method(CUBES) is CUBES
    for method in ("profile", "no such"):
        with pytest.raises(InputError):
            find_cube_method(method)
    assert METHODS["profile"].run_limit.drops and PAPER.run_limit == RunLimit(to_the_end=True)
    assert all(list(radii) == sorted(radii) for radii in (PAPER.radii, METHODS["profile"].radii))


def test_models_for_scans_are_others_than_those_for_whole_objects():
    assert shipped_model() == shipped_model("fast", scans=False) != shipped_model(scans=True)
    asked = inference_model(None, None)
    assert model_for_views(asked, given=True) is asked
    assert model_for_views(asked, given=False) is inference_model(shipped_model("fast", scans=True), "fast")
    assert model_for_views(asked.only("cup"), given=False).functions_ == ("cup",)
    with pytest.raises(InputError):
        shipped_model("no such")


def test_the_paper_asks_the_nearest_of_all_at_the_best_radius_and_cubes_let_radii_vote(monkeypatch):
    members = np.array([True, True, True, False, False])
    distances = np.array([[1.0, 1.0, 1.0, 10.0, 10.0]])
    assert member_scores(distances, members, PAPER)[0] == 1 and 0.5 < member_scores(distances, members, CUBES)[0] < 1
    monkeypatch.setattr(validation, "validated_f_measure", lambda f_measure, *_: f_measure)
    measured = {0.01: 1.0, 0.02: 0.75, 0.03: 0.5}
    assert radius_weights(measured, members, PAPER, 0) == {0.01: 1.0}
    # By how far each is above one half, squared.
    assert radius_weights(measured, members, CUBES, 0) == pytest.approx({0.01: 0.8, 0.02: 0.2})


def test_trees_that_lead_nowhere_are_refused():
    whole = Forest(
        roots=np.array([0]),
        feature=np.array([0, LEAF, LEAF]),
        threshold=np.array([0.5, 0.0, 0.0]),
        below=np.array([1, 0, 0]),
        vote=np.array([0.0, 0.25, 1.0]),
    )
    whole.require_whole(1)
    assert whole.votes(np.array([[0.4], [0.6]])).tolist() == [0.25, 1.0]
    odd = {"roots": ([], [3], [-1]), "feature": ([1, LEAF, LEAF], [-2, LEAF, LEAF]), "below": ([0, 0, 0], [2, 0, 0])}
    odd |= {"threshold": ([np.nan, 0.0, 0.0], [0.5]), "vote": ([0.0, 0.0, 1.1], [0.0, -0.1, 1.0])}
    for name, values in ((name, value) for name, several in odd.items() for value in several):
        with pytest.raises(FormatError, match="trees over 1"):
            replace(whole, **{name: np.array(values, getattr(whole, name).dtype)}).require_whole(1)


def test_files_leave_out_what_follows_from_the_rest():
    """The children's places, but for trees in another order; votes of nodes that nobody ends in are 0."""
    X = RANDOM(0).uniform(size=(80, 3))
    grown = forest_from_sklearn(
        ExtraTreesClassifier(7, random_state=0).fit(X, X.sum(axis=1) + 0.3 * X[:, 0] ** 2 > 1.6)
    )
    other = replace(grown, below=np.where(grown.feature == LEAF, 0, grown.below).astype(np.int32))
    assert (grown.vote[grown.feature != LEAF] == 0).all()
    kept = forest_arrays([grown, None, other])
    assert "below_0" not in kept and "below_2" in kept
    for one, again in zip([grown, None, other], rebuilt_forests(kept, 3), strict=True):
        assert again is None or all(np.array_equal(again.arrays()[name], own) for name, own in one.arrays().items())
        assert (one is None) == (again is None)


def test_a_plain_forest_says_what_it_learnt():
    X = RANDOM(0).uniform(size=(60, 3))
    y = np.array(["cup", "none", "table"])[RANDOM(1).integers(3, size=60)]
    assert PlainForest(5, random_state=0).fit(X, y).predict(X).tolist() == y.tolist()


@pytest.mark.parametrize("indicator", [False, True])
def test_the_score_is_the_share_whose_functions_are_all_right(indicator):
    objects, sets = [clouds.mug(), clouds.plate(), clouds.mug()], [{"cup"}, set(), {"cup"}]
    as_said = (lambda labels: np.array([[int("cup" in label)] for label in labels])) if indicator else list
    model = CubeClassifier(radii=(0.02,)).fit(objects, as_said(sets))
    assert model.score(objects, as_said(sets)) == 1
    assert model.score(objects, as_said([{"cup"}, {"cup"}, set()])) == pytest.approx(1 / 3)
    assert model.score(objects, as_said([{"cup"}, {"cup"}, set()]), [2, 1, 1]) == pytest.approx(0.5)
    assert isinstance(model.predict(objects), np.ndarray if indicator else list)


@pytest.fixture(scope="module")
def in_scenes() -> FunctionClassifier:
    """Return what has learnt that shelves are high from 60 cm on, or else where a wall is beside them."""
    heights = np.linspace(0.2, 1.0, 30)
    wall = (np.arange(30) % 3 == 0).astype(float)[:, None]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(function_classifier, "TREES", 20)
        model = FunctionClassifier(radii=(0.01, 0.02), drops=40, early_drops=20)
        high = heights > 0.6
        model.fit_settled([shelves(h) for h in heights], ["high" if h else "none" for h in high], [*map(str, heights)])
        members = np.column_stack([high | (wall[:, 0] > 0)])
        return model.fit_scene_forests(wall, ["wall"], members, np.ones_like(members))


def test_what_surrounds_an_object_counts_where_it_was_learnt(in_scenes, tmp_path):
    low, wall = [shelves(0.25), shelves(0.25)], np.array([[0.0], [1.0]])
    scores = [one["high"].score for one in in_scenes.scene_memberships(low, wall)]
    assert scores[0] < 0.3 and scores[1] > scores[0] + 0.15
    save_model(in_scenes, tmp_path / "model.npz")
    for again in (load_model(tmp_path / "model.npz"), inference_model(tmp_path / "model.npz", None)):
        for model in (again, again.only("high")):
            assert [one["high"].score for one in model.scene_memberships(low, wall)] == scores
    assert in_scenes.scene_forests_.scores(np.empty((0, 60)), np.empty((0, 1))).shape == (0, 1)


@pytest.mark.parametrize("beyond", [False, True])
def test_trees_over_more_quantities_than_there_are_are_refused(in_scenes, tmp_path, beyond):
    """What surrounds objects comes after their quantities, and after it there is nothing."""
    save_model(in_scenes, tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz") as file:
        arrays = dict(file)
    last = 2 * len(NAMES)
    feature = arrays["scenes_feature_0"]
    arrays["scenes_feature_0"] = np.where(feature == -1, -1, last + beyond).astype(feature.dtype)
    np.savez(tmp_path / "other.npz", **arrays)
    with pytest.raises(InputError) if beyond else nullcontext():
        load_model(tmp_path / "other.npz")


def test_a_function_is_unsure_between_the_scores_that_were_learnt(in_scenes):
    model = SimpleNamespace(functions_=("high", "low"), unsure_ranges_={"high": (0.2, 0.9)})
    model.unsure_range = lambda name: FunctionClassifier.unsure_range(model, name)
    asked = np.array([[0.2, 0.0], [0.21, 0.0], [0.9, 0.4], [0.95, 0.41], [0.95, 0.6]])
    assert FunctionClassifier.are_uncertain(model, asked).tolist() == [False, True, False, True, False]
    rows = np.full((3, 6), np.nan, np.float32)
    assert drops_from_rows(0.02, rows).rests.shape == (0, 3)


def test_what_is_trained_reads_as_much_as_what_ships():
    """So that one's own model is asked as soon, and compared with it."""
    ships, own = load_model(), FunctionClassifier()
    assert own.run_limit == ships.run_limit and own.early_drops == ships.early_.drops and own.radii == ships.radii
    assert own.seed == ships.seed == 0 and METHODS["profile"].run_limit == ships.run_limit
    drops = [drop(clouds.mug(), "fast", [0.02], run_limit=RunLimit(drops=30))[0.02] for drop in (settle, settle_cached)]
    assert np.array_equal(drops[0].rests, drops[1].rests)


def test_an_object_is_prepared_before_drops_with_the_cache_and_without():
    """What is predicted is of prepared objects, so what is learnt has to be as well."""
    angle = np.radians(8)
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    askew = rotated_cloud(clouds.chair(), turn)
    assert prepare(askew) is not askew
    profiles = [RestingProfile(0.02, drops=20, cache=cache).transform([askew]) for cache in (True, False)]
    assert np.array_equal(*profiles)


@pytest.mark.parametrize(("early", "there"), [(0, False), (20, True), (40, False), (50, False)])
def test_there_is_an_early_answer_where_it_takes_less_than_the_whole(early, there):
    objects, labels = [shelves(height) for height in (0.3, 0.4, 0.8, 0.9)], ["none", "none", "high", "high"]
    model = FunctionClassifier(radii=(0.01, 0.02), drops=40, early_drops=early, estimator=DecisionTreeClassifier())
    assert (model.fit_settled(objects, labels, [*"abcd"]).early_ is not None) == there


@pytest.mark.parametrize("sources", [None, [*"xy"] * 20])
def test_how_sure_to_be_is_known_where_whole_sources_were_left_out(sources):
    """One label in five is wrong, so that the scores between which an answer is unsure are far apart."""
    random = RANDOM(0)
    objects = [shelves(height) for height in np.linspace(0.2, 1.0, 40)]
    labels = ["high" if (k >= 20) ^ (random.uniform() < 0.2) else "none" for k in range(40)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(function_classifier, "TREES", 20)
        model = FunctionClassifier(radii=(0.01, 0.02), drops=40, early_drops=0)
        model.fit_settled(objects, labels, [*map(str, range(40))], sources=sources)
    low, high = model.unsure_range("high")
    assert (
        (low, high) == DEFAULT_UNSURE_RANGE
        if sources is None
        else (low, high) != DEFAULT_UNSURE_RANGE and low <= DEFAULT_UNSURE_RANGE[0] < DEFAULT_UNSURE_RANGE[1] <= high
    )


def test_a_score_of_a_half_is_no_membership():
    whole, scores = SimpleNamespace(copy_groups_=group_copies([*"abc"], [""] * 3)), np.array([0.5, 0.51, 0.2])
    assert FunctionClassifier._f_measure(whole, scores, np.array([False, True, False])) == 1


def test_quantiles_quarter_turns_and_votes_by_hand():
    columns = columns_of(layer(10, 1, 0.4), RADIUS)  # side by side, so that each is a column
    assert columns.quantiles(np.arange(10.0), (0.1, 0.5, 0.9)) == [0, 4, 8]
    centers = RANDOM(0).normal(size=(5, 3))
    assert np.array_equal(quarter_turns(centers, 4), centers)
    assert np.array_equal(quarter_turns(centers, -1), quarter_turns(centers, 3))
    members = np.arange(20) < 8
    apart = np.where(members[:, None] == members, 1.0, 9.0)
    assert radius_weights({0.01: apart, 0.02: apart}, members, CUBES) == {0.01: 0.5, 0.02: 0.5}
    assert CubeHistogram().radius == SphereHistogram().radius > 0


def test_what_is_beside_a_sphere_is_not_beneath_it():
    large, small = np.array([[0.0, 0, 0.5]]), np.array([[0.0, 0.031, 0.4], [0.031, 0.0, 0.4]])
    drops = {0.01: resting_drops(0.01, small), 0.03: resting_drops(0.03, large)}
    gap = NAMES.index("gap")
    assert profiles_over([drops], (0.01, 0.03))[0, len(NAMES) + gap] == 0
    drops[0.01] = resting_drops(0.01, np.concatenate([small, [[0.01, 0.01, 0.4]]]))
    assert profiles_over([drops], (0.01, 0.03))[0, len(NAMES) + gap] == pytest.approx(0.47 - 0.39)


@pytest.mark.parametrize("rare", ["cup", "none"])
def test_one_example_of_a_side_explains_its_score_and_measures_nothing(rare):
    other = "none" if rare == "cup" else "cup"
    model = fitted([heap(rare, 0), *(heap(other, k) for k in range(1, 7))], [rare, *[other] * 6], [*"abcdefg"])
    assert model.held_out_f_measures() == {"cup": None}
    rows, score = model.neighbors(heap("cup", 9), "cup"), model.score_settled([heap("cup", 9)])[0, 0]
    assert sum(row["weight"] for row in rows if row["member"]) == pytest.approx(score, abs=1e-3)
