"""What falls over when it is put down has no function, whatever spheres say that were dropped on it held still."""

from __future__ import annotations

import json

import clouds
import numpy as np
import pytest
import trimesh
from objects_to_scan import slab_on_posts

import spherefunc_bullet as sf
from spherefunc_bullet.classification import FALLS_OVER
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.commands.command_line import main
from spherefunc_bullet.compare.evaluation.impaired import apply_stability_check
from spherefunc_bullet.compare.evaluation.protocol import Labels, Split
from spherefunc_bullet.compare.evaluation.readings import ProfileFeatures, UseChecks
from spherefunc_bullet.learning.cube_classifier import CubeClassifier
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.scenes.impairment.harmless import other_legs
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.settling.records import passed
from spherefunc_bullet.settling.settling import falls_over, stands_safely

TABLE = (1.2, 0.8, 0.74)


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))


def cloud_of(mesh: trimesh.Trimesh) -> Cloud:
    return cloud_from_mesh(mesh.vertices, mesh.faces, "object")


def turned(mesh: trimesh.Trimesh, degrees: float) -> trimesh.Trimesh:
    return mesh.copy().apply_transform(trimesh.transformations.rotation_matrix(np.radians(degrees), [0, 1, 0]))


def one_sided() -> trimesh.Trimesh:
    """Return a table whose legs all stand below one half of its top, which is level."""
    table = slab_on_posts(*TABLE)
    legs = table.vertices[:, 2] < TABLE[2] - 0.041
    legs |= np.abs(table.vertices[:, 2] - TABLE[2]) < 1e-9  # and where legs end in the top
    corner = np.abs(table.vertices[:, 0]) < TABLE[0] / 2 - 0.01
    table.vertices[legs & corner & (table.vertices[:, 0] > 0), 0] -= 0.7
    return table


@pytest.mark.parametrize(
    ("degrees", "falls"), [(0, False), (5, False), (15, False), (25, True), (60, True), (80, False), (90, False)]
)
def test_a_table_that_leans_falls_on_its_feet_or_its_side(degrees, falls):
    """It turns by as much as it leans, or by what it lacks of lying on its side."""
    assert falls_over(cloud_of(turned(slab_on_posts(*TABLE), degrees))) == falls


def test_what_stands_safely_never_falls():
    """The quick answer, against the slow one, on blocks that lean more and more."""
    quick, slow = [], []
    for offset in np.linspace(0, 0.2, 41):
        block = trimesh.creation.box((0.2, 0.2, 0.4))
        block.vertices[block.vertices[:, 2] > 0, 0] += 2 * offset
        cloud = cloud_of(block)
        quick.append(stands_safely(cloud))
        slow.append(falls_over(cloud))
    assert not np.logical_and(quick, slow).any()
    assert sum(quick) >= 17 and slow == sorted(slow) and 19 <= sum(slow) <= 21  # the weight acts beyond the foot at 0.1


def test_of_points_and_of_sheets_nobody_knows():
    leaning = cloud_of(turned(slab_on_posts(*TABLE), 40))
    assert falls_over(leaning) and not falls_over(Cloud(leaning.points, "points"))
    square = np.array([[0, 0, 0.0], [0.5, 0, 0.3], [0.5, 0.5, 0.3], [0, 0.5, 0]])
    assert not falls_over(cloud_from_mesh(square, np.array([[0, 1, 2], [0, 2, 3]]), "sheet"))


def test_a_table_that_falls_over_is_none_with_the_reason(tmp_path, monkeypatch, capsys):
    mesh = one_sided()
    answer, by_points = sf.classify([mesh, cloud_of(mesh).points])
    assert not answer.functions and not answer.unsure and set(answer.scores.values()) == {0.0}
    assert answer.reasons[0] == FALLS_OVER and answer.reasons[1].startswith("table")
    assert by_points.functions == {"table"} and FALLS_OVER not in by_points.reasons
    path = tmp_path / "one_sided.ply"
    mesh.export(path)
    monkeypatch.setattr("sys.argv", ["spherefunc", "classify", str(path), "--explain", "--json"])
    for _ in range(2):  # anew, and as it was kept
        with pytest.raises(SystemExit) as stop:
            main()
        (row,) = json.loads(capsys.readouterr().out)
        assert not stop.value.code and row["reasons"][0] == FALLS_OVER and not row["unsure"]
        assert [(result["member"], result["score"]) for result in row["functions"].values()] == [(False, 0.0)] * 3
        assert row["nearest"] and not any(row["quantities"].values())


def test_the_estimator_says_the_same():
    model = load_model(shipped_model("fast"))
    stood, fallen = model.predict_proba([slab_on_posts(*TABLE), one_sided()])
    assert stood.max() > 0.9 and fallen.max() == 0


def test_cubes_are_read_as_the_paper_reads_them():
    objects, labels = [slab_on_posts(*TABLE), clouds.mug()] * 2, [{"table"}, {"cup"}] * 2
    model = CubeClassifier(radii=(0.03,), cache=False).fit(objects, labels)
    assert model.predict([one_sided()]) == [frozenset({"table"})]


def test_an_evaluation_scores_what_falls_over_with_nothing():
    labels = Labels(
        functions=("table",),
        members=np.array([[True], [False]] * 4),
        also=np.zeros((8, 1), bool),
        groups=np.array(["all"] * 8),
    )
    profiles = np.repeat(np.arange(2.0), 1)[None].T[[0, 1] * 4] * np.ones((1, 2))
    classifier = FunctionClassifier(radii=(0.01,))
    checks = UseChecks(fallen=np.arange(8) == 4, uses=(passed,) * 8)
    asked = ProfileFeatures(profiles=profiles, labels=labels, classifier=classifier, checks=checks)
    said = asked.trial([Split(np.arange(4), np.arange(4, 8))])
    assert said.scores[0] == 0 and said.scores[2] > 0.5 > said.scores[[1, 3]].max()
    [put_down], [held] = apply_stability_check(asked, [[Split(np.arange(4), np.arange(4, 8))]])
    assert put_down.ravel().tolist() == [False, False, True, False]
    assert held.ravel().tolist() == [True, False, True, False]


def seat_beside(height: float) -> Specimen:
    """Return a stool that has grown together with a box of a height beside it, metres."""
    beside = trimesh.creation.box((0.4, 0.5, height))
    beside.apply_translation([0.46, 0, height / 2])
    return Specimen(cloud_of(trimesh.util.concatenate([slab_on_posts(0.5, 0.5, 0.45), beside])), "sittable")


@pytest.mark.slow
@pytest.mark.parametrize(("height", "stands"), [(0.3, True), (1.2, False)])
def test_new_legs_on_which_a_seat_would_fall_are_no_harmless_change(height, stands):
    """They are below the seat alone, and what is left of a high box beside it is heavier than the seat."""
    made = [other_legs(seat_beside(height), np.random.default_rng(seed)) for seed in range(6)]
    assert [one is not None for one in made] == [stands] * 6
