"""What is said of proposals: by whom, above which thresholds, and by what surrounds them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from clouds import level
from room_shapes import square_table
from sklearn.ensemble import ExtraTreesClassifier

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import Stopwatch
from spherefunc_bullet.function_model import Membership
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import load_model, save_model
from spherefunc_bullet.scenes.recognition.judging import RecognitionContext, classify_proposals, surroundings_for
from spherefunc_bullet.scenes.recognition.proposals import CLUSTERS, POOLS, Proposal
from spherefunc_bullet.scenes.recognition.room import THRESHOLDS
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


def test_models_of_other_surroundings_are_refused_and_of_none_have_none(learnt, monkeypatch):
    wall = np.zeros(len(ROOM), bool)
    assert surroundings_for(Sure(), ROOM, wall) is None
    monkeypatch.setattr("spherefunc_bullet.scenes.recognition.judging.NAMES", ("other",))
    with pytest.raises(InputError, match="other surroundings"):
        surroundings_for(learnt, ROOM, wall)
