"""Bodies in the Bullet world by what is known of them: how a vessel leans, how bodies fall, and places are used."""

from __future__ import annotations

from dataclasses import replace

import clouds
import numpy as np
import pytest
import trimesh
from clouds import boxed
from scipy.spatial.transform import Rotation

from spherefunc_bullet.bullet.bodies.carrying import (
    INTERVAL,
    LEAKS,
    WAITING,
    CarryOutcome,
    Filling,
    carry_result,
    filling_of,
    notes_on,
    phases,
    tilted,
)
from spherefunc_bullet.bullet.bodies.falling import APART, ParallelDropWorld, even_rotations, free_body, moved
from spherefunc_bullet.bullet.engine import pybullet
from spherefunc_bullet.bullet.proofs.setting_down import inertia_of, put_down
from spherefunc_bullet.bullet.proofs.sitter import BREADTH, SLID, STILL, SUNK, sit_down, spread_of, why_not
from spherefunc_bullet.bullet.proofs.stage import G, Stage, shape_of, tilt_of
from spherefunc_bullet.bullet.proofs.stream import OPENING, PACKED, pour, sphere_radius
from spherefunc_bullet.clouds.cloud import Cloud, Mesh, cloud_from_mesh
from spherefunc_bullet.clouds.flooding import Basin
from spherefunc_bullet.simulator import DropSettings, Stop, make_simulator
from spherefunc_bullet.simulator.mechanics import CarrySettings, Material
from spherefunc_bullet.simulator.proofs import PourUse, ProofSettings, PutUse, SitUse
from spherefunc_bullet.simulator.statics.body import body_of

RANDOM = np.random.default_rng
BOX = trimesh.creation.box((0.4, 0.2, 0.1))


# How a vessel is carried


def test_a_vessel_leans_to_every_side_at_each_angle_and_is_set_down():
    settings, radius = CarrySettings(angles_deg=(10.0, 30.0), shake=0.0), 0.005
    ways = list(phases(settings, 60, radius))
    wait, before = int(WAITING / INTERVAL), 0.0
    assert len(ways) == 3 and [way.shaken for way in ways] == [False, False, True]
    for way, angle in zip(ways[:2], settings.angles_deg, strict=True):
        assert np.allclose(np.linalg.norm(way.gravity, axis=1), 1)
        leans = np.degrees(np.arccos(-way.gravity[:, 2]))
        rising = np.flatnonzero(leans < angle - 1e-6)
        assert leans[0] == pytest.approx(before, abs=1e-6) and (np.diff(leans[rising]) > 0).all()
        assert np.array_equal(rising, np.arange(len(rising))) and np.allclose(leans[len(rising) :], angle)
        headings = np.degrees(np.arctan2(way.gravity[:, 1], way.gravity[:, 0]))[len(rising) :] % 360
        turning = headings[wait:-wait]
        assert np.allclose([headings[:wait], headings[-wait:]], 0, atol=1e-6)  # it waits before it turns, and after
        assert np.allclose(np.diff(turning), turning[1]) and turning[-1] + turning[1] >= 360 - 1e-6
        before = angle
    assert np.degrees(np.arccos(-ways[2].gravity[0, 2])) == pytest.approx(30) and np.allclose(
        ways[2].gravity[wait - 1 :], [0, 0, -1]
    )
    assert np.allclose(
        tilted(np.array([90.0, 90, 30]), np.array([0.0, 90, 45])),
        [
            [1, 0, 0],
            [0, 1, 0],
            [8**-0.5, 8**-0.5, -np.sqrt(0.75)],
        ],
    )


@pytest.mark.parametrize(("spheres", "faster"), [(1, 3.0), (100, 5.0), (1000, 14.0)])
def test_few_spheres_are_turned_slowly_and_many_faster_and_haste_counts(spheres, faster):
    for haste in (1.0, 0.5):
        (way, _) = phases(CarrySettings(angles_deg=(30.0,), haste=haste), spheres, 0.005)
        headings = np.degrees(np.arctan2(way.gravity[:, 1], way.gravity[:, 0])) % 360
        turn = headings[(headings > 1e-6) & (headings < 180)]
        assert turn[0] == pytest.approx(haste * faster * INTERVAL)


def basin(fullness: float = 1.0) -> Basin:
    """Return a basin of ten cells in each direction, of one radius each."""
    return Basin(np.zeros(3), 1.0, np.ones((10, 10, 10), bool), fullness)


def filled(count: int, stop: Stop, radius: float = 0.01):
    """Return a run in which spheres settled at heights of half a radius on, and two beside the vessel."""
    heights = np.linspace(0.5, 7.5, count)
    centers = np.column_stack([np.full(count, 5.0), np.full(count, 5.0), heights])
    centers = np.concatenate([centers, [[20, 0, 0.1], [0, -30, 0.1]]])[RANDOM(0).permutation(count + 2)]
    result = make_simulator("fast").drop(clouds.plate(), DropSettings(radius=0.02, max_drops=1, miss_limit=1))
    unknown = {"columns": np.empty((0, 2)), "outcomes": np.empty(0, np.int8)}
    return replace(result, centers=centers * radius, stop=stop, **unknown)


def test_a_vessel_is_filled_from_below_with_what_is_in_it():
    full = filling_of(filled(20, Stop.MISSES), 0.01, basin(), 0.5)
    assert len(full.centers) == full.full == 10 and full.centers[:, 2].max() < 4 and (full.centers[:, 0] == 5).all()
    assert filling_of(filled(20, Stop.MISSES), 0.01, basin(0.5), 0.5).full == 20  # with whole walls it would hold twice
    reached = filling_of(filled(16, Stop.SPHERE_LIMIT), 0.01, basin(), 0.4)  # they reach up to eight tenths of it
    assert reached.full == len(reached.centers) == 8
    assert filling_of(filled(16, Stop.SPHERE_LIMIT), 0.01, basin(), 0.9).full == 16  # too few: all of them
    assert filling_of(filled(0, Stop.MISSES), 0.01, basin(), 0.5).full == 0


def test_what_is_kept_is_said_of_what_a_whole_vessel_would_hold():
    settings, some = CarrySettings(angles_deg=(10.0, 20.0), density=800.0), RANDOM(0).uniform(size=(5, 3))
    kept = carry_result(CarryOutcome([6, 5, 4], some, 0), Filling(some, 8), basin(0.6), 0.01, settings, 1.0, {})
    assert kept.kept == (6 / 8, 5 / 8) and kept.kept_shaken == 4 / 8 and kept.filled == 5 and kept.holds == 0.6
    assert np.allclose(kept.centers, 0.01 * some) and "hole" in kept.notes[0] and "60 %" in kept.notes[0]
    assert kept.weight == pytest.approx(5 * 800 * 4 / 3 * np.pi * 1e-6)
    assert carry_result(
        CarryOutcome([1, 1, 0], some, 0), Filling(some[:1], 1), basin(), 0.01, settings, 1.0, {}
    ).kept == (1, 1)
    none = carry_result(CarryOutcome([0, 0, 0], some[:0], 0), Filling(some[:0], 0), basin(), 0.01, settings, 1.0, {})
    assert none.kept == (0, 0) and none.kept_shaken == 0 and none.weight == 0 and len(none.notes) == 1
    assert none.centers.shape == (0, 3)
    assert notes_on(Filling(some, 8), basin(LEAKS)) == () != notes_on(Filling(some, 8), basin(LEAKS - 0.01))


# Free bodies


def test_directions_of_drops_are_spread_evenly():
    for seed in (0, 1):
        down = -even_rotations(400, seed)[:, 2]  # which way of the body points down
        assert np.allclose(np.linalg.norm(down, axis=1), 1) and np.abs(down.mean(axis=0)).max() < 0.01
        near = np.sort(np.arccos(np.clip(down @ down.T, -1, 1)), axis=1)[:, 1]
        assert near.min() > 0.6 * near.max()  # by lot some would be next to others
    assert not np.allclose(even_rotations(5, 0), even_rotations(5, 1))


def test_a_body_s_axes_are_those_of_its_inertia():
    askew = Rotation.from_euler("xyz", [0.3, 0.5, 0.2]).as_matrix()
    body = body_of(cloud_from_mesh(BOX.vertices @ askew.T, BOX.faces, "box"), Material())
    free = free_body(body)
    assert np.linalg.det(free.axes) == pytest.approx(1) and np.allclose(np.diff(free.inertia) >= 0, True)
    assert np.allclose(free.axes @ np.diag(free.inertia) @ free.axes.T, body.inertia / body.mass / body.extent**2)
    assert np.ptp(free.corners, axis=0) == pytest.approx(np.array([0.4, 0.2, 0.1]) / body.extent)
    turns = free.world_rotation(np.array([np.eye(3), askew]))
    assert np.allclose(free.down(turns), [[0, 0, -1], -askew[2]])


def test_a_body_has_moved_by_its_way_or_by_its_turn():
    places, turns = np.zeros((4, 3)), np.tile(np.eye(3), (4, 1, 1))
    other = Rotation.from_euler("z", [[0], [0.01], [0], [0.001]]).as_matrix()
    ways = np.array([[0.02, 0, 0], [0, 0.003, 0.004], [np.nan, 0, 0], [0, 0, 0]])
    found = moved(places, turns, ways, other)
    assert found[:2] == pytest.approx([0.02, 0.01], rel=1e-3) and np.isinf(found[2])
    assert found[3] == pytest.approx(0.001, rel=1e-3)


def test_bodies_begin_over_places_of_their_own_at_the_height_they_fall_from():
    free = free_body(body_of(boxed(), Material()))
    with ParallelDropWorld(Material()) as world:
        hull, turn = world.hull(free), free.world_rotation(np.eye(3)[None])[0]
        numbers = [world.add(free, hull, turn, 0.25, place) for place in range(20)]
        places, turns = world.state(numbers, np.arange(20))
        apart = np.linalg.norm(places[:, None, :2] - places[None, :, :2], axis=2) + 9 * np.eye(20)
        assert apart.min() == pytest.approx(APART) and np.allclose(turns, turn, atol=1e-6)
        lowest = (free.corners @ turn.T)[:, 2].min()
        assert np.allclose(places[:, 2] + lowest, 0.25, atol=1e-6)
        down = world.until_rest([free] * 20, numbers, lambda left, down: np.ones(len(left), bool), 60.0)
        assert np.allclose(down, [0, 0, -1], atol=1e-2)
        again = [world.add(free, hull, turn, 0.25, 0)]
        late = world.until_rest([free], again, lambda left, down: np.zeros(len(left), bool), 20.0)
        assert np.isnan(late).all()  # balance is no rest
        assert world.state(again, np.arange(1))[0][0] == pytest.approx([0, 0, -lowest], abs=0.01)  # on level ground
        high = [world.add(free, hull, turn, 50.0, 0)]
        falls = world.until_rest([free], high, lambda left, down: np.ones(len(left), bool), 9.0)
        assert np.isnan(falls).all()  # in the air for ten units of time


# Places that are used


@pytest.mark.parametrize(
    ("moved", "tipped", "speed", "spread", "why"),
    [
        ((0, 0, 0), False, 0, 1, ""), ((0, 0, -1.01 * SUNK), True, 9, 0, "sank"), ((9, 9, 0), True, 0, 1, "tipped"),
        ((0.8 * SLID, 0.8 * SLID, 0), False, 0, 1, "slid"), ((0.6 * SLID, 0.6 * SLID, 0), False, 0, 1, ""),
        ((0, 0, 1.01 * SUNK), False, 9, 0, "knees hit"), ((0, 0, 0.99 * SUNK), False, 0, 1, ""),
        ((0, 0, -0.99 * SUNK), False, 1.01 * STILL, 0, "slid"), ((0, 0, 0), False, 0.99 * STILL, 1, ""),
        ((0, 0, 0), False, 0, 0.99 * BREADTH, "sharp"), ((0, 0, 0), False, 0, 1.01 * BREADTH, ""),
    ],
)  # fmt: skip
def test_why_a_person_does_not_sit(moved, tipped, speed, spread, why):
    for scale in (1.0, 0.7):
        sized = scale * np.array(moved), tipped, speed, scale * spread, scale
        assert why_not(*sized) == why


@pytest.mark.parametrize("person", [1.2, 1.75, 2.0])
def test_who_sits_is_pushed_from_four_sides_as_hard_as_large(monkeypatch, person):
    """On a stool of a person's size nobody slides or sinks, however large; where the seat is lower, they sink."""
    pushes, push, scale = [], Stage.push, person / 1.75
    monkeypatch.setattr(Stage, "push", lambda stage, body, *how: (pushes.append(how), push(stage, body, *how)))
    stool = boxed((0.4 * scale, 0.4 * scale, 0.45 * scale))
    use = SitUse(position=np.array([0, 0, stool.bounds[1, 2]]), heading=0.3)
    with Stage(stool, 0.6) as stage:
        verdict = sit_down(stage, use, ProofSettings(person=person))
        assert verdict.held and verdict.moved < 0.08 * scale and verdict.tilt_deg < 15
        newtons, headings, seconds, _ = np.array(pushes).T
        assert newtons == pytest.approx(40 * scale**3) and np.diff(headings) == pytest.approx(np.pi / 2)
        assert headings[0] == pytest.approx(0.3) and len(pushes) == 4 and (0 < seconds).all() and (seconds < 0.5).all()
        air = replace(use, position=use.position + [0, 0, 0.2])
        assert not sit_down(stage, air, ProofSettings(person=person)).held and len(pushes) == 4
        assert pybullet().getNumBodies(**stage.engine) == 2


def test_a_person_is_let_down_from_above_and_touches_nothing_before(monkeypatch):
    stool, gaps, steps = boxed((0.4, 0.4, 0.45)), [], Stage.steps

    def watched(stage: Stage, seconds: float, rate: float):
        person = pybullet().getBodyUniqueId(pybullet().getNumBodies(**stage.engine) - 1, **stage.engine)
        near = pybullet().getClosestPoints(person, stage.object, 0.5, **stage.engine)
        gaps.append(min(point[8] for point in near))
        steps(stage, seconds, rate)

    monkeypatch.setattr(Stage, "steps", watched)
    with Stage(stool, 0.6) as stage:
        sit_down(stage, SitUse(position=np.array([0, 0, stool.bounds[1, 2]]), heading=0.0), ProofSettings())
    assert 0 < gaps[0] < 0.05 and max(gaps[1:]) < 0.005  # then it sits


def test_the_breadth_over_which_contacts_carry():
    """Two points with as much force are as broad as they are apart, however they lie; one is none."""

    def contact(x: float, y: float, force: float) -> tuple:
        return (*[None] * 6, (x, y, 0.5), None, None, force)

    assert spread_of([]) == 0 == spread_of([contact(1, 1, 0)]) and spread_of([contact(1, 2, 5)]) == pytest.approx(0)
    pair = [contact(0, 0, 3), contact(0.3, 0.4, 3)]
    assert spread_of(pair) == pytest.approx(0.5) and spread_of([*pair, contact(9, 9, 0)]) == pytest.approx(0.5)
    assert spread_of([contact(0, 0, 9), contact(0.3, 0.4, 1)]) == pytest.approx(2 * 0.5 * np.sqrt(0.09))


def test_spheres_stand_for_a_volume_or_fit_through_the_opening():
    use = PourUse(position=np.zeros(3), radius=0.04, volume=1e-4, low=np.zeros(3), high=np.ones(3))
    radius = sphere_radius(use, 50)
    assert 50 * 4 / 3 * np.pi * radius**3 == pytest.approx(PACKED * use.volume)
    assert use.radius > sphere_radius(replace(use, volume=1.0), 50) == pytest.approx(OPENING * use.radius)


def test_a_stream_stays_in_a_box_and_runs_off_a_lid(monkeypatch):
    """What is over a rim by less than a sphere is inside yet, and what has run off is not."""
    bottom, wall = trimesh.creation.box((0.1, 0.1, 0.01)), []
    for x, y, sx, sy in ((0.05, 0, 0.01, 0.11), (-0.05, 0, 0.01, 0.11), (0, 0.05, 0.11, 0.01), (0, -0.05, 0.11, 0.01)):
        wall.append(trimesh.creation.box((sx, sy, 0.1)).apply_translation([x, y, 0.05]))
    use = PourUse(position=np.array([0, 0, 0.14]), radius=0.045, volume=3e-4,
                  low=np.array([-0.05, -0.05, 0]), high=np.array([0.05, 0.05, 0.1]))  # fmt: skip
    shares, steps, aside = {}, Stage.steps, set()

    def watched(stage: Stage, seconds: float, rate: float):
        aside.add(round(pybullet().getPhysicsEngineParameters(**stage.engine)["gravityAccelerationX"] / G, 6))
        steps(stage, seconds, rate)

    monkeypatch.setattr(Stage, "steps", watched)
    half, lid = trimesh.creation.box((0.05, 0.1, 0.01)), bottom.copy().apply_translation([0, 0, 0.1])
    half.apply_translation([-0.025, 0, 0.05])
    for name, parts in (("box", [bottom, *wall]), ("half", [half, *wall]), ("lid", [lid])):
        mesh = trimesh.util.concatenate(parts)
        with Stage(Cloud(mesh.sample(500, seed=0), name, Mesh(mesh.vertices, mesh.faces)), 0.6) as stage:
            low = np.array([-0.05, -0.05, 0.04 * (name == "half")])  # what falls through lies below
            verdict = pour(stage, replace(use, low=low), ProofSettings(spheres=20), 0)
            assert pybullet().getNumBodies(**stage.engine) == 2  # what was poured is gone
            after = pybullet().getPhysicsEngineParameters(**stage.engine)
            assert [after[f"gravityAcceleration{axis}"] for axis in "XYZ"] == pytest.approx([0, 0, -G])
            assert verdict.held == (verdict.why == "") and verdict.tilt_deg == 0
            shares[name] = 1 - verdict.moved
    assert shares["box"] > 0.9 and shares["lid"] < 0.3 < shares["half"] < 0.9
    assert len(aside) == 3 and max(aside) == -min(aside) < 0.1  # carried level, to one side and to the other
    assert 20 * shares["half"] == pytest.approx(round(20 * shares["half"]))  # of so many spheres


@pytest.mark.parametrize(("friction", "aside", "why"), [(0.6, 0.0, ""), (0.01, 0.0, "slid"), (0.6, 1.01, "tipped")])
def test_what_is_put_down_is_pushed_and_looked_at_again(friction, aside, why):
    """On ice it stays until somebody pushes; with its weight beyond the edge it tips."""
    pose, block, board = np.eye(4), boxed((0.05, 0.05, 0.06)), boxed((2.0, 0.3, 0.05))
    pose[:3, 3] = [aside, 0, board.bounds[1, 2] - block.bounds[0, 2]]
    use = PutUse(cloud=block, pose=pose)
    with Stage(board, friction) as stage:
        verdict = put_down(stage, use, ProofSettings())
        assert (verdict.held, verdict.why) == (why == "", why) and (verdict.moved > 0.02) == (why != "")
        assert pybullet().getNumBodies(**stage.engine) == 2
        if why == "slid":
            assert put_down(stage, use, ProofSettings(push=0.0)).held


def test_a_stage_s_friction_time_and_push_are_what_they_say():
    with Stage(clouds.plate(), 0.49) as stage:
        for body in (stage.ground, stage.object):
            assert pybullet().getDynamicsInfo(body, -1, **stage.engine)[1] == pytest.approx(0.7)
        p, ball = pybullet(), stage.add_static(pybullet().createCollisionShape(pybullet().GEOM_SPHERE, radius=0.05))
        shape = p.createCollisionShape(p.GEOM_SPHERE, radius=0.05, **stage.engine)
        body = p.createMultiBody(2.0, shape, stage.visual, [0, 0, 50], **stage.engine)
        p.changeDynamics(body, -1, linearDamping=0, angularDamping=0, **stage.engine)
        stage.set_friction(body)
        assert p.getDynamicsInfo(body, -1, **stage.engine)[1] == pytest.approx(0.7) and ball > stage.object
        stage.steps(0.5, 240)
        assert p.getBaseVelocity(body, **stage.engine)[0] == pytest.approx((0, 0, -G / 2), abs=1e-3)
        stage.push(body, 3.0, np.pi / 6, 0.25, 240)
        speed = p.getBaseVelocity(body, **stage.engine)[0]  # force times time over mass
        assert speed[:2] == pytest.approx((0.375 * np.cos(np.pi / 6), 0.375 / 2), abs=1e-3)
    assert [tilt_of(Rotation.from_euler("xz", [degrees, 50], degrees=True).as_quat()) for degrees in (0, 30, 120)] == (
        pytest.approx([0, 30, 120], abs=1e-4)
    )
    box = body_of(boxed(), Material(mass=3.0))
    assert inertia_of(box) == np.diag(box.inertia).tolist()


@pytest.mark.parametrize("scale", [0.3, 1.0, 3.0])
def test_a_stage_takes_a_mesh_as_it_is_and_spans_a_cloud_in_metres(scale):
    mug = clouds.mug(0.04 * scale, 0.1 * scale)
    shape = shape_of(mug)
    assert np.allclose(shape.vertices.min(axis=0), mug.bounds[0], atol=0.01 * scale)
    assert np.allclose(shape.vertices.max(axis=0), mug.bounds[1], atol=0.01 * scale) and shape.gap is None
    assert shape.columns[:, 2].max() == pytest.approx(mug.bounds[1, 2], abs=0.01 * scale)
    exact = shape_of(boxed())
    assert exact.kind == "mesh" and np.ptp(exact.vertices, axis=0) == pytest.approx([0.4, 0.2, 0.1])
