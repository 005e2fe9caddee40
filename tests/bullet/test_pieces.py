"""Convex pieces cover the surface and bridge no opening."""

import numpy as np
import pytest
from clouds import chair, cloud, level, mug, plate, sheet, table
from scipy.spatial import ConvexHull, cKDTree

from spherefunc_bullet.bullet.collision.pieces import convex_pieces
from spherefunc_bullet.bullet.collision.triangulation import faces_between

RADIUS = 0.02  # metres
TOLERANCE = 0.02  # radii
REACH = 0.25  # radii: 5 mm, as the paper's greatest gap; lattices are 4 mm apart


def l_plate():
    arms = sheet([0, 0, 0.1], [0.3, 0, 0], [0, 0.1, 0]), sheet([0, 0, 0.1], [0.1, 0, 0], [0, 0.3, 0])
    return cloud(*arms, name="L")


def holed_plate():
    points = level(0.3, 0.3, 0.1)
    return cloud(points[np.abs(points[:, :2]).max(axis=1) > 0.05], name="plate with a hole")


def two_sheets():
    return cloud(level(0.2, 0.2, 0.1), level(0.2, 0.2, 0.1 + 0.3 * RADIUS), name="two sheets")


SHAPES = {f.__name__: f for f in (plate, l_plate, holed_plate, two_sheets, mug, chair, table)}


def soup(shape):
    """Return the surface of a shape: vertices (N, 3), sorted, in radii, and faces (M, 3)."""
    points = shape.points[np.lexsort(shape.points.T[::-1])] / RADIUS
    return points, faces_between(points, REACH, REACH)


@pytest.fixture(scope="module", params=SHAPES)
def case(request):
    vertices, faces = soup(SHAPES[request.param]())
    return request.param, vertices, faces, convex_pieces(vertices, faces, TOLERANCE, REACH)


def half_spaces(piece):
    """Return normals (E, 3) and offsets (E,) of the half-spaces whose intersection is a piece, flat or not."""
    mean = piece.mean(axis=0)
    axes = np.linalg.svd(piece - mean)[2]
    placed = (piece - mean) @ axes.T
    if np.ptp(placed[:, 2]) > 2 * TOLERANCE:
        planes = ConvexHull(piece).equations
        return planes[:, :3], -planes[:, 3]
    edges = ConvexHull(placed[:, :2]).equations
    normals = np.concatenate([edges[:, :2] @ axes[:2], axes[2:], -axes[2:]])
    offsets = np.concatenate([-edges[:, 2], [placed[:, 2].max(), -placed[:, 2].min()]])
    return normals, offsets + normals @ mean


def excess(points, pieces):
    """Return how far each point (N, 3) lies outside the half-spaces of the piece that holds it best."""
    best = np.full(len(points), np.inf)
    for piece in pieces:
        near = ((points > piece.min(axis=0) - 0.2) & (points < piece.max(axis=0) + 0.2)).all(axis=1)
        normals, offsets = half_spaces(piece)
        best[near] = np.minimum(best[near], (points[near] @ normals.T - offsets).max(axis=1))
    return best


def locations(piece, generator, count=200):
    """Return random locations of a piece (count, 3)."""
    return generator.dirichlet(np.full(len(piece), 0.5), count) @ piece


@pytest.mark.slow
def test_faces_are_covered(case):
    _, vertices, faces, pieces = case
    weights = np.random.default_rng(0).dirichlet([0.5] * 3, min(len(faces), 20_000))
    chosen = np.linspace(0, len(faces) - 1, len(weights)).astype(int)
    points = (vertices[faces[chosen]] * weights[:, :, None]).sum(axis=1)
    assert excess(points, pieces).max() <= 2 * TOLERANCE


def test_no_opening_is_bridged(case):
    _, vertices, _, pieces = case
    generator = np.random.default_rng(0)
    places = np.concatenate([locations(piece, generator) for piece in pieces])
    # Hulls are looked at on a grid of a quarter of the reach, and bends are thin wedges.
    assert cKDTree(vertices).query(places)[0].max() <= 1.25 * REACH


def test_pieces_are_few(case):
    name, _, _, pieces = case
    # Two sheets a sphere's third apart have a rim of four sides.
    limits = {"plate": 1, "l_plate": 2, "holed_plate": 5, "two_sheets": 6, "mug": 100, "chair": 100, "table": 100}
    assert len(pieces) <= limits[name]
    assert all(3 <= len(piece) <= 48 for piece in pieces)


def test_corners_are_vertices(case):
    _, vertices, _, pieces = case
    assert cKDTree(vertices).query(np.concatenate(pieces))[0].max() == 0


def test_same_again():
    vertices, faces = soup(mug())
    first, again = (convex_pieces(vertices, faces, TOLERANCE, REACH) for _ in range(2))
    assert len(first) == len(again) and all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))


def test_rim_of_a_sheet_turned_any_way():
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    vertices, faces = soup(l_plate())
    assert len(convex_pieces(vertices @ turn, faces, TOLERANCE, REACH)) == 2


def test_a_box_has_a_piece_for_each_side():
    sides = [level(0.1, 0.1, 0), level(0.1, 0.1, 0.1)]
    for corner, across in (([-0.05, -0.05, 0], [0.1, 0, 0]), ([-0.05, 0.05, 0], [0.1, 0, 0])):
        sides += [sheet(corner, across, [0, 0, 0.1])]
    for x in (-0.05, 0.05):
        sides += [sheet([x, -0.05, 0], [0, 0.1, 0], [0, 0, 0.1])]
    pieces = convex_pieces(*soup(cloud(*sides, name="box")), TOLERANCE, REACH)
    assert 6 <= len(pieces) <= 6 + 12 + 8  # and perhaps a bend along each edge and at each corner


def test_faces_without_area_are_kept():
    row = np.column_stack([np.linspace(0, 1, 6), np.zeros((6, 2))])
    pieces = convex_pieces(row, np.array([[0, 1, 2], [2, 3, 4], [3, 4, 5]]), TOLERANCE, REACH)
    corners = np.concatenate(pieces)
    assert corners[:, 0].min() == 0 and corners[:, 0].max() == 1 and all(len(piece) >= 3 for piece in pieces)


def test_nothing():
    assert convex_pieces(np.empty((0, 3)), np.empty((0, 3), int), TOLERANCE, REACH) == []
