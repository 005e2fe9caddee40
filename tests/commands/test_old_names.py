"""Public names of the version before: they work for one version more, and say what they are called now."""

from __future__ import annotations

import clouds
import numpy as np
import pytest

from spherefunc_bullet.batch.batch import Batch
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.scenes.arrangements.together import Together
from spherefunc_bullet.settling.cached_runs import DropConfig

RADIUS = 0.02


def shelf(height: float) -> np.ndarray:
    """Return drops as rows of numbers, all of which stay at a height."""
    x, y = (0.04 * part.ravel() for part in np.mgrid[:6, :5])
    return np.column_stack([x, y, x, y, np.full(30, height), np.zeros(30)])


def test_drops_may_still_be_arrays():
    model = FunctionClassifier(radii=(RADIUS,), drops=30, early_drops=0)
    rows = [{RADIUS: shelf(height)} for height in (0.2, 0.3, 0.7, 0.8)]
    with pytest.warns(DeprecationWarning, match="Drops"):
        model.fit_settled(rows, ["none", "none", "high", "high"], list("abcd"))
    with pytest.warns(DeprecationWarning):
        scores = model.score_settled(rows)
    assert scores[2] > 0.5 > scores[0]
    with pytest.warns(DeprecationWarning, match="copy_groups_"):
        assert model.kin_ is model.copy_groups_


def test_methods_keep_their_old_names():
    with pytest.warns(DeprecationWarning, match="cached"):
        assert clouds.mug().once("seven", lambda: 7) == 7
    found = Together(objects=(), drop=None, radius=0.01, notes=(), seconds=0.0)
    with pytest.warns(DeprecationWarning, match="objects"):
        assert found.things == ()


def test_what_a_batch_is_made_of_keeps_its_old_names():
    with pytest.warns(DeprecationWarning, match="cached_runs.DropConfig"):
        from spherefunc_bullet.settling.dropping import Dropping
    config = Dropping(simulator="fast", radii=(RADIUS,))
    with pytest.warns(DeprecationWarning, match="drop_config"):
        batch = Batch(dataset=None, dropping=config, folder=None)
    assert isinstance(config, DropConfig) and batch.drop_config is config


def test_attributes_of_a_model_keep_their_old_names():
    model = FunctionClassifier()
    model.calibrations_, model.familiar_distance_ = [(1.0, 0.0)], 0.1
    with pytest.warns(DeprecationWarning, match="calibrations_"):
        assert model.lines_ is model.calibrations_
    with pytest.warns(DeprecationWarning, match="familiar_distance_"):
        assert model.familiar_ == 0.1
    with pytest.warns(DeprecationWarning, match="run_limit"):
        assert model.length == model.run_limit
