"""Collision shapes by their definitions: faces of empty balls, flat sides, cuts, voxels, tried one by one."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from scipy.spatial import ConvexHull, cKDTree

from spherefunc_bullet.bullet.collision.cuts import (
    CELLS,
    bare_cells,
    best_cut,
    corners_of_faces,
    count_inside,
    hull_of,
    largest_patch,
    parts_without_bridges,
    vertical_span,
)
from spherefunc_bullet.bullet.collision.pieces import first_sides, split_by, unique_rows
from spherefunc_bullet.bullet.collision.sides import (
    bending,
    faces_of_vertices,
    fit_plane,
    grow_sides,
    near,
    plane_of_face,
    unit_normals,
)
from spherefunc_bullet.bullet.collision.triangulation import SLACK, faces_between
from spherefunc_bullet.bullet.collision.voxels import (
    extreme,
    mean_beyond,
    split,
    voxel_normals,
)
from spherefunc_bullet.clouds.outline import chain

RANDOM = np.random.default_rng


def spanned(points: np.ndarray, alpha: float, gap: float) -> set[tuple[int, ...]]:
    """Return the faces that the definition says: of three points that an empty ball touches, by trying all."""
    found = set()
    for three in combinations(range(len(points)), 3):
        a, u, v = points[three[0]], *(points[list(three[1:])] - points[three[0]])
        normal = np.cross(u, v)
        middle = np.cross(normal, u) * (v @ v) + np.cross(v, normal) * (u @ u)
        middle = a + middle / (2 * normal @ normal)
        radius = np.linalg.norm(middle - a)
        if radius > gap:
            continue
        others = np.delete(points, three, axis=0)

        def empty(center: np.ndarray, ball: float, others: np.ndarray = others) -> bool:
            return np.linalg.norm(others - center, axis=1).min() >= SLACK * ball

        if radius > alpha and not empty(middle, radius):
            continue
        ball = alpha if radius <= alpha else gap
        aside = np.sqrt(ball**2 - radius**2) * normal / np.linalg.norm(normal)
        if empty(middle + aside, ball) or empty(middle - aside, ball):
            found.add(three)
    return found


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("extent", [(1, 1, 0.02), (0.6, 0.5, 0.4), (1.2, 0.3, 0.3)])
@pytest.mark.slow
def test_faces_are_those_of_empty_balls(seed, extent):
    points = RANDOM(seed).uniform(-0.5, 0.5, (30, 3)) * extent + RANDOM(seed + 2).uniform(-9, 9, 3)
    faces = faces_between(points, 0.16, 0.22)
    assert len(faces) > 10
    assert {tuple(sorted(face)) for face in faces.tolist()} == spanned(points, 0.16, 0.22)


def bumpy(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and faces of two level squares at an angle, with a bump in one of them."""
    x, y = (part.ravel() for part in np.mgrid[0:9, 0:9] * 0.1)
    z = np.where(x > 0.45, 0.6 * (x - 0.4), 0.0) + 0.03 * ((x == 0.2) & (y == 0.2))
    first = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()
    halves = [np.column_stack([first, first + 9, first + 10]), np.column_stack([first, first + 10, first + 1])]
    faces = np.concatenate(halves)[RANDOM(seed).permutation(128)]
    turn = np.linalg.qr(RANDOM(9).normal(size=(3, 3)))[0]
    return np.column_stack([x, y, z]) @ turn + [0.3, -2, 5], faces.astype(np.int32)


@pytest.mark.parametrize("seed", range(3))
def test_sides_are_flat_hang_together_and_are_the_same_in_any_order(seed):
    vertices, faces = bumpy(seed)
    sides = grow_sides(vertices, faces, 0.01)
    sizes = np.bincount(sides)
    assert (np.diff(sizes) <= 0).all() and sizes[:2].sum() > 110 and len(sizes) > 2
    for side in range(len(sizes)):
        used = vertices[np.unique(faces[sides == side])]
        assert np.linalg.svd(used - used.mean(axis=0))[2].shape == (3, 3)
        across = (used - used.mean(axis=0)) @ np.linalg.svd(used - used.mean(axis=0))[2][2]
        assert np.ptp(across) <= 2.05 * 0.01
    flat, steep = (unit_normals(vertices, faces[sides == side]) for side in (0, 1))
    assert np.median(np.abs(flat @ steep[0])) == pytest.approx(1 / np.hypot(1, 0.6), abs=1e-6)
    other = grow_sides(vertices, bumpy(seed + 5)[1], 0.01)
    assert np.array_equal(np.bincount(other)[:2], sizes[:2])


def test_faces_bend_by_how_far_their_neighbours_corners_lie_from_their_planes():
    vertices, faces = bumpy(0)
    normals = unit_normals(vertices, faces)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)
    assert np.isnan(unit_normals(vertices, np.array([[0, 1, 2], [4, 4, 9]]))).all()  # in a row, and twice the same
    starts, incident = faces_of_vertices(faces, len(vertices))
    for vertex in range(len(vertices)):
        assert set(incident[starts[vertex] : starts[vertex + 1]]) == set(np.flatnonzero((faces == vertex).any(axis=1)))
    found = bending(vertices, faces, normals, starts, incident)
    for face in range(len(faces)):
        beside = np.isin(faces, faces[face]).any(axis=1)
        away = np.abs((vertices[faces[beside]] - vertices[faces[face, 0]]) @ normals[face]).max()
        assert found[face] == pytest.approx(away, abs=1e-12)
        plane = plane_of_face(vertices, faces, normals, face)
        assert np.allclose(vertices[faces[face]] @ plane[:3], plane[3])
        others = np.abs(vertices[faces] @ plane[:3] - plane[3]).max(axis=1)
        assert [near(vertices, faces, k, plane, 0.05) for k in range(128)] == (others <= 0.05).tolist()


def test_a_plane_lies_midway_between_the_outermost_of_its_points():
    points = np.concatenate([RANDOM(4).normal(size=(80, 3)) * [3, 2, 0], [[0, 0, 0.2]]]) + [0, 0, 1]
    plane = fit_plane(points, np.arange(81, dtype=np.int32))
    away = points @ plane[:3] - plane[3]
    assert (
        away.max() == pytest.approx(-away.min())
        and away.max() < 0.11
        and np.linalg.norm(plane[:3]) == (pytest.approx(1))
    )
    spread = RANDOM(5).normal(size=(60, 3)) * [3, 1, 0.2] @ np.linalg.qr(RANDOM(6).normal(size=(3, 3)))[0]
    least = np.linalg.eigh(np.cov(spread.T))[1][:, 0]
    assert np.abs(fit_plane(spread, np.arange(60, dtype=np.int32))[:3] @ least) == pytest.approx(1)


def test_a_vertical_line_crosses_a_polygon_where_it_is_as_wide():
    points = RANDOM(2).normal(size=(40, 2))
    hull = points[hull_of(points, 0.0)]
    planes = ConvexHull(points).equations
    for x in np.linspace(hull[:, 0].min() + 1e-3, hull[:, 0].max() - 1e-3, 15):
        heights = np.linspace(-4, 4, 4001)
        held = (planes[:, :2] @ np.vstack([np.full(4001, x), heights]) + planes[:, 2:] <= 0).all(axis=0)
        assert vertical_span(hull, x) == pytest.approx((heights[held].min(), heights[held].max()), abs=0.004)
    assert count_inside(points, hull) == 40 and count_inside(points * 5, hull) < 20
    order = np.lexsort((points[:, 1], points[:, 0]))
    assert sorted(chain(points, order)) == sorted(ConvexHull(points).vertices)
    assert len(chain(points, order[:1])) == 1


def test_bare_cells_are_all_over_the_hull_where_no_point_is_near():
    reach, flat = 0.4, RANDOM(3).uniform(0, [4, 3], (400, 2))
    points = flat[(np.hypot(*(flat - [1.2, 1.5]).T) > 0.8) & (np.hypot(*(flat - [3, 1.5]).T) > 0.6)]
    hull = points[hull_of(points, 0.0)]
    bare = bare_cells(points, hull, reach)
    gaps = cKDTree(points).query(bare)[0]
    assert len(bare) > 10 and gaps.min() > reach and count_inside(bare, hull) == len(bare)
    x, y = (part.ravel() for part in np.mgrid[0:4:0.02, 0:3:0.02])
    places = np.column_stack([x, y])
    planes = ConvexHull(points).equations
    places = places[(planes[:, :2] @ places.T + planes[:, 2:] <= -1e-9).all(axis=0)]
    places = places[cKDTree(points).query(places)[0] > reach]
    area = len(bare) * (reach / CELLS) ** 2
    assert area == pytest.approx(len(places) * 0.02**2, rel=0.1) and cKDTree(bare).query(places)[0].max() < 0.15
    patch = largest_patch(bare, reach)
    assert np.abs(patch.mean(axis=0) - [1.2, 1.5]).max() < 0.15 and 0.5 < len(patch) / len(bare) < 1
    assert not len(bare_cells(points[:3] * 0.01, hull[:3] * 0.01, reach))


def test_a_cut_leaves_the_fewest_bare_cells_inside_the_two_hulls():
    """An L falls into its two arms: one cut is enough, and no part bridges the notch."""
    x, y = (part.ravel() for part in np.mgrid[0:13, 0:13] * 0.25)
    index = np.arange(169).reshape(13, 13)
    first = index[:-1, :-1].ravel()
    halves = [np.column_stack([first, first + 13, first + 14]), np.column_stack([first, first + 14, first + 1])]
    faces = np.concatenate(halves)
    flat = np.column_stack([x, y])
    faces = faces[~(flat[faces].mean(axis=1) > 1).all(axis=1)].astype(np.int64)
    order = np.lexsort((flat[:, 1], flat[:, 0]))
    used = corners_of_faces(order, faces, np.ones(len(faces), bool), True)
    assert set(used) == set(faces.ravel()) and not len(corners_of_faces(order, faces, np.ones(len(faces), bool), False))
    hull = flat[chain(flat, used)]
    bare = bare_cells(flat[used], hull, 0.3)
    side = best_cut(flat, faces, order, hull, largest_patch(bare, 0.3), bare, 0.3)
    halves = [flat[chain(flat, corners_of_faces(order, faces, side, half))] for half in (True, False)]
    assert sum(count_inside(bare, half) for half in halves) < 0.1 * len(bare)
    parts = parts_without_bridges(flat, faces, np.empty((0, 2)), 0.3)
    assert 2 <= len(parts) <= 3 and set(np.concatenate(parts)) == set(used)
    assert len(parts_without_bridges(flat, faces, flat, 0.3)) == 1  # where others lie in the notch it is none


def test_numbers_of_sides_go_to_their_vertices_and_names_to_their_items():
    owners = np.array([[0, 5], [0, 2], [0, 9], [1, 3], [3, 1], [3, 0]])
    first, second = first_sides(owners, 10, 5)
    assert first.tolist() == [2, 3, 10, 0, 10] and second.tolist() == [5, 10, 10, 1, 10]
    pairs = RANDOM(0).integers(0, 4, (50, 2))
    assert np.array_equal(unique_rows(pairs), np.unique(pairs, axis=0)) and unique_rows(pairs[:0]).shape == (0, 2)
    split_items = split_by(np.array([10, 11, 12, 13]), np.array([2, 0, 2, 1]))
    assert [part.tolist() for part in split_items] == [[11], [13], [10, 12]] and split_by(pairs[:0], pairs[:0]) == []


def test_layers_of_a_voxel_are_told_by_gaps_and_thickness():
    assert split(np.array([0.0, 0.01, 0.039]), 0.02)[0] == 1 and split(np.array([0.0, 0.03, 0.041]), 0.02)[0] == 0
    layers, border = split(np.array([0.5, 0.0, 0.03, 0.52]), 0.02)
    assert layers == 2 and border == pytest.approx(0.265)
    for neither in ([0.0, 0.03, 0.2, 0.3], [0.0, 0.03, 0.045, 0.08]):
        assert split(np.array(neither), 0.02)[0] == 0
    points, across = RANDOM(1).normal(size=(30, 3)), RANDOM(2).normal(size=30)
    beyond = np.flatnonzero(across > 0.2)
    assert mean_beyond(points, across, 0.2) == pytest.approx(points[beyond].mean(axis=0))
    away = np.linalg.norm(points[beyond] - [1, 1, 1], axis=1)
    assert extreme(points, across, 0.2, np.ones(3), True) == beyond[away.argmax()]
    assert extreme(points, across, 0.2, np.ones(3), False) == beyond[away.argmin()]


def test_voxels_are_spread_least_across_their_normals():
    turn = np.linalg.qr(RANDOM(3).normal(size=(3, 3)))[0]
    sheets = [RANDOM(k).normal(size=(40, 3)) * [1, 1, 0.01] @ turn[[k, (k + 1) % 3, (k + 2) % 3]] + k for k in range(3)]
    found = voxel_normals(np.concatenate(sheets), np.array([0, 40, 80, 120]))
    for k, normal in enumerate(found):
        assert np.abs(normal @ turn[(k + 2) % 3]) == pytest.approx(1, abs=1e-3)
