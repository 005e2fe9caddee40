"""What is walled in, beside arithmetic that tries every point in every direction, whichever way objects are turned."""

from __future__ import annotations

import numpy as np
import pytest

from spherefunc_bullet.settling.enclosure import DIRECTIONS, NARROWER, around, can_meet, directions, walled_in

RADIUS = 0.01
REACH = NARROWER * RADIUS


def met_everywhere(points: np.ndarray, center: np.ndarray) -> bool:
    """Return whether a sphere pushed from a centre, in each direction alone, comes within reach of some point."""
    ahead = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    way = np.column_stack([np.cos(ahead), np.sin(ahead), np.zeros(DIRECTIONS)])
    to_points = points - center
    along = to_points @ way.T
    aside = (to_points**2).sum(axis=1)[:, None] - along**2
    apart = np.hypot(*to_points[:, :2].T) ** 2 > REACH**2 - to_points[:, 2] ** 2  # not where it is already
    return bool(((aside < REACH**2) & (along > 0) & apart[:, None]).any(axis=0).all())


@pytest.mark.parametrize("seed", range(6))
def test_all_directions_are_met_if_each_one_is(seed):
    """In clouds of which half of the places are walled in, near the middle or near the edge, wherever they are."""
    random = np.random.default_rng(seed)
    away = random.uniform(-3, 3, 3)
    points = random.uniform([-0.1, -0.1, 0.0], [0.1, 0.1, 0.1], (random.choice([700, 1000, 1400]), 3)) + away
    centers = random.uniform([-0.12, -0.12, -0.02], [0.12, 0.12, 0.12], (120, 3)) + away
    expected = [met_everywhere(points, center) for center in centers]
    assert walled_in(points, centers, RADIUS).tolist() == expected
    assert 0.03 < np.mean(expected) < 0.97


def ring(gap: float, heading: float) -> np.ndarray:
    """Return a round wall of 4 cm about the axis, 8 cm high, open as wide as said, in a direction (radians)."""
    half = np.arcsin(gap / 2 / 0.04)
    angle, z = np.meshgrid(heading + np.linspace(half, 2 * np.pi - half, 300), np.arange(0, 0.08, 0.002))
    return np.column_stack([0.04 * np.cos(angle).ravel(), 0.04 * np.sin(angle).ravel(), z.ravel()])


@pytest.mark.parametrize("heading", np.arange(0, DIRECTIONS, 5) * 2 * np.pi / DIRECTIONS)
def test_a_slit_is_one_from_four_fifths_of_a_sphere_whichever_way_it_points(heading):
    center, way = np.array([[0, 0, 0.04]]), np.array([np.cos(heading), np.sin(heading), 0])
    narrow, wide = ring(1.8 * NARROWER * RADIUS, heading), ring(2.4 * NARROWER * RADIUS, heading)
    assert walled_in(narrow, center, RADIUS).all() and not walled_in(wide, center, RADIUS).any()
    assert not walled_in(wide, center - 0.02 * way, RADIUS).any()  # nor from the far side, if it faces the slit


@pytest.mark.parametrize(("height", "met"), [(-0.02, False), (0.02, True), (0.095, False)])
def test_under_and_over_a_wall_nothing_is_met(height, met):
    assert walled_in(ring(0.0, 0.0), np.array([[0, 0, height]]), RADIUS).tolist() == [met]


def test_a_ring_held_by_nothing_else_walls_in_what_is_at_its_height():
    """Three layers of points, one alone of them at the height of the sphere."""
    wall = ring(0.0, 0.0)
    for k, z in enumerate((0.0, 0.03, 0.06)):
        band = wall[abs(wall[:, 2] - 0.03) < 1e-9] + [0, 0, z - 0.03]
        ends = np.array([[0.5, 0.5, 0.0], [0.5, 0.5, 0.06]])
        places = np.array([[0, 0, 0.0], [0, 0, 0.03], [0, 0, 0.06]])
        assert walled_in(np.concatenate([band, ends]), places, RADIUS).tolist() == [k == n for n in range(3)]


@pytest.mark.parametrize("heading", np.arange(0, DIRECTIONS, 7) * 2 * np.pi / DIRECTIONS)
def test_what_a_sphere_touches_already_holds_it_no_more_than_nothing_does(heading):
    """Through an open side it leaves, whatever lies within it, and a wall holds it whatever else is there."""
    center, inside = np.array([[0, 0, 0.04]]), np.array([[0.002, 0.001, 0.04], [-0.003, 0, 0.041]])
    for gap, held in ((2.4 * NARROWER * RADIUS, False), (0.0, True)):
        wall = np.concatenate([ring(gap, heading), inside])
        assert walled_in(wall, center, RADIUS).tolist() == [held]


def named(bits: int) -> set[int]:
    """Return which directions a number's bits are."""
    return {k for k in range(DIRECTIONS) if int(bits) >> k & 1}


@pytest.mark.parametrize("first", [-130, -64, -3, 0, 5, 63, 64, 100])
def test_directions_from_one_to_another_are_those_between_them(first):
    for count in (-1, 0, 1, 2, 40, 63, 64, 200):
        between = {k % DIRECTIONS for k in range(first, first + count)}
        assert named(directions(first, first + count - 1)) == between


def test_what_may_be_met_is_what_is_met_and_hardly_more():
    """The bounds on angles are within a hundredth, a tenth of the way from one direction to the next, or a little."""
    random, step, more = np.random.default_rng(0), 2 * np.pi / DIRECTIONS, []
    for _ in range(3000):
        angle, sine = random.uniform(-np.pi, np.pi), random.uniform(0.02, 0.999)
        dx, dy = random.uniform(0.001, 3) * np.array([np.cos(angle), np.sin(angle)])
        half = np.arcsin(sine)
        exact = {k % DIRECTIONS for k in range(int(np.ceil((angle - half) / step)), int((angle + half) // step) + 1)}
        found = named(can_meet(dx, dy, sine**2))
        assert exact <= found
        bound = sine * (1 + (np.pi / 2 - 1) * sine**2) - half  # of the arcsine, which is loose in between
        more.append((len(found) - len(exact)) - 2 * bound / step)
    assert np.mean(more) < 0.3 and max(more) <= 2.2
    for dx, dy, straight in ((1, 0, 0), (0, 1, 16), (-1, 0, 32), (0, -1, 48), (1, 1, 8), (-1, -1, 40), (-1, 1, 24)):
        assert named(can_meet(float(dx), float(dy), 1e-4)) == {straight}


def test_layers_next_to_a_height():
    assert [around(z, -1.0, 0.5, 6) for z in (-0.9, -0.4, 0.1, 1.6, 1.9)] == [(0, 2), (0, 3), (1, 4), (4, 6), (4, 6)]
    assert around(-9.0, -1.0, 0.5, 6) == (0, 0) and around(9.0, -1.0, 0.5, 6) == (6, 6)
