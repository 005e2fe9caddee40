"""A cup from which water runs out is none, though spheres stay in it; a crack between two parts is no hole."""

from __future__ import annotations

import json

import clouds
import numpy as np
import pytest
import trimesh

import spherefunc_bullet as sf
from spherefunc_bullet.classification import HOLE_SEEN, LEAKS, OPEN
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.clouds.water import Water, leaks, share_under_water, waters_of
from spherefunc_bullet.commands.command_line import main
from spherefunc_bullet.compare.evaluation.impaired import apply_stability_check
from spherefunc_bullet.compare.evaluation.protocol import Labels, Split
from spherefunc_bullet.compare.evaluation.readings import ProfileFeatures, UseChecks
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import load_model, shipped_model

RADIUS, HEIGHT, WALL = 0.04, 0.1, 0.004  # metres


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))


def cup(hole: float = 0.0, turn: float = 0.0) -> trimesh.Trimesh:
    """Return a cup turned on a lathe, with a hole of some diameter in its floor, metres, turned about z."""
    inner = RADIUS - WALL
    profile = [(hole / 2, 0), (RADIUS, 0), (RADIUS, HEIGHT), (inner, HEIGHT), (inner, WALL), (hole / 2, WALL)]
    mesh = trimesh.creation.revolve(np.array([*profile, profile[0]] if hole else profile), sections=48)
    return mesh.apply_transform(trimesh.transformations.rotation_matrix(turn, [0, 0, 1]))


def slit_cup(width: float) -> trimesh.Trimesh:
    """Return a cup of sheets whose wall is open over a width from the floor to the brim, metres."""
    gap = width / RADIUS
    angles = np.linspace(gap / 2, 2 * np.pi - gap / 2, 65)
    ring = RADIUS * np.column_stack([np.cos(angles), np.sin(angles)])
    corners = np.vstack([np.column_stack([ring, np.full(65, z)]) for z in (0.0, HEIGHT)] + [np.zeros((1, 3))])
    wall = [(k, k + 1, 65 + k) for k in range(64)] + [(k + 1, 66 + k, 65 + k) for k in range(64)]
    floor = [(130, k, k + 1) for k in range(64)] + [(130, 64, 0)]
    return trimesh.Trimesh(corners, np.array(wall + floor), process=False)


def parted_cup(crack: float) -> trimesh.Trimesh:
    """Return a cup whose floor is a part of its own, a crack narrower than its wall, metres."""
    wall = trimesh.creation.annulus(RADIUS - WALL, RADIUS, HEIGHT)
    floor = trimesh.creation.cylinder(RADIUS - WALL - crack, WALL)
    wall.apply_translation([0, 0, HEIGHT / 2])
    floor.apply_translation([0, 0, WALL / 2])
    return trimesh.util.concatenate([wall, floor])


def cloud_of(mesh: trimesh.Trimesh) -> Cloud:
    return cloud_from_mesh(mesh.vertices, mesh.faces, "object")


def filled(count: int = 150, bottom: float = WALL, top: float = HEIGHT) -> np.ndarray:
    """Return centres of spheres of 5 mm all over the inside of the cup."""
    rng = np.random.default_rng(0)
    across = (RADIUS - WALL - 0.005) * np.sqrt(rng.random(count))
    angles = rng.uniform(0, 2 * np.pi, count)
    heights = rng.uniform(bottom + 0.005, top, count)
    return np.column_stack([across * np.cos(angles), across * np.sin(angles), heights])


@pytest.mark.parametrize("turn", np.linspace(0.0, 0.3, 5))
@pytest.mark.parametrize(("hole", "runs_out"), [(0.0, False), (0.006, True), (0.009, True)])
def test_a_hole_of_six_millimetres_empties_a_cup_whichever_way_it_faces(hole, runs_out, turn):
    assert leaks(cloud_of(cup(hole, turn)), filled()) == runs_out


@pytest.mark.parametrize("crack", [0.0001, 0.0005, 0.001])
@pytest.mark.parametrize("turn", [0.0, 0.1, 0.2])
def test_a_crack_between_parts_is_no_hole(crack, turn):
    mesh = parted_cup(crack).apply_transform(trimesh.transformations.rotation_matrix(turn, [0, 0, 1]))
    assert not leaks(cloud_of(mesh), filled())


def test_a_slit_too_narrow_for_the_spheres_empties_a_cup():
    assert leaks(cloud_of(slit_cup(0.008)), filled(bottom=0.0)) and not leaks(cloud_of(slit_cup(0.0)), filled(bottom=0))


def test_spheres_on_a_saucer_do_not_count():
    """Twice as many lie on a plate around the cup as in it."""
    plate = trimesh.creation.cylinder(0.09, 0.003)
    mesh = trimesh.util.concatenate([cup(), plate.apply_translation([0, 0, -0.0015])])
    angles = np.linspace(0, 2 * np.pi, 300)
    beside = np.column_stack([0.07 * np.cos(angles), 0.07 * np.sin(angles), np.full(300, 0.005)])
    assert not leaks(cloud_of(mesh), np.vstack([filled(), beside]))


def test_in_a_straight_vessel_water_rises_evenly_and_covers_what_is_below_its_level():
    cells = np.argwhere(np.ones((2, 2, 4), bool)) + [5, 5, 1]
    row = np.column_stack([np.full((7, 2), 5), np.arange(7)])  # up to the layer above the water and one more
    centers = (np.concatenate([row, row + [9, 0, 0], row - [9, 0, 0]]) + 0.5) * 0.01  # and beside it
    assert share_under_water(np.zeros(3), 0.01, cells, centers) == pytest.approx(5 / 7)
    assert share_under_water(np.zeros(3), 0.01, cells[:0], centers) == 0
    water = Water(np.array([0, 0, 0.1]), 0.01, cells, brim=5, opening=cells[-1:, :2], extra=0.0)
    assert water.volume == pytest.approx(16e-6) and water.brim_height == pytest.approx(0.15)
    assert np.array(water.levels(4)) == pytest.approx(np.transpose([[0, 4, 8, 12, 16], [0.11, 0.12, 0.13, 0.14, 0.15]]))


def test_water_is_open_where_nothing_lies_above_it():
    roof = trimesh.creation.box((RADIUS, 2 * RADIUS, 0.002)).apply_translation([RADIUS / 2, 0, HEIGHT + 0.03])
    (water,) = waters_of(cloud_of(trimesh.util.concatenate([cup(), roof])))
    (free,) = waters_of(cloud_of(cup()))
    assert (water.origin[0] + water.opening[:, 0] * water.cell < water.cell).all()
    assert len(water.opening) * water.cell**2 == pytest.approx(len(free.opening) * free.cell**2 / 2, rel=0.1)


@pytest.mark.parametrize(("scale", "bodies"), [(0.5, 2), (0.3, 1)])
def test_what_holds_a_twentieth_of_the_largest_is_no_puddle(scale, bodies):
    beside = cup().apply_scale(scale).apply_translation([0.08, 0, 0])
    waters = waters_of(cloud_of(trimesh.util.concatenate([beside, cup()])))
    inside = np.pi * (RADIUS - WALL) ** 2 * (HEIGHT - WALL) * scale ** (3 * np.arange(bodies))
    assert [water.volume for water in waters] == pytest.approx(inside.tolist(), rel=0.05)


@pytest.mark.parametrize("backend", ["fast", "bullet"])
def test_a_cup_with_a_hole_is_none_and_the_reason_says_so(backend):
    if backend == "bullet":
        pytest.importorskip("pybullet")
    holed, whole = sf.classify([cup(0.007), cup()], backend=backend)
    assert whole.functions == {"cup"} and not whole.unsure and LEAKS not in whole.reasons
    assert not holed.functions and holed.scores["cup"] == 0 and holed.unsure and LEAKS in holed.reasons


def test_the_command_says_the_same_anew_and_as_it_was_kept(tmp_path, monkeypatch, capsys):
    cup(0.007).export(tmp_path / "holed.ply")
    monkeypatch.setattr("sys.argv", ["spherefunc", "classify", str(tmp_path / "holed.ply"), "--json"])
    for _ in range(2):
        with pytest.raises(SystemExit):
            main()
        (row,) = json.loads(capsys.readouterr().out)
        assert row["functions"]["cup"] == {"member": False, "score": 0.0, "radius": row["functions"]["cup"]["radius"]}
        assert row["unsure"] and LEAKS in row["reasons"]


def test_points_do_not_show_a_hole():
    """A cloud whose points are farther apart than a hole is wide is not asked."""
    answer = sf.classify(clouds.mug().points)
    assert answer.functions == {"cup"} and LEAKS not in answer.reasons


def test_an_evaluation_scores_a_cup_that_leaks_as_none_and_unsure():
    labels = Labels(
        functions=("cup", "table"),
        members=np.array([[True, False], [False, True]] * 4),
        also=np.zeros((8, 2), bool),
        groups=np.array(["all"] * 8),
    )
    asked = []
    checks = UseChecks(
        fallen=np.zeros(8, bool),
        uses=tuple(lambda name, check, row=row: bool(asked.append(row)) or row == 4 for row in range(8)),
    )
    read = ProfileFeatures(
        profiles=np.array([0.0, 1.0] * 4)[:, None] * np.ones((1, 2)),
        labels=labels,
        classifier=FunctionClassifier(radii=(0.01,)),
        checks=checks,
    )
    split = Split(np.arange(4), np.arange(4, 8))
    said = read.trial([split])
    assert said.scores[0, 0] == 0 and said.scores[2, 0] > 0.5 and said.unsure[0] and set(asked) == {4, 6}
    [checked], [unchecked] = apply_stability_check(read, [[split]])
    assert checked[:, 0].tolist() == [False, False, True, False]
    assert unchecked[:, 0].tolist() == [True, False, True, False]


def test_a_fitted_estimator_says_the_same():
    whole, holed = load_model(shipped_model("fast")).predict_proba([cup(), cup(0.007)])
    assert whole[0] > 0.9 and holed[0] == 0


def sampled(mesh: trimesh.Trimesh, missing: np.ndarray | None = None, count: int = 20_000) -> np.ndarray:
    """Return points (N, 3) at random on a mesh, without those in a box ``missing`` (2, 3), metres."""
    points = trimesh.sample.sample_surface(mesh, count, seed=0)[0]
    return points if missing is None else points[~((points > missing[0]) & (points < missing[1])).all(axis=1)]


INSIDE = RADIUS - WALL


@pytest.mark.parametrize(
    ("missing", "is_cup", "doubt"),
    [
        (None, True, None),
        ([[0, -INSIDE, -0.001], [INSIDE, INSIDE, 2 * WALL]], False, HOLE_SEEN),  # half of the bottom
        ([[-INSIDE, -INSIDE, -0.001], [INSIDE, INSIDE, 2 * WALL]], True, OPEN),  # all of it: a scan may not show it
    ],
)
@pytest.mark.parametrize("backend", ["fast", "bullet"])
def test_points_of_a_cup_are_sure_if_water_stays_between_them(missing, is_cup, doubt, backend):
    """Of a cup without a bottom, seen from above and from all sides, nobody knows whether it has one."""
    answer = sf.classify(sampled(cup(), None if missing is None else np.array(missing)), backend=backend)
    assert ("cup" in answer.functions) == is_cup, answer.reasons
    surely_none = answer.scores["cup"] > 0  # by the spheres alone, as `bullet` says of half a bottom
    assert (doubt in answer.reasons) != (doubt is None or (surely_none and not is_cup))


@pytest.mark.parametrize("spacing", [0.002, 0.004, 0.006])
def test_water_does_not_run_out_between_sparse_points(spacing):
    cloud = Cloud(sampled(cup(), count=int(2.4 * cup().area / spacing**2 / 2)), "cup")
    assert not leaks(cloud, filled())
