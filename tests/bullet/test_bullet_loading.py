"""What goes into the Bullet world, and what comes out: files, rays, groups, shapes, spheres that fall and touch."""

from __future__ import annotations

from dataclasses import replace

import clouds
import numpy as np
import pytest
import trimesh
from clouds import boxed

from spherefunc_bullet.bullet.bodies.carrying import Carriage
from spherefunc_bullet.bullet.collision.shape import collision_shape, of_mesh, require_room, with_slivers
from spherefunc_bullet.bullet.dropping import DropRun
from spherefunc_bullet.bullet.engine import Physics, pybullet
from spherefunc_bullet.bullet.loading import LONG, SHORT, rays, sphere_of_urdf, write_groups, write_stl
from spherefunc_bullet.bullet.world import BAKED, FAR, World, neighbors, waiting
from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.clouds.flooding import Basin
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.simulator import DropSettings, Outcome, Stop, make_simulator

RANDOM = np.random.default_rng
BOX = trimesh.creation.box((0.4, 0.2, 0.1))


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
        time = world.physics.check_interval
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


class StillWorld:
    """A world in which nothing moves: it notes what is asked of it."""

    def __init__(self):
        self.physics, self.frozen, self.renewed, self.parked, self.near = Physics(), [], [], [], (np.inf, np.inf)
        self.freeze, self.renew, self.park = self.frozen.append, self.renewed.append, self.parked.append
        self.placed = {}

    def add_spheres(self, count: int):
        self.count = count

    def contacts(self, slot: int) -> tuple[float, float]:
        return self.near

    def place(self, slot: int, at: tuple[float, float, float]):
        self.placed[slot] = at


def still_run(size: float = 0.4, **limits) -> DropRun:
    """Return a run above a board of a size, metres, whose top is one radius above the ground."""
    board, settings = boxed((size, size, 0.02)), DropSettings(radius=0.02, **limits)
    return DropRun(StillWorld(), of_mesh(board, 0.02), board, settings, 0)


@pytest.mark.parametrize(
    ("place", "on_object", "outcome"),
    [
        ((0, 0, 2.0), True, Outcome.SETTLED), ((0, 0, 0.97), True, Outcome.ROLLED_OFF),
        ((10.9, 0, 1.5), True, Outcome.SETTLED), ((10.9, 0, 1.5), False, Outcome.REJECTED),
        ((0, 0, 1.93), True, Outcome.TIMED_OUT), ((0, 0, 3.9), False, Outcome.REJECTED),
    ],
)  # fmt: skip
def test_where_a_sphere_may_rest(place, on_object, outcome):
    """On the object, or on others within its box; not on the ground, and not deep in the cloud."""
    run = still_run()
    before = run.columns.height(0.5, 0.0)
    assert run.resting_place(np.array(place), on_object) == outcome
    settled = outcome == Outcome.SETTLED
    assert len(run.world.frozen) == len(run.centers) == len(run.on_object) == settled
    if place == (0, 0, 2.0):
        assert before == pytest.approx(2, abs=0.1)
        assert run.columns.height(0.5, 0.0) == pytest.approx(2 + np.sqrt(4 - 0.25))


@pytest.mark.parametrize(
    ("near", "late", "ends"),
    [
        ((0.0, 0.0), False, Outcome.SETTLED), ((0.0, -0.035), False, None), ((0.0, -0.035), True, Outcome.SETTLED),
        ((0.0, -0.06), True, Outcome.TIMED_OUT), ((0.03, 0.0), False, Outcome.REJECTED),
    ],
)  # fmt: skip
def test_a_sphere_that_is_pushed_out_yet_is_watched_until_its_time_is_over(near, late, ends):
    run = still_run()
    run.flights.start(0, (10.5, 0.0, 2.0))
    run.starts[0], run.flights.slow[0] = (3.0, 4.0), 9.0
    run.flights.time[0], run.world.near = 1e9 * late, near
    run.end(0, Outcome.SETTLED)
    assert run.flights.flying[0] == (ends is None) and run.outcomes == [ends] * (ends is not None)
    assert run.flights.slow[0] == (0 if ends is None else 9) and run.ended_at == [(3.0, 4.0)] * (ends is not None)


def test_a_sphere_that_is_nowhere_is_replaced_and_counts_as_given_up():
    run = still_run(miss_limit=2)
    for slot, place in enumerate([(np.nan, 0, 0), (0.0, 0.0, 0.0), (0.0, 0.0, 2.0)]):
        run.flights.start(slot, place)
    run.end(0, Outcome.TIMED_OUT)
    assert run.world.renewed == [0] and run.misses == 1 and not run.over
    run.world.near = (0.0, 0.0)
    run.end(2, Outcome.SETTLED)
    assert run.misses == 0 and run.world.renewed == [0]
    for _ in range(2):
        assert not run.over
        run.end(1, Outcome.ROLLED_OFF)
    assert run.over and run.stop() == Stop.MISSES and run.world.renewed == [0]
    result = run.result(1.0, make_simulator("fast").drop(boxed(), DropSettings(radius=0.02, max_drops=1)).provenance)
    assert (result.settled, result.timed_out, result.rolled_off, result.rejected) == (1, 1, 2, 0)
    assert result.centers.tolist() == [[0, 0, 0.04]] and result.on_object.tolist() == [True]


@pytest.mark.parametrize(("size", "most"), [(0.05, 1), (0.3, 7), (2.0, 16)])
def test_as_many_spheres_are_in_the_air_as_there_is_room_for(size, most):
    run = still_run(size, max_drops=1000)
    assert run.world.count == len(run.flights.flying) == pytest.approx(most, abs=most == 7)
    run.launch()
    places = np.array(list(run.world.placed.values()))
    assert 1 <= len(places) <= run.world.count and len(places) == run.flights.flying.sum()
    assert (np.abs(places[:, :2]) <= 25 * size).all() and places[:, 2] == pytest.approx(2.1, abs=0.06)
    apart = np.linalg.norm(places[:, None, :2] - places[None, :, :2], axis=2) + 99 * np.eye(len(places))
    assert apart.min() > 2.2 and {*run.world.placed, *run.world.parked} == set(range(run.world.count))
    drawn = np.random.default_rng(0).uniform(run.low[:2], run.high[:2], size=(1024, 2))
    assert all(np.abs(drawn - place[:2]).sum(axis=1).min() < 1e-12 for place in places)


def test_what_is_nearly_too_fast_is_slowed_and_nothing_else():
    """At eight tenths of the speed at which a sphere might come through a wall between two steps."""
    run, slowed = still_run(max_drops=1000), []
    run.world.limit_speed = lambda slot, limit: slowed.append((slot, limit))
    limit, look = run.world.physics.terminal_speed, run.world.physics.check_interval
    for shares, expected in ([0.1, 0.79, 0.0], []), ([0.1, 0.81, 0.9], [1, 2]):
        for slot in range(3):
            run.flights.start(slot, (slot, 0.0, 500.0))
        ways = np.zeros_like(run.flights.positions)
        ways[:3, 2] = -np.array(shares) * limit * look
        there = run.flights.positions + ways
        run.world.positions = lambda there=there: there
        run.check()
        assert slowed == [(slot, limit) for slot in expected] and not run.outcomes


def test_over_empty_ground_a_drop_is_a_miss_without_a_flight():
    run = still_run(miss_limit=3)
    run.columns.height = lambda x, y: -np.inf
    run.launch()
    assert run.outcomes == [Outcome.ROLLED_OFF] * 3 and run.over and not run.flights.flying.any()
    assert not run.world.placed and len({*map(tuple, run.ended_at)}) == 3


def test_what_leaves_a_vessel_is_taken_away_and_what_came_through_its_wall_is_counted():
    with World(replace(Physics(), rolling_friction=0.0)) as world:
        world.add_object(of_mesh(boxed((0.4, 0.4, 0.02)), 0.02))
        cells = Basin(np.array([-10.0, -10, 1]), 1.0, np.ones((20, 20, 8), bool), 1.0)
        carriage = Carriage(world, cells, np.array([[0, 0, 2.0], [4, 0, 2], [-4, 0, 2], [0, 5, 2]]))
        still, move = np.array([0, 0, -1.0]), pybullet().resetBasePositionAndOrientation
        carriage.damp(0.1)
        for _ in range(3):
            carriage.advance(still)
        assert len(world.air) == 4 and carriage.crossed == 0
        for slot, place in ((1, (4, 0, -30)), (2, (-4, 40, 2))):  # through the board, and away over its edge
            move(world.air[slot], [world.scale * x for x in place], [0, 0, 0, 1], **world.engine)
        carriage.advance(still)
        assert len(world.air) == 2 == len(carriage.seen) and carriage.crossed == 1
        assert np.allclose(carriage.seen[:, :2], [[0, 0], [0, 5]], atol=0.1)
        carriage.advance(np.array([1.0, 0, 0]))
        assert (world.positions()[:, 0] > 0.05).all()  # gravity pulls the way it is said to
