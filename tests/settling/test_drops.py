"""Drops as rows: what becomes of each, what is walled in, thinned points, forests as arrays, and reasons in words."""

from __future__ import annotations

from dataclasses import replace

import clouds
import numpy as np
import pytest
from sklearn.base import clone
from sklearn.ensemble import ExtraTreesClassifier

from spherefunc_bullet.clouds.cloud import THINNED, Cloud
from spherefunc_bullet.clouds.preparation import headed, turned_cloud
from spherefunc_bullet.formats import FormatError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import inference_model, load_model, save_model
from spherefunc_bullet.learning.profiles.forest import forest_from_sklearn
from spherefunc_bullet.learning.profiles.trees import PlainForest
from spherefunc_bullet.learning.profiles.words import deciding_quantities, nearest, sentences
from spherefunc_bullet.settling.drops import NOT_SETTLED, RunLimit, drops_from_rows
from spherefunc_bullet.settling.enclosure import walled_in
from spherefunc_bullet.settling.settling import HANDHELD, settle
from spherefunc_bullet.simulator import DropSettings, make_simulator

RADIUS = 0.01


def ring(gap: float) -> np.ndarray:
    """Return a round wall of 4 cm about the axis, 8 cm high, open towards +x as wide as said (metres)."""
    angle, z = np.meshgrid(np.linspace(-np.pi, np.pi, 200), np.arange(0, 0.08, 0.002))
    x, y = 0.04 * np.cos(angle).ravel(), 0.04 * np.sin(angle).ravel()
    open_ = (x > 0) & (np.abs(y) < gap / 2)
    return np.column_stack([x, y, z.ravel()])[~open_]


@pytest.mark.parametrize(("gap", "held"), [(0.0, True), (0.01, True), (0.03, False)])
def test_a_gap_that_a_sphere_gets_through_is_one(gap, held):
    centers = np.array([[0, 0, 0.04], [0.01, -0.01, 0.03]])
    assert walled_in(ring(gap), centers, RADIUS).tolist() == [held, held]


def test_over_the_wall_nothing_is_in_the_way():
    assert walled_in(ring(0.0), np.array([[0, 0, 0.1]]), RADIUS).tolist() == [False]


def test_every_drop_has_a_row():
    drops = settle(clouds.mug(), "fast", [RADIUS], 0, RunLimit(drops=60))[RADIUS]
    cloud, angle = headed(clouds.mug())
    settings = DropSettings(radius=RADIUS, miss_limit=60, max_drops=60, even_columns=True)
    again = make_simulator("fast").drop(cloud, settings, 0)
    assert len(drops) == 60 and drops.radius == RADIUS and drops.provenance == again.provenance
    own = drops.turned(angle)
    assert np.allclose(own.rests, again.centers, atol=1e-6)
    assert np.allclose(own.places, again.columns, atol=1e-6)
    assert np.array_equal(drops.outcomes, again.outcomes) and drops.settled.sum() == len(drops.rests)


@pytest.mark.parametrize("length", [RunLimit(drops=60), RunLimit()])
def test_what_is_kept_of_drops_is_all_of_them(length):
    drops = settle(clouds.mug(), "fast", [RADIUS], 0, length)[RADIUS]
    again = drops_from_rows(RADIUS, drops.rows(), drops.outcomes)
    for name in ("places", "rests", "walled_in", "outcomes"):
        assert np.array_equal(getattr(again, name), getattr(drops, name), equal_nan=True), name
    assert again.losses_known == drops.losses_known == (length.drops is not None)
    old = drops_from_rows(RADIUS, drops.rows())  # of a file that knows no outcomes
    assert np.array_equal(old.settled, drops.settled) and set(old.outcomes[~old.settled]) <= {NOT_SETTLED}


@pytest.mark.parametrize("degrees", [30, 90, -120])
def test_drops_turn_with_their_object(degrees):
    """Columns and rests alike, counterclockwise; what stays or not, and how high, does not change."""
    drops, angle = settle(clouds.mug(), "fast", [RADIUS], 0, RunLimit(drops=40))[RADIUS], np.radians(degrees)
    other, way = drops.turned(angle), np.exp(1j * angle)
    for before, after in ((drops.places, other.places), (drops.rests, other.rests)):
        assert before.shape == after.shape and before.dtype == after.dtype
        assert np.allclose(after[:, 0] + 1j * after[:, 1], way * (before[:, 0] + 1j * before[:, 1]), atol=1e-6)
        assert np.array_equal(before[:, 2:], after[:, 2:])
    assert other.outcomes is drops.outcomes and drops.turned(0.0) is drops
    sheet = clouds.cloud(clouds.plate(0.5, 0.2).points, name="sheet")
    askew = settle(turned_cloud(sheet, angle), "fast", [RADIUS], 0, RunLimit(drops=40))[RADIUS]
    ends = Cloud(askew.rests + [0, 0, 0.1]).bounds  # where the object is, not where it was turned to
    assert (np.ptp(ends[:, :2], axis=0) <= turned_cloud(sheet, angle).size[:2] + 2 * RADIUS).all()


def test_a_shorter_run_is_the_beginning_of_a_longer_one():
    short, long = (settle(clouds.mug(), "fast", [RADIUS], 0, RunLimit(drops=n))[RADIUS] for n in (30, 90))
    first = long.first(30)
    assert np.array_equal(short.places, first.places) and np.array_equal(short.rests, first.rests)
    assert np.array_equal(short.outcomes, first.outcomes)


def test_fine_spheres_fall_on_what_a_hand_holds():
    assert len(settle(clouds.mug(), "fast", [0.005], 0, RunLimit(drops=20))[0.005]) == 20
    table = clouds.table()
    assert table.size.max() > HANDHELD
    assert settle(table, "fast", [0.005], 0, RunLimit(drops=20))[0.005].outcomes.size == 0


@pytest.mark.parametrize("side", [0.004, 0.005, 0.012, 0.02])
def test_thinned_points_are_the_same_in_any_order(side):
    cloud = clouds.mug()
    mixed = Cloud(np.random.default_rng(0).permutation(cloud.points))
    one, two = (np.unique(some.thinned(side), axis=0) for some in (cloud, mixed))
    assert np.array_equal(one, two)
    if side < THINNED:
        assert len(one) == len(np.unique(cloud.points, axis=0))
    else:
        cell = THINNED * 2 ** int(np.log2(side / THINNED))
        assert len(np.unique(np.floor(one / cell), axis=0)) == len(one)


@pytest.fixture(scope="module")
def grown():
    random = np.random.default_rng(0)
    X = random.normal(size=(200, 7))
    return X, ExtraTreesClassifier(30, random_state=0).fit(X, X[:, 0] + X[:, 3] * X[:, 5] > 0.3)


def builder_of_another_version(*arguments):
    raise TypeError


@pytest.mark.parametrize("builder", [PlainForest._tree, builder_of_another_version])
@pytest.mark.parametrize("copied", [False, True])
def test_plain_trees_grow_as_scikit_learn_grows_them(monkeypatch, builder, copied):
    monkeypatch.setattr(PlainForest, "_tree", builder)
    rng = np.random.default_rng(0)
    X, weights = rng.normal(size=(60, 7)), rng.uniform(0.1, 1, 60)
    members = X[:, 0] > X[:, 3]
    plain = clone(PlainForest(20, random_state=3)) if copied else PlainForest(20, random_state=3)
    grown = [one.fit(X, members, sample_weight=weights) for one in (plain, ExtraTreesClassifier(20, random_state=3))]
    ours, theirs = (forest_from_sklearn(one).arrays() for one in grown)
    assert all(ours[name].tobytes() == values.tobytes() for name, values in theirs.items())
    votes, counts = zip(*((one.predict_proba(X[::-1] + 0.1), one.feature_importances_) for one in grown), strict=True)
    assert (votes[0] == votes[1]).all() and (counts[0] == counts[1]).all()


def test_a_forest_as_arrays_votes_as_it_grew(grown):
    X, trees = grown
    forest, asked = forest_from_sklearn(trees), np.random.default_rng(1).normal(size=(50, 7))
    forest.require_whole(7)
    assert np.allclose(forest.votes(asked), trees.predict_proba(asked)[:, 1], atol=1e-6)


@pytest.mark.parametrize("name", ["feature", "below", "vote", "threshold", "roots"])
def test_a_forest_that_was_tampered_with_is_refused(grown, name):
    forest = forest_from_sklearn(grown[1])
    broken = getattr(forest, name).copy()
    broken[0] = {"feature": 7, "below": 0, "vote": 2, "threshold": np.nan, "roots": -1}[name]
    with pytest.raises(FormatError, match="expected trees"):
        type(forest)(**forest.arrays() | {name: broken}).require_whole(7)


def test_trees_that_begin_after_the_last_node_and_no_trees_at_all_are_refused(grown):
    forest = forest_from_sklearn(grown[1])
    beyond = np.append(forest.roots[:-1], len(forest.feature)).astype(forest.roots.dtype)
    for roots in (beyond, forest.roots[:0]):
        with pytest.raises(FormatError, match="expected trees"):
            type(forest)(**forest.arrays() | {"roots": roots}).require_whole(7)


@pytest.fixture(scope="module")
def model():
    shapes = [clouds.mug, clouds.bin_, clouds.plate, clouds.chair, clouds.table, clouds.groove]
    many = [shape() for shape in shapes for _ in range(2)]
    labels = ["cup", "none", "none", "sittable", "table", "none"]
    return FunctionClassifier(radii=(0.01, 0.02), drops=60).fit(many, [label for label in labels for _ in range(2)])


@pytest.mark.slow
def test_a_model_by_profiles_is_read_back_whole(model, tmp_path):
    save_model(model, tmp_path / "model.npz")
    again = load_model(tmp_path / "model.npz", "fast")
    assert (
        again.run_limit == model.run_limit
        and again.radius_ == model.radius_
        and again.familiar_distance_ == model.familiar_distance_
    )
    asked = [clouds.mug(), clouds.chair()]
    assert again.predict_proba(asked).tobytes() == model.predict_proba(asked).tobytes()
    more = [clouds.table()], ["table"]
    assert (
        again.partial_fit(*more).predict_proba(asked).tobytes()
        == model.partial_fit(*more).predict_proba(asked).tobytes()
    )


def test_reasons_name_what_was_met(model):
    settled = settle(clouds.mug(), "fast", model.radii, 0, model.run_limit)
    reading = model.reading_of(settled)
    (said,) = sentences(reading)
    assert said.startswith("cup ") and "walls on every side" in said
    decided = deciding_quantities(reading, "cup")
    assert decided and decided[0]["share"] > 0 and {row["radius"] for row in decided} <= set(model.radii)
    assert nearest(reading)[0]["functions"] == ["cup"]
    assert not [doubt for doubt in model.doubts(reading) if "unlike" in doubt]


def test_what_is_like_nothing_learnt_is_unsure(model):
    strange = settle(clouds.mug(0.15, 1.5), "fast", model.radii, 0, model.run_limit)
    reading = model.reading_of(strange)
    assert any("unlike all" in doubt for doubt in model.doubts(reading))
    close = replace(reading, scores=np.array([0.55, 0.0, 0.0]))
    assert any("uncertain" in doubt for doubt in model.doubts(close))


def test_what_is_sure_after_the_first_drops_is_dropped_on_no_more(model):
    lengths = []

    def drop(length):
        lengths.append(length.drops)
        return settle(clouds.mug(), "fast", model.radii, 0, length)

    settled = model.read(drop).drops
    assert lengths == [model.early_.drops] and all(len(drops) == model.early_.drops for drops in settled.values())
    assert model.score_settled([settled]).tobytes() == model.early_.score_settled([settled]).tobytes()
    assert model.only("cup").read(drop).drops.keys() == settled.keys()


def test_what_is_strange_is_dropped_on_to_the_end(model):
    def drop(length):
        return settle(clouds.mug(0.15, 1.5), "fast", model.radii, 0, length)

    settled = model.read(drop).drops
    assert {len(drops) for drops in settled.values()} == {model.drops}
    both = [settled, drop(model.early_.run_limit)]  # each is read by what has learnt as many drops
    one_by_one = [model.score_settled([settled])[0], model.early_.score_settled(both[1:])[0]]
    assert model.score_settled(both).tolist() == np.array(one_by_one).tolist()


def test_early_answers_can_be_left_out():
    shapes, labels = [clouds.mug(), clouds.plate()] * 2, [["cup"], []] * 2
    model = FunctionClassifier(radii=(0.02,), drops=60, early_drops=0).fit(shapes, labels)
    assert model.early_ is None
    assert len(model.read(lambda length: settle(shapes[0], "fast", (0.02,), 0, length)).drops[0.02]) == 60


def test_early_answers_are_kept_with_a_model(model, tmp_path):
    save_model(model, tmp_path / "model.npz")
    for again in (load_model(tmp_path / "model.npz"), inference_model(tmp_path / "model.npz", None)):
        first = settle(clouds.chair(), "fast", model.radii, 0, model.early_.run_limit)
        assert again.early_.run_limit == model.early_.run_limit
        assert again.score_settled([first]).tobytes() == model.score_settled([first]).tobytes()
