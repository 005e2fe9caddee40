"""What people write in Python: anything that holds an object goes in, an answer or a clear refusal comes out."""

from __future__ import annotations

import gc
import json
import pickle
import re
import runpy
import shutil
import warnings

import clouds
import numpy as np
import pytest
import trimesh
from checkout import ROOT
from commands import spherefunc

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.clouds.conversion import as_cloud
from spherefunc_bullet.formats.files import cache_home
from spherefunc_bullet.learning.model_file import cached_model, shipped_model

README = ROOT / "docs" / "python.md"
TURNED = {"y": ((0, 2, 1), (1, 1, -1)), "-y": ((0, 2, 1), (1, -1, 1)), "-z": ((0, 1, 2), (1, -1, -1))}


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def mug_mesh() -> trimesh.Trimesh:
    """Return a cup without a lid, walls 4 mm thick."""
    wall = trimesh.creation.annulus(0.036, 0.04, 0.1)
    wall.apply_translation([0, 0, 0.05])
    floor = trimesh.creation.cylinder(0.04, 0.004)
    floor.apply_translation([0, 0, 0.002])
    return trimesh.util.concatenate([wall, floor])


def test_an_array_in_millimetres_with_y_up_is_told_with_a_reason():
    order, sign = TURNED["y"]
    answer = sf.classify(1000 * clouds.mug().points[:, order] * sign, units="mm", up="y")
    assert answer.functions == {"cup"} and not answer.unsure
    assert answer.scores["cup"] > 0.9 and answer.reasons[0].startswith("cup")


@pytest.mark.parametrize("up", TURNED)
def test_an_axis_may_point_down(up):
    points = clouds.chair().points
    order, sign = TURNED[up]
    cloud = sf.cloud_from_points(points[:, order] * sign, up=up)
    # Turned back exactly: signs and places of numbers alone.
    assert np.allclose(cloud.points, sf.cloud_from_points(points).points, atol=1e-12)


def test_everything_that_holds_an_object_is_the_same_object(mug_mesh, tmp_path):
    path = tmp_path / "mug.ply"
    mug_mesh.export(path)
    asked = [path, str(path), mug_mesh, trimesh.Scene([mug_mesh]), sf.load_cloud(path)]
    answers = sf.classify(asked)
    assert [answer.functions for answer in answers] == [{"cup"}] * 5
    points = clouds.mug().points
    several = sf.classify([points, points.tolist(), trimesh.PointCloud(points)], explain=False)
    assert len({tuple(answer.scores.values()) for answer in several}) == 1 and len(several) == 3
    as_it_stands = sf.classify(sf.Cloud(points), explain=False)  # not moved, so spheres fall a little aside
    assert as_it_stands.scores == pytest.approx(several[0].scores, abs=0.02)
    assert sf.classify(points.tolist()).scores == several[0].scores and sf.classify([]) == []


def test_open3d_objects_are_taken(mug_mesh):
    geometry = pytest.importorskip("open3d").geometry
    utility = pytest.importorskip("open3d").utility
    mesh = geometry.TriangleMesh(utility.Vector3dVector(mug_mesh.vertices), utility.Vector3iVector(mug_mesh.faces))
    assert np.array_equal(as_cloud(mesh).points, as_cloud(mug_mesh).points)
    points = clouds.mug().points
    assert len(as_cloud(geometry.PointCloud(utility.Vector3dVector(points)))) == len(points)


def test_a_unit_that_is_forgotten_is_not_passed_over_in_silence():
    points = clouds.mug(height=0.12).points
    with pytest.raises(sf.InputError, match="120 m wide; in millimetres"):
        sf.classify(1000 * points)
    with pytest.warns(UserWarning, match="80 m wide; in millimetres"):
        as_cloud(800 * clouds.mug(height=0.1).points)
    with pytest.raises(sf.InputError, match="is the unit right"):
        sf.classify(points, units="mm")
    with pytest.raises(sf.InputError, match="350 m wide; in millimetres"):
        sf.cloud_from_points(3500 * clouds.mug(height=0.1).points)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        as_cloud(points)


def test_a_mesh_in_millimetres_is_refused_for_its_size(mug_mesh):
    with pytest.raises(sf.InputError, match=r"99.9 m wide; in millimetres"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        as_cloud(mug_mesh.apply_scale(1000 * 0.999))


@pytest.mark.parametrize("odd", [3, object(), np.zeros((20, 4)), {"points": 1}, None, "nothing.ply"])
def test_what_holds_no_object_is_refused(odd):
    with pytest.raises(sf.InputError, match="expected"):
        sf.classify(odd)
    with pytest.raises(sf.InputError, match="metres with z up"):
        as_cloud(clouds.mug(), units="mm")


def test_a_sensors_gaps_are_left_out_and_said():
    points = np.vstack([clouds.mug().points, np.full((9, 3), np.nan)])
    with pytest.warns(UserWarning, match="dropped 9"):
        assert sf.classify(points).functions == {"cup"}


def test_one_function_alone_is_asked_for():
    whole, alone = (sf.classify(clouds.mug(), function=name) for name in (None, "table"))
    assert alone.scores == {"table": whole.scores["table"]} and alone.functions == frozenset()
    with pytest.raises(sf.InputError, match="cup, sittable, table"):
        sf.classify(clouds.mug(), function="shelf")


@pytest.mark.slow
def test_the_model_that_ships_is_loaded_without_arguments():
    assert sf.load_model().functions_ == sf.load_model(sf.shipped_model(), "fast").functions_
    assert sf.load_model() is not sf.load_model()  # who learns more changes nobody else's


def test_objects_of_a_table_top_are_found():
    top = clouds.level(0.8, 0.6, 0.0)
    mugs = [clouds.mug().points + [x, 0.0, 0.004] for x in (-0.2, 0.2)]
    targets = sf.find_objects(np.vstack([top, *mugs]), up="z", units="m")
    cups = [target for target in targets if "cup" in target.functions]
    assert len(cups) == 2
    for target, x in zip(sorted(cups, key=lambda cup: cup.box.center[0]), (-0.2, 0.2), strict=True):
        assert set(target.scores) == {"cup", "sittable", "table"}
        # The scan is thinned to voxels of 1 cm, and a box may lose one at its edge.
        assert abs(target.box.center[0] - x) < 0.02 and abs(target.points[:, 0].mean() - x) < 0.02
        assert target.corners.shape == (8, 3)
        assert target.reasons[0].startswith("cup") and not target.unsure and not target.inferred
        for place in (target.places[0], pickle.loads(pickle.dumps(target)).places[0]):
            assert place.kind == "pour" and abs(place.position[0] - x) < 0.02


def test_a_depth_image_is_a_scan(tmp_path):
    camera = sf.Intrinsics(width=160, height=120, fx=130, fy=130, cx=79.5, cy=59.5)
    depth = np.full((120, 160), 1000, np.uint16)  # a level top, seen from a metre above, and a box on it
    depth[40:80, 60:100] = 800
    path = tmp_path / "depth.npy"
    np.save(path, depth)
    matrix = [[130, 0, 79.5], [0, 130, 59.5], [0, 0, 1]]
    seen = [sf.find_objects(each, intrinsics=camera, up="-z") for each in (path, depth)]
    seen.append(sf.find_objects(depth / 1000, intrinsics=matrix, up="-z", inferred=True))
    corners = [[each.corners for each in found] for found in seen]
    assert corners[0] and np.allclose(corners[0], corners[1]) and np.allclose(corners[0], corners[2])
    with pytest.raises(sf.InputError, match="expected a camera of 160 x 100"):
        sf.find_objects(depth[:100], intrinsics=camera)


def test_spheres_fall_once_on_the_same_cloud(monkeypatch):
    drops = []
    simulator = sf.make_simulator("fast")
    dropped = type(simulator).drop

    def counted(self, *arguments):
        drops.append(arguments)
        return dropped(self, *arguments)

    monkeypatch.setattr(type(simulator), "drop", counted)
    objects, labels = [as_cloud(each.points) for each in (clouds.mug(), clouds.chair())], ["cup", "table"]
    first = sf.FunctionClassifier(radii=(0.01,), drops=30).fit(objects, labels)
    once = len(drops)
    again = sf.FunctionClassifier(radii=(0.01,), drops=30).fit([each.points for each in objects], labels)
    assert len(drops) == once > 0 and (cache_home() / "settled").is_dir()
    assert again.profiles_.tobytes() == first.profiles_.tobytes()
    anew = sf.FunctionClassifier(radii=(0.01,), drops=30, cache=False).fit(objects, labels)
    assert len(drops) == once + 2 and anew.profiles_.tobytes() == first.profiles_.tobytes()


class CountingMug:
    """A mug that counts the clouds in memory whenever its points are read."""

    def __init__(self):
        self.counts = []

    def __array__(self, dtype=None, copy=None) -> np.ndarray:
        self.counts.append(sum(isinstance(each, Cloud) for each in gc.get_objects()))
        return clouds.mug().points


@pytest.mark.slow
def test_a_library_is_read_object_by_object():
    mug, labels = CountingMug(), ["cup", "none"] * 3
    model = sf.FunctionClassifier(radii=(0.01,), drops=30).fit([mug] * 6, labels)
    model.predict([mug] * 6)
    sf.SphereHistogram(radius=0.01).fit_transform([mug] * 6)
    answers = sf.classify([mug] * 6, cache=True)
    assert len(mug.counts) == 24 and max(mug.counts) < min(mug.counts) + 6  # one cloud, and what is derived from it
    assert np.array_equal(answers[0].cloud.points, as_cloud(mug).points) and answers[0].name == "object 0"
    assert sf.FunctionClassifier(radii=(0.01,), drops=30).fit(iter([mug] * 6), iter(labels)).names_ == model.names_


@pytest.mark.slow
def test_python_by_example_runs_as_it_stands(tmp_path, monkeypatch, capsys):
    """Its Python, in a folder with one scan and one model."""
    text = README.read_text(encoding="utf-8")
    snippets = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert snippets
    room = np.vstack([clouds.level(0.8, 0.6, 0.0), clouds.mug().points + [0, 0, 0.004]])
    np.savetxt(tmp_path / "room.xyz", room)
    np.savez(tmp_path / "chair.npz", points=clouds.chair().points)
    (tmp_path / "example.py").write_text("\n".join(snippets))
    monkeypatch.chdir(tmp_path)
    runpy.run_path("example.py", run_name="__main__")
    printed = capsys.readouterr().out
    assert printed.startswith("frozenset({'cup'})") and printed.count("frozenset({'table'})") >= 2


def test_an_answer_is_what_the_command_prints(tmp_path):
    path = tmp_path / "mug.npz"
    np.savez(path, points=clouds.mug().points)
    answer = sf.classify(path)
    (row,) = json.loads(spherefunc("classify", path, "--explain", "--json").stdout)
    assert answer.to_dict(explain=True) | {"seconds": 0} == row | {"seconds": 0}
    assert set(row) - set(answer.to_dict()) == {"quantities", "nearest"}
    for reason, decided in zip(answer.deciding["cup"], row["quantities"]["cup"], strict=True):
        assert (reason.function, reason.quantity, reason.value) == ("cup", decided["quantity"], decided["value"])
        assert reason.effect == decided["share"] and reason.unit in ("m", "m2", "share", "")


def test_objects_are_asked_for_one_by_one():
    order = []

    def each():
        for shape in (clouds.mug(), clouds.plate()):
            order.append(shape.name)
            yield shape

    class Watched(sf.FunctionClassifier):
        def read(self, drop):
            order.append("read")
            return super().read(drop)

    model = Watched(radii=(0.01,), drops=10).fit([clouds.mug(), clouds.plate()], ["cup", "table"])
    assert len(sf.classify(each(), model=model)) == 2 and order == ["mug", "read", "plate", "read"]


def test_equal_answers_are_one_in_a_set():
    answers = [sf.classify(shape) for shape in (clouds.mug(), clouds.mug(), clouds.plate())]
    assert answers[0] == answers[1] != answers[2] and len(set(answers)) == 2


@pytest.mark.parametrize("function", [None, "cup"])
def test_a_kept_answer_is_read_without_its_model(tmp_path, function):
    path = tmp_path / "model.npz"
    shutil.copy(shipped_model("fast"), path)
    answer = sf.classify(clouds.mug(), model=path, function=function)
    sent = pickle.dumps(answer)
    assert pickle.loads(sent).to_dict() == answer.to_dict()
    path.unlink()
    cached_model.cache_clear()  # as in a later process
    again = pickle.loads(pickle.dumps(pickle.loads(sent)))
    assert again == answer and again.reasons and again.functions == {"cup"}
    for ask in (again.to_dict, again.plot, lambda: again.deciding):
        with pytest.raises(sf.InputError, match="model.npz: expected a file, found none"):
            ask()


@pytest.mark.slow
def test_several_backends_are_asked_at_once(tmp_path):
    path = tmp_path / "mug.npz"
    np.savez(path, points=clouds.mug().points)
    answer = sf.classify(path, backend="fast,bullet")
    (row,) = json.loads(spherefunc("classify", path, "--backend", "fast,bullet", "--json").stdout)
    assert answer.to_dict() | {"seconds": 0} == row | {"seconds": 0}
    for name, opinion in row["backends"].items():
        alone = sf.classify(path, backend=name)
        assert {function: one["score"] for function, one in opinion.items()} == alone.scores
    assert row["functions"] == row["backends"]["fast"] and set(row["backends"]) == {"fast", "bullet"}


def test_an_answer_shows_itself_in_a_notebook():
    answer = sf.classify(clouds.mug())
    (axes,) = answer.plot().axes
    assert axes.get_title() == "cup" and len(axes.collections) == 2  # the object and its spheres
    (bar,), (note,) = axes.lines, axes.figure.texts
    (length,) = re.findall(r"spheres of radius .* Black bar: (\d+) cm", note.get_text(), re.S)
    assert np.ptp(bar.get_data_3d()[0]) == pytest.approx(float(length) / 100)
    shown = answer._repr_html_()
    assert shown.startswith("<img") and "cup 1.00" in shown and len(shown) < 100_000


def test_an_answer_is_about_the_object_as_it_was(mug_mesh):
    """Robots use one array for one object after another."""
    points = as_cloud(mug_mesh).points.copy()
    places = [place.position for place in sf.classify(points.copy()).places]
    answers = [sf.classify(points), sf.classify(mug_mesh)]
    points[:] = 0
    mug_mesh.apply_scale(1000)
    assert all(answer.functions == {"cup"} and len(answer.places) == len(places) == 1 for answer in answers)
    assert np.allclose(answers[0].places[0].position, places[0])


def test_repeated_points_change_no_answer(mug_mesh):
    points = as_cloud(mug_mesh).points
    filled = np.vstack([points, np.repeat(points[:1], len(points) + 100, axis=0)])
    whole, answer = sf.classify(points), sf.classify(filled)
    assert answer.functions == whole.functions == {"cup"} and answer.unsure == whole.unsure
    assert [place.kind for place in sf.find_places(filled)] == ["pour"]
