"""The Bullet backend where it could fail: what the engine drops or forgets, damage, time-outs, memory, repetition."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import clouds
import numpy as np
import pytest
from checkout import TESTS

from spherefunc_bullet.clouds.cloud import cloud_from_mesh
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.simulator import DropSettings, Stop, make_simulator

pytest.importorskip("pybullet", reason="PyBullet is not installed")

from spherefunc_bullet.bullet import dropping, engine, loading
from spherefunc_bullet.bullet.backend import SHAPES
from spherefunc_bullet.bullet.collision.shape import CollisionShape, collision_shape
from spherefunc_bullet.bullet.engine import Physics
from spherefunc_bullet.bullet.world import BAKED, BAKED_OF_MANY, MANY, MERGED, TWINS, World

CLIENTS = 64  # more than this process ever has open at once
PAGE = 4096  # bytes; of Linux on every machine that PyBullet has wheels for


def cup():
    """Return a small cup: a run on it takes hundredths of a second."""
    return clouds.mug(0.025, 0.04)


def dropped(cloud=None, radius: float = 0.008, seed: int = 0, **options):
    return make_simulator("bullet", **options).drop(cloud or cup(), DropSettings(radius=radius), seed)


def open_clients() -> int:
    p = engine.pybullet()
    return sum(bool(p.getConnectionInfo(i)["isConnected"]) for i in range(CLIENTS))


def refusal(call, *arguments, **options) -> str:
    """Return the message with which a call is refused, one line."""
    with pytest.raises(InputError) as error:
        call(*arguments, **options)
    assert "\n" not in str(error.value) and len(str(error.value)) < 400
    return str(error.value)


def panel(size: float, pitch: float = 1.0, height: float = 0.0) -> CollisionShape:
    """Return a level square of triangles, lengths in radii."""
    side = np.arange(0, size + pitch / 2, pitch) - size / 2
    count = len(side)
    x, y = np.meshgrid(side, side, indexing="ij")
    first = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    halves = [first, first + 1, first + count + 1], [first, first + count + 1, first + count]
    faces = np.concatenate([np.column_stack(each) for each in halves]).astype(np.int32)
    vertices = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)])
    return CollisionShape(
        name="panel",
        kind="mesh",
        vertices=vertices,
        faces=faces,
        pieces=None,
        columns=vertices,
        voxel_size=None,
        gap=None,
    )


# What does not arrive in the engine


def test_the_whole_shape_is_accepted():
    with World(Physics()) as world:
        world.add_object(panel(20.0))
        assert world.object is not None


@pytest.mark.parametrize("share", [0.5, 0.95])
def test_faces_withheld_at_loading_are_noticed(monkeypatch, share):
    write = loading.write_stl

    def write_some(path, vertices, faces):
        kept = np.random.default_rng(0).random(len(faces)) < share
        write(path, vertices, faces[kept])

    monkeypatch.setattr(loading, "write_stl", write_some)
    with World(Physics()) as world:
        assert "whole shape" in refusal(world.add_object, panel(40.0))


def test_half_of_the_surface_withheld_is_noticed(monkeypatch):
    write = loading.write_stl
    monkeypatch.setattr(loading, "write_stl", lambda path, vertices, faces: write(path, vertices, faces[::2]))
    assert "mug" in refusal(dropped)
    assert open_clients() == 0


def test_pieces_withheld_at_loading_are_noticed(monkeypatch):
    corners = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], float)
    pieces = tuple(corners + [4.0 * i, 4.0 * j, 0] for i in range(6) for j in range(6))
    vertices = np.concatenate(pieces)
    faces = np.concatenate([[[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]] for k in range(36)])
    shape = replace(panel(4.0), kind="compound", vertices=vertices, faces=faces.astype(np.int32), pieces=pieces)
    with World(Physics()) as world:
        world.add_object(shape)
    write = loading.write_groups
    monkeypatch.setattr(loading, "write_groups", lambda path, pieces: write(path, pieces[:BAKED] + pieces[-1:]))
    with World(Physics()) as world:
        assert "whole shape" in refusal(world.add_object, shape)


@pytest.mark.parametrize("shape", [panel(20.0, height=1.0), panel(24.0)], ids=["moved", "larger"])
def test_the_wrong_file_is_noticed(monkeypatch, shape):
    write, other = loading.write_stl, shape
    monkeypatch.setattr(loading, "write_stl", lambda path, *_: write(path, other.vertices, other.faces))
    with World(Physics()) as world:
        assert "whole shape" in refusal(world.add_object, panel(20.0))


@pytest.mark.parametrize("content", [b"", b"solid nothing\nendsolid\n", bytes(84)], ids=["empty", "text", "no faces"])
def test_a_file_that_the_engine_refuses(monkeypatch, content):
    monkeypatch.setattr(loading, "write_stl", lambda path, *_: path.write_bytes(content))
    assert "mug" in refusal(dropped)
    assert open_clients() == 0


@pytest.mark.parametrize("one_engine", [True, False])
def test_a_second_shape_under_the_same_file_name_is_the_second(monkeypatch, tmp_path, one_engine):
    @contextmanager
    def same_folder(prefix):
        yield str(tmp_path)

    monkeypatch.setattr(loading, "TemporaryDirectory", same_folder)
    with World(Physics()) as first, World(Physics()) as second:
        first.add_object(panel(20.0))
        other = first if one_engine else second
        other.add_object(panel(12.0, height=3.0))  # refused if it is the first panel again
        assert other.object is not None


# Spheres at rest


def lattice(count: int) -> np.ndarray:
    """Return places (count, 3) for spheres that do not touch."""
    side = int(np.ceil(np.sqrt(count)))
    place = np.arange(count)
    return np.column_stack([3.0 * (place // side), 3.0 * (place % side), 1.0 + 0.01 * place])


def met_from_above(world: World, centers: np.ndarray) -> np.ndarray:
    """Return the heights at which rays down upon centres meet something, -inf without a function."""
    ends = centers * [1, 1, 0] - [0, 0, 5]
    starts = centers + [0, 0, 100]
    scaled = ((world.scale * each).tolist() for each in (starts, ends))
    hits = engine.pybullet().rayTestBatch(*scaled, **world.engine)
    return np.array([hit[3][2] / world.scale if hit[0] >= 0 else -np.inf for hit in hits])


@pytest.mark.parametrize("count", [1, BAKED + 1, TWINS, TWINS + 1, 4 * TWINS + 1, MANY + 1, 1000])
def test_every_frozen_sphere_is_there(count):
    """Also with more than 16 in a bake, where createCollisionShapeArray would drop some, and after baking anew."""
    centers = np.random.default_rng(0).permutation(lattice(count))
    with World(Physics()) as world:
        empty = engine.pybullet().getNumBodies(**world.engine)
        for center in centers:
            world.freeze(center)
        # Single precision; in a compound some 100 radii wide rays are as exact as 1e-3.
        assert np.abs(met_from_above(world, centers) - centers[:, 2] - 1).max() < 0.005
        baked = sum(len(batch.centers) for batch in world.batches)
        assert baked + len(world.fresh) == count
        for batch in world.batches:
            most = BAKED if len(batch.centers) < MANY else BAKED_OF_MANY
            assert len(batch.compounds) == int(np.ceil(len(batch.centers) / most))
        # As a number is written to the base of 4, with up to three batches of each size.
        assert all(np.unique([len(batch.centers) for batch in world.batches], return_counts=True)[1] < MERGED)
        assert {len(batch.centers) for batch in world.batches} <= {TWINS * MERGED**k for k in range(5)}
        compounds = sum(len(batch.compounds) for batch in world.batches)
        assert engine.pybullet().getNumBodies(**world.engine) == empty + compounds  # none costs time that is baked anew
        still = [*world.twins, *(body for batch in world.batches for body in batch.compounds)]
        materials = {engine.pybullet().getDynamicsInfo(body, -1, **world.engine)[:2] for body in still}
        assert materials == {(0.0, 1.0)}  # of no mass; friction is that of the sphere that moves


@pytest.mark.parametrize("count", [8 * TWINS + 1, MANY + TWINS + 1])  # so many that there are some around (9, 9)
def test_a_sphere_rests_on_baked_spheres(count):
    with World(Physics()) as world:
        place = np.arange(count)
        for center in np.column_stack([2.0 * (place % 12), 2.0 * (place // 12), np.ones(len(place))]):
            world.freeze(center)
        world.add_spheres(1)
        world.place(0, [9.0, 9.0, 1 + np.sqrt(2) + 0.1])
        for _ in range(40):
            world.step()
        # Between four spheres that touch, its centre is sqrt(2) radii above theirs; contacts may give 2 %.
        assert world.positions()[0] == pytest.approx([9, 9, 1 + np.sqrt(2)], abs=0.03)


# Damage and time-outs are outcomes


def test_a_sphere_that_never_rests_times_out_and_the_run_ends():
    result = dropped(time_limit=1e-3)
    assert result.stop == Stop.MISSES and result.settled == 0
    # The others came down where nothing is below; a box has that much beside a circle.
    assert result.timed_out + result.rolled_off == result.drops == 50 and result.timed_out > 50 * np.pi / 4 - 10


@pytest.mark.parametrize("coordinate", [float("nan"), float("inf")])
def test_a_sphere_that_the_engine_lost_is_counted_and_replaced(monkeypatch, coordinate):
    step, renew, looks, renewed = World.step, World.renew, [], []

    def step_and_lose(world):
        step(world)
        looks.append(1)
        if len(looks) in (3, 30, 100):  # when it is under way
            place = [coordinate] * 3
            engine.pybullet().resetBasePositionAndOrientation(world.air[0], place, [0, 0, 0, 1], **world.engine)

    usual = dropped(clouds.mug(), 0.01)
    monkeypatch.setattr(World, "step", step_and_lose)
    monkeypatch.setattr(World, "renew", lambda world, slot: (renewed.append(slot), renew(world, slot)))
    result = dropped(clouds.mug(), 0.01)
    assert renewed == [0, 0, 0] and result.timed_out == usual.timed_out + 3 and result.stop == Stop.MISSES
    # None of the others suffers: the number that settles differs from run to run by about a tenth.
    assert np.isfinite(result.centers).all() and result.settled == pytest.approx(usual.settled, rel=0.3)


def test_mesh_of_an_object_of_points():
    assert "points" in refusal(dropped, shape="mesh") and open_clients() == 0


@pytest.mark.parametrize("shape", SHAPES)
def test_an_object_that_is_a_line_or_a_few_points(shape):
    """No surface to speak of: settles nothing or is refused in one line, but does not crash."""
    line = np.column_stack([np.linspace(0, 0.3, 60), np.zeros(60), np.full(60, 0.1)])
    scattered = np.random.default_rng(0).uniform(0, 0.5, (12, 3))
    for points in (line, scattered, np.repeat(scattered[:1], 12, axis=0) + [[0, 0, 0.1 * k] for k in range(12)]):
        try:
            result = dropped(clouds.cloud(points, name="odd"), 0.02, shape=shape)
        except InputError as error:
            assert "odd" in str(error) and "\n" not in str(error)
        else:
            assert np.isfinite(result.centers).all() and result.stop == Stop.MISSES
    assert open_clients() == 0


@pytest.mark.parametrize(
    "setting, value",
    [
        ("friction", -0.1),
        ("rolling_friction", -1.0),
        ("rolling_friction", float("nan")),
        ("restitution", 1.0),
        ("restitution", -0.5),
        ("time_step", 1.0),
        ("time_step", 0.0),
        ("time_step", float("inf")),
        ("sub_steps", 0),
        ("iterations", 0),
        ("scale", -1.0),
        ("rest_speed", 0.0),
        ("rest_time", 0.0),
        ("time_limit", -3.0),
        ("in_air", 0),
        ("shape", "cube"),
        ("voxel_size", 0.0),
        ("voxel_size", float("nan")),
        ("voxel_size", -0.01),
    ],
)
def test_a_setting_out_of_range_is_named(setting, value):
    message = refusal(make_simulator, "bullet", **{setting: value})
    assert "bullet" in message and setting in message and "expected" in message


def test_without_pybullet(monkeypatch):
    def missing(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(engine, "version", missing)
    engine.engine_version.cache_clear()
    message = refusal(make_simulator, "bullet")
    assert "pip install" in message and "pybullet" in message and "3.11" in message
    assert make_simulator("fast").drop(cup(), DropSettings(radius=0.008), 0).settled > 0


def test_nothing_is_printed(capfd):
    dropped()
    refusal(dropped, shape="mesh")
    assert capfd.readouterr().out == ""


@pytest.mark.slow
def test_nothing_is_printed_by_a_new_process():
    """The engine says when it was built as it is imported, and more when it connects."""
    assert len(printed_by_a_new_process(SCRIPT).splitlines()) == 1  # by the script itself


# What is left behind


@pytest.mark.parametrize("name", ["until_over", "__init__", "result"])
def test_the_engine_is_given_back_when_a_run_fails(monkeypatch, name):
    def fail(*_):
        raise RuntimeError("amid a run")

    monkeypatch.setattr(dropping.DropRun, name, fail)
    with pytest.raises(RuntimeError, match="amid"):
        dropped()
    assert open_clients() == 0


def test_the_engine_is_given_back_after_a_run():
    dropped()
    assert open_clients() == 0


# In a process of its own, since the memory of one in which many tests ran wanders by megabytes.
MEMORY = """
import gc, sys
from pathlib import Path
sys.path.insert(0, {tests!r})
import clouds
from spherefunc_bullet.simulator import DropSettings, make_simulator
simulator, pages = make_simulator("bullet"), []
for i in range(1, 41):
    simulator.drop(clouds.mug(0.025, 0.04), DropSettings(radius=0.008, miss_limit=3), i)
    if i in (10, 40):
        gc.collect()
        pages.append(int(Path("/proc/self/statm").read_text().split()[1]))
print(pages[1] - pages[0])
"""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs Linux's /proc")
def test_memory_stays_over_many_drops():
    # A shape kept by each of the 30 runs would be 30 times 2,200 faces or some 15 MB; the allocator wanders by one.
    assert int(printed_by_a_new_process(MEMORY)) * PAGE < 4e6


# The same bits


SCRIPT = """
import hashlib, sys
sys.path.insert(0, {tests!r})
import clouds
from spherefunc_bullet.simulator import DropSettings, make_simulator
result = make_simulator("bullet", shape="voxel").drop(clouds.mug(0.025, 0.04), DropSettings(radius=0.008), 3)
print(hashlib.sha256(result.centers.tobytes()).hexdigest())
"""


@cache
def printed_by_a_new_process(script: str) -> str:
    """Return what a new process prints that runs a script."""
    code = script.format(tests=str(TESTS / "support"))
    return subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, check=True).stdout


@pytest.mark.slow
def test_same_bits_after_other_objects_and_in_another_process():
    alone = dropped(seed=3).centers.tobytes()
    dropped(clouds.bin_(0.08, 0.08, 0.04), 0.01)
    dropped(clouds.plate(0.15, 0.15), 0.012)
    assert dropped(seed=3).centers.tobytes() == alone
    assert printed_by_a_new_process(SCRIPT).strip() == hashlib.sha256(alone).hexdigest()


@pytest.mark.parametrize("shape", SHAPES)
def test_same_bits_again_in_each_shape(shape):
    corners = np.array([[0, 0, 0.1], [0.2, 0, 0.1], [0.2, 0.2, 0.1], [0, 0.2, 0.1]])
    board = cloud_from_mesh(corners, [[0, 1, 2], [0, 2, 3]], "board")
    first, second = (dropped(board, 0.02, shape=shape) for _ in range(2))
    assert first.settled > 5 and first.centers.tobytes() == second.centers.tobytes()
    # A level square: the same in every shape, up to contacts that give 2 %.
    assert np.abs(first.centers[:, 2] - first.centers[:, 2].mean()).max() < 0.02 * 0.02


def test_another_world_open_beside_it_changes_nothing():
    alone = dropped().centers.tobytes()
    with World(Physics()) as other:
        other.add_object(collision_shape(cup(), 0.008, "voxel"))
        other.add_spheres(1)
        other.step()
        assert dropped().centers.tobytes() == alone
