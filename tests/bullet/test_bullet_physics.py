"""The Bullet backend against mechanics: rest, rolling, sliding, energy, packing, and nothing inside anything."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import catalogues
import clouds
import numpy as np
import pytest
from scipy.spatial import cKDTree

from spherefunc_bullet.clouds.cloud import Cloud, Mesh, cloud_from_mesh
from spherefunc_bullet.simulator import DropSettings, make_simulator

pytest.importorskip("pybullet", reason="PyBullet is not installed")

from spherefunc_bullet.bullet.backend import SHAPES
from spherefunc_bullet.bullet.collision.shape import CollisionShape, collision_shape
from spherefunc_bullet.bullet.engine import Physics, pybullet
from spherefunc_bullet.bullet.world import World

pytestmark = pytest.mark.slow

RADII = (0.005, 0.01, 0.02)
CONTACT = 0.02  # radii: the engine's slop, by which contacts may overlap or stand off
OVERLAP = 0.05  # of the radius, promised of every settled sphere


def drop(cloud: Cloud, radius: float, seed: int = 0, max_spheres: int = 5_000_000, **options):
    settings = DropSettings(radius=radius, max_spheres=max_spheres)
    return make_simulator("bullet", **options).drop(cloud, settings, seed)


def triangles(vertices, faces, name: str) -> CollisionShape:
    """Return faces in radii as a shape."""
    vertices = np.asarray(vertices, float)
    return CollisionShape(
        name=name,
        kind="mesh",
        vertices=vertices,
        faces=np.asarray(faces, np.int32),
        pieces=None,
        columns=vertices,
        voxel_size=None,
        gap=None,
    )


def slope(angle_deg: float, half: float = 80.0) -> CollisionShape:
    """Return two triangles through the origin that rise towards +y."""
    a = np.radians(angle_deg)
    up = half * np.array([0, np.cos(a), np.sin(a)])
    aside = np.array([half, 0, 0])
    return triangles([-aside - up, aside - up, aside + up, up - aside], [[0, 1, 2], [0, 2, 3]], "slope")


def path(physics: Physics, shape: CollisionShape, start, duration: float, speed=(0, 0, 0)):
    """Return times (T,), centres (T, 3), velocities (T, 3) and spins (T, 3) of one sphere, seen at every look."""
    p = pybullet()
    seen = []
    with World(physics) as world:
        world.add_object(shape)
        world.add_spheres(1)
        world.place(0, start)
        p.resetBaseVelocity(world.air[0], [physics.scale * v for v in speed], [0, 0, 0], **world.engine)
        for _ in range(int(duration / physics.check_interval)):
            world.step()
            velocity, spin = p.getBaseVelocity(world.air[0], **world.engine)
            seen.append((world.positions()[0], np.array(velocity) / physics.scale, np.array(spin)))
    return physics.check_interval * np.arange(1, len(seen) + 1), *(np.array(each) for each in zip(*seen, strict=True))


# One sphere on one surface


@pytest.mark.parametrize("radius", RADII)
def test_sphere_on_a_plate_rests_one_radius_above_it(radius):
    side = min(0.2, 20 * radius)  # metres: room for some fifty spheres
    result = drop(clouds.plate(side, side), radius)
    x, y, z = (result.centers - [0, 0, 0.4]).T
    over = np.maximum(abs(x), abs(y)) <= side / 2  # a sphere may hold on to the edge by its side
    assert result.settled > 15 and over.mean() > 0.8 and result.on_object.all()
    # A lattice of a plane is met as the plane, at any pitch. A few wedged between others sink as all overlaps may.
    assert np.abs(z[over] - radius).max() <= OVERLAP * radius
    assert np.median(np.abs(z[over] - radius)) <= CONTACT * radius


@pytest.mark.parametrize("angle_deg", [0, 20, 45])
def test_sphere_is_one_radius_from_two_triangles(angle_deg):
    """Held by rolling friction and friction above the tangent of the slope."""
    physics = Physics(friction=2.0, rolling_friction=2.0)
    normal = np.array([0, -np.sin(np.radians(angle_deg)), np.cos(np.radians(angle_deg))])
    _, centers, velocities, _ = path(physics, slope(angle_deg), 1.05 * normal, 10.0)
    assert centers[-1] @ normal == pytest.approx(1, abs=CONTACT)
    assert np.linalg.norm(velocities[-1]) < physics.rest_speed


def advance(physics: Physics, angle_deg: float, duration: float = 20.0, heading_deg: float = 90.0) -> float:
    """Return how far a sphere goes down a slope from rest; the slope rises towards the heading."""
    a, h = np.radians(angle_deg), np.radians(heading_deg - 90)
    turn = np.array([[np.cos(h), -np.sin(h), 0], [np.sin(h), np.cos(h), 0], [0, 0, 1]])
    start = turn @ [0.3, 100 * np.cos(a) - np.sin(a), 100 * np.sin(a) + np.cos(a)]
    shape = slope(angle_deg, 250.0)
    _, centers, _, _ = path(physics, replace(shape, vertices=shape.vertices @ turn.T), start, duration)
    return np.linalg.norm(centers[-1] - start)


@pytest.mark.parametrize("rolling_friction", [0.0, 0.05, 0.0875, 0.2])
@pytest.mark.parametrize("above_deg", [1.0, 5.0])
def test_sphere_rolls_down_as_a_sphere_does(rolling_friction, above_deg):
    """Rolling without sliding a sphere keeps 5/7 of the acceleration, its moment of inertia being 2/5 m r²."""
    a, duration = np.radians(np.degrees(np.arctan(rolling_friction)) + above_deg), 20.0
    pull, friction = (5 / 7 * each * duration**2 / 2 for each in (np.sin(a), rolling_friction * np.cos(a)))
    way = advance(Physics(rolling_friction=rolling_friction), np.degrees(a), duration)
    # The start counts one step of 0.1 more. While a sphere rolls at 0.2 to 1, the engine's rolling friction is up to
    # a quarter larger than what was set, for it keeps the last contacts besides the present one.
    assert (pull - 1.1 * friction) * 0.99 < way < (pull - friction) * 1.01


@pytest.mark.parametrize("rolling_friction", [0.05, 0.0875, 0.2])
@pytest.mark.parametrize("heading_deg", [0, 90, 180, 270])
def test_rolling_friction_holds_up_to_its_tangent(rolling_friction, heading_deg):
    physics, limit = Physics(rolling_friction=rolling_friction), np.degrees(np.arctan(rolling_friction))
    # A third of a degree above, a sphere goes 5/7 · 0.0058 · 20² / 2 = 0.8 radii; half of it at least.
    assert advance(physics, limit - 0.3, heading_deg=heading_deg) < 0.1
    assert advance(physics, limit + 0.3, heading_deg=heading_deg) > 0.4


@pytest.mark.xfail(strict=True, reason="the engine limits rolling friction along x and y: sqrt(2) of it between")
def test_rolling_friction_is_the_same_in_every_direction():
    limit = np.degrees(np.arctan(0.0875))
    assert advance(Physics(rolling_friction=0.0875), limit + 0.5, heading_deg=45) > 0.4


def test_sphere_without_friction_slides():
    physics, a = Physics(friction=0.0, rolling_friction=0.0), np.radians(30)
    assert advance(physics, 30, 16.0) == pytest.approx(np.sin(a) * 16**2 / 2, rel=0.02)


def test_sphere_slides_where_friction_is_too_small_to_roll_it():
    """It rolls without sliding up to tan(angle) = 7/2 friction, beyond it slides with sin - friction cos."""
    physics, a = Physics(friction=0.1, rolling_friction=0.0), np.radians(35)
    theory = (np.sin(a) - 0.1 * np.cos(a)) * 16**2 / 2
    assert advance(physics, 35, 16.0) == pytest.approx(theory, rel=0.03)


def on_the_slope(result, angle_deg: float, radius: float) -> np.ndarray:
    """Return which centres are over the face of a `clouds.incline`, not on its upper edge or past the lower."""
    a = np.radians(angle_deg)
    along = (result.centers - [0, 0, 0.3]) @ [0, np.cos(a), np.sin(a)]
    edge = LENGTH / 2 * np.cos(a) ** 2 + LENGTH * np.sin(a) ** 2
    return along < edge - 0.2 * radius


LENGTH = 0.2  # metres, of the inclines


@pytest.mark.parametrize("angle_deg", [1, 4.5, 7.5])
@pytest.mark.parametrize("radius", RADII)
def test_incline_of_points_holds_a_layer(radius, angle_deg):
    """Rolling friction is set to 8 degrees."""
    result = drop(clouds.incline(angle_deg, LENGTH), radius, max_spheres=200)
    # A loose layer, about half of the area, or as many as are asked for.
    assert result.settled > min(200, 0.4 * LENGTH**2 / (np.pi * radius**2)) - 1
    a = np.radians(angle_deg)
    above = (result.centers - [0, 0, 0.3 + LENGTH / 2 * np.sin(a)]) @ [0, -np.sin(a), np.cos(a)]
    assert above[result.on_object].max() <= (1 + OVERLAP) * radius and above.min() >= (1 - OVERLAP) * radius


@pytest.mark.parametrize("angle_deg", [12, 30])
@pytest.mark.parametrize("radius", RADII)
def test_steep_incline_of_points_is_left_by_all(radius, angle_deg):
    """But for those that balance on its upper edge, which has room for each direction up to the vertical."""
    result = drop(clouds.incline(angle_deg, LENGTH), radius, max_spheres=300)
    assert not on_the_slope(result, angle_deg, radius).any() and result.settled < 5


EDGES = pytest.mark.xfail(strict=True, reason="edges between faces hold spheres up to two degrees beyond theory")


@pytest.mark.parametrize("shape", [pytest.param("voxel", marks=EDGES), "compound"])
@pytest.mark.parametrize("radius", [0.01, 0.02])
def test_incline_lets_go_where_theory_says(shape, radius):
    """A degree above that of the default: it was 6 when rolling friction held on 5, and is 9 since it holds on 8."""
    result = drop(inclined_mesh(9.0), radius, max_spheres=60, shape=shape)
    assert not on_the_slope(result, 9.0, radius).any()


def inclined_mesh(angle_deg: float) -> Cloud:
    """Return `clouds.incline` as the samples of two triangles."""
    points, a = clouds.incline(angle_deg, LENGTH).points, np.radians(angle_deg)
    corner, aside = points.min(axis=0), np.array([LENGTH, 0, 0])
    up = LENGTH * np.array([0, np.cos(a), np.sin(a)])
    vertices = np.array([corner, corner + aside, corner + aside + up, corner + up])
    sampled = cloud_from_mesh(vertices, [[0, 1, 2], [0, 2, 3]])
    moved = corner - sampled.mesh.vertices.min(axis=0)
    return Cloud(sampled.points + moved, "incline", Mesh(sampled.mesh.vertices + moved, sampled.mesh.faces))


@pytest.mark.parametrize("option, angle_deg, settled", [(0.0, 3.0, False), (0.3, 15.0, True), (0.3, 30.0, False)])
def test_rolling_friction_is_an_option(option, angle_deg, settled):
    result = drop(clouds.incline(angle_deg, LENGTH), 0.01, rolling_friction=option)
    assert (on_the_slope(result, angle_deg, 0.01).sum() > 20) == settled and (settled or result.settled < 5)


# An edge between points may be filled as far as the ball that finds the faces does not reach: of 5 mm on points 4 mm
# apart, which lifts a sphere of that size by 0.3; of 0.65 radii where voxels of 0.4 radii widen the gaps.
@pytest.mark.parametrize("radius, off", [(0.005, 0.3), (0.01, OVERLAP), (0.02, 0.1), (0.05, OVERLAP)])
def test_spheres_low_in_a_groove_touch_both_walls(radius, off):
    centers = np.concatenate([drop(clouds.groove(), radius, seed, max_spheres=1).centers for seed in range(6)])
    height, aside = centers[:, 2] - 0.2, centers[:, 1]
    # Away from the ends: these are open, and on their rims a sphere can rest too.
    bottom = (abs(centers[:, 0]) < 0.14) & (abs(aside) < radius)
    assert bottom.sum() >= 3
    for wall in ((height - aside) / np.sqrt(2), (height + aside) / np.sqrt(2)):
        assert wall[bottom].min() >= (1 - OVERLAP) * radius and wall[bottom].max() <= (1 + off) * radius


# Energy


def energy(centers, velocities, spins) -> np.ndarray:
    """Return potential, kinetic and rotational energy, in units of m g r; a sphere's moment of inertia is 2/5 m r²."""
    return centers[:, 2] + (velocities**2).sum(axis=1) / 2 + (spins**2).sum(axis=1) / 5


@cache
def bumpy() -> CollisionShape:
    """Return a rough field between points, in radii of a sphere of 1 cm."""
    x, y = np.meshgrid(clouds.steps(0.4), clouds.steps(0.4))
    random = np.random.default_rng(0)
    z = 0.02 + 0.004 * np.sin(x / 0.012) * np.cos(y / 0.017) + random.uniform(-0.0007, 0.0007, x.shape)
    field = Cloud(np.column_stack([x.ravel() - 0.2, y.ravel() - 0.2, z.ravel()]), "bumpy")
    return collision_shape(field, 0.01, "voxel")


@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("surface", ["level", "bumpy"])
def test_energy_never_grows(surface, restitution):
    shape = {"level": slope(0), "bumpy": bumpy()}[surface]
    physics = Physics(restitution=restitution)
    for speed in ((0, 0, 0), (1.0, 0.3, 0), (0, -2.0, -1.0)):
        _, centers, velocities, spins = path(physics, shape, [0.3, 2.0, 8.0], 40.0, speed)
        on_it = np.maximum(abs(centers[:, 0]), abs(centers[:, 1])) < 18
        total = energy(centers, velocities, spins)[on_it | (surface == "level")]
        # A contact that overlaps is pushed apart; a fall of 7 radii, which ends at a speed of 3.7, overlaps by a tenth.
        lowest = np.minimum.accumulate(total)
        assert (total[1:] - lowest[:-1]).max() <= 0.1
        assert total[0] <= 8.0 + np.dot(speed, speed) / 2


@pytest.mark.parametrize("restitution", [0.3, 0.6, 0.9])
def test_sphere_bounces_as_high_as_restitution_says(restitution):
    physics = Physics(restitution=restitution, time_step=0.02, sub_steps=1)
    _, centers, _, _ = path(physics, slope(0), [0.3, 0.2, 6.0], 15.0)
    height = centers[:, 2] - 1
    landed = np.argmax(height < 0.2)
    # Five radii come back as restitution squared; contacts a step early, or overlaps pushed apart, are worth a tenth.
    assert height[landed:].max() == pytest.approx(5 * restitution**2, rel=0.12, abs=0.1)


# Many spheres


@cache
def tube():
    """Return what fills a tube of 10 radii inside and 24 high."""
    radius = 0.005
    return drop(clouds.mug(10 * radius, 24 * radius, floor=0.0), radius).centers / radius


def filled(centers: np.ndarray, inner: float, outer: float, low: float, high: float) -> float:
    """Return the share of a ring, lengths in radii, that lies in spheres: by 100,000 random places, to 0.2 %."""
    random = np.random.default_rng(0)
    aside, angle = np.sqrt(random.uniform(inner**2, outer**2, 100_000)), random.uniform(0, 2 * np.pi, 100_000)
    places = np.column_stack([aside * np.cos(angle), aside * np.sin(angle), random.uniform(low, high, 100_000)])
    return float(np.mean(cKDTree(centers).query(places)[0] < 1))


def test_tube_fills_to_the_rim():
    centers = tube()
    highest = np.sort(centers[:, 2])[-20:]
    # Seventy spheres cover a cross-section; the highest twenty reach the rim, and no heap stands above it.
    assert highest[0] > 24 - 1 and highest[-1] < 24 + 2
    assert centers[:, 2].min() >= 1 - OVERLAP
    assert np.hypot(*centers[centers[:, 2] < 23].T[:2]).max() <= 9 + OVERLAP


def test_tube_holds_what_spheres_laid_down_one_by_one_fill():
    """By volume. Each stays where it first finds support: looser than random close packing's 0.64, a ceiling."""
    # Two radii from floor and wall, four from the rim, where spheres rest on three others as they would without walls.
    inside = filled(tube(), 0, 8, 2, 20)
    assert 0.50 < inside < 0.60
    # The wall orders spheres against it, but leaves the gaps between them and itself: looser over one diameter.
    assert filled(tube(), 8, 10, 2, 20) < inside
    assert 0.45 < filled(tube(), 0, 10, 0, 20) < 0.60


# Nothing inside anything, on objects as they are modelled


@cache
def household() -> dict:
    """Return the meshes of the household catalogue by name."""
    return {each.name: each.mesh for each in catalogues.household()}


@cache
def model(name: str) -> Cloud:
    return cloud_from_mesh(household()[name].vertices, household()[name].faces, name)


@cache
def corner_of(name: str) -> Cloud:
    """Return the corner of a sofa at +x, +y, 40 cm each way: of the seat, one arm and the back."""
    points = model(name).points
    return Cloud(points[np.all(points[:, :2] > points[:, :2].max(axis=0) - 0.4, axis=1)], f"corner of {name}")


# Name in the catalogue, or of a sofa its corner; radius in metres.
CASES = {
    "mug at 5 mm": ("mug_01", 0.005),
    "mug at 1 cm": ("mug_01", 0.01),
    "glass at 5 mm": ("wine_glass_01", 0.005),
    "chair at 1 cm": ("dining_chair_01", 0.01),
    "chair at 2 cm": ("dining_chair_01", 0.02),
    "chair at 5 cm": ("dining_chair_01", 0.05),
    "shell chair at 2 cm": ("shell_chair_01", 0.02),
    "sofa's corner at 1 cm": ("corner of sofa_01", 0.01),
    "sofa's corner at 2 cm": ("corner of sofa_01", 0.02),
    "sofa's corner at 5 cm": ("corner of sofa_01", 0.05),
}


@cache
def settled_on(case: str) -> tuple[Cloud, float, np.ndarray]:
    name, radius = CASES[case]
    cloud = corner_of("sofa_01") if name.startswith("corner") else model(name)
    return cloud, radius, drop(cloud, radius, max_spheres=200).centers


@pytest.mark.parametrize("case", CASES)
def test_no_settled_sphere_overlaps_the_object(case):
    cloud, radius, centers = settled_on(case)
    assert len(centers) > 5
    assert cKDTree(cloud.points).query(centers)[0].min() >= (1 - OVERLAP) * radius


@pytest.mark.parametrize("case", CASES)
def test_no_settled_sphere_overlaps_another(case):
    _, radius, centers = settled_on(case)
    assert cKDTree(centers).query(centers, k=2)[0][:, 1].min() >= (2 - OVERLAP) * radius


@pytest.mark.parametrize("case", CASES)
def test_no_settled_sphere_is_below_the_objects_floor(case):
    cloud, radius, centers = settled_on(case)
    assert centers[:, 2].min() >= cloud.bounds[0, 2] + (1 - CONTACT) * radius


@pytest.mark.parametrize("name, radius", [("mug_01", 0.008), ("stool_01", 0.02)])
def test_every_shape_holds_the_same_spheres(name, radius):
    """What spheres collide with is made in three ways; the object is the same."""
    cloud, counts, heights = model(name), [], []
    for shape in SHAPES:
        centers = drop(cloud, radius, shape=shape).centers
        assert cKDTree(cloud.points).query(centers)[0].min() >= (1 - OVERLAP) * radius
        assert cKDTree(centers).query(centers, k=2)[0][:, 1].min() >= (2 - OVERLAP) * radius
        counts.append(len(centers))
        heights.append(centers[:, 2].mean())
    # As between seeds: some five per cent of fifty to a hundred spheres, and a quarter of a radius.
    assert max(counts) < 1.25 * min(counts) and np.ptp(heights) < 0.5 * radius
