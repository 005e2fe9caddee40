"""The feature: counts per cube, and that distances come out as if every cube of space had a column."""

from __future__ import annotations

from collections import Counter

import clouds
import numpy as np
import pytest
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.metrics.pairwise import euclidean_distances

from spherefunc_bullet.learning.histogram import (
    CubeHistogram,
    SphereHistogram,
    cube_indices,
    cube_keys,
    quarter_turns,
    widened,
)

RADIUS = 0.02
SIDE = 3.5 * 2 * RADIUS


def pile(seed: int, count: int = 200, size: float = 0.5) -> np.ndarray:
    return np.random.default_rng(seed).uniform([-size, -size, 0], [size, size, size], (count, 3))


def dense(piles) -> np.ndarray:
    """Return the histograms over every cube that any of the piles touches, counted one sphere at a time."""
    cubes = [Counter(map(tuple, np.floor(each / SIDE + [0.5, 0.5, 0]).astype(int).tolist())) for each in piles]
    columns = sorted(set().union(*cubes))
    return np.array([[each[cube] for cube in columns] for each in cubes], float)


def test_counts_sum_to_the_number_of_spheres():
    piles = [pile(0, 30), pile(1, 400), np.empty((0, 3))]
    assert CubeHistogram(RADIUS).fit_transform(piles).sum(axis=1).A1.tolist() == [30, 400, 0]


def test_side_of_a_cube_is_three_and_a_half_diameters():
    assert CubeHistogram(RADIUS).side == pytest.approx(0.14)
    assert CubeHistogram(RADIUS, diameters=4).side == pytest.approx(0.16)


def test_cubes_begin_at_the_floor_and_are_centred_on_the_axis():
    just = SIDE / 2 * 0.999
    inside = np.array([[just, just, 0.999 * SIDE], [-just, -just, 0.0]])
    outside = np.array([[SIDE / 2 * 1.001, 0, 0], [0, 0, 1.001 * SIDE]])
    assert cube_indices(cube_keys(inside, SIDE)).tolist() == [[0, 0, 0], [0, 0, 0]]
    assert cube_indices(cube_keys(outside, SIDE)).tolist() == [[1, 0, 0], [0, 0, 1]]


def test_keys_name_cubes_far_from_the_axis():
    centers = np.array([[-1000.0, 2000.0, 30.0], [0.0, 0.0, 0.0]])
    expected = np.floor(centers / SIDE + [0.5, 0.5, 0]).astype(int)
    assert np.array_equal(cube_indices(cube_keys(centers, SIDE)), expected)


def test_distances_are_those_over_all_of_space():
    """Also to objects with spheres where no training object had any: that is what "elsewhere" is for."""
    learnt, asked = [pile(i) for i in range(4)], [pile(9, 300, 0.9), pile(10, 50, 0.2), np.empty((0, 3))]
    histogram = CubeHistogram(RADIUS).fit(learnt)
    truth = dense([*learnt, *asked])
    measured = euclidean_distances(histogram.transform(asked), histogram.transform(learnt))
    # Both are sums of a few hundred squares of counts in double precision.
    assert np.allclose(measured, euclidean_distances(truth[4:], truth[:4]), rtol=1e-9)
    assert histogram.transform(asked)[0, -1] > 0 and histogram.transform(learnt)[:, -1].sum() == 0


def test_growing_gives_the_distances_of_learning_everything():
    first, later, asked = [pile(0), pile(1, 100, 0.3)], [pile(2, 150, 0.8)], [pile(3, 90, 1.0)]
    grown = CubeHistogram(RADIUS).fit(first)
    before, rows = grown.keys_, grown.transform(first)
    grown.partial_fit(later)
    rows = widened(rows, before, grown.keys_)
    whole = CubeHistogram(RADIUS).fit(first + later)
    assert np.array_equal(grown.keys_, whole.keys_)
    assert np.array_equal(rows.toarray(), whole.transform(first).toarray())
    assert np.array_equal(grown.transform(asked).toarray(), whole.transform(asked).toarray())


def test_widened_keeps_what_is_elsewhere_at_the_end():
    histogram = CubeHistogram(RADIUS).fit([pile(0, 20, 0.2)])
    rows = histogram.transform([pile(1, 50, 0.9)])
    more = np.union1d(histogram.keys_, cube_keys(pile(1, 50, 0.9) + 5, SIDE))
    wide = widened(rows, histogram.keys_, more)
    assert wide.shape == (1, len(more) + 1) and wide[0, -1] == rows[0, -1] > 0
    assert wide.sum() == rows.sum()


def test_partial_fit_first_is_fit():
    piles = [pile(0), pile(1)]
    assert np.array_equal(CubeHistogram(RADIUS).partial_fit(piles).keys_, CubeHistogram(RADIUS).fit(piles).keys_)


def test_four_quarter_turns_are_none():
    centers = pile(0)
    assert np.array_equal(quarter_turns(quarter_turns(centers, 1), 3), centers)


def test_nothing_in_nothing_out():
    assert CubeHistogram(RADIUS).fit([pile(0)]).transform([]).shape[0] == 0
    assert CubeHistogram(RADIUS).fit([np.empty((0, 3))]).transform([pile(0, 16)])[0, -1] > 0


def test_transform_before_fit_says_so():
    with pytest.raises(NotFittedError):
        CubeHistogram(RADIUS).transform([pile(0)])


def test_sphere_histogram_takes_clouds():
    histogram = SphereHistogram(radius=0.02)
    both = [clouds.plate(), clouds.mug()]
    rows = histogram.fit_transform(both)
    assert rows.shape[0] == 2 and (rows.sum(axis=1).A1 > 5).all()
    assert np.array_equal(histogram.transform(both).toarray(), rows.toarray())
    assert np.array_equal(SphereHistogram(radius=0.02).fit(both).transform(both).toarray(), rows.toarray())


def test_sphere_histogram_is_a_scikit_learn_transformer():
    histogram = SphereHistogram("fast", 0.03, seed=4, diameters=3.0)
    copy = clone(histogram)
    assert copy is not histogram and copy.get_params() == histogram.get_params()
    assert set(CubeHistogram().get_params()) < set(histogram.get_params())
    assert clone(CubeHistogram(0.03, diameters=4.0)).get_params()["diameters"] == 4.0
