"""What is said of proposals: by whom, above which thresholds, and by what surrounds them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from clouds import level
from room_shapes import square_table
from sklearn.ensemble import ExtraTreesClassifier

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import Stopwatch
from spherefunc_bullet.function_model import Membership
from spherefunc_bullet.learning.cube_classifier import CubeClassifier
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import load_model, save_model
from spherefunc_bullet.learning.profiles.forest import LEAF, Forest, Screening
from spherefunc_bullet.scenes.recognition import judging
from spherefunc_bullet.scenes.recognition.judging import (
    RecognitionContext,
    classify_proposals,
    settle_parts,
    surroundings_for,
    unsure_ranges,
)
from spherefunc_bullet.scenes.recognition.proposals import CLUSTERS, POOLS, Proposal
from spherefunc_bullet.scenes.recognition.recognition import scene_object
from spherefunc_bullet.scenes.recognition.room import SCREENED, THRESHOLDS, UNSURE_RANGE, Room
from spherefunc_bullet.scenes.recognition.surroundings import NAMES
from spherefunc_bullet.settling.drops import NO_DROPS

STOOL = square_table(0.6, 0.6, 0.45)
ROOM = np.vstack([STOOL, level(2.0, 2.0, 0.0)])


class Sure(FunctionClassifier):
    """Says the same of everything."""

    functions_, radius_ = ("sittable",), {"sittable": 0.03}

    def memberships_of(self, settled, *, any_heading=False):
        return [{"sittable": Membership(member=True, score=0.45, radius=0.03)} for _ in settled]


@pytest.fixture(scope="module")
def learnt() -> FunctionClassifier:
    """Return a model that knows a function by what surrounds objects alone: the first quantity of that."""
    forest = ExtraTreesClassifier(50, random_state=0, max_features=None)
    model = FunctionClassifier("fast", radii=(0.03,), drops=20, early_drops=0, estimator=forest)
    rng = np.random.default_rng(0)
    profiles, surroundings = rng.uniform(size=(80, len(model.quantity_names()))), rng.uniform(size=(80, len(NAMES)))
    members = np.column_stack([surroundings[:, 0] > 0.5, profiles[:, 0] > 0.5])
    names = [str(row) for row in range(80)]
    model.fit_profiles(profiles, members, ("cup", "table"), names)
    return model.fit_scene_forests(surroundings, NAMES, members, np.ones_like(members)).keep(np.arange(80))


def constant_forest(vote: float) -> Forest:
    """Return a forest of one leaf."""
    leaf = {"feature": np.array([LEAF], np.int16), "threshold": np.zeros(1), "below": np.zeros(1, np.int32)}
    return Forest(roots=np.zeros(1, np.int32), vote=np.array([vote], np.float32), **leaf)


def proposal(by: str) -> Proposal:
    return Proposal(by=by, members=np.arange(len(STOOL)), support=0.0)


def test_each_kind_has_its_bar():
    context = RecognitionContext(model=Sure(radii=(0.03,), drops=20), completion=(), thresholds=THRESHOLDS)
    answer = classify_proposals(ROOM, [proposal(CLUSTERS), proposal(POOLS)], context, Stopwatch())
    assert [one.functions["sittable"].member for one in answer] == [True, False]


def test_what_surrounds_things_tells_where_it_was_learnt(learnt):
    rng = np.random.default_rng(1)
    profiles, surroundings = rng.uniform(size=(60, learnt.profiles_.shape[1])), rng.uniform(size=(60, len(NAMES)))
    scores = learnt.scene_forests_.scores(profiles, surroundings)
    has = surroundings[:, 0] > 0.5
    assert scores[has, 0].mean() > scores[~has, 0].mean() + 0.1  # by chance, the same
    assert np.array_equal(learnt.only("table").scene_forests_.scores(profiles, surroundings)[:, 0], scores[:, 1])


def test_a_model_keeps_what_it_learnt_of_surroundings(learnt, tmp_path: Path):
    save_model(learnt, tmp_path / "model.npz")
    read = load_model(tmp_path / "model.npz")
    profiles, surroundings = learnt.profiles_[:20], np.random.default_rng(1).uniform(size=(20, len(NAMES)))
    assert np.array_equal(
        read.scene_forests_.scores(profiles, surroundings), learnt.scene_forests_.scores(profiles, surroundings)
    )
    assert read.scene_forests_.names == NAMES


def test_what_has_learnt_more_things_has_learnt_no_scenes(learnt, tmp_path: Path):
    save_model(learnt, tmp_path / "model.npz")
    read = load_model(tmp_path / "model.npz")
    assert read.add_settled([{0.03: NO_DROPS}], [{"cup"}], ["more"]).scene_forests_ is None


def test_proposals_are_told_by_what_surrounds_them(learnt):
    around = surroundings_for(learnt, ROOM, np.zeros(len(ROOM), bool))
    context = RecognitionContext(model=learnt, completion=(), surroundings=around)
    (answer,) = classify_proposals(ROOM, [proposal(CLUSTERS)], context, Stopwatch())
    assert answer.functions["cup"].member  # 0.6 m long


@pytest.mark.parametrize(("threshold", "screened"), [(0.01, False), (1.5, True)])
def test_no_sphere_falls_where_surroundings_rule_out_all_functions(learnt, monkeypatch, threshold, screened):
    forests = learnt.scene_forests_
    screening = Screening(forest=constant_forest(0.5), threshold=threshold)
    monkeypatch.setattr(learnt, "scene_forests_", replace(forests, screening=screening))
    around = surroundings_for(learnt, ROOM, np.zeros(len(ROOM), bool))
    context, watch = RecognitionContext(model=learnt, completion=(), surroundings=around), Stopwatch()
    dropped = []
    monkeypatch.setattr(
        judging, "settle_parts", lambda clouds, model: dropped.extend(clouds) or settle_parts(clouds, model)
    )
    (answer,) = classify_proposals(ROOM, [proposal(CLUSTERS)], context, watch)
    assert answer.screened == screened == (not dropped)
    assert screened == all(one.score == 0 and not one.member for one in answer.functions.values())
    item = scene_object(0, ROOM, answer)
    reasons = Room(levelling=None, labels=None, objects=[item], thresholds=THRESHOLDS).reasons(item)
    assert (reasons == [SCREENED]) == screened


def test_scores_in_scans_have_a_range_of_their_own_that_is_unsure(learnt, monkeypatch):
    assert unsure_ranges(learnt) == dict.fromkeys(learnt.functions_, UNSURE_RANGE)
    monkeypatch.setattr(learnt, "scene_forests_", None)
    assert unsure_ranges(learnt) == {name: learnt.unsure_range(name) for name in learnt.functions_}
    assert unsure_ranges(CubeClassifier()) == {}


def test_a_model_keeps_its_screening(learnt, monkeypatch, tmp_path: Path):
    screening = Screening(forest=constant_forest(0.25), threshold=0.2)
    monkeypatch.setattr(learnt, "scene_forests_", replace(learnt.scene_forests_, screening=screening))
    save_model(learnt, tmp_path / "model.npz")
    read, few = load_model(tmp_path / "model.npz").scene_forests_.screening, np.zeros((3, len(NAMES)))
    assert read.threshold == 0.2 and read.forest.votes(few).tolist() == [0.25] * 3 and read.passes(few).all()


def test_models_of_other_surroundings_are_refused_and_of_none_have_none(learnt, monkeypatch):
    wall = np.zeros(len(ROOM), bool)
    assert surroundings_for(Sure(), ROOM, wall) is None
    monkeypatch.setattr("spherefunc_bullet.scenes.recognition.judging.NAMES", ("other",))
    with pytest.raises(InputError, match="other surroundings"):
        surroundings_for(learnt, ROOM, wall)
