"""What is round at the bottom: a ball rolls, a bowl rights itself, and every backend and mesh says the same."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.simulator import make_simulator
from spherefunc_bullet.simulator.mechanics import Stance, StandResult, StandSettings, able_backends

MESHES = [(8, 16), (16, 32), (32, 64)]  # stacks and sections: the coarsest has facets of 11 degrees
BACKENDS = able_backends("stands")


def cloud_of(*meshes: trimesh.Trimesh) -> Cloud:
    mesh = trimesh.util.concatenate(list(meshes))
    return cloud_from_mesh(mesh.vertices, mesh.faces, "object")


def bowl(radius: float, half_deg: float, stacks: int, sections: int) -> trimesh.Trimesh:
    """Return the part of a sphere about its lowest point, an open sheet; metres."""
    angles = np.linspace(0, np.radians(half_deg), stacks + 1)
    profile = np.column_stack([radius * np.sin(angles), radius * (1 - np.cos(angles))])
    return trimesh.creation.revolve(profile, sections=sections)


def height_of(sheet: trimesh.Trimesh) -> float:
    """Return the height of the centre of mass of a sheet."""
    return float(sheet.triangles_center[:, 2] @ sheet.area_faces / sheet.area)


def turned(mesh: trimesh.Trimesh, degrees: float) -> trimesh.Trimesh:
    return mesh.copy().apply_transform(trimesh.transformations.rotation_matrix(np.radians(degrees), [1, 0, 0]))


def stood(cloud: Cloud, load: float = 0.0, places: np.ndarray | None = None) -> list[StandResult]:
    settings, at = StandSettings(load=load), np.empty((0, 3)) if places is None else places
    return [make_simulator(name).stands(cloud, settings, at) for name in BACKENDS]


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(("radius", "half_deg"), [(0.08, 90), (0.15, 40), (0.3, 15)])
def test_a_bowl_without_a_foot_stands(radius, half_deg, mesh):
    for result in stood(cloud_of(bowl(radius, half_deg, *mesh))):
        assert result.stance is Stance.STANDS and result.tilt_deg < 0.3  # the hull has 300 corners, not quite evenly


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(("degrees", "stance"), [(8, Stance.ROCKS), (40, Stance.TIPS)])
def test_a_bowl_that_came_tilted_rights_itself(degrees, stance, mesh):
    for result in stood(cloud_of(turned(bowl(0.08, 90, *mesh), degrees))):
        assert result.stance is stance and result.tilt_deg == pytest.approx(degrees, abs=0.3)


@pytest.mark.parametrize("mesh", MESHES)
def test_a_bowl_weighted_beside_its_middle_leans_until_its_weight_is_below_its_centre(mesh):
    radius = 0.15
    weight = trimesh.creation.box((0.02, 0.02, 0.02)).apply_translation([0.06, 0, 0.03])
    dish = bowl(radius, 40, *mesh)
    # Moments about the centre of curvature, the bowl's and the weight's.
    aside = weight.area * 0.06
    below = dish.area * (radius - height_of(dish)) + weight.area * (radius - 0.03)
    expected = np.degrees(np.arctan2(aside, below))
    for result in stood(cloud_of(dish, weight)):
        assert result.stance is Stance.ROCKS and result.tilt_deg == pytest.approx(expected, abs=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("mesh", MESHES)
def test_a_bowl_keeps_its_pose_under_a_load_that_leans_it_by_less_than_a_degree(mesh):
    """Load and bowl balance about the centre of curvature: load (aside - depth t) = mass lever t, t = tan 1°."""
    radius, place = 0.15, np.array([[0.0, 0.0, 0.02], [0.03, 0.0, 0.04]])
    dish, lean = bowl(radius, 40, *mesh), np.tan(np.radians(1))
    cloud = cloud_of(dish)
    expected = 5.0 * dish.area * (radius - height_of(dish)) * lean / (0.03 - (radius - 0.04) * lean)
    for load, carries in ((0.5 * expected, True), (2 * expected, False)):
        for result in stood(cloud, load, place):
            assert result.carries.tolist() == [True, carries]
            assert np.isinf(result.tipping_load[0])
            assert result.tipping_load[1] == pytest.approx(expected, rel=0.15)  # 0.1 degrees of the mesh's


@pytest.mark.parametrize(
    "mesh",
    [
        *(trimesh.creation.icosphere(level, 0.1) for level in (2, 4)),
        *(trimesh.creation.uv_sphere(0.1, count=(count, count)) for count in (16, 64)),
    ],
)
def test_a_ball_rolls_whatever_its_mesh(mesh):
    assert [result.stance for result in stood(cloud_of(mesh))] == [Stance.ROLLS] * len(BACKENDS)


@pytest.mark.parametrize("sections", [12, 24, 64])
@pytest.mark.parametrize(("radius", "length"), [(0.05, 0.3), (0.15, 0.2)])
def test_a_lying_cylinder_rolls_whatever_its_mesh(radius, length, sections):
    lying = turned(trimesh.creation.cylinder(radius, length, sections=sections), 90)
    assert [result.stance for result in stood(cloud_of(lying))] == [Stance.ROLLS] * len(BACKENDS)


def test_a_beaker_that_lies_rolls_and_one_that_is_put_on_its_foot_stands():
    beaker = trimesh.creation.revolve(np.array([[0, 0], [0.03, 0], [0.045, 0.1]]), sections=32)
    lying = turned(beaker, 90 - np.degrees(np.arctan(0.15)))
    assert [result.stance for result in stood(cloud_of(lying))] == [Stance.ROLLS] * len(BACKENDS)
    assert [result.stance for result in stood(cloud_of(beaker))] == [Stance.STANDS] * len(BACKENDS)


@pytest.mark.parametrize("sections", [16, 32, 64])
def test_half_a_cylinder_rights_itself_across_and_stands_along(sections):
    angles = np.linspace(-np.pi / 2, np.pi / 2, sections // 2 + 1)
    arc = np.column_stack([0.1 * np.sin(angles), np.full(len(angles), -0.2), 0.1 * (1 - np.cos(angles))])
    rocker = trimesh.convex.convex_hull(np.concatenate([arc, arc * [1, -1, 1]]))
    for result in stood(cloud_of(rocker)):
        assert result.stance is Stance.STANDS and result.tilt_deg < 0.1


def test_splayed_feet_are_no_round_bottom():
    """A stool's hull goes on at small turns from the square of its feet to their slanting sides."""
    feet = [[x, y, 0.0] for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
    sides = [[1.1 * x, 1.1 * y, 0.005] for x, y, _ in feet]
    seat = [[x, y, 0.7] for x in (-0.15, 0.15) for y in (-0.15, 0.15)]
    cloud = cloud_of(trimesh.convex.convex_hull(np.array(feet + sides + seat)))
    places = np.array([[x, y, 0.7] for x in (-0.12, 0.0, 0.12) for y in (-0.12, 0.12)])
    for result in stood(cloud, 40.0, places):
        assert result.stance is Stance.STANDS and result.margin == pytest.approx(0.2, abs=1e-3)
        assert result.carries.all() and result.tipping_words == "no load tips it"
