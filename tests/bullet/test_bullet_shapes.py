"""The collision shape: what is spanned between points, which of them stand for it, and that nothing leaks through."""

from __future__ import annotations

from functools import cache

import clouds
import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from spherefunc_bullet.bullet.backend import BulletSimulator
from spherefunc_bullet.bullet.collision.triangulation import (
    MAX_NEIGHBORS,
    RINGS,
    ROOM,
    faces_between,
    gather,
    point_cells,
    span_faces,
)
from spherefunc_bullet.bullet.collision.voxels import in_voxels, represent, representatives, voxel_normals
from spherefunc_bullet.bullet.columns import ColumnIndex
from spherefunc_bullet.bullet.dropping import (
    IN_FLIGHT,
    LEANING,
    ROLLED_OFF,
    SETTLED,
    TIMED_OUT,
    Flights,
    first_apart,
    update_flights,
)
from spherefunc_bullet.bullet.engine import Physics
from spherefunc_bullet.clouds.cloud import MAX_GAP, Cloud, Mesh, cloud_from_mesh
from spherefunc_bullet.scenes.household.parts.solids import box
from spherefunc_bullet.simulator import DropSettings

FLAT = 0.02  # radii, the tolerance that shapes are made with


def turned(points: np.ndarray, tilt_deg: float, heading_deg: float = 31.0) -> np.ndarray:
    """Return points turned about x and then about z."""
    a, h = np.radians([tilt_deg, heading_deg])
    tilt = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    turn = np.array([[np.cos(h), -np.sin(h), 0], [np.sin(h), np.cos(h), 0], [0, 0, 1]])
    return points @ (turn @ tilt).T


def square(size: float, pitch: float) -> np.ndarray:
    """Return a level lattice (N, 3) about the origin."""
    side = np.linspace(-size / 2, size / 2, int(round(size / pitch)) + 1)
    x, y = np.meshgrid(side, side)
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])


@cache
def blue_noise(size: float, apart: float) -> np.ndarray:
    """Return random points on a level square, none nearer to another than a distance, and nowhere room for one more."""
    fine = square(size, apart / 8)
    fine = np.random.default_rng(0).permutation(fine)
    tree, free, chosen = cKDTree(fine), np.ones(len(fine), bool), []
    for i in range(len(fine)):
        if free[i]:
            chosen.append(i)
            free[tree.query_ball_point(fine[i], apart)] = False
    return fine[chosen]


# Faces between points


def covered(flat: np.ndarray, faces: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return how many of the faces each place (P, 2) lies in."""
    a, b, c = (flat[faces[:, k]] for k in range(3))
    sides = []
    for p, q in ((a, b), (b, c), (c, a)):
        edge, off = q - p, places[:, None] - p
        sides.append(edge[:, 0] * off[..., 1] - edge[:, 1] * off[..., 0])
    sides = np.array(sides)
    return ((sides >= -1e-12).all(axis=0) | (sides <= 1e-12).all(axis=0)).sum(axis=1)


@pytest.mark.parametrize("tilt_deg", [0, 20, 45, 90])
@pytest.mark.parametrize("noise", [False, True], ids=["lattice", "blue noise"])
def test_faces_cover_a_square_and_nothing_else(noise, tilt_deg):
    flat = blue_noise(5.0, 0.4) if noise else square(5.0, 0.4)
    gap = 0.5  # no less than 0.4 of blue noise, or half a lattice's diagonal
    faces = faces_between(turned(flat, tilt_deg), 0.45, gap)
    places = np.random.default_rng(1).uniform(-2.5, 2.5, (2000, 2))
    hull = np.abs(places).max(axis=1) < (2.0 if noise else 2.5)  # random points have no straight edge
    counts = covered(flat[:, :2], faces, places)
    assert (counts[hull] > 0).all()
    # Four points on one circle make four faces, and so a square is covered twice; others once.
    assert counts.max() <= 2 and (counts[hull] == (1 if noise else 2)).mean() > 0.97
    # None reaches across anything wider than the gap.
    edges = flat[faces] - flat[np.roll(faces, 1, axis=1)]
    assert np.linalg.norm(edges, axis=2).max() <= 2 * gap


def fibonacci(count: int) -> np.ndarray:
    """Return evenly spread directions."""
    i = np.arange(count) + 0.5
    z, angle = 1 - 2 * i / count, i * np.pi * (1 + 5**0.5)
    return np.column_stack([np.sqrt(1 - z**2) * np.cos(angle), np.sqrt(1 - z**2) * np.sin(angle), z])


def pierced(vertices: np.ndarray, faces: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Return whether each ray (R, 3) from the origin meets a face."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    sides = np.array([rays @ np.cross(p, q).T for p, q in ((a, b), (b, c), (c, a))])
    ahead = rays @ (a + b + c).T > 0
    return (ahead & ((sides >= -1e-12).all(axis=0) | (sides <= 1e-12).all(axis=0))).any(axis=1)


@pytest.mark.parametrize("random", [False, True])
def test_a_round_surface_has_no_holes(random):
    sphere = 4.0 * fibonacci(700)
    if random:
        sphere = sphere + np.random.default_rng(2).uniform(-0.05, 0.05, sphere.shape)
        sphere *= 4.0 / np.linalg.norm(sphere, axis=1, keepdims=True)
    gap = 1.1 * cKDTree(sphere).query(4.0 * fibonacci(20_000))[0].max()
    faces = faces_between(sphere, min(gap, 0.58), gap)
    assert pierced(sphere, faces, fibonacci(4_001)).all()


def test_holes_wider_than_the_gap_stay_open():
    flat = square(6.0, 0.4)
    flat = flat[np.hypot(flat[:, 0], flat[:, 1]) > 1.5]
    faces = faces_between(flat, 0.5, 0.6)
    angles = np.linspace(0, 2 * np.pi, 50)
    # Points begin at 1.5; no face of a ball of 0.6 reaches inwards from there.
    assert not covered(flat[:, :2], faces, 0.9 * np.column_stack([np.cos(angles), np.sin(angles)])).any()


def test_two_sheets_as_far_apart_as_a_gap_are_not_tied_together():
    sheet = square(4.0, 0.2)
    faces = faces_between(np.concatenate([sheet, sheet + [0, 0, 0.6]]), 0.25, 0.25)
    is_upper = (faces >= len(sheet)).sum(axis=1)
    assert set(is_upper) == {0, 3}


def face_set(points: np.ndarray, faces: np.ndarray) -> set:
    """Return the faces by the coordinates of their corners."""
    corners = points[faces]
    return {tuple(sorted(map(tuple, each))) for each in corners}


@pytest.mark.parametrize("tilt_deg", [0, 33])
def test_faces_do_not_depend_on_the_order_of_points(tilt_deg):
    points = turned(np.concatenate([square(3.0, 0.4), 1.5 * fibonacci(200)]), tilt_deg)
    shuffled = np.random.default_rng(3).permutation(points)
    first, second = (face_set(each, faces_between(each, 0.45, 0.5)) for each in (points, shuffled))
    assert len(first) > 300 and first == second


def test_kernel_of_faces_is_its_python_original():
    points = np.concatenate([square(1.2, 0.4), 0.8 * fibonacci(30)])
    order, starts, keys, dims, low = point_cells(points, 1.0)
    results = []
    for form in (span_faces, span_faces.py_func):
        faces = np.full((400, 3), -1, np.int32)
        count = form(points[order], keys, starts, dims, low, 0.45, 0.5, faces)
        results.append((count, faces[:count].tolist()))
    assert results[0] == results[1] and results[0][0] > 30


@pytest.mark.parametrize("count", [100, 900, 3000], ids=["all are kept", "the nearest are", "there is no room"])
def test_neighbours_are_the_nearest_ones_nearest_first(count):
    """Of those as near, as many on this lattice are, the one that comes first."""
    points = np.random.default_rng(8).integers(-9, 10, (count, 3)) / 20
    order, starts, keys, dims, low = point_cells(points, 1.0)
    placed = points[order]
    found, near = np.empty(ROOM, np.int64), np.empty(ROOM, np.int64)
    distances, squared, rings = np.empty(ROOM), np.empty(ROOM), np.empty(RINGS + 1, np.int64)
    for i in range(0, count, 50):
        gathered = gather(placed, i, keys, starts, dims, low, 1.0, found, distances, rings, near, squared)
        dx, dy, dz = (placed - placed[i]).T
        truth = dx * dx + dy * dy + dz * dz
        expected = np.argsort(truth, kind="stable")
        expected = expected[(truth[expected] > 0) & (truth[expected] <= 1)][:MAX_NEIGHBORS]
        assert np.array_equal(near[:gathered], expected) and np.array_equal(squared[:gathered], truth[expected])


def test_count_of_faces_is_told_also_without_room_for_them():
    points = square(2.0, 0.4)
    order, starts, keys, dims, low = point_cells(points, 1.0)
    faces = np.full((3, 3), -1, np.int32)
    count = span_faces(points[order], keys, starts, dims, low, 0.45, 0.5, faces)
    assert count == len(faces_between(points, 0.45, 0.5)) > 3 and faces.min() >= 0


# Points that stand for voxels


@cache
def rough() -> np.ndarray:
    """Return a mug's points in radii of 1 cm, with a tilted board and some noise beside it."""
    board = turned(square(6.0, 0.1), 25) + [15, 0, 5]
    noise = np.random.default_rng(4).uniform(-2, 2, (500, 3)) + [0, 12, 5]
    return np.concatenate([clouds.mug().points / 0.01, board, noise])


def test_representatives_are_points_of_the_cloud_in_any_order():
    points = rough()
    chosen = representatives(points, 0.4, FLAT)
    shuffled = representatives(np.random.default_rng(5).permutation(points), 0.4, FLAT)
    assert np.array_equal(chosen, shuffled)
    assert {tuple(each) for each in chosen} <= {tuple(each) for each in points}
    assert len(np.unique(chosen, axis=0)) == len(chosen)
    # Every occupied voxel is stood for: no point is farther than its diagonal from one that is chosen.
    assert cKDTree(chosen).query(points)[0].max() <= 0.4 * np.sqrt(3)


def test_kernel_of_representatives_is_its_python_original():
    points, starts, around = in_voxels(rough(), 0.8)
    arguments = (points, starts, around, voxel_normals(points, starts), 0.8, FLAT)
    compiled, python = represent(*arguments), represent.py_func(*arguments)
    for one, other in zip(np.atleast_2d(compiled), np.atleast_2d(python), strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("tilt_deg", [0, 20, 45])
@pytest.mark.parametrize("voxel", [0.3, 0.5])
def test_planes_are_thinned_to_one_point_a_voxel_and_keep_their_rims(tilt_deg, voxel):
    flat = square(8.0, 0.05)
    points = turned(flat, tilt_deg)
    chosen = representatives(points, voxel, FLAT)
    voxels = len(np.unique(np.floor((points - points.min(axis=0)) / voxel), axis=0))
    # One of each voxel, and more only where rounding makes a point stray.
    assert len(chosen) <= 1.05 * voxels < len(points) / 5
    back = flat[cKDTree(points).query(chosen)[1]]
    # Voxels at the rim keep what sticks out farthest; a tilted one cuts off a corner with few points in it.
    lost = np.abs([flat.min(axis=0) - back.min(axis=0), flat.max(axis=0) - back.max(axis=0)]).max()
    assert lost <= 0.15 * voxel
    # Along the whole of the rim, not only at its corners: nowhere is the nearest kept point on it two voxels away.
    rim = flat[np.abs(flat[:, 0]) > 4 - 1e-9]
    assert cKDTree(back[:, :2]).query(rim[:, :2])[0].max() < 1.5 * voxel


@pytest.mark.parametrize("apart", [3, 5, 8])
@pytest.mark.parametrize("tilt_deg", [0, 20])
def test_two_sheets_near_each_other_are_both_kept(tilt_deg, apart):
    sheet = square(5.0, 0.05)
    thickness = apart * FLAT
    upper = sheet + [0, 0, thickness]
    points = turned(np.concatenate([sheet, upper]), tilt_deg)
    is_upper = np.repeat([False, True], len(sheet))[cKDTree(points).query(representatives(points, 0.4, FLAT))[1]]
    # As many of one as of the other, but for voxels that hold only one of them.
    assert is_upper.mean() == pytest.approx(0.5, abs=0.1)


def test_a_bend_keeps_what_sticks_out():
    """A wall on a floor: the edge between them is where it was, to half a voxel."""
    floor = square(4.0, 0.05)
    wall = np.column_stack([floor[:, 0], np.full(len(floor), 2.0), floor[:, 1] + 2])
    chosen = representatives(np.unique(np.concatenate([floor, wall]), axis=0), 0.4, FLAT)
    edge = np.column_stack([np.linspace(-2, 2, 81), np.full(81, 2.0), np.zeros(81)])
    assert cKDTree(chosen).query(edge)[0].max() <= 0.4
    assert chosen[:, 1].max() == 2 and chosen[:, 2].min() == 0


# Where spheres start


def contact_height(points: np.ndarray, centers: np.ndarray, x: float, y: float) -> float:
    """Return the height of a sphere that comes down a column, by trying everything there is."""
    heights = [-np.inf]
    for objects, reach in ((points, 1.0), (centers, 2.0)):
        aside = np.hypot(objects[:, 0] - x, objects[:, 1] - y)
        near = aside < reach
        heights += (objects[near, 2] + np.sqrt(reach**2 - aside[near] ** 2)).tolist()
    return max(heights)


@pytest.mark.parametrize("max_cells", [4_000_000, 20])
def test_columns_are_as_high_as_brute_force_says(monkeypatch, max_cells):
    monkeypatch.setattr("spherefunc_bullet.bullet.columns.MAX_CELLS", max_cells)
    random = np.random.default_rng(6)
    low, high = np.array([-15.0, -9.0, 0.0]), np.array([12.0, 14.0, 20.0])
    points = random.uniform(low, high, (150, 3))
    columns, centers = ColumnIndex(points, low, high), np.empty((0, 3))
    for round_ in range(4):
        for x, y in random.uniform(low[:2] - 1, high[:2] + 1, (60, 2)):
            assert columns.height(x, y) == pytest.approx(contact_height(points, centers, x, y))
        # More than it has room for at first; some lie beside the footprint, as spheres on a rim do.
        new = random.uniform(low - [1, 1, 0], high + [1, 1, 0], (100 + 60 * round_, 3))
        for center in new:
            columns.add(center)
        centers = np.concatenate([centers, new])


def test_empty_ground_has_no_height():
    columns = ColumnIndex(np.array([[0.0, 0.0, 3.0]]), np.array([-9.0, -9, 0]), np.array([9.0, 9, 5]))
    assert columns.height(0.0, 0.0) == 4 and columns.height(1.01, 0.0) == -np.inf


# Whose flight is over

LOW, HIGH = np.array([-10.0, -10, 0]), np.array([10.0, 10, 10])
LIMITS = (0.8, 0.01, 1.6, 100.0)  # time between looks, speed of rest, time of rest, time limit


def judged(form, now, before=None, time=10.0, slow=0.0, flying=None):
    """Return the outcomes of one look."""
    now = np.array(now, float)
    count = len(now)
    outcomes = np.full(count, 99)
    state = (
        np.ones(count, bool) if flying is None else np.array(flying),
        now.copy() if before is None else np.array(before, float),
        np.zeros(count),
        np.full(count, time) * 1.0,
        np.broadcast_to(np.asarray(slow, float), count).copy(),
        outcomes,
    )
    with np.errstate(invalid="ignore"):  # the Python form warns of what lies at infinity
        form(now, *state, LOW, HIGH, *LIMITS)
    return outcomes.tolist(), state


FORMS = pytest.mark.parametrize("form", [update_flights, update_flights.py_func], ids=["compiled", "python"])


@FORMS
def test_flights_end_as_they_should(form):
    still, moving = 1.0, 0.0
    cases = [
        ([0, 0, 5], still, SETTLED),
        ([0, 0, 5], moving, IN_FLIGHT),
        ([11.5, 0, 5], still, ROLLED_OFF),  # beside the box, and nothing that could hold it
        ([0, -11.5, 5], still, ROLLED_OFF),
        ([10.9, 0, 5], still, SETTLED),  # over the edge
        ([0, 0, 0.5], moving, ROLLED_OFF),  # half in the ground
        ([0, 0, 0.95], still, SETTLED),  # on a floor at the ground
        ([np.nan, 0, 5], still, TIMED_OUT),
        ([0, np.inf, 5], still, TIMED_OUT),
    ]
    for place, rest, outcome in cases:
        # A sphere that is still has been so for 1 unit of time, and 0.8 more makes it 1.8 of the 1.6 that it takes.
        found, _ = judged(form, [place], slow=rest)
        assert found == [outcome], place
    assert judged(form, [[0, 0, 5]], before=[[0, 0, 5.1]], slow=1.5)[0] == [IN_FLIGHT]  # faster than rest
    assert judged(form, [[0, 0, 5]], before=[[0, 0, 5.1]], time=99.5)[0] == [TIMED_OUT]
    assert judged(form, [[0, 0, 5]], slow=1.0, time=99.5)[0] == [SETTLED]  # at rest in the last moment
    assert judged(form, [[0, 0, 0]], flying=[False])[0] == [IN_FLIGHT]


@FORMS
def test_speed_starts_and_ends_the_time_of_rest(form):
    _, state = judged(form, [[0, 0, 5], [0, 5, 5]], before=[[0, 0, 5.007], [0, 5, 5.5]], slow=0.3)
    assert state[2] == pytest.approx([0.007 / 0.8, 0.5 / 0.8]) and state[4] == pytest.approx([1.1, 0.0])
    assert state[3] == pytest.approx([10.8, 10.8])


@FORMS
def test_spheres_that_lean_on_a_moving_one_are_not_at_rest(form):
    chain = [[0, 0, 1], [2, 0, 1], [4, 0, 1], [0, 6, 1]]
    before = [[0, 0, 1], [2, 0, 1], [4, 0.5, 1], [0, 6, 1]]
    # The third moves; the second leans on it, the first on the second; the fourth stands alone.
    assert judged(form, chain, before, slow=[2.0, 2, 0, 2])[0] == [IN_FLIGHT] * 3 + [SETTLED]
    assert judged(form, chain, chain, slow=2.0)[0] == [SETTLED] * 4
    apart = [[0, 0, 1], [LEANING + 0.01, 0, 1]]
    assert judged(form, apart, [apart[0], [9, 0, 1]], slow=[2.0, 0])[0] == [SETTLED, IN_FLIGHT]
    # A slot that is free moves nobody.
    assert judged(form, chain[:2], before[:2], slow=[2.0, 0], flying=[True, False])[0] == [SETTLED, IN_FLIGHT]


def test_compiled_and_python_judge_alike():
    random = np.random.default_rng(7)
    for _ in range(200):
        count = random.integers(1, 17)
        now = random.uniform(LOW - 1.5, HIGH + 1.5, (count, 3)) * random.choice([0.3, 1.0])
        before = now + random.normal(size=(count, 3)) * random.choice([1e-4, 0.01, 1.0], (count, 1))
        options = dict(time=random.uniform(0, 110), slow=random.uniform(0, 2, count), flying=random.random(count) < 0.8)
        (first, one), (second, other) = (
            judged(form, now, before, **options) for form in (update_flights, update_flights.py_func)
        )
        assert first == second
        for a, b in zip(one, other, strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-12)


@pytest.mark.parametrize("form", [first_apart, first_apart.py_func], ids=["compiled", "python"])
def test_first_column_apart_from_all_in_the_air_is_put_before_the_others(form):
    columns = np.array([[7.0, 7], [0, 0], [1, 0], [5, 0], [9, 9]])
    positions = np.array([[0.5, 0, 3], [5, 1, 3]])

    def order(flying, start=1, few=4):
        own = columns.copy()
        found = form(own, start, few, np.array(flying), positions, 2.0)
        return found, own[:, 0].tolist()

    assert order([True, True]) == (True, [7, 9, 0, 1, 5])
    assert order([True, False]) == (True, [7, 5, 0, 1, 9])
    assert order([False, False]) == (True, [7, 0, 1, 5, 9])
    assert order([True, True], few=2) == (False, [7, 0, 1, 5, 9])
    assert order([True, True], start=0, few=1) == (True, [7, 0, 1, 5, 9])


def test_flights_time_of_rest_is_reached_after_two_looks():
    physics = Physics()
    flights = Flights(1, physics, LOW, HIGH)
    flights.start(0, np.array([0.0, 0, 5]))
    looks = 0
    while flights.update(np.array([[0.0, 0, 5]]))[0] == IN_FLIGHT:
        looks += 1
    assert (looks + 1) * physics.check_interval == pytest.approx(physics.rest_time, abs=physics.check_interval)


# In the engine


@pytest.fixture(scope="module")
def engine():
    pytest.importorskip("pybullet", reason="PyBullet is not installed")
    from spherefunc_bullet.bullet import engine

    return engine.pybullet()


SIDE = 0.16  # metres, of the sheets


def tilted_sheet(kind: str, tilt_deg: float) -> tuple[Cloud, np.ndarray]:
    """Return a sheet sampled at 5 mm, and the upward normal; it hangs half a metre up."""
    normal = turned(np.array([[0, 0, 1.0]]), tilt_deg)[0]
    up = np.array([0, 0, 0.5])
    if kind == "blue noise":
        return Cloud(turned(blue_noise(SIDE, MAX_GAP), tilt_deg) + up, "sheet"), normal
    corners = turned(square(SIDE, SIDE), tilt_deg)
    sampled = cloud_from_mesh(corners, [[0, 1, 2], [1, 3, 2]], "sheet")
    middle = (sampled.bounds[0] + sampled.bounds[1]) / 2
    mesh = Mesh(sampled.mesh.vertices - middle + up, sampled.mesh.faces)
    return Cloud(sampled.points - middle + up, "sheet", mesh), normal


def leaks(p, shape, physics: Physics, normal: np.ndarray, up: float, half: float) -> int:
    """Return how many of many spheres, thrown at a sheet as fast as any moves, come out below it."""
    from spherefunc_bullet.bullet.world import World

    across = np.linalg.svd(normal[None])[2][1:]
    random, lost = np.random.default_rng(8), 0
    with World(physics) as world:
        world.add_object(shape)
        world.add_spheres(8)
        for _ in range(4):
            for slot in range(8):
                # One above the other: in the end they press on each other too.
                place = random.uniform(-0.6, 0.6, 2) * half @ across
                world.place(slot, place + [0, 0, up] + (2.5 + 2.2 * slot) * normal)
                speed = -physics.terminal_speed * physics.scale * normal
                p.resetBaseVelocity(world.air[slot], speed.tolist(), [0, 0, 0], **world.engine)
            below = np.zeros(8, bool)
            for _ in range(10):
                world.step()
                for slot in range(8):
                    world.limit_speed(slot, physics.terminal_speed)
                off = world.positions() - [0, 0, up]
                inside = np.abs(off @ across.T).max(axis=1) < half - 1.5
                below |= inside & (off @ normal < 0)
            lost += below.sum()
    return lost


@pytest.mark.parametrize("tilt_deg", [0, 20, 50])
@pytest.mark.parametrize("radius", [0.003, 0.005, 0.01, 0.02])
@pytest.mark.parametrize(
    "shape, kind",
    [(s, k) for s in ("voxel", "compound") for k in ("lattice", "blue noise")] + [("mesh", "lattice")],
)
@pytest.mark.slow
def test_nothing_leaks_through_a_sheet(engine, shape, kind, radius, tilt_deg):
    from spherefunc_bullet.bullet.collision.shape import collision_shape

    sheet, normal = tilted_sheet(kind, tilt_deg)
    made = collision_shape(sheet, radius, shape)
    for restitution in (0.0, 0.6):
        physics = Physics(restitution=restitution)
        assert leaks(engine, made, physics, normal, 0.5 / radius, SIDE / 2 / radius) == 0


def test_leaks_are_seen_where_there_is_a_hole(engine):
    from spherefunc_bullet.bullet.collision.shape import collision_shape

    sheet, normal = tilted_sheet("lattice", 20)
    holed = Cloud(sheet.points[np.linalg.norm(sheet.points - [0, 0, 0.5], axis=1) > 0.04], "holed")
    assert leaks(engine, collision_shape(holed, 0.01, "voxel"), Physics(), normal, 50, 8) > 5


def widths(shape, heights: np.ndarray, reach: float) -> np.ndarray:
    """Return the inner widths (H, A) of a shape about the z axis at heights, in radii, by rays in the engine."""
    from spherefunc_bullet.bullet.engine import pybullet
    from spherefunc_bullet.bullet.world import World

    angles = np.radians(np.arange(3, 363, 6.0))
    out = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    with World(Physics()) as world:
        world.add_object(shape)
        starts = np.repeat(heights, len(angles))[:, None] * [0, 0, 1.0]
        ends = starts + reach * np.tile(out, (len(heights), 1))
        scaled = ((world.scale * each).tolist() for each in (starts, ends))
        hits = pybullet().rayTestBatch(*scaled, **world.engine)
    far = reach * np.array([hit[2] for hit in hits]).reshape(len(heights), -1)
    return far[:, : len(angles) // 2] + far[:, len(angles) // 2 :]


@pytest.mark.parametrize("shape", ["voxel", "compound"])
@pytest.mark.parametrize("radius", [0.005, 0.01, 0.02])
def test_a_cup_keeps_its_inner_width_to_a_voxel(engine, shape, radius):
    from spherefunc_bullet.bullet.collision.shape import VOXEL, collision_shape

    wall, height = 0.04, 0.1
    made = collision_shape(clouds.mug(wall, height), radius, shape)
    found = widths(made, np.linspace(0.03, 0.09, 13) / radius, 2 * wall / radius)
    shrunk = 2 * wall / radius - found
    assert shrunk.max() <= (made.voxel_size or VOXEL)
    # And not widened, by more than what a face may lie off its points: no ray gets out.
    assert shrunk.min() >= -2 * FLAT


@pytest.mark.parametrize("shape", ["voxel", "compound"])
@pytest.mark.parametrize("radius", [0.005, 0.01, 0.02])
def test_a_mug_with_thick_walls_keeps_its_inner_width_to_a_voxel(engine, shape, radius):
    from spherefunc_bullet.bullet.collision.shape import VOXEL, collision_shape

    cup = thick_cup()
    heights = np.linspace(0.035, 0.085, 11) / radius
    true, found = (widths(collision_shape(cup, radius, each), heights, 0.08 / radius) for each in ("mesh", shape))
    assert true == pytest.approx(2 * 0.036 / radius, rel=0.01)
    assert (true - found).max() <= VOXEL
    assert (true - found).min() >= -2 * FLAT


@cache
def thick_cup() -> Cloud:
    """Return a cup of 48 sides with an outer radius of 4 cm and walls of 4 mm."""
    angles = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    ring = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(48)])
    profile = [(0.0, 0.0), (0.04, 0.0), (0.04, 0.1), (0.036, 0.1), (0.036, 0.004), (0.0, 0.004)]
    vertices = np.concatenate([ring * [r, r, 0] + [0, 0, z] for r, z in profile])
    faces = []
    for k in range(len(profile) - 1):
        for i in range(48):
            j = (i + 1) % 48
            a, b, c, d = 48 * k + i, 48 * k + j, 48 * (k + 1) + j, 48 * (k + 1) + i
            faces += [[a, b, c], [a, c, d]]
    return cloud_from_mesh(vertices, faces, "thick cup")


# Which of the shapes


def test_an_object_that_came_as_a_mesh_is_met_as_one():
    plate = box(0.2, 0.2, 0.02)
    meshed = cloud_from_mesh(plate.vertices, plate.faces, "plate")
    points = Cloud(meshed.points, "points")
    assert [BulletSimulator().kind_for(cloud, 0.01) for cloud in (meshed, points)] == ["mesh", "voxel"]
    assert BulletSimulator(shape="voxel").kind_for(meshed, 0.01) == "voxel"


@pytest.mark.slow
def test_a_mesh_of_minute_faces_is_met_as_voxels_by_large_spheres():
    """What a scanner makes has faces of a millimetre: a sphere of 3 cm would be held against thousands at each step."""
    plate = subdivided(box(0.2, 0.2, 0.02), 7)
    scanned = cloud_from_mesh(plate.vertices, plate.faces, "scanned")
    kinds = [BulletSimulator().kind_for(scanned, radius) for radius in (0.005, 0.1)]
    assert kinds == ["mesh", "voxel"]
    fine, coarse = (
        BulletSimulator(shape=shape).drop(scanned, DropSettings(radius=0.02, max_drops=40), 0)
        for shape in ("voxel", "mesh")
    )
    # On a plate the same drops stay, whichever surface holds them.
    assert fine.settled == pytest.approx(coarse.settled, abs=5) and fine.settled > 10


def subdivided(mesh: trimesh.Trimesh, times: int) -> trimesh.Trimesh:
    """Return a mesh with each face cut in four, so many times."""
    for _ in range(times):
        mesh = mesh.subdivide()
    return mesh
