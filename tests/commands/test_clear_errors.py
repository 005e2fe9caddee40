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


SETTINGS = sf.DropSettings(radius=0.01)
CLOUD = sf.as_cloud(POINTS)
IMAGE, CAMERA = np.full((48, 64), 2.0), [[50, 0, 32], [0, 50, 24], [0, 0, 1]]
Histogram = sf.SphereHistogram
WRONG_CALLS = [
    ("radius: expected a finite number of more than 0, got '2cm'", lambda: sf.DropSettings(radius="2cm")),
    ("radius: expected a finite number of more than 0, got True", lambda: sf.DropSettings(radius=True)),
    ("max_drops: expected a whole number of at least 1", lambda: sf.DropSettings(radius=0.01, max_drops=2.5)),
    ("max_drops: expected at least 1 and at most 1e+18", lambda: sf.DropSettings(radius=0.01, max_drops=10**400)),
    ("voxel_size: expected a finite number", lambda: sf.FusionSettings(voxel_size="2cm")),
    ("smoothing: expected a whole number", lambda: sf.FusionSettings(smoothing=2.5)),
    ("x: expected a finite number of at least -1e+06", lambda: sf.Placement(x="1")),
    ("z: expected at least 0 and at most 1e+06, got -1", lambda: sf.Placement(z=-1)),
    ("backend 'fast': cores: expected a whole number", lambda: sf.make_simulator("fast", cores="2")),
    ("backend 'bullet': voxel_size: expected a finite number", lambda: sf.make_simulator("bullet", voxel_size="1cm")),
    ("backend None: expected one of bullet, fast", lambda: sf.make_simulator(None)),
    ("expected one of bullet, fast", lambda: sf.make_simulator(type(sf.make_simulator("fast")))),
    ("cores: expected with a backend's name", lambda: sf.make_simulator(sf.make_simulator("fast"), cores=1)),
    ("settings: expected a DropSettings, got 0.01", lambda: sf.make_simulator("fast").drop(CLOUD, 0.01)),
    ("settings: expected a DropSettings, got 0.01", lambda: sf.make_simulator("bullet").drop(CLOUD, 0.01)),
    ("cloud: expected a Cloud, got ndarray", lambda: sf.make_simulator("fast").drop(POINTS, SETTINGS)),
    ("cloud: expected a Cloud, got ndarray", lambda: sf.make_simulator("bullet").drop(POINTS, SETTINGS)),
    ("seed: expected a whole number", lambda: sf.make_simulator("fast").drop(sf.as_cloud(POINTS), SETTINGS, None)),
    ("seed: expected at least 0", lambda: sf.make_simulator("bullet").drop(sf.as_cloud(POINTS), SETTINGS, -1)),
    ("radii: expected a finite number", lambda: Histogram(radius="2cm").fit([POINTS])),
    ("diameters: expected more than 0, got 0", lambda: Histogram(diameters=0).fit([POINTS])),
    ("backend None: expected", lambda: sf.RestingProfile(simulator=None).transform([POINTS])),
    ("drops: expected a whole number", lambda: sf.RestingProfile(drops=2.5).transform([POINTS])),
    ("data set: expected a folder", lambda: sf.open_dataset("")),
    ("data set: expected a folder", lambda: sf.open_dataset(None)),
    ("model: expected a path", lambda: sf.classify(POINTS, model=3)),
    ("model: expected a fitted classifier", lambda: sf.classify(POINTS, model=sf.FunctionClassifier())),
    ("backend 3: expected a name", lambda: sf.classify(POINTS, backend=3)),
    ("expected several objects in a list", lambda: sf.FunctionClassifier().fit(None, ["cup"])),
    ("expected several objects in a list", lambda: sf.FunctionClassifier().fit({"cup": POINTS}, ["cup"])),
    ("expected as many labels as objects", lambda: sf.FunctionClassifier().fit([POINTS], ["cup", "none"])),
    ("n_neighbors: expected a whole number", lambda: sf.InverseDistanceClassifier("3").fit(np.eye(2), [0, 1])),
    ("backend='foo': expected with prove=True", lambda: sf.find_places(POINTS, backend="foo")),
    ("scores=: expected of one object", lambda: sf.find_places(POINTS, scores={}, scan=True)),
    ("depth_scale=: expected with a depth image", lambda: sf.find_objects(POINTS, depth_scale=5000)),
    (r'up="3": expected auto, x, y, z', lambda: sf.find_objects(POINTS, up=3)),
    ("settings: expected a Segmentation, got 3", lambda: sf.find_objects(POINTS, settings=3)),
    ("fusion: expected a FusionSettings", lambda: sf.SceneFusion(fusion={"voxel_size": 0.01})),
    ("color=: expected with a depth image", lambda: sf.find_objects(POINTS, color="color.png")),
    ("depth_scale=: expected with a depth image of whole numbers",
     lambda: sf.find_objects(IMAGE, intrinsics=CAMERA, depth_scale=5000)),
    ("depth_scale=: expected a finite number",
     lambda: sf.find_objects(IMAGE.astype(int), intrinsics=CAMERA, depth_scale="5000")),
    ("is it transposed?", lambda: sf.find_objects(IMAGE, intrinsics=np.transpose(CAMERA))),
    ("expected intrinsics as a camera matrix (3, 3)", lambda: sf.find_objects(IMAGE, intrinsics=[["a"]])),
    ("depth: fx: expected more than 0", lambda: sf.find_objects(IMAGE, intrinsics=[[0, 0, 9], [0, 9, 9], [0, 0, 1]])),
]  # fmt: skip


@pytest.mark.parametrize(("says", "call"), WRONG_CALLS)
def test_wrong_arguments(says, call, tmp_path, monkeypatch):
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path))
    assert says in refused(call)


WRONG_PARAMETERS = [
    {"radii": "2cm"}, {"radii": 0.02}, {"radii": ("2cm",)}, {"radii": ()}, {"radii": (0.01, float("nan"))},
    {"simulator": None}, {"seed": None}, {"seed": "a"}, {"drops": 2.5}, {"drops": None}, {"early_drops": -1},
    {"early_drops": 2.5}, {"method": None}, {"method": "profile"},
]  # fmt: skip


@pytest.mark.parametrize("cache", [True, False])
@pytest.mark.parametrize("wrong", WRONG_PARAMETERS, ids=str)
def test_parameters_of_estimators_are_refused_when_they_are_fitted(wrong, cache, tmp_path, monkeypatch):
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path))
    kind, [(name, _)] = (sf.CubeClassifier if "method" in wrong else sf.FunctionClassifier), wrong.items()
    model = kind(**{"radii": (0.03,), "cache": cache} | wrong)
    said = refused(lambda: model.fit([POINTS, 2 * POINTS], ["cup", "none"]))
    assert said.startswith({"simulator": "backend"}.get(name, name)) and "expected" in said


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
