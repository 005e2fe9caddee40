"""The arithmetic of the Bullet world by itself: cells, hulls, halves, planes of sides, and how a vessel is shaken."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace

import clouds
import numpy as np
import pytest
from scipy.spatial import ConvexHull, Delaunay, cKDTree

from spherefunc_bullet.bullet import loading
from spherefunc_bullet.bullet.bodies.carrying import FINER, INTERVAL, MANY, WAITING, G, carrying_physics, shaken
from spherefunc_bullet.bullet.collision.cuts import hull_of, in_halves
from spherefunc_bullet.bullet.collision.pieces import bends_between, corners
from spherefunc_bullet.bullet.collision.shape import thinned
from spherefunc_bullet.bullet.collision.sides import fit_plane, grow_sides
from spherefunc_bullet.bullet.collision.triangulation import point_cells
from spherefunc_bullet.bullet.collision.voxels import in_voxels, representatives
from spherefunc_bullet.bullet.columns import in_cells, is_clear
from spherefunc_bullet.bullet.engine import Physics
from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.simulator.mechanics import CarrySettings

RANDOM = np.random.default_rng


def test_finer_steps_cover_the_same_time():
    for spheres in (1, MANY, MANY + 1):
        steps = [carrying_physics(Physics(), CarrySettings(), spheres, finer) for finer in FINER]
        assert all(how.check_interval == pytest.approx(INTERVAL) and how.rolling_friction == 0 for how in steps)
        assert [how.sub_steps / steps[0].sub_steps for how in steps] == list(FINER)
    many, few = (carrying_physics(Physics(), CarrySettings(), count, 1) for count in (MANY + 1, MANY))
    assert many.sub_steps < few.sub_steps  # each sphere more costs more


def test_a_vessel_is_shaken_once_along_each_axis_as_hard_as_asked():
    settings, radius = CarrySettings(shake=0.02, frequency=2.0), 0.005
    gravity = shaken(settings, radius) + [0, 0, 1]  # what is left are strokes
    wait = int(WAITING / INTERVAL)
    looks = (len(gravity) - wait) // 3
    strokes = gravity[: 3 * looks].reshape(3, looks, 3)
    assert np.allclose(gravity[-wait:], 0) and np.allclose(strokes[~np.eye(3, dtype=bool)[:, None].repeat(looks, 1)], 0)
    peak = 0.02 * (2 * np.pi * 2.0) ** 2 / G  # of a swing of 2 cm at 2 Hz
    for axis in range(3):
        assert np.abs(strokes[axis, :, axis]).max() == pytest.approx(peak, rel=0.02)
    assert looks * INTERVAL * np.sqrt(radius / G) == pytest.approx(
        1 / 2.0, abs=INTERVAL * np.sqrt(radius / G)
    )  # one swing


def test_each_voxel_holds_the_points_of_one_cube():
    points, side = RANDOM(0).uniform(-1, [2, 1, 1.5], (400, 3)), 0.3
    ordered, starts, around = in_voxels(points, side)
    cells = np.floor((ordered - points.min(axis=0)) / side)
    names, counts = np.unique(cells, axis=0, return_counts=True)
    assert len(starts) == len(names) + 1 and np.array_equal(np.diff(starts), counts)
    for v, first in enumerate(starts[:-1]):
        near = np.abs(cells - cells[first]).max(axis=1) <= 1
        assert (cells[first : starts[v + 1]] == cells[first]).all()
        assert around[v] == pytest.approx(ordered[near].mean(axis=0))


def test_each_cell_holds_the_points_of_one_cube_and_has_cells_around_it():
    points, side = RANDOM(1).uniform(0, [3, 1, 2], (300, 3)), 0.4
    order, starts, keys, dims, low = point_cells(points, side)
    cells = np.floor((points[order] - low) / side).astype(int)
    assert dims.shape == (3,) and (cells >= 1).all() and (cells < dims - 1).all()
    assert np.array_equal(np.ravel_multi_index(cells[starts[:-1]].T, dims), keys)
    assert np.array_equal(np.repeat(keys, np.diff(starts)), np.ravel_multi_index(cells.T, dims))


def test_a_hull_leaves_out_corners_that_hardly_stand_out():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, -0.01], [0.5, 0.5]], float)
    assert sorted(hull_of(square, 0.0)) == [0, 1, 2, 3, 4] and sorted(hull_of(square, 0.05)) == [0, 1, 2, 3]
    points = RANDOM(2).normal(size=(60, 2))
    assert sorted(hull_of(points, 0.0)) == sorted(ConvexHull(points).vertices)


def test_a_flat_piece_is_its_outline_less_what_hardly_stands_out():
    points = np.array([[-2, -1, 0], [2, -1, 0], [2, 1, 0], [-2, 1, 0], [0, -1.001, 0], [0.3, 0.2, 0.001]])
    assert sorted(corners(points, 0.02)) == [0, 1, 2, 3]
    row = np.column_stack([np.arange(6.0), np.zeros(6), np.zeros(6)])  # of a row three at least, which span a face
    assert len(corners(row, 0.02)) >= 3


def test_a_face_hangs_between_the_two_sides_that_its_corners_lie_on():
    owners = np.array([[0, 0], [1, 0], [2, 1], [3, 0], [3, 1], [4, 2]])  # vertex, side
    (bend,), others = bends_between(np.array([[0, 1, 2], [0, 1, 5]]), np.arange(2), owners, 3, 6)
    # With the vertex that those two share; the other face has a corner on no side.
    assert [part.tolist() for part in bend] == [[0], [3]] and others.tolist() == [1]
    owners = np.array([[0, 1], [1, 1], [2, 2], [3, 1], [3, 2], [4, 0], [5, 0], [5, 2], [6, 0], [6, 1]])
    bends, others = bends_between(np.array([[0, 1, 2], [0, 3, 2], [4, 2, 1]]), np.arange(3), owners, 3, 7)
    # In a corner of three sides it hangs between the larger two, which come first.
    assert [[part.tolist() for part in bend] for bend in bends] == [[[2], [6]], [[0, 1], [3]]] and not len(others)


@pytest.mark.parametrize(("looks", "refused"), [([1.0], False), ([0.9, 1.0], False), ([0.9, 0.9], True)])
def test_what_a_first_look_misses_is_looked_at_closer(monkeypatch, looks, refused):
    shape = SimpleNamespace(name="plate", vertices=np.eye(3), faces=np.array([[0, 1, 2]]))
    monkeypatch.setattr(loading, "pybullet", lambda: SimpleNamespace(getAABB=lambda *_, **__: ([0] * 3, [1] * 3)))
    left = list(looks)
    monkeypatch.setattr(loading, "share_met", lambda *_: left.pop(0))
    with pytest.raises(InputError, match="90.0% of it was met") if refused else nullcontext():
        loading.require_arrived(shape, 0, 1.0, 0)
    assert not left


def test_halves_are_cut_across_the_longer_side():
    middles = RANDOM(3).uniform(0, [1, 5], (41, 2))
    side = in_halves(middles)
    assert side.sum() == 20 and middles[side, 1].max() <= middles[~side, 1].min()


def test_the_plane_of_a_side_is_the_one_its_points_are_spread_along():
    normal = np.array([2, -3, 6]) / 7
    spread = RANDOM(4).normal(size=(80, 3))
    points = spread - np.outer(spread @ normal, normal) + 0.7 * normal
    plane = fit_plane(points, np.arange(80, dtype=np.int32))
    assert np.abs(plane[:3] @ normal) == pytest.approx(1) and np.abs(plane[3]) == pytest.approx(0.7)


@pytest.mark.parametrize("scale", [2.0**-8, 2.0**8])
def test_sides_are_the_same_in_every_unit(scale):
    vertices = RANDOM(8).uniform(-1, 1, (200, 2))
    wavy = np.column_stack([vertices, 0.1 * np.sin(4 * vertices[:, 0]) * vertices[:, 1]])
    faces = Delaunay(vertices).simplices.astype(np.int32)
    found = grow_sides(wavy, faces, 0.02)
    assert np.array_equal(grow_sides(scale * wavy, faces, scale * 0.02), found) and len(np.unique(found)) > 5


def test_a_place_is_clear_where_no_point_is_near():
    points, low = RANDOM(5).uniform(0, [6, 4, 3], (250, 3)), np.zeros(2)
    dims = np.array([12, 8])
    placed, starts = in_cells(points, low, 0.5, dims)
    places = RANDOM(6).uniform(0, [6, 4, 3], (400, 3))
    nearest = cKDTree(points).query(places)[0]
    found = [is_clear(place, 0.4, low, 0.5, dims, placed, starts) for place in places]
    assert np.array_equal(found, nearest >= 0.4) and 0 < sum(found) < 400


def test_a_dense_cloud_is_spanned_between_few_of_its_points():
    cloud = clouds.plate()
    points, voxel, gap = thinned(cloud, 0.03, None)
    assert voxel == pytest.approx(0.4) and gap > voxel and len(points) < len(cloud) / 3


@pytest.mark.parametrize(("pitch", "gap"), [(0.001, 0.003), (0.0045, 0.00563)])
def test_a_gap_is_thrice_the_spacing_of_a_fine_scan_and_hardly_more_than_that_of_a_coarse_one(pitch, gap):
    steps = np.arange(0, 40) * pitch
    cloud = Cloud(np.array([[x, y, 0.3] for x in steps for y in steps]))
    points, voxel, found = thinned(cloud, 0.02, 0.01)
    assert voxel == pytest.approx(0.5) and (found - voxel) * 0.02 == pytest.approx(gap, rel=0.02)
    assert len(thinned(cloud, 0.001, None)[0]) == len(cloud)  # as small as their spacing, spheres meet every point


def test_of_a_board_both_sides_are_represented():
    xy = RANDOM(7).uniform(-1, 1, (900, 2))
    board = np.concatenate([np.column_stack([xy, np.full(900, z)]) for z in (0.0, 0.1)])
    kept = representatives(board, 0.5, 0.02)
    lattice = representatives(np.array([[x, y, 0.0] for x in range(9) for y in range(9)]), 1.5, 0.02)
    assert np.array_equal(lattice, np.unique(lattice, axis=0))  # in the order of coordinates, each once
    for z in (0.0, 0.1):
        layer = kept[np.abs(kept[:, 2] - z) < 1e-9]
        assert cKDTree(layer[:, :2]).query(xy)[0].max() < 0.8 and len(layer) < 100
