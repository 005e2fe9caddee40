"""What goes into the Bullet world, and what comes out: files, rays, groups, shapes, spheres that fall and touch."""

from __future__ import annotations

from dataclasses import replace

import clouds
import numpy as np
import pytest
import trimesh

from spherefunc_bullet.bullet.collision.shape import collision_shape, of_mesh, require_room, with_slivers
from spherefunc_bullet.bullet.engine import pybullet
from spherefunc_bullet.bullet.loading import LONG, SHORT, rays, sphere_of_urdf, write_groups, write_stl
from spherefunc_bullet.bullet.physics import Physics
from spherefunc_bullet.bullet.world import BAKED, FAR, World, neighbors, waiting
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.simulator import DropSettings, Outcome, Stop, make_simulator

RANDOM = np.random.default_rng
BOX = trimesh.creation.box((0.4, 0.2, 0.1))


def boxed(extents=(0.4, 0.2, 0.1)) -> Cloud:
    box = trimesh.creation.box(extents)
    return cloud_from_mesh(box.vertices, box.faces, "box")


def test_groups_of_centres_are_small_and_near_each_other():
    centers = RANDOM(0).uniform(0, [30, 10, 1], (1000, 3))
    groups = neighbors(centers, BAKED)
    assert sorted(np.concatenate(groups)) == list(range(1000)) and max(map(len, groups)) <= BAKED
    assert len(groups) == np.ceil(1000 / BAKED)
    assert np.mean([np.ptp(centers[group], axis=0)[:2].max() for group in groups]) < 6  # by lot they would be 25
    assert [group.tolist() for group in neighbors(centers[:3], 16)] == [[0, 1, 2]]


def test_bodies_that_are_not_in_use_touch_nothing():
    places = np.array([waiting(number, x) for number in range(50) for x in (FAR, -FAR)])
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) + 99 * np.eye(100)
    assert apart.min() > 4 and np.abs(places[:, 0]).min() == FAR


def test_a_sphere_of_the_air_falls_is_slowed_and_touches_what_it_lies_on():
    board = boxed((0.4, 0.4, 0.05))
    with World(Physics()) as world:
        world.add_object(of_mesh(board, 0.02))
        world.add_spheres(2)
        top = board.bounds[1, 2] / 0.02
        world.place(0, [0, 0, top + 1 + 3])
        world.park(1)
        assert np.isinf(world.contacts(0)).all()
        world.step()
        time = world.physics.look
        assert world.positions()[0, 2] == pytest.approx(top + 4 - 0.5 * time**2, abs=0.06 * time)
        world.limit_speed(0, 0.25)
        (velocity, _), scale = pybullet().getBaseVelocity(world.air[0], world.client), world.scale
        assert velocity == pytest.approx((0, 0, -0.25 * scale))
        world.limit_speed(0, 9.0)
        assert pybullet().getBaseVelocity(world.air[0], world.client)[0] == velocity
        for _ in range(20):
            world.step()
        to_object, nearest = world.contacts(0)
        assert nearest == to_object == pytest.approx(0, abs=0.02)
        world.freeze(world.positions()[0] + [1.9, 0, 0])
        world.step()
        assert world.contacts(0)[1] < -0.03 < world.contacts(0)[0]
        world.renew(1)
        assert world.positions()[1, 0] == pytest.approx(FAR)


def test_a_dropped_run_counts_what_became_of_each_column():
    cloud, settings = boxed((0.3, 0.3, 0.04)), DropSettings(radius=0.02, max_drops=30, miss_limit=30)
    result = make_simulator("bullet").drop(cloud, settings, 5)
    assert result.drops == 30 == len(result.outcomes) == len(result.columns) and result.stop == Stop.DROP_LIMIT
    lost = (Outcome.ROLLED_OFF, Outcome.REJECTED, Outcome.TIMED_OUT)
    counts = [int((result.outcomes == kind).sum()) for kind in lost]
    assert counts == [result.rolled_off, result.rejected, result.timed_out] and result.settled == 30 - sum(counts)
    assert (np.abs(result.columns) <= 0.15).all() and result.on_object.any()
    few = make_simulator("bullet").drop(cloud, replace(settings, max_spheres=3, max_drops=None), 5)
    assert few.settled == 3 and few.stop == Stop.SPHERE_LIMIT


@pytest.mark.parametrize("pieces", [None, (np.eye(3),)])
def test_rays_go_through_faces_all_over_a_shape(pieces):
    shape = replace(of_mesh(boxed(), 0.05), pieces=pieces)
    starts, ends = rays(shape, 200)
    length = SHORT if pieces is None else LONG
    assert np.linalg.norm(ends - starts, axis=1) == pytest.approx(2 * length)
    middles = (starts + ends) / 2
    corners = shape.vertices[shape.faces].mean(axis=1)
    assert all(np.abs(corners - middle).sum(axis=1).min() < 1e-9 for middle in middles)
    assert len(middles) > 1 and len(rays(shape, 2)[0]) <= 3


def test_what_is_written_is_what_is_read(tmp_path):
    write_stl(tmp_path / "box.stl", BOX.vertices, BOX.faces)
    again = trimesh.load(tmp_path / "box.stl")
    assert again.volume == pytest.approx(BOX.volume) and len(again.faces) == len(BOX.faces)
    pieces = [RANDOM(k).uniform(size=(3 + k, 3)) for k in range(3)]
    write_groups(tmp_path / "some.obj", pieces)
    lines = (tmp_path / "some.obj").read_text().split("\n")
    vertices = np.array([line.split()[1:] for line in lines if line[:2] == "v "], float)
    faces = np.array([line.split()[1:] for line in lines if line[:2] == "f "], int)
    assert np.allclose(vertices, np.concatenate(pieces), rtol=1e-6) and len([x for x in lines if x[:2] == "o "]) == 3
    owners = np.repeat(range(3), [3, 4, 5])[faces - 1]
    assert (owners == owners[:, :1]).all() and set(faces.ravel()) == set(range(1, 13)) and len(faces) == 1 + 2 + 3
    assert 'xyz="1 2 -3"' in sphere_of_urdf([1, 2, -3], 0.5) and 'radius="0.5"' in sphere_of_urdf([1, 2, -3], 0.5)


def test_points_without_a_face_get_slivers_to_their_nearest():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [3, 0, 0], [3.5, 0, 0], [30, 0, 0.0]])
    vertices, faces = with_slivers(points, np.array([[0, 1, 2]], np.int32), 0.5)
    assert len(vertices) == len(points) + 2 * 3 and np.array_equal(vertices[:6], points)
    assert set(faces.ravel()) == set(range(12)) and np.abs(vertices[6:] - np.tile(points[3:], (2, 1))).max() < 0.011
    linked = [set(face[:2]) for face in faces.tolist() if max(face[:2]) < 6]
    assert {3, 4} in linked and not any(5 in pair for pair in linked)  # as far as a gap, not farther
    same = with_slivers(points[:3], np.array([[0, 1, 2]], np.int32), 0.5)
    assert len(same[0]) == 3


def test_shapes_are_in_radii_and_say_so_in_metres():
    cloud = boxed((0.4, 0.3, 0.1))
    exact = collision_shape(cloud, 0.05, "mesh")
    assert np.ptp(exact.vertices, axis=0) == pytest.approx([8, 6, 2]) == np.ptp(exact.columns, axis=0)
    assert exact.facts(0.05) == {"kind": "mesh", "faces": 12, "voxel_size": None, "gap": None}
    spanned = collision_shape(cloud, 0.05, "compound", 0.03)
    facts = spanned.facts(0.05)
    assert facts["voxel_size"] == pytest.approx(0.03) and facts["pieces"] == len(spanned.pieces) > 0
    assert facts["gap"] == pytest.approx(0.05 * spanned.gap) and spanned.gap > 0.6
    with pytest.raises(InputError):
        collision_shape(clouds.plate(), 0.05, "mesh")
    with pytest.raises(InputError):
        require_room("it", np.broadcast_to(np.int32(0), (12_000_001, 3)))
    assert require_room("it", np.broadcast_to(np.int32(0), (12_000_000, 3))).shape[1] == 3


def test_minute_faces_are_met_as_voxels():
    """Where a face is smaller on average than some ten thousandths of a sphere's square radius."""
    simulator, box = make_simulator("bullet"), boxed()
    mean = box_area(box) / len(box.mesh.faces)
    assert simulator.kind_for(box, np.sqrt(mean / 3e-4) * 0.99) == "mesh"
    assert simulator.kind_for(box, np.sqrt(mean / 3e-4) * 1.01) == "voxel" == simulator.kind_for(clouds.mug(), 0.01)
    assert make_simulator("bullet", shape="compound").kind_for(box, 0.01) == "compound"


def box_area(cloud: Cloud) -> float:
    return float(trimesh.Trimesh(cloud.mesh.vertices, cloud.mesh.faces).area)


def test_spheres_start_right_above_what_lies_under_them(monkeypatch):
    """Nobody watches them fall through empty air: less than half a radius, and they touch nothing yet."""
    starts, place, board = [], World.place, boxed((0.4, 0.4, 0.04))
    monkeypatch.setattr(World, "place", lambda world, slot, at: (starts.append(tuple(at)), place(world, slot, at)))
    make_simulator("bullet").drop(board, DropSettings(radius=0.02, max_drops=8, miss_limit=8, max_spheres=8), 0)
    heights = np.array([z for x, _, z in starts if abs(x) < 100]) - board.bounds[1, 2] / 0.02 - 1
    assert len(heights) >= 4 and heights.min() > 0 and np.median(heights) < 0.5
