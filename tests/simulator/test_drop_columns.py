"""Columns: drawn at random as in the paper, or spread evenly."""

import numpy as np
import pytest

from spherefunc_bullet.simulator import Columns, DropSettings, generator_of

LOW, HIGH = np.array([-1.0, 2.0]), np.array([3.0, 2.5])
RANDOM, EVEN = DropSettings(radius=0.01), DropSettings(radius=0.01, even_columns=True)


@pytest.mark.parametrize("settings", [RANDOM, EVEN])
def test_columns_do_not_depend_on_how_many_are_drawn_at_a_time(settings):
    one_by_one, at_once = Columns(LOW, HIGH, settings, 3), Columns(LOW, HIGH, settings, 3).draw(300)
    assert np.array_equal(np.concatenate([one_by_one.draw(1) for _ in range(300)]), at_once)
    assert ((at_once >= LOW) & (at_once < HIGH)).all()
    assert not np.array_equal(at_once, Columns(LOW, HIGH, settings, 4).draw(300))


def test_random_columns_are_those_of_the_generator():
    assert np.array_equal(Columns(LOW, HIGH, RANDOM, 5).draw(20), generator_of(5).uniform(LOW, HIGH, size=(20, 2)))


@pytest.mark.parametrize("count", [40, 200])
def test_evenly_spread_columns_measure_an_area_better_than_random_ones(count):
    """The share of columns within a disc: its error over 50 seeds is at most half as large."""

    def error(settings: DropSettings) -> float:
        drawn = [(Columns(LOW, HIGH, settings, seed).draw(count) - LOW) / (HIGH - LOW) for seed in range(50)]
        shares = [np.mean(((columns - 0.5) ** 2).sum(axis=1) < 0.3**2) for columns in drawn]
        return float(np.sqrt(np.mean((np.array(shares) - np.pi * 0.3**2) ** 2)))

    assert error(EVEN) < 0.5 * error(RANDOM)
