"""How objects can lie: against theory where there is one, and as the command says it."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh
from catalogues import household
from mishaps import MishapPoser
from scipy.spatial.transform import Rotation

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, cloud_from_points, load_cloud
from spherefunc_bullet.clouds.preparation import rotated_cloud
from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.function_model import Membership
from spherefunc_bullet.learning.any_pose import PoseFunctions
from spherefunc_bullet.simulator import backend_entry_points, make_simulator
from spherefunc_bullet.simulator.mechanics import Material, Pose, PoseSettings, able_backends, require_ability
from spherefunc_bullet.simulator.statics.body import body_of
from spherefunc_bullet.simulator.statics.facets import facets_of
from spherefunc_bullet.viewer import mechanics_pictures
from spherefunc_bullet.viewer.pictures import CameraView

ABLE = [name for name in sorted(backend_entry_points()) if name in able_backends("poses")]
# Directions are spread evenly, so that shares of 100 drops are good to 0.02; the engine moves them by as much again.
NEAR = 0.05


@pytest.fixture(scope="module", params=ABLE)
def simulator(request):
    try:
        return make_simulator(request.param)
    except InputError as error:
        pytest.skip(str(error))


def cloud_of(mesh: trimesh.Trimesh, name: str = "object") -> Cloud:
    return cloud_from_mesh(mesh.vertices, mesh.faces, name)


def hull_of(seed: int) -> trimesh.Trimesh:
    points = np.random.default_rng(seed).normal(size=(30, 3)) * [0.1, 0.06, 0.04]
    return trimesh.convex.convex_hull(points)


def tilts(result) -> list[int]:
    return [round(pose.tilt_deg) for pose in result.poses]


def run(*arguments: str) -> object:
    from typer.testing import CliRunner

    return CliRunner().invoke(application(), ["poses", *arguments])


def test_a_cube_lies_on_each_face_as_often(simulator):
    result = simulator.poses(cloud_of(trimesh.creation.box((0.1, 0.1, 0.1))), PoseSettings())
    assert sorted(tilts(result)) == [0, 90, 90, 90, 90, 180]
    assert np.allclose([pose.probability for pose in result.poses], 1 / 6, atol=NEAR)


def test_a_brick_lies_as_theory_says(simulator):
    """The share of a face is the solid angle it takes from the centre, and a brick of 1 x 2 x 3 rests on every face."""
    result = simulator.poses(cloud_of(trimesh.creation.box((0.1, 0.2, 0.3))), PoseSettings())
    a, b, c = 0.05, 0.1, 0.15
    shares = [
        np.arcsin(p * q / np.sqrt((p * p + r * r) * (q * q + r * r))) / np.pi
        for p, q, r in [(b, c, a), (a, c, b), (a, b, c)]
    ]
    found = sorted((pose.probability for pose in result.poses), reverse=True)
    assert np.allclose(found, np.repeat(shares, 2), atol=NEAR)
    assert sum(shares) == pytest.approx(0.5)


@pytest.mark.parametrize("height", [0.05, 0.15, 0.4])
@pytest.mark.slow
def test_a_cylinder_stands_as_often_as_theory_says(simulator, height):
    """An end takes the solid angle of a cone, 2 pi (1 - cos), and the mantle is one way to lie."""
    result = simulator.poses(cloud_of(trimesh.creation.cylinder(0.1, height, sections=48)), PoseSettings())
    end = (1 - height / 2 / np.hypot(height / 2, 0.1)) / 2
    by_tilt = {round(pose.tilt_deg): pose.probability for pose in result.poses}
    assert set(by_tilt) == {0, 90, 180}
    assert by_tilt[0] == pytest.approx(end, abs=NEAR) and by_tilt[180] == pytest.approx(end, abs=NEAR)


def test_a_cone_lies_on_its_base_or_its_mantle(simulator):
    """The base takes the cone of directions from the centre of the surface, which is at a height that is known."""
    radius, height = 0.1, 0.2
    slant = np.hypot(radius, height)
    center = slant / (slant + radius) * height / 3  # of the mantle's third of the height, weighed with the base at 0
    result = simulator.poses(cloud_of(trimesh.creation.cone(radius, height, sections=48)), PoseSettings())
    upright = next(pose for pose in result.poses if pose.tilt_deg < 1)
    assert len(result.poses) == 2
    assert upright.probability == pytest.approx((1 - center / np.hypot(center, radius)) / 2, abs=NEAR)


def test_a_ball_has_one_pose(simulator):
    result = simulator.poses(cloud_of(trimesh.creation.icosphere(3, 0.05)), PoseSettings(drops=20))
    assert len(result.poses) == 1 and result.poses[0].probability == pytest.approx(1)


@pytest.mark.parametrize("seed", range(4))
def test_statics_is_that_of_trimesh(seed):
    mesh = hull_of(seed)
    body = body_of(cloud_of(mesh), Material())
    facets = facets_of(body)
    shares = np.bincount(facets.rests_on, weights=facets.solid_angles(), minlength=len(facets.heights))
    hull = trimesh.convex.convex_hull(body.corners)
    transforms, theirs = trimesh.poses.compute_stable_poses(hull, center_mass=body.center)
    assert (shares > 0).sum() == len(theirs)
    for transform, share in zip(transforms, theirs, strict=True):
        facet = (facets.normals @ -transform[2, :3]).argmax()
        assert shares[facet] == pytest.approx(share, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_drops_are_near_statics_on_bodies_of_any_shape(seed):
    if "bullet" not in ABLE:
        pytest.skip("PyBullet is not installed")
    result = make_simulator("bullet").poses(cloud_of(hull_of(seed)), PoseSettings(drops=300))
    # What has speed rolls over a low sill where statics stops.
    assert max(abs(pose.probability - pose.statics) for pose in result.poses) < 0.2
    assert result.timed_out <= 15


def test_same_seed_gives_the_same_bits(simulator):
    cloud = cloud_of(hull_of(1))
    first, again, other = (simulator.poses(cloud, PoseSettings(drops=40), seed) for seed in (3, 3, 4))
    assert [pose.rotation.tobytes() for pose in first.poses] == [pose.rotation.tobytes() for pose in again.poses]
    assert [pose.probability for pose in first.poses] == [pose.probability for pose in again.poses]
    assert [pose.statics for pose in first.poses] == [pose.statics for pose in other.poses]


def test_rotations_turn_and_do_not_mirror(simulator):
    for pose in simulator.poses(cloud_of(hull_of(2)), PoseSettings(drops=30)).poses:
        assert np.allclose(pose.rotation @ pose.rotation.T, np.eye(3)) and np.linalg.det(pose.rotation) > 0


def test_an_object_that_was_turned_lies_in_the_same_poses():
    mesh = trimesh.creation.box((0.1, 0.2, 0.3))
    turn = Rotation.random(random_state=5).as_matrix()
    simulator = make_simulator("fast")
    upright, turned = (
        simulator.poses(cloud, PoseSettings()) for cloud in (cloud_of(mesh), rotated_cloud(cloud_of(mesh), turn))
    )
    assert np.allclose([pose.probability for pose in upright.poses], [pose.probability for pose in turned.poses])
    own_up = [(pose.rotation @ turn)[2, 2] for pose in turned.poses]
    assert np.isclose(np.abs(own_up), 1).sum() == 2


def test_a_body_that_never_rests_is_an_outcome():
    if "bullet" not in ABLE:
        pytest.skip("PyBullet is not installed")
    settings = PoseSettings(drops=10, time_limit=0.5)
    result = make_simulator("bullet").poses(cloud_of(hull_of(0)), settings)
    assert result.timed_out == 10
    assert all(pose.probability == 0 and pose.statics > 0 for pose in result.poses)


def test_mass_does_not_change_how_a_thing_lies(simulator):
    cloud = cloud_of(hull_of(3))
    light, heavy = (simulator.poses(cloud, PoseSettings(drops=30, matter=Material(mass=mass))) for mass in (0.01, 50.0))
    assert [pose.probability for pose in light.poses] == [pose.probability for pose in heavy.poses]


def test_a_flat_sheet_is_refused(simulator):
    sheet = trimesh.Trimesh([[0, 0, 0], [0.3, 0, 0], [0.3, 0.3, 0], [0, 0.3, 0]], [[0, 1, 2], [0, 2, 3]])
    with pytest.raises(InputError, match="sheet.*flat") as caught:
        simulator.poses(cloud_of(sheet, "sheet"), PoseSettings())
    assert "\n" not in str(caught.value)


def test_an_open_shell_is_a_body():
    mesh = trimesh.creation.cylinder(0.04, 0.1, sections=32)
    open_top = trimesh.Trimesh(mesh.vertices, mesh.faces[mesh.face_normals[:, 2] < 0.5])
    result = make_simulator("fast").poses(cloud_of(open_top), PoseSettings())
    by_tilt = {round(pose.tilt_deg): pose.statics for pose in result.poses}
    assert by_tilt[0] > by_tilt[180] > 0 and result.notes == ()


def test_a_cloud_alone_is_said_to_be_one(simulator):
    points = trimesh.creation.box((0.2, 0.2, 0.2)).sample(4000, seed=0)
    result = simulator.poses(cloud_from_points(points), PoseSettings(drops=20))
    assert any("cloud alone" in note for note in result.notes) and len(result.poses) >= 6


def test_loose_parts_are_said_and_taken_as_one_body(simulator):
    parts = [trimesh.creation.box((0.1, 0.1, 0.1)) for _ in range(3)]
    for k, part in enumerate(parts):
        part.apply_translation([0.4 * k, 0, 0])
    result = simulator.poses(cloud_of(trimesh.util.concatenate(parts)), PoseSettings(drops=20))
    assert "3 loose parts, taken as one rigid body" in result.notes


@pytest.mark.parametrize("wrong", [{"drops": 0}, {"fall": -1}, {"time_limit": 0}, {"fall": float("nan")}])
def test_settings_out_of_range_are_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        PoseSettings(**wrong)


@pytest.mark.parametrize("wrong", [{"mass": 0.0}, {"area_density": -1.0}, {"restitution": 1.5}, {"friction": -0.1}])
def test_matter_out_of_range_is_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        Material(**wrong)


def test_a_backend_that_lacks_an_ability_says_so_in_one_line():
    class Bare:
        name, version, drop, options = "bare", "1", print, print

    with pytest.raises(InputError, match="backend 'bare' cannot find poses: expected one that can: .*fast") as caught:
        require_ability(Bare(), "poses")
    assert "\n" not in str(caught.value)


def test_command_prints_the_contract(tmp_path):
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "brick.ply")
    done = run(str(tmp_path / "brick.ply"), "--backend", "fast", "--json")
    assert done.exit_code == 0, done.stderr
    (row,) = json.loads(done.stdout)
    assert row["file"].endswith("brick.ply") and len(row["poses"]) == 6
    for pose in row["poses"]:
        assert np.array(pose["rotation"]).shape == (3, 3) and 0 <= pose["probability"] <= 1
        assert set(pose["functions"]["cup"]) == {"member", "score"}
    assert set(row["best"]) == {"cup", "sittable", "table"}


def test_command_draws_a_picture_and_a_page(tmp_path, monkeypatch):
    monkeypatch.setattr(mechanics_pictures, "TILE", CameraView(size=(90, 75)))  # a sixteenth of the rays
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "brick.ply")
    picture, page = tmp_path / "poses.png", tmp_path / "poses.html"
    done = run(str(tmp_path / "brick.ply"), "--backend", "fast", "--picture", str(picture), "--page", str(page))
    assert done.exit_code == 0, done.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert "brick.ply" in page.read_text() and "data:image/png" in page.read_text()


def test_only_the_best_pose_for_a_function_is_framed():
    """A mug that leans on its handle is a cup too, and is not framed; no pose is framed for what no pose has."""
    from spherefunc_bullet.viewer.mechanics_pictures import framed_poses, pose_words

    def pose(probability, cup, table):
        answers = {"cup": (cup > 0.5, cup), "table": (table > 0.5, table)}
        functions = {name: Membership(member=has, score=score, radius=0.01) for name, (has, score) in answers.items()}
        return PoseFunctions(pose=Pose(rotation=np.eye(3), probability=probability, statics=0.1), functions=functions)

    leaning = pose(0.0, 0.88, 0.0)
    assert framed_poses([pose(0.7, 0.1, 0.4), pose(0.3, 0.99, 0.0), leaning]) == {1}
    assert pose_words(leaning) == ("less than 1 %", "cup 0.88")


def test_command_goes_on_after_a_file_that_cannot_be_used(tmp_path, capsys):
    trimesh.creation.box((60000, 10, 10)).export(tmp_path / "huge.ply")
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "brick.ply")
    done = run(str(tmp_path / "huge.ply"), str(tmp_path / "brick.ply"), "--backend", "fast", "--json")
    assert done.exit_code == 2 and len(json.loads(done.stdout)) == 1
    lines = [line for line in done.stderr.splitlines() if line.startswith("spherefunc:")]
    assert len(lines) == 1 and "huge.ply" in lines[0]


@pytest.mark.slow
def test_a_crash_costs_one_object_and_not_the_run(tmp_path):
    from spherefunc_bullet.commands.poses import posed_file
    from spherefunc_bullet.learning.model_file import load_model, shipped_model
    from spherefunc_bullet.processes.tasks import run_tasks
    from spherefunc_bullet.simulator import isolated

    files = [tmp_path / "segfault.ply", tmp_path / "brick.ply"]
    for file in files:
        trimesh.creation.box((0.1, 0.2, 0.3)).export(file)
    simulator, classifier = MishapPoser(), load_model(shipped_model("fast"))
    tasks = [(file, simulator, classifier, PoseSettings(), 0, "m") for file in files]
    (_, lost), (_, kept) = run_tasks(posed_file, tasks, files, isolate=isolated(simulator))
    assert isinstance(lost, InputError) and "SIGSEGV" in str(lost)
    assert len(kept[1].poses) == 6


def test_classify_any_pose_tells_a_mug_that_lies(tmp_path):
    from typer.testing import CliRunner

    mug = next(item.mesh for item in household() if item.name == "mug_01").copy()
    mug.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    mug.export(tmp_path / "mug.ply")
    runs = [
        CliRunner().invoke(application(), ["classify", str(tmp_path / "mug.ply"), "--json", *more])
        for more in ([], ["--any-pose"])
    ]
    as_it_lies, best = (json.loads(done.stdout)[0]["functions"]["cup"] for done in runs)
    assert not as_it_lies["member"] and best["member"]
    assert np.array(best["rotation"]) @ [0, -1, 0] == pytest.approx([0, 0, 1], abs=0.05)


def test_a_mug_lying_on_its_side_is_a_cup_turned_upright(tmp_path):
    from spherefunc_bullet.learning.any_pose import best_poses, pose_functions
    from spherefunc_bullet.learning.model_file import load_model, shipped_model

    mug = next(item.mesh for item in household() if item.name == "mug_01")
    on_side = trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0])
    lying = mug.copy()
    lying.apply_transform(on_side)
    lying.export(tmp_path / "mug.ply")
    cloud = load_cloud(tmp_path / "mug.ply")
    result = make_simulator("fast").poses(cloud, PoseSettings())
    answer = pose_functions(cloud, result.poses, load_model(shipped_model("fast")))
    best = answer[best_poses(answer)["cup"]]
    assert best.functions["cup"].member
    assert np.degrees(np.arccos((best.pose.rotation @ on_side[:3, :3])[2, 2])) < 3
