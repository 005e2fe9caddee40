"""What an object may be given as: every form of the same points gives the same cloud."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from clouds import mug

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.conversion import as_cloud, as_clouds, holds_several, without_table
from spherefunc_bullet.errors import InputError


@pytest.fixture(scope="module")
def points() -> np.ndarray:
    return mug().points[:1900]


def structured(points: np.ndarray) -> np.ndarray:
    """Return points as ROS has them: named fields, an intensity among them."""
    rows = np.zeros(len(points), [("x", "f8"), ("intensity", "f4"), ("y", "f8"), ("z", "f8")])
    rows["x"], rows["y"], rows["z"] = points.T
    return rows


def masked(points: np.ndarray) -> np.ma.MaskedArray:
    """Return points with as many masked ones between them, which lie far away."""
    both = np.repeat(points, 2, axis=0)
    both[1::2] = 1e6
    mask = np.zeros(both.shape, bool)
    mask[1::2, 0] = True
    return np.ma.array(both, mask=mask)


FORMS = {
    "colours": lambda points: np.hstack([points, np.full((len(points), 3), 0.5)]),
    "intensity": lambda points: np.hstack([points, np.full((len(points), 1), 7.0)]),
    "image": lambda points: points.reshape(38, 50, 3),
    "structured": structured,
    "structured image": lambda points: structured(points).reshape(38, 50),
    "list": lambda points: points.tolist(),
    "float32": lambda points: points.astype(np.float32),
}


@pytest.mark.parametrize("form", FORMS)
def test_every_form_is_the_same_cloud(points, form):
    given = FORMS[form](points)
    assert not holds_several(given)
    assert np.allclose(as_cloud(given).points, as_cloud(points).points, atol=1e-6)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_masked_points_are_left_out(points):
    assert np.allclose(as_cloud(masked(points)).points, as_cloud(points).points)


def test_vertices_and_faces_are_one_mesh():
    vertices = np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.3, 0], [0, 0, 0.3]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    assert not holds_several((vertices, faces))
    cloud = as_cloud((vertices, faces))
    assert cloud.mesh is not None and len(cloud.mesh.faces) == 4
    assert cloud.size == pytest.approx([0.3, 0.3, 0.3], abs=1e-9)


@pytest.mark.parametrize(
    "form", [list, lambda rows: [tuple(row) for row in rows], lambda rows: tuple(map(tuple, rows))]
)
def test_vertices_and_faces_as_lists_are_one_mesh(form):
    box = trimesh.creation.box((0.4, 0.4, 0.7))
    vertices, faces = box.vertices.tolist(), box.faces.tolist()
    assert not holds_several((form(vertices), form(faces))) and not holds_several((box.vertices, form(faces)))
    mesh = as_cloud((form(vertices), form(faces))).mesh
    assert mesh is not None and len(mesh.faces) == len(faces)


def test_two_lists_of_points_are_two_objects():
    metres, millimetres = [[0.1, 0.0, 0.0], [0.0, 0.1, 0.3]], [[100, 0, 0], [0, 100, 300]]
    for pair in ((metres, metres), (millimetres, millimetres), (metres, millimetres), (metres, metres[:1] + [[0.0]])):
        assert holds_several(pair)


def test_a_column_of_objects_is_taken_as_a_list_and_a_table_is_refused(tmp_path, points):
    np.save(tmp_path / "a.npy", points)
    (cloud,) = as_clouds(np.array([[str(tmp_path / "a.npy")]]))
    assert cloud.name == "a.npy"
    with pytest.raises(InputError, match="several objects in a list.*a table of 3 columns"):
        as_clouds(points)


def test_a_data_frame_is_read_by_the_names_of_its_columns(points):
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"intensity": 9.0, "z": points[:, 2], "x": points[:, 0], "y": points[:, 1]})
    assert np.array_equal(as_cloud(frame).points, as_cloud(points).points)


@pytest.mark.parametrize("gap", [None, float("nan")])
def test_a_gap_in_a_column_is_named(gap, points):
    with pytest.raises(InputError, match=f"object 1: expected a path, .* got {gap}"):
        sf.classify([points, gap])


def test_a_home_folder_is_expanded(points, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    np.savez(tmp_path / "mug.npz", points=points)
    assert as_cloud("~/mug.npz").name == "mug.npz"


def test_lists_dicts_and_generators_hold_several(points):
    several = [points, points], (points, points), {"a": points}, iter([points]), {"a": points}.values(), {"a.ply"}
    assert all(map(holds_several, several))


COLUMNS = {
    "texts": np.array,
    "rows of one": lambda paths: np.array(paths)[:, None],
    "paths": lambda paths: np.array([Path(path) for path in paths]),
    "series": lambda paths: pytest.importorskip("pandas").Series(paths),
    "frame": lambda paths: pytest.importorskip("pandas").DataFrame({"file": paths}),
}


@pytest.mark.parametrize("form", COLUMNS)
def test_a_column_of_paths_is_several_objects(form, points, tmp_path):
    paths = [str(tmp_path / f"{name}.npy") for name in "ab"]
    for path in paths:
        np.save(path, points)
    column = COLUMNS[form](paths)
    assert holds_several(without_table(column)) and [cloud.name for cloud in as_clouds(column)] == ["a.npy", "b.npy"]
    assert [answer.name for answer in sf.classify(column)] == ["a.npy", "b.npy"]
    assert sf.RestingProfile(0.02, drops=5).transform(column).shape[0] == 2


@pytest.mark.parametrize("wrong", [np.zeros((20, 5)), np.zeros((3, 20, 2)), np.zeros(9), np.zeros(4, [("a", "f8")])])
def test_other_shapes_are_one_line(wrong):
    with pytest.raises(InputError, match="expected"):
        as_cloud(wrong)


@pytest.mark.parametrize("faces", [np.array([[0, 1, 2, 3]]), np.array([[0.0, 1.0, 2.7]]), np.arange(8)])
def test_faces_that_are_no_triangles_are_refused(points, faces):
    """PyVista writes each face with the number of its corners; quads would be read as other triangles."""
    with pytest.raises(InputError, match=r"cloud: expected triangles \(M, 3\) of integers, got faces"):
        as_cloud(SimpleNamespace(points=points, faces=faces))


def test_a_scene_of_clouds_is_read_as_its_points(points):
    scene = trimesh.Scene([trimesh.PointCloud(points)])
    assert np.allclose(as_cloud(scene).points, as_cloud(points).points)


def test_repeated_points_change_no_distances(points):
    """Programs repeat points to fill arrays of a fixed size, one point or all."""
    cloud = as_cloud(points)
    for filled in (np.vstack([points, np.repeat(points[:1], len(points) + 100, axis=0)]), np.vstack([points] * 7)):
        more = as_cloud(filled)
        assert more.to_neighbour(6) == pytest.approx(cloud.to_neighbour(6), rel=0.05)
        assert len(more.distinct) == len(np.unique(points, axis=0)) and len(more) == len(filled)
