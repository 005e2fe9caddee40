"""Poses that are off are aligned with the map, as far as the map shows it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.cloud import Mesh
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.household.parts.solids import box, shift
from spherefunc_bullet.scenes.virtual_rooms.kinect import Kinect, Surfaces, look_at, photograph

KINECT = Kinect(width=320, height=240)
CORNER = (shift(box(6, 6, 0.02), z=-0.02), shift(box(6, 0.02, 2), y=2, z=0), shift(box(0.02, 6, 2), x=-2, z=0))
CRATE = shift(box(0.5, 0.5, 0.5), x=-0.5, y=0.5)
EYES = ([1.5, -1.5, 1.4], [0.8, -1.9, 1.6], [1.9, -0.8, 1.5])
OFF = np.eye(4)
OFF[:3, :3] = Rotation.from_rotvec(np.radians([0.6, -0.5, 0.4])).as_matrix()
OFF[:3, 3] = [0.025, -0.02, 0.015]
BODY = np.eye(4)
BODY[:3, :3] = Rotation.from_euler("xz", [90, 90], degrees=True).as_matrix()  # x ahead and z up in place of z and -y


def images_of(*solids, eyes=EYES) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return what the camera sees of solids from each of the eyes, with its true poses."""
    meshes = [Mesh(np.array(one.vertices), np.array(one.faces)) for one in solids]
    surfaces, rng = Surfaces(enumerate(meshes)), np.random.default_rng(0)
    poses = [look_at(np.array(eye), [-0.8, 0.8, 0.4]) for eye in eyes]
    return [(photograph(surfaces, pose, KINECT, rng).depth, pose) for pose in poses]


def error_of(fusion: sf.SceneFusion, number: int, pose: np.ndarray) -> float:
    """Return how far an image's pose in the map is from the true one, metres, at 2 m from the camera."""
    ahead = np.array([0.0, 0, 2, 1])
    return float(np.linalg.norm(fusion.views[number].T_world_camera @ ahead - pose @ ahead))


def fused(images, settings: sf.FusionSettings, off: np.ndarray = OFF) -> sf.SceneFusion:
    """Return the fusion of images, all of whose poses but the first are off."""
    fusion = sf.SceneFusion(fusion=settings)
    for number, (depth, pose) in enumerate(images):
        fusion.add(depth, KINECT.camera, pose @ off if number else pose)
    return fusion


def test_a_pose_that_is_off_is_aligned_and_the_images_agree():
    images = images_of(*CORNER, CRATE)
    as_given, aligned = (fused(images, sf.FusionSettings(pose_error=error)) for error in (0, 0.02))
    for number in (1, 2):
        assert error_of(as_given, number, images[number][1]) > 0.03
        assert error_of(aligned, number, images[number][1]) < 0.006
    assert aligned.map.agreement > as_given.map.agreement
    assert len(aligned.map.points) < len(as_given.map.points)


def test_a_true_pose_stays_nearly_as_it_is():
    images = images_of(*CORNER, CRATE)
    fusion = fused(images, sf.FusionSettings(), off=np.eye(4))
    assert max(error_of(fusion, number, images[number][1]) for number in (1, 2)) < 0.003
    assert fusion.map.agreement > 0.98


def test_a_view_of_a_single_wall_does_not_slide_along_it():
    wall, along = shift(box(0.02, 6, 4), x=-2, z=0), np.eye(4)
    images = images_of(wall, eyes=EYES[:2])
    along[:3, 3] = images[1][1][:3, :3].T @ [0, 0.02, 0]  # along the wall, in the camera's frame
    fusion = fused(images, sf.FusionSettings(), off=along)
    moved = fusion.views[1].T_world_camera[:3, 3] - (images[1][1] @ along)[:3, 3]
    assert abs(moved[1]) < 0.002


@pytest.mark.parametrize("wrong", [np.linalg.inv, lambda T: T @ BODY])
def test_images_that_disagree_are_said_once(wrong, caplog):
    fusion = sf.SceneFusion()
    for depth, pose in images_of(*CORNER, CRATE, eyes=(*EYES, *EYES[:2])):
        fusion.add(depth, KINECT.camera, wrong(pose) if fusion.count else pose)
    assert [record.message[:18] for record in caplog.records] == ["depth images show "]
    with pytest.raises(InputError, match="expected depth images that show at least 50% of the map, got"):
        fusion.objects()  # which would look at thousands of pieces


def test_a_pose_that_is_said_to_be_exact_is_moved_less():
    images, moved = images_of(*CORNER, CRATE), []
    for error in (0.002, 0.02):
        fusion = fused(images, sf.FusionSettings(pose_error=error))
        moved.append(np.linalg.norm((fusion.views[1].T_world_camera - images[1][1] @ OFF)[:3, 3]))
    assert moved[0] < moved[1] / 2


def test_an_image_of_something_else_stays_in_its_given_pose():
    depth, pose = images_of(*CORNER, CRATE)[0]
    away = look_at(np.array([0, 0, 1.0]), [3.0, -3.0, 1.0])
    fusion = sf.SceneFusion().add(depth, KINECT.camera, pose).add(np.full(depth.shape, 1.0), KINECT.camera, away)
    assert np.array_equal(fusion.views[1].T_world_camera, away)


@pytest.mark.parametrize("error", [-0.01, 1.0, "2 cm"])
def test_errors_of_poses_that_are_no_such_distance_are_refused(error):
    with pytest.raises(sf.InputError, match="pose_error"):
        sf.FusionSettings(pose_error=error)
