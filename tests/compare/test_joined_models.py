"""Two models for scans whose trees vote together: each tree has one vote, whatever quantities its model reads."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.ensemble import ExtraTreesClassifier

from spherefunc_bullet.compare.rooms.scan_model import join
from spherefunc_bullet.compare.rooms.screening import with_screening
from spherefunc_bullet.compare.rooms.training_examples import TrainingExample
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import load_model, save_model
from spherefunc_bullet.scenes.recognition.room import LOWEST_THRESHOLD

FUNCTIONS, AROUND = ("cup", "table"), ("height", "free")
TREES = ExtraTreesClassifier(10, min_samples_leaf=2, random_state=0)


def fitted(quantities: int, seed: int) -> FunctionClassifier:
    """Return a model that has learnt random objects, by its first so many quantities."""
    rng = np.random.default_rng(seed)
    model = FunctionClassifier("fast", radii=(0.01, 0.03), drops=40, early_drops=0, estimator=TREES)
    model.quantities = model.quantities[:quantities]
    members = rng.random((60, 2)) < 0.5
    profiles = rng.random((60, 2 * quantities)) + members[:, :1]
    model.fit_profiles(profiles, members, FUNCTIONS, [f"{number}" for number in range(60)])
    model.fit_scene_forests(rng.random((60, 2)) + members[:, 1:], AROUND, members, np.ones_like(members))
    return model.keep(np.arange(60))


def test_every_tree_has_one_vote_also_those_that_read_fewer_quantities(tmp_path):
    own, earlier = fitted(6, seed=1), fitted(4, seed=2)
    X, around = np.random.default_rng(3).random((20, 12)), np.random.default_rng(4).random((20, 2))
    fewer = X.reshape(20, 2, 6)[:, :, :4].reshape(20, 8)
    alone = [own.votes(X), earlier.votes(fewer)]
    both = [[one.votes(np.hstack([X, around])) for one in own.scene_forests_.forests]]
    both += [[one.votes(np.hstack([fewer, around])) for one in earlier.scene_forests_.forests]]
    joined = join(own, earlier)
    np.testing.assert_allclose(joined.votes(X), np.mean(alone, axis=0), atol=1e-6)  # votes are kept in single precision
    of_scans = [one.votes(np.hstack([X, around])) for one in joined.scene_forests_.forests]
    np.testing.assert_allclose(of_scans, np.mean(both, axis=0), atol=1e-6)
    save_model(joined, tmp_path / "joined.npz")
    np.testing.assert_array_equal(load_model(tmp_path / "joined.npz").votes(X), joined.votes(X))


def test_calibration_is_the_mean_of_both():
    own, earlier = fitted(4, seed=1), fitted(4, seed=2)
    expected = np.mean([own.calibrations_, earlier.calibrations_], axis=0)
    np.testing.assert_allclose(join(own, earlier).calibrations_, expected)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"radii": (0.01, 0.02)}, "radii"),
        ({"functions_": ("cup", "sittable")}, "functions"),
        ({"scene_forests_": None}, "surroundings"),
    ],
)
def test_models_that_do_not_fit_together_are_refused(changed, message):
    own, earlier = fitted(4, seed=1), fitted(4, seed=2)
    vars(earlier).update(changed)
    with pytest.raises(InputError, match=message):
        join(own, earlier)


def test_an_earlier_model_that_reads_more_is_refused():
    with pytest.raises(InputError, match="lacks"):
        join(fitted(4, seed=1), fitted(6, seed=2))


def test_screening_rejects_what_the_model_gives_no_function():
    rng = np.random.default_rng(0)
    how = {"name": "", "source": "", "functions": frozenset(), "settled": {}}
    around = rng.uniform(0, 2, (400, 2))
    examples = [TrainingExample(surroundings=row, **how) for row in around]
    model = fitted(4, seed=1)
    model = with_screening(model, [examples[:200], examples[200:300], examples[300:]], ["one", "two", "three"])
    claimed = (model.scene_forests_.scores(np.zeros((400, 8)), around) > LOWEST_THRESHOLD).any(axis=1)
    passed = model.scene_forests_.screening.passes(around)
    assert 50 < claimed.sum() < 350
    assert passed[claimed].all() and passed[~claimed].mean() < 0.5
