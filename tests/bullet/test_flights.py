"""When a flight is over and how: gone, at rest for long enough, lost, or given up; and which column is free for one."""

from __future__ import annotations

import numpy as np
import pytest

from spherefunc_bullet.bullet.dropping import IN_FLIGHT, LEANING, TOUCH, Flights, first_apart
from spherefunc_bullet.bullet.engine import Physics
from spherefunc_bullet.simulator import Outcome

PHYSICS = Physics()
LOW, HIGH = np.array([-10.0, -6.0, 0.0]), np.array([8.0, 12.0, 5.0])


def flights_at(*places) -> Flights:
    """Return flights that begin at some places, radii."""
    flights = Flights(len(places), PHYSICS, LOW, HIGH)
    for slot, place in enumerate(places):
        flights.start(slot, place)
    return flights


def looked(flights: Flights, velocity, looks: int) -> list[int]:
    """Return the first flight's outcome after each look while all move at a velocity (radii per unit of time)."""
    said = []
    for _ in range(looks):
        said.append(int(flights.update(flights.positions + PHYSICS.check_interval * np.array(velocity))[0]))
    return said


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99, 1.01, 3.0])
def test_a_sphere_is_at_rest_after_it_was_slow_for_so_long(share):
    velocity = share * PHYSICS.rest_speed * np.array([0.6, 0.0, 0.8])
    looks = round(PHYSICS.rest_time / PHYSICS.check_interval)
    said = looked(flights_at([0, 0, 3]), velocity, looks + 1)
    if share < 1:
        assert said[: looks - 1] == [IN_FLIGHT] * (looks - 1) and said[looks - 1] == Outcome.SETTLED
    else:
        assert said == [IN_FLIGHT] * (looks + 1)


def test_one_move_begins_the_rest_anew():
    flights, looks = flights_at([0, 0, 3]), round(PHYSICS.rest_time / PHYSICS.check_interval)
    still = looked(flights, [0, 0, 0], looks - 1)
    assert still + looked(flights, [0, 1, 0], 1) + looked(flights, [0, 0, 0], looks - 1) == [IN_FLIGHT] * (
        2 * looks - 1
    )
    assert looked(flights, [0, 0, 0], 1) == [Outcome.SETTLED]
    flights.reset_rest(0)
    assert looked(flights, [0, 0, 0], looks) == [IN_FLIGHT] * (looks - 1) + [Outcome.SETTLED]


def test_what_never_rests_is_given_up_when_its_time_is_over():
    flights, looks = flights_at([0, 0, 3]), int(PHYSICS.time_limit / PHYSICS.check_interval)
    circle = np.exp(0.7j * np.arange(looks + 2))
    said = [int(flights.update(np.array([[z.real, z.imag, 3.0]]))[0]) for z in circle]
    assert set(said[: looks - 1]) == {IN_FLIGHT} and said[-1] == Outcome.TIMED_OUT
    assert flights.late(0)
    flights.start(0, [0, 0, 3])
    assert not flights.late(0) and looked(flights, [1, 0, 0], 1) == [IN_FLIGHT]


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", [-1, 1])
def test_a_sphere_beside_the_box_or_on_the_ground_has_rolled_off(axis, side):
    edge = (LOW if side < 0 else HIGH)[axis] + side * (1 + TOUCH)
    for beyond, outcome in ((-1e-6, IN_FLIGHT), (1e-6, Outcome.ROLLED_OFF)):
        place = np.array([0.0, 0.0, 3.0])
        place[axis] = edge + side * beyond
        assert flights_at([0, 0, 3]).update(place[None])[0] == outcome
    for z, outcome in ((1.0, IN_FLIGHT), (0.95, IN_FLIGHT), (0.85, Outcome.ROLLED_OFF), (-3, Outcome.ROLLED_OFF)):
        assert flights_at([0, 0, 3]).update(np.array([[0, 0, z]]))[0] == outcome


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("axis", range(3))
def test_a_sphere_that_is_nowhere_is_lost(axis, value):
    place = np.array([[0.0, 0.0, 3.0]])
    place[0, axis] = value
    flights = flights_at([0, 0, 3])
    assert flights.update(place)[0] == Outcome.TIMED_OUT and flights.ended == 1


def test_speeds_are_ways_over_time():
    flights = flights_at([0, 0, 3], [5, 0, 3], [0, 5, 3], [-5, 0, 3])
    flights.flying[3] = False
    ways = PHYSICS.check_interval * np.array([[3, 4, 0], [0, 0, 2], [0, 0, 0], [9, 9, 9]])
    flights.update(flights.positions + ways)
    assert flights.speeds[:3].tolist() == pytest.approx([5, 2, 0]) and flights.fastest == pytest.approx(5)
    assert flights.fast(1.9) == [0, 1] and flights.fast(2.1) == [0] and flights.free == [3]
    assert flights.ended == 0 and flights.positions[3].tolist() == [-5, 0, 3]  # of which nothing is known


@pytest.mark.parametrize(("apart", "leans"), [(2.0, True), (LEANING - 1e-3, True), (LEANING + 1e-3, False)])
def test_nothing_is_at_rest_that_leans_on_what_moves(apart, leans):
    """Nor what leans on that: of four in a row only the last is moving, and one beside them is alone."""
    row = [[apart * k, 0, 3] for k in range(-2, 2)]
    flights, looks = flights_at(*row, [0, 9, 3]), round(PHYSICS.rest_time / PHYSICS.check_interval)
    for k in range(looks):
        places = np.array([*row, [0, 9, 3]])
        places[3, 1] += 0.05 * (k % 2)  # to and fro
        said = flights.update(places).tolist()
    expected = IN_FLIGHT if leans else Outcome.SETTLED
    assert said == [expected] * 3 + [IN_FLIGHT, Outcome.SETTLED] and flights.ended == 1 + 3 * (not leans)


@pytest.mark.parametrize("seed", range(20))
def test_the_first_column_that_is_apart_comes_first_and_the_others_keep_their_order(seed):
    random = np.random.default_rng(seed)
    columns, positions = random.uniform(0, 10, (30, 2)), random.uniform(0, 10, (6, 3))
    flying, start, few = random.uniform(size=6) < 0.8, 5, int(random.integers(1, 8))
    gaps = np.linalg.norm(columns[:, None] - positions[None, flying, :2], axis=2).min(axis=1, initial=np.inf)
    free = [c for c in range(start, start + few) if gaps[c] >= 4.1]
    order = list(range(30))
    if free:
        order.insert(start, order.pop(free[0]))
    expected = columns[order]
    assert first_apart(columns, start, few, flying, positions, 4.1) == bool(free)
    assert np.array_equal(columns, expected)
