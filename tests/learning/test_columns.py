"""Columns, outlines and levels of spheres: what holds of them wherever they are, and of those known by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_resting_profile import DIAMETER, RADIUS, dropped, heap, layer, quantities, quantities_of, turned

from spherefunc_bullet.learning.profiles.columns import (
    SphereColumns,
    columns_of,
    edges_of,
    enclosed_area,
    fullest_level,
    half_hull,
    largest_piece,
    outline_of,
)
from spherefunc_bullet.learning.profiles.quantities import NAMES, profiles_over

RANDOM = np.random.default_rng


@pytest.mark.parametrize("points", [layer(4, 3, 0.0)[:, :2], layer(9, 8, 0.0)[:, :2], RANDOM(0).normal(size=(300, 2))])
def test_an_outline_is_strictly_convex_and_holds_every_point(points):
    """So that each corner is needed: of a grid four are, however many points it has and whatever their order."""
    outline = outline_of(RANDOM(1).permutation(np.concatenate([points, points[::2]])), RADIUS)
    along = edges_of(outline.corners)
    following = np.roll(along, -1, axis=0)
    turn = along[:, 0] * following[:, 1] - along[:, 1] * following[:, 0]
    assert (turn > 1e-12).all() and outline.inside(points).min() >= -1e-12
    assert {tuple(corner) for corner in outline.corners} <= {tuple(point) for point in points}


def test_an_area_is_as_exact_a_kilometre_away():
    triangle = np.array([[0, 0], [0.01, 0], [0, 0.01]])
    for far in (0, 1e3, -1e3):
        assert enclosed_area(triangle + far) == pytest.approx(5e-5, rel=1e-9)


def test_of_two_spheres_the_outline_is_the_way_between_them():
    pair = outline_of(np.array([[0.3, 0.0], [0.0, 0.0]]), RADIUS)
    assert pair.corners.tolist() == [[0, 0], [0.3, 0]] and pair.width == pytest.approx(2 * RADIUS)
    assert np.sort(pair.depths(np.array([[0.1, 0.05]]))[:, 0]) == pytest.approx([-0.05, 0.05])  # of either side
    assert half_hull(np.array([[0.0, 0], [1, 0], [2, 0]])) == [0, 2]


@pytest.mark.parametrize("value", [0.1, 0.7, 123.4])
def test_what_is_alike_has_no_spread(value):
    columns = columns_of(np.concatenate([layer(3, 3, 0.4 + k * DIAMETER) for k in range(3)]), RADIUS)
    assert columns.spread(np.full(27, value)) == pytest.approx(0, abs=1e-7 * value)  # a root of rounding
    assert columns.spread(columns.centers[:, 0]) == pytest.approx(DIAMETER * np.sqrt(2 / 3))
    for seed in range(20):
        weights = RANDOM(seed).uniform(size=9)
        uneven = SphereColumns(centers=np.zeros((9, 3)), radius=RADIUS, weights=weights, tops=weights, bottoms=weights)
        assert uneven.spread(np.full(9, value)) == pytest.approx(0, abs=1e-7 * value)


def test_quantiles_count_columns_and_not_spheres():
    """A stack of nine is one column of ten, so that no less than nine tenths lie on the ground."""
    stack = np.concatenate([layer(9, 1, 0.0), [[1.0, 0, RADIUS + k * DIAMETER] for k in range(9)]])
    columns = columns_of(stack, RADIUS)
    assert columns.quantiles(columns.tops, (0.0, 0.5, 0.9, 0.91, 1.0)) == pytest.approx(
        [RADIUS, RADIUS, RADIUS, RADIUS + 8 * DIAMETER, RADIUS + 8 * DIAMETER]
    )
    assert columns.mean(columns.depths) == pytest.approx((9 + 9) / 10 * DIAMETER)


@pytest.mark.parametrize("seed", range(3))
def test_neither_order_nor_place_of_spheres_changes_their_columns_level_and_piece(seed):
    centers = heap(seed)
    order = RANDOM(seed).permutation(len(centers))
    here, there = columns_of(centers, RADIUS), columns_of((turned(centers, 1.0) + [5, -3, 0])[order], RADIUS)
    assert there.weights == pytest.approx(here.weights[order]) and there.depths == pytest.approx(here.depths[order])
    pieces = [largest_piece(fullest_level(columns)[1]) for columns in (here, there)]
    assert sorted(pieces[0].centers[:, 2]) == sorted(pieces[1].centers[:, 2])
    assert pieces[0].outline.area == pytest.approx(pieces[1].outline.area)


def test_of_single_spheres_the_highest_is_the_level():
    apart = np.array([[0.5 * k, 0, height] for k, height in enumerate((0.2, 0.8, 0.4, 0.6))])
    height, level = fullest_level(columns_of(apart, RADIUS))
    assert height == 0.8 and len(level) == 1


@pytest.mark.parametrize("lift", [0.0, 0.1, 0.3, 0.7])
@pytest.mark.parametrize("rows", [(5, 5, 1), (1, 5, 5)])
def test_a_level_reaches_as_far_down_as_up(rows, lift):
    """Of three steps, each a radius high, that in the middle holds all columns, whichever of the others holds few."""
    steps = [layer(4, count, lift + k * RADIUS, corner=(k, 0)) for k, count in enumerate(rows)]
    assert len(fullest_level(columns_of(np.concatenate(steps), RADIUS))[1]) == 4 * sum(rows)


@pytest.mark.parametrize("far", [0.1, 1.0])
def test_two_shelves_of_which_neither_reaches_the_other_are_no_one_level(far):
    """Ten columns each, one and a half radii apart, are less than fifteen that are on one level, lower or higher."""
    two = [layer(2, 5, 0.5 + k * 1.5 * RADIUS, corner=(k, 0)) for k in range(2)]
    height, level = fullest_level(columns_of(np.concatenate([*two, layer(3, 5, far, corner=(2, 0))]), RADIUS))
    assert height == pytest.approx(far + RADIUS) and len(level) == 15


@pytest.mark.parametrize(("apart", "linked"), [(2.9, True), (3.1, False)])
def test_stacks_are_linked_up_to_three_radii(apart, linked):
    """However closely spheres lie over one another, what is a sphere's width away belongs together."""
    stacks = [[x, 0, RADIUS + k * DIAMETER] for x in (0, apart * RADIUS) for k in range(20)]
    assert len(largest_piece(columns_of(np.array(stacks), RADIUS))) == 20 * (1 + linked)


@pytest.mark.parametrize(("apart", "linked"), [(1.8, True), (2.4, False)])
def test_few_spheres_are_linked_up_to_twice_their_mean_spacing(apart, linked):
    """In two fields of 100 each, ten spheres' widths between them, hardly any are at an edge."""
    spacing = 10 * RADIUS
    field = layer(10, 10, 0.4) * [spacing / DIAMETER, spacing / DIAMETER, 1]
    both = np.concatenate([field, field + [(9 + apart) * spacing, 0, 0]])
    for centers in (both, both[:, [1, 0, 2]]):
        assert len(largest_piece(columns_of(centers, RADIUS))) == 100 * (1 + linked)
        assert quantities(centers)["level_piece"] == pytest.approx(1.0 if linked else 0.5)


@pytest.mark.parametrize(("spacing", "rim"), [(2.2, 1.0), (1.7, (24 * 1 + 16 * 2) / 40)])
def test_the_rim_is_what_lies_within_a_sphere_s_width_of_the_outline(spacing, rim):
    """Of seven by seven columns, all but the outermost two deep, the rim has the second ring where that is as near."""
    grid = layer(7, 7, 0.4) * [spacing / 2, spacing / 2, 1]
    low, high = grid[:, :2].min() + RADIUS, grid[:, :2].max() - RADIUS
    within = ((grid[:, :2] > low) & (grid[:, :2] < high)).all(axis=1)
    found = quantities(np.concatenate([grid, grid[within] + [0, 0, DIAMETER]]))
    assert found["rim_to_middle"] == pytest.approx(rim / ((24 * 1 + 25 * 2) / 49))
    assert found["one_deep"] == pytest.approx(24 / 49)


@pytest.mark.parametrize(
    ("hung", "gap", "over"),
    [(-0.006, 0, 0), (-0.004, -0.004, 0), (0.009, 0.009, 0), (0.011, 0.011, 1), (0.149, 0.149, 1), (0.151, 0, 0)],
)
def test_a_gap_is_more_than_a_centimetre_and_no_more_than_fifteen(hung, gap, over):
    """A small sphere as high as the large one lies beside it; one far below is on another part of the object."""
    small, large = 0.01, 0.03
    drops = {small: dropped(np.array([[0, 0, small + 0.2]])), large: dropped(np.array([[0, 0, large + 0.2 + hung]]))}
    drops = {radius: replace(one, radius=radius) for radius, one in drops.items()}
    found = dict(zip(NAMES, profiles_over([drops], (small, large))[0, len(NAMES) :].tolist(), strict=True))
    assert (found["gap"], found["middle_gap"], found["over_gaps"]) == pytest.approx((gap, gap, over))


@pytest.mark.parametrize(("place", "counted"), [(-1.1, 0), (-0.9, 1), (-0.1, 1), (0.1, 2), (4.9, 2), (5.1, 3)])
def test_a_drop_is_lost_where_the_object_might_have_held_it(place, counted):
    """So many radii inside of the outline of a plate's centres, ten of them to its middle, drops fall through it first.

    They are lost to the plate as far out as spheres reach, to its level inside, and to its middle from half way on.
    """
    rows = dropped(layer(11, 11, 0.4), np.tile([place * RADIUS, 10 * RADIUS], (9, 1))).rows()
    found = quantities_of(np.concatenate([rows[121:], rows[:121]]))
    assert [found[name] < 1 for name in ("stays", "level_stays", "middle_stays")] == [counted > k for k in range(3)]
    assert (found["stays_early"] < 1) == (counted > 0)


def test_columns_begin_and_end_at_a_sphere_s_own_ends():
    """Of ten columns, each higher and deeper than the last, half lie as low as the fifth, nine tenths as the ninth."""
    stacks = [[k, 0, RADIUS + (k + layers) * DIAMETER] for k in range(10) for layers in range(k + 1)]
    found = quantities(RANDOM(0).permutation(np.array(stacks)))
    assert (found["middle_bottom"], found["high_bottom"]) == pytest.approx((4 * DIAMETER, 8 * DIAMETER))
    assert (found["middle_top"], found["high_top"]) == pytest.approx((9 * DIAMETER, 17 * DIAMETER))
    assert found["settled"] == 55 and found["one_deep"] == pytest.approx(1 / 10)
    assert found["on_spheres"] == pytest.approx(45 / 55)
