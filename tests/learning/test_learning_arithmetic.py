"""The arithmetic of learning by itself: parts on a table, evidence of cubes, sources, lines of votes, levels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sklearn.base import BaseEstimator, ClassifierMixin
from test_resting_profile import RADIUS, layer, quantities

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.function_model import Membership
from spherefunc_bullet.learning.any_pose import PoseFunctions, best_poses
from spherefunc_bullet.learning.profiles.calibration import (
    ALLOWED_ERROR,
    DEFAULT_UNSURE_RANGE,
    UNCERTAIN_MARGIN,
    WIDEST_MARGIN,
    CopyGroups,
    calibrated,
    equal_source_weights,
    fit_calibration,
    group_copies,
    held_out_votes,
    log_odds,
    unsure_range,
)
from spherefunc_bullet.learning.profiles.columns import (
    CELL,
    LARGEST,
    LEAST,
    SPARED,
    columns_of,
    count_parts,
    fullest_level,
    largest_piece,
    objects_on_table,
    outline_of,
    scatter_of,
)
from spherefunc_bullet.learning.profiles.quantities import Ranks, evenness
from spherefunc_bullet.settling.drops import resting_drops

RANDOM = np.random.default_rng


def square(corner: tuple[float, float], side: float, z: float = 0.0) -> np.ndarray:
    """Return points a third of a cell apart."""
    steps = np.arange(CELL / 6, side, CELL / 3)
    return np.array([[corner[0] + x, corner[1] + y, z] for x in steps for y in steps])


@pytest.mark.parametrize(("gap", "parts"), [(0, 1), (1, 2), (2, 2)])
def test_parts_are_apart_where_a_cell_between_them_is_empty(gap, parts):
    two = [square((k * (2 + gap) * CELL, 0), 2 * CELL)[:, :2] for k in range(2)]
    assert count_parts(np.concatenate(two), 1.0) == parts
    assert count_parts(np.concatenate([two[0], two[0] + 2 * CELL]), 1.0) == 1  # corner to corner


def test_of_nothing_there_are_no_parts_and_large_ones_are_furniture():
    assert count_parts(np.empty((0, 2)), 1.0) == 0
    both = np.concatenate([square((0, 0), 2 * CELL), square((1, 1), 4 * CELL)])[:, :2]
    assert [count_parts(both, cells * CELL**2) for cells in (3.5, 4.5, 15.5, 16.5)] == [0, 1, 1, 2]


def on_table(*objects: np.ndarray, count: int = 400) -> int:
    """Return how many objects stand on a plate of 80 cm at 0.7 m, on which spheres rest side by side."""
    rests = layer(20, 20, 0.7)[:count]
    drops = {2 * RADIUS: resting_drops(2 * RADIUS, rests[:2] + 1), RADIUS: resting_drops(RADIUS, rests)}
    return objects_on_table(Cloud(np.concatenate([layer(20, 20, 0.7 - RADIUS), *objects])), drops)


def test_what_stands_on_a_table_rises_from_it_inside_its_edge():
    box = square((0.3, 0.3), 0.1)
    assert on_table() == 0 and on_table(box + [0, 0, 0.7 + 1.2 * LEAST]) == 1
    assert on_table(box + [0, 0, 0.7 + 0.8 * LEAST]) == 0  # of the level
    assert on_table(*(box + [x, x, 0.75] for x in (-0.2, 0, 0.2))) == 3
    edge = np.array([[x, y, 0.75] for x in (0.002, 0.012) for y in np.arange(0.3, 0.4, 0.01)])
    assert on_table(edge) == 0 and on_table(edge + [3 * SPARED, 0, 0]) == 1
    assert on_table(square((0.1, 0.1), np.sqrt(LARGEST) * 0.8 * 1.1) + [0, 0, 0.75]) == 0  # a shelf above
    assert on_table(box + [0, 0, 0.75], count=2) == 0  # hardly a sphere stays: no level
    assert on_table(box[::7] * [3, 3, 1] - [0.7, 0.7, -0.75]) == 0  # points that belong to no surface


def test_three_spheres_show_a_level_and_two_do_not():
    corners = np.array([[-0.06, -0.035, 0.72], [0.06, -0.035, 0.72], [0, 0.07, 0.72]])
    box = np.concatenate([square((-0.01, -0.01), 0.02, height) for height in np.arange(0.73, 0.8, 0.01)])
    found = [objects_on_table(Cloud(box), {RADIUS: resting_drops(RADIUS, corners[:count])}) for count in (3, 2)]
    assert found == [1, 0]


def test_the_scatter_of_a_level_is_its_deviation_whatever_stands_on_it():
    level = RANDOM(0).normal(0, 0.002, 4000)
    assert scatter_of(np.concatenate([level, np.full(4000, 0.1)])) == pytest.approx(0.002, rel=0.05)
    assert scatter_of(np.full(3, 0.1)) == 0


class Memory(ClassifierMixin, BaseEstimator):
    """Says whether an object with the same first quantity was learnt, so that what was held out shows."""

    def fit(self, X, y):
        self.learnt_, self.classes_ = set(X[:, 0].tolist()), np.unique(y)
        return self

    def predict_proba(self, X):
        seen = np.array([value in self.learnt_ for value in X[:, 0].tolist()], float)
        return np.column_stack([1 - seen, seen])


def test_nothing_of_the_same_source_is_learnt_and_what_has_none_always_is():
    sources = ["b", "a", "", "b", "a", "", "b", "a"]
    copy_groups = group_copies([str(k) for k in range(8)], [""] * 8, sources)
    assert copy_groups.has_sources and copy_groups.sources.tolist() == [1, 0, -1, 1, 0, -1, 1, 0]
    members = np.array([True, False] * 4)
    quantity = np.array([0, 1, 2, 0, 1, 2, 2, 2.0])[:, None]  # by source, but for two like those of nobody
    votes = held_out_votes(Memory(), quantity, members, copy_groups, 0)
    assert np.isnan(votes).tolist() == [False, False, True, False, False, True, False, False]
    assert votes[[0, 3]].tolist() == votes[[1, 4]].tolist() == [0, 0] and votes[[6, 7]].tolist() == [1, 1]
    alone = held_out_votes(Memory(), quantity, np.array(sources) == "b", copy_groups, 0)
    assert np.isnan(alone[[0, 3, 6]]).all() and not np.isnan(alone[[1, 4, 7]]).any()  # without b's, no member is left


def test_who_comes_later_is_nobodys_copy_and_of_no_source():
    first = group_copies(["a", "b", "c"], ["", "a", "gone"], ["x", "x", ""])
    assert first.groups[0] == first.groups[1] != first.groups[2] and first.weights.tolist() == [1, 0.1, 0.1]
    assert not first.has_sources and first.sources.tolist() == [0, 0, -1]
    more = first.with_more(2)
    assert len(set(more.groups.tolist())) == 4 and more.weights[3:].tolist() == [1, 1]
    assert more.groups[:3].tolist() == first.groups.tolist() and more.sources.tolist() == [0, 0, -1, -1, -1]
    assert first.of(np.array([2, 0])).sources.tolist() == [-1, 0] and group_copies(["a"], [""]).sources is None
    two = CopyGroups(weights=np.ones(3), groups=np.arange(3), sources=np.array([0, -1, 1]))
    assert two.has_sources and not replace(two, sources=np.array([0, -1, 0])).has_sources
    together = group_copies(["one", "two"], ["gone", "gone"])
    assert together.groups[0] == together.groups[1] and together.with_more(1).sources is None


def test_bands_leave_no_more_wrong_and_sure_than_may_be():
    """Of 1,000 answers three either way; where there are fewer members than that, all of them may be missed."""
    allowed, members = int(ALLOWED_ERROR * 1000), np.arange(1000) < 400
    scores = np.where(members, 0.9, 0.1)
    scores[: allowed + 1], scores[-allowed - 1 :] = (
        np.linspace(0.2, 0.23, allowed + 1),
        np.linspace(0.8, 0.77, allowed + 1),
    )
    assert DEFAULT_UNSURE_RANGE[0] < 0.5 < DEFAULT_UNSURE_RANGE[1] and sum(DEFAULT_UNSURE_RANGE) == pytest.approx(
        1
    )  # where nobody knows: either side alike
    low, high = unsure_range(scores, members)
    assert (scores[members] < low).sum() == (scores[~members] > high).sum() == allowed
    assert (low, high) == pytest.approx((0.23, 0.77))
    few = np.arange(1000) < allowed
    assert unsure_range(np.zeros(1000), few) == pytest.approx((0.5 - UNCERTAIN_MARGIN, 0.5 + UNCERTAIN_MARGIN))
    assert unsure_range(np.ones(1000), ~few)[1] == pytest.approx(0.5 + UNCERTAIN_MARGIN)
    assert unsure_range(np.where(members, 0.0, 1.0), members) == pytest.approx(
        (0.5 - WIDEST_MARGIN, 0.5 + WIDEST_MARGIN)
    )


def test_every_source_counts_alike_in_a_band():
    """Fifty of the 10,000 objects of a large source are more than may be missed of all, but not of two sources."""
    weights = equal_source_weights(np.repeat([0, 1], [10_000, 1_000]))
    assert weights[:10_000].sum() == pytest.approx(weights[10_000:].sum())
    scores, members = np.full(11_000, 0.9), np.ones(11_000, bool)
    scores[:50], scores[50:100] = 0.1, 0.2
    assert unsure_range(scores, members)[0] == pytest.approx(0.1)
    assert unsure_range(scores, members, weights)[0] == pytest.approx(0.2)


def test_votes_that_are_probabilities_stay_and_others_come_near_them():
    random, shares = RANDOM(0), np.linspace(0.05, 0.95, 19)
    truth = np.tile(shares, 400)
    members = random.uniform(size=len(truth)) < truth
    slope, offset = fit_calibration(truth, members)
    assert (slope, offset) == pytest.approx((1, 0), abs=0.1)  # thrice the error of some thousand coins
    timid = calibrated(truth, (0.5, 0.4))
    assert calibrated(timid, fit_calibration(timid, members)) == pytest.approx(truth, abs=0.03)
    few = fit_calibration(np.array([0.6, 0.4]), np.array([True, False]))
    assert few[1] == pytest.approx(0, abs=1e-3) and 1 < few[0] < 1.2  # two examples change little
    assert fit_calibration(1 - np.array([0.6, 0.4]), np.array([True, False]))[0] < 1
    assert log_odds(np.array([0.0, 0.5, 1.0])) == pytest.approx([-np.log(99), 0, np.log(99)])
    for line in ((1e9, 0.0), (1.0, -1e9)):
        assert np.isfinite(calibrated(np.array([0.0, 0.3]), line)).all()


def stepped(step: float, columns: int = 10) -> np.ndarray:
    """Return spheres side by side, each column of them a step higher than the one before."""
    centers = layer(columns, 10, 0.4)
    centers[:, 2] += step * np.round(centers[:, 0] / (2 * RADIUS))
    return centers


def test_how_even_a_level_is_by_hand():
    """Ten steps, a tenth of the columns on each: of these eight tenths lie within eight steps."""
    step = 0.09 * RADIUS
    found = quantities(stepped(step))
    assert found["level_share"] == 1 and found["level_range"] == pytest.approx(8 * step)
    assert found["level_unevenness"] == pytest.approx(step * np.sqrt((10**2 - 1) / 12))
    assert found["level_roughness"] == pytest.approx(0, abs=1e-9)
    assert found["level_tilt"] == pytest.approx(np.degrees(np.arctan(step / (2 * RADIUS))))


def test_spheres_of_a_column_weigh_as_one():
    stack = np.array([[0, 0, 0.1], [0, 0, 0.14], [0, 0, 0.18], [1, 1, 0.1]])
    assert columns_of(stack, RADIUS).weights == pytest.approx([1 / 3] * 3 + [1])


@pytest.mark.parametrize("turn", [1, -1])
def test_of_equal_pieces_the_wider_one_is_the_largest(turn):
    close, wide = layer(5, 5, 0.4), layer(5, 5, 0.4) * [1.1, 1.1, 1] + [1.0, 0, 0]
    piece = largest_piece(columns_of(np.concatenate([close, wide][::turn]), RADIUS))
    assert len(piece) == 25 and piece.centers[:, 0].min() >= 1


@pytest.mark.parametrize("lift", [0.0, 0.1, 0.3, 0.7])
def test_a_level_ends_one_radius_up_and_down_however_high_it_is(lift):
    """Of steps one radius high, three in a row are one level: heights that rounding parts are the same."""
    _, level = fullest_level(columns_of(stepped(RADIUS) + [0, 0, lift], RADIUS))
    assert len(level) == 3 * 10


@pytest.mark.parametrize(("count", "tilted"), [(5, False), (6, True)])
def test_a_plane_is_laid_through_six_spheres_or_more(count, tilted):
    slope = stepped(0.2 * RADIUS, columns=2)[:count]
    tilt, rough = evenness(columns_of(slope, RADIUS))
    assert (tilt > 1) == tilted and rough == pytest.approx(0, abs=1e-9)


def test_columns_weigh_alike_in_a_plane_however_deep():
    """A stack on one corner of a slope counts as one column, so that the plane is that of the slope's undersides."""
    slope = stepped(0.2 * RADIUS, columns=4)
    piled = np.concatenate([slope, slope[-1:] + [[0, 0, 0.0]] * 30])  # one place thirty times more
    piled[-30:, 2] += 0.3 * RADIUS
    assert evenness(columns_of(piled, RADIUS))[0] == pytest.approx(evenness(columns_of(slope, RADIUS))[0], abs=1e-6)


@pytest.mark.parametrize(("higher", "share"), [(0.3, 1.0), (1.0, 0.0)])
def test_one_deep_is_less_than_two_spheres(higher, share):
    """Spheres that lean on others, their axes nearer than one and a half radii, make columns that are deeper."""
    pairs = np.concatenate([layer(1, 3, 0.4) + [4 * k * RADIUS, 0, 0] for k in range(3)])
    leaning = pairs + [1.2 * RADIUS, 0, higher * RADIUS]
    assert quantities(np.concatenate([pairs, leaning]))["one_deep"] == share


def test_shares_of_no_drops_are_none():
    """On a single row no drop falls inside of the outline of the centres, and what is not there has no share."""
    found = quantities(layer(1, 2, 0.4))
    assert found["stays"] == found["middle_stays"] == found["level_stays"] == 0


def test_an_outline_holds_what_is_as_far_inside_as_it_says():
    corners = np.array([[0, 0], [0.6, 0], [0.6, 0.2], [0, 0.2]])
    outline = outline_of(corners, 0.05)
    assert outline.area == pytest.approx(0.12 + 1.6 * 0.05 + np.pi * 0.05**2) and outline.width == pytest.approx(0.3)
    assert outline.inside(np.array([[0.3, 0.1], [0.55, 0.1], [0.7, 0.1], [0.3, 0.0]])) == pytest.approx(
        [0.1, 0.05, -0.1, 0]
    )
    assert outline_of(corners[:3], 0.05).inside(np.array([[0.5, 0.1]])) == pytest.approx(0.2 / np.sqrt(10))
    assert (outline_of(corners[:2], 0.05).inside(corners) == -np.inf).all()
    assert outline_of(corners[:2], 0.05).area == pytest.approx(1.2 * 0.05 + np.pi * 0.05**2)
    assert outline_of(corners[:1], 0.05).width == pytest.approx(0.1)


def test_ranks_are_shares_that_have_less_and_distances_their_mean_difference():
    learnt = np.column_stack([np.arange(40.0), np.repeat([0.0, 1.0], 20)])
    found = Ranks(learnt).distances(np.array([[-1.0, 0.0], [19.5, 1.0], [100, 2]]))
    first, second = (np.arange(40) + 0.5) / 40, np.repeat([0.25, 0.75], 20)
    assert found[0] == pytest.approx(0.5 * first + 0.5 * np.abs(0.25 - second))
    assert found[1, 20] == pytest.approx(0.5 * 0.5 / 40) and found[2, 39] == pytest.approx(0.5 * 0.5 / 40 + 0.125)
    assert Ranks(learnt).distances(np.empty((0, 2))).shape == (0, 40)


def test_of_equally_good_poses_the_likelier_comes_first():
    def pose(**scores: float) -> PoseFunctions:
        functions = {name: Membership(member=False, score=score, radius=0.01) for name, score in scores.items()}
        return PoseFunctions(pose=None, functions=functions)

    answers = [pose(cup=0.2, table=0.9), pose(cup=0.7, table=0.9), pose(cup=0.7, table=0.1)]
    assert best_poses(answers) == {"cup": 1, "table": 0} and best_poses([]) == {}
    assert best_poses(answers[:1]) == {"cup": 0, "table": 0}
