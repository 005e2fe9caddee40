"""The arithmetic of learning by itself: parts on a table, evidence of cubes, sources, lines of votes, levels."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import clouds
import numpy as np
import pytest
from sklearn.base import BaseEstimator, ClassifierMixin
from test_classifier import collection, fitted, heap
from test_doubts import dropped as shelves
from test_resting_profile import RADIUS, layer, quantities

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.function_model import Membership
from spherefunc_bullet.learning import function_classifier
from spherefunc_bullet.learning.any_pose import PoseFunctions, best_poses
from spherefunc_bullet.learning.cube_arrays import rebuilt_method
from spherefunc_bullet.learning.cube_classifier import CubeClassifier
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.histogram import counts_matrix, cube_keys, quarter_turns
from spherefunc_bullet.learning.method import CUBES, METHODS, PAPER, find_cube_method
from spherefunc_bullet.learning.model_file import (
    inference_model,
    load_model,
    model_for_views,
    save_model,
    shipped_model,
)
from spherefunc_bullet.learning.profiles.calibration import (
    ERROR,
    UNCERTAIN_MARGIN,
    WIDEST,
    CopyGroups,
    calibrated,
    calibration_line,
    group_copies,
    held_out_votes,
    log_odds,
    unsure_band,
)
from spherefunc_bullet.learning.profiles.columns import columns_of, outline_of
from spherefunc_bullet.learning.profiles.on_top import CELL, LARGEST, LEAST, SPARED, count_parts, objects_on_table
from spherefunc_bullet.learning.profiles.quantities import NAMES, Ranks, evenness
from spherefunc_bullet.learning.reasons.cubes import cube_evidence, side_weights, strongest_cubes
from spherefunc_bullet.settling.drops import RunLimit, drops_from_rows, resting_drops

RANDOM = np.random.default_rng


def square(corner: tuple[float, float], side: float, z: float = 0.0) -> np.ndarray:
    """Return points a third of a cell apart."""
    steps = np.arange(CELL / 6, side, CELL / 3)
    return np.array([[corner[0] + x, corner[1] + y, z] for x in steps for y in steps])


@pytest.mark.parametrize(("gap", "parts"), [(0, 1), (1, 2), (2, 2)])
def test_parts_are_apart_where_a_cell_between_them_is_empty(gap, parts):
    two = [square((k * (2 + gap) * CELL, 0), 2 * CELL)[:, :2] for k in range(2)]
    assert count_parts(np.concatenate(two), 1.0) == parts
    assert count_parts(np.concatenate([two[0], two[0] + 2 * CELL]), 1.0) == 1  # corner to corner


def test_of_nothing_there_are_no_parts_and_large_ones_are_furniture():
    assert count_parts(np.empty((0, 2)), 1.0) == 0
    both = np.concatenate([square((0, 0), 2 * CELL), square((1, 1), 4 * CELL)])[:, :2]
    assert [count_parts(both, cells * CELL**2) for cells in (3.5, 4.5, 15.5, 16.5)] == [0, 1, 1, 2]


def on_table(*objects: np.ndarray, count: int = 400) -> int:
    """Return how many objects stand on a plate of 80 cm at 0.7 m, on which spheres rest side by side."""
    rests = layer(20, 20, 0.7)[:count]
    drops = {2 * RADIUS: resting_drops(2 * RADIUS, rests[:2] + 1), RADIUS: resting_drops(RADIUS, rests)}
    return objects_on_table(Cloud(np.concatenate([layer(20, 20, 0.7 - RADIUS), *objects])), drops)


def test_what_stands_on_a_table_rises_from_it_inside_its_edge():
    box = square((0.3, 0.3), 0.1)
    assert on_table() == 0 and on_table(box + [0, 0, 0.7 + 1.2 * LEAST]) == 1
    assert on_table(box + [0, 0, 0.7 + 0.8 * LEAST]) == 0  # of the level
    assert on_table(*(box + [x, x, 0.75] for x in (-0.2, 0, 0.2))) == 3
    edge = square((0, 0.3), 0.5 * SPARED) + [0, 0, 0.75]
    assert on_table(edge) == 0 and on_table(edge + [3 * SPARED, 0, 0]) == 1
    assert on_table(square((0.1, 0.1), np.sqrt(LARGEST) * 0.8 * 1.1) + [0, 0, 0.75]) == 0  # a shelf above
    assert on_table(box + [0, 0, 0.75], count=2) == 0  # hardly a sphere stays: no level


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


def test_spheres_where_nobody_had_any_speak_neither_way():
    model = fitted(*collection(3))
    asked = {radius: resting_drops(radius, one.rests + 4) for radius, one in heap("cup", 5).items()}
    cubes = cube_evidence(model, asked, "cup", model.radius_["cup"])
    new = cubes.counts > 0
    assert new.any() and not (cubes.speaks_for[new].any() or cubes.members[new].any() or cubes.others[new].any())


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
        each = [model._distances([quarter_turns(lying[0.01].rests, k)], 0.01) for k in range(4)]
        assert np.allclose(model.turned_distances([turned], 0.01), np.min(each, axis=0))
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
    assert METHODS["profile"].length.drops and PAPER.length == RunLimit(to_the_end=True)


def test_models_for_scans_are_others_than_those_for_whole_objects():
    assert shipped_model() == shipped_model("fast", scans=False) != shipped_model(scans=True)
    asked = inference_model(None, None)
    assert model_for_views(asked, given=True) is asked
    assert model_for_views(asked, given=False).functions_ == inference_model(shipped_model(scans=True), None).functions_
    assert model_for_views(asked.only("cup"), given=False).functions_ == ("cup",)
    with pytest.raises(InputError):
        shipped_model("no such")


class Memory(ClassifierMixin, BaseEstimator):
    """Says whether an object with the same first quantity was learnt, so that what was held out shows."""

    def fit(self, X, y):
        self.learnt_, self.classes_ = set(X[:, 0].tolist()), np.unique(y)
        return self

    def predict_proba(self, X):
        seen = np.array([value in self.learnt_ for value in X[:, 0].tolist()], float)
        return np.column_stack([1 - seen, seen])


def test_nothing_of_the_same_source_is_learnt_and_what_has_none_always_is():
    sources = ["b", "a", "", "b", "a", "", "b", "a"]
    copy_groups = group_copies([str(k) for k in range(8)], [""] * 8, sources)
    assert copy_groups.has_sources and copy_groups.sources.tolist() == [1, 0, -1, 1, 0, -1, 1, 0]
    members = np.array([True, False] * 4)
    quantity = np.array([0, 1, 2, 0, 1, 2, 2, 2.0])[:, None]  # by source, but for two like those of nobody
    votes = held_out_votes(Memory(), quantity, members, copy_groups, 0)
    assert np.isnan(votes).tolist() == [False, False, True, False, False, True, False, False]
    assert votes[[0, 3]].tolist() == votes[[1, 4]].tolist() == [0, 0] and votes[[6, 7]].tolist() == [1, 1]
    alone = held_out_votes(Memory(), quantity, np.array(sources) == "b", copy_groups, 0)
    assert np.isnan(alone[[0, 3, 6]]).all() and not np.isnan(alone[[1, 4, 7]]).any()  # without b's, no member is left


def test_who_comes_later_is_nobodys_copy_and_of_no_source():
    first = group_copies(["a", "b", "c"], ["", "a", "gone"], ["x", "x", ""])
    assert first.groups[0] == first.groups[1] != first.groups[2] and first.weights.tolist() == [1, 0.1, 0.1]
    assert not first.has_sources and first.sources.tolist() == [0, 0, -1]
    more = first.with_more(2)
    assert len(set(more.groups.tolist())) == 4 and more.weights[3:].tolist() == [1, 1]
    assert more.groups[:3].tolist() == first.groups.tolist() and more.sources.tolist() == [0, 0, -1, -1, -1]
    assert first.of(np.array([2, 0])).sources.tolist() == [-1, 0] and group_copies(["a"], [""]).sources is None
    two = CopyGroups(weights=np.ones(3), groups=np.arange(3), sources=np.array([0, -1, 1]))
    assert two.has_sources and not replace(two, sources=np.array([0, -1, 0])).has_sources
    together = group_copies(["one", "two"], ["gone", "gone"])
    assert together.groups[0] == together.groups[1] and together.with_more(1).sources is None


def test_bands_leave_no_more_wrong_and_sure_than_may_be():
    """Of 1,000 answers three either way; where there are fewer members than that, all of them may be missed."""
    allowed, members = int(ERROR * 1000), np.arange(1000) < 400
    scores = np.where(members, 0.9, 0.1)
    scores[: allowed + 1], scores[-allowed - 1 :] = np.linspace(0.2, 0.23, allowed + 1), np.linspace(
        0.8, 0.77, allowed + 1
    )
    low, high = unsure_band(scores, members)
    assert (scores[members] < low).sum() == (scores[~members] > high).sum() == allowed
    assert (low, high) == pytest.approx((0.23, 0.77))
    few = np.arange(1000) < allowed
    assert unsure_band(np.zeros(1000), few) == pytest.approx((0.5 - UNCERTAIN_MARGIN, 0.5 + UNCERTAIN_MARGIN))
    assert unsure_band(np.ones(1000), ~few)[1] == pytest.approx(0.5 + UNCERTAIN_MARGIN)
    assert unsure_band(np.where(members, 0.0, 1.0), members) == pytest.approx((0.5 - WIDEST, 0.5 + WIDEST))


def test_votes_that_are_probabilities_stay_and_others_come_near_them():
    random, shares = RANDOM(0), np.linspace(0.05, 0.95, 19)
    truth = np.tile(shares, 400)
    members = random.uniform(size=len(truth)) < truth
    slope, offset = calibration_line(truth, members)
    assert (slope, offset) == pytest.approx((1, 0), abs=0.1)  # thrice the error of some thousand coins
    timid = calibrated(truth, (0.5, 0.4))
    assert calibrated(timid, calibration_line(timid, members)) == pytest.approx(truth, abs=0.03)
    few = calibration_line(np.array([0.6, 0.4]), np.array([True, False]))
    assert few[1] == pytest.approx(0, abs=1e-3) and 1 < few[0] < 1.2  # two examples change little
    assert calibration_line(1 - np.array([0.6, 0.4]), np.array([True, False]))[0] < 1
    assert log_odds(np.array([0.0, 0.5, 1.0])) == pytest.approx([-np.log(99), 0, np.log(99)])
    for line in ((1e9, 0.0), (1.0, -1e9)):
        assert np.isfinite(calibrated(np.array([0.0, 0.3]), line)).all()


def stepped(step: float, columns: int = 10) -> np.ndarray:
    """Return spheres side by side, each column of them a step higher than the one before."""
    centers = layer(columns, 10, 0.4)
    centers[:, 2] += step * np.round(centers[:, 0] / (2 * RADIUS))
    return centers


def test_how_even_a_level_is_by_hand():
    """Ten steps, a tenth of the columns on each: of these eight tenths lie within eight steps."""
    step = 0.09 * RADIUS
    found = quantities(stepped(step))
    assert found["level_share"] == 1 and found["level_range"] == pytest.approx(8 * step)
    assert found["level_unevenness"] == pytest.approx(step * np.sqrt((10**2 - 1) / 12))
    assert found["level_roughness"] == pytest.approx(0, abs=1e-9)
    assert found["level_tilt"] == pytest.approx(np.degrees(np.arctan(step / (2 * RADIUS))))


@pytest.mark.parametrize(("count", "tilted"), [(5, False), (6, True)])
def test_a_plane_is_laid_through_six_spheres_or_more(count, tilted):
    slope = stepped(0.2 * RADIUS, columns=2)[:count]
    tilt, rough = evenness(columns_of(slope, RADIUS))
    assert (tilt > 1) == tilted and rough == pytest.approx(0, abs=1e-9)


def test_columns_weigh_alike_in_a_plane_however_deep():
    """A stack on one corner of a slope counts as one column, so that the plane is that of the slope's undersides."""
    slope = stepped(0.2 * RADIUS, columns=4)
    piled = np.concatenate([slope, slope[-1:] + [[0, 0, 0.0]] * 30])  # one place thirty times more
    piled[-30:, 2] += 0.3 * RADIUS
    assert evenness(columns_of(piled, RADIUS))[0] == pytest.approx(evenness(columns_of(slope, RADIUS))[0], abs=1e-6)


@pytest.mark.parametrize(("higher", "share"), [(0.3, 1.0), (1.0, 0.0)])
def test_one_deep_is_less_than_two_spheres(higher, share):
    """Spheres that lean on others, their axes nearer than one and a half radii, make columns that are deeper."""
    pairs = np.concatenate([layer(1, 3, 0.4) + [4 * k * RADIUS, 0, 0] for k in range(3)])
    leaning = pairs + [1.2 * RADIUS, 0, higher * RADIUS]
    assert quantities(np.concatenate([pairs, leaning]))["one_deep"] == share


def test_shares_of_no_drops_are_none():
    """On a single row no drop falls inside of the outline of the centres, and what is not there has no share."""
    found = quantities(layer(1, 2, 0.4))
    assert found["stays"] == found["middle_stays"] == found["level_stays"] == 0


def test_an_outline_holds_what_is_as_far_inside_as_it_says():
    corners = np.array([[0, 0], [0.6, 0], [0.6, 0.2], [0, 0.2]])
    outline = outline_of(corners, 0.05)
    assert outline.area == pytest.approx(0.12 + 1.6 * 0.05 + np.pi * 0.05**2) and outline.width == pytest.approx(0.3)
    assert outline.inside(np.array([[0.3, 0.1], [0.55, 0.1], [0.7, 0.1], [0.3, 0.0]])) == pytest.approx(
        [0.1, 0.05, -0.1, 0]
    )
    assert (outline_of(corners[:2], 0.05).inside(corners) == -np.inf).all()
    assert outline_of(corners[:2], 0.05).area == pytest.approx(1.2 * 0.05 + np.pi * 0.05**2)
    assert outline_of(corners[:1], 0.05).width == pytest.approx(0.1)


def test_ranks_are_shares_that_have_less_and_distances_their_mean_difference():
    learnt = np.column_stack([np.arange(40.0), np.repeat([0.0, 1.0], 20)])
    found = Ranks(learnt).distances(np.array([[-1.0, 0.0], [19.5, 1.0], [100, 2]]))
    first, second = (np.arange(40) + 0.5) / 40, np.repeat([0.25, 0.75], 20)
    assert found[0] == pytest.approx(0.5 * first + 0.5 * np.abs(0.25 - second))
    assert found[1, 20] == pytest.approx(0.5 * 0.5 / 40) and found[2, 39] == pytest.approx(0.5 * 0.5 / 40 + 0.125)
    assert Ranks(learnt).distances(np.empty((0, 2))).shape == (0, 40)


def test_of_equally_good_poses_the_likelier_comes_first():
    def pose(**scores: float) -> PoseFunctions:
        functions = {name: Membership(member=False, score=score, radius=0.01) for name, score in scores.items()}
        return PoseFunctions(pose=None, functions=functions)

    answers = [pose(cup=0.2, table=0.9), pose(cup=0.7, table=0.9), pose(cup=0.7, table=0.1)]
    assert best_poses(answers) == {"cup": 1, "table": 0} and best_poses([]) == {}


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
        return model.fit_in_scenes(wall, ["wall"], members, np.ones_like(members))


def test_what_surrounds_an_object_counts_where_it_was_learnt(in_scenes, tmp_path):
    low, wall = [shelves(0.25), shelves(0.25)], np.array([[0.0], [1.0]])
    scores = [one["high"].score for one in in_scenes.memberships_in_scene(low, wall)]
    assert scores[0] < 0.3 and scores[1] > scores[0] + 0.15
    save_model(in_scenes, tmp_path / "model.npz")
    for again in (load_model(tmp_path / "model.npz"), inference_model(tmp_path / "model.npz", None)):
        for model in (again, again.only("high")):
            assert [one["high"].score for one in model.memberships_in_scene(low, wall)] == scores
    assert in_scenes.in_scenes_.scores(np.empty((0, 60)), np.empty((0, 1))).shape == (0, 1)


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
    model = SimpleNamespace(functions_=("high", "low"), bands_={"high": (0.2, 0.9)})
    model.band = lambda name: FunctionClassifier.band(model, name)
    asked = np.array([[0.2, 0.0], [0.21, 0.0], [0.9, 0.4], [0.95, 0.41], [0.95, 0.6]])
    assert FunctionClassifier.are_doubtful(model, asked).tolist() == [False, True, False, True, False]
    rows = np.full((3, 6), np.nan, np.float32)
    assert drops_from_rows(0.02, rows).rests.shape == (0, 3)
