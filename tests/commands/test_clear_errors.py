"""Wrong calls in Python get one clear line, not what numpy, scikit-learn or a loop without end would say."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest
from sklearn.exceptions import NotFittedError

import spherefunc_bullet as sf
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.model_file import inference_model, shipped_model

POINTS = np.random.default_rng(0).random((200, 3)) * 0.1


def refused(call, kind=InputError) -> str:
    with pytest.raises(kind) as error:
        call()
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize("kind", [sf.FunctionClassifier, sf.CubeClassifier])
def test_a_model_that_has_not_learnt_is_not_saved(tmp_path, kind):
    assert kind.__name__ in refused(lambda: sf.save_model(kind("fast"), tmp_path / "model.npz"), NotFittedError)
    assert not (tmp_path / "model.npz").exists()


@pytest.mark.parametrize("kind", [sf.FunctionClassifier, sf.CubeClassifier])
@pytest.mark.parametrize("labels", [["cup", None], [["cup"], [None]], [None, "cup"], None, ["cup", float("nan")]])
def test_labels_that_are_none(labels, kind):
    assert "labels: expected functions' names" in refused(lambda: kind("fast").fit([POINTS, POINTS], labels))


@pytest.mark.parametrize("model", [shipped_model("fast"), inference_model(None, "fast")])
def test_a_model_that_is_given_is_of_one_backend(model):
    asked = refused(lambda: sf.classify(POINTS, backend="fast,bullet", model=model))
    assert "backend 'fast,bullet': expected one" in asked


@pytest.mark.parametrize("call", [lambda name: sf.classify(POINTS, backend=name), sf.load_model, sf.shipped_model])
def test_a_backend_that_is_none_is_answered_with_those_there_are(call):
    asked = (lambda: sf.load_model(backend="Bullet")) if call is sf.load_model else (lambda: call("Bullet"))
    assert "backend 'Bullet': expected one of bullet, fast" in refused(asked)


@cache
def shipped() -> dict:
    """Return the arrays of the model that ships."""
    with np.load(shipped_model()) as file:
        return dict(file)


def asking(path, **about):
    """Write the model that ships, which asks for something else."""
    about = json.dumps(json.loads(str(shipped()["about"])) | about)
    np.savez(path, **shipped() | {"about": np.array(about)})
    return path


@pytest.mark.parametrize("read", [sf.load_model, lambda path: inference_model(path, None)])
@pytest.mark.slow
def test_a_model_that_asks_for_too_much_is_refused(tmp_path, read):
    about = json.loads(str(shipped()["about"]))
    many = about["method"] | {"drops": 10**9}
    changes = [{"radii": [1e-7, 0.01, 0.03]}, {"radii": [0.005, 0.01, float("nan")]}, {"radii": [0.01] * 1000}]
    changes += [{"radii": []}, {"method": many}, {"early": about["early"] | {"method": many}}]
    changes += [{"method": about["method"] | {"drops": 0}}]
    for number, change in enumerate(changes):
        path = asking(tmp_path / f"model{number}.npz", **change)
        message = refused(lambda path=path: read(path))
        assert message.startswith(str(path)) and ("drops" in message or "radii" in message)


def test_a_model_that_could_not_be_read_back_is_not_written(tmp_path):
    model = sf.load_model()
    model.drops = 10**9
    refused(lambda: sf.save_model(model, tmp_path / "model.npz"))
    assert not (tmp_path / "model.npz").exists()
