"""The spheres in the air: where each is, since when, and whether its flight is over."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..processes.compilation import njit
from ..simulator import Outcome
from .physics import Physics

IN_FLIGHT = -1
SETTLED, ROLLED_OFF, TIMED_OUT = int(Outcome.SETTLED), int(Outcome.ROLLED_OFF), int(Outcome.TIMED_OUT)
TOUCH = 0.02  # radii: gap that counts as contact, as the engine's own threshold
SUNK = 0.1  # radii: a sphere whose lowest point is so far below the ground is on the ground
LEANING = 2.05  # radii between centres at which one sphere may lean on the other


class Flights:
    """Slots, each a place for one sphere in the air; lengths in radii, times in sqrt(radius / g)."""

    def __init__(self, count: int, physics: Physics, low: np.ndarray, high: np.ndarray):
        self.physics = physics
        self.flying = np.zeros(count, bool)
        self.positions = np.zeros((count, 3))
        self.speeds = np.zeros(count)
        self.time = np.zeros(count)  # since the start
        self.slow = np.zeros(count)  # for how long slower than the speed of rest
        self.outcomes = np.full(count, IN_FLIGHT)
        limits = (physics.look, physics.rest_speed, 0.99 * physics.rest_time, physics.time_limit)
        arrays = (self.flying, self.positions, self.speeds, self.time, self.slow, self.outcomes)
        self.state = (*arrays, low, high, *limits)  # what is judged, and by what
        self.ended, self.fastest = 0, 0.0  # at the last look: flights that are over, and the speed of the fastest

    @property
    def free(self) -> list[int]:
        """The slots in which no sphere is in the air."""
        return [] if self.flying.all() else np.flatnonzero(~self.flying).tolist()

    def start(self, slot: int, position: Sequence[float]):
        """Begin a flight."""
        self.positions[slot] = position
        self.flying[slot], self.time[slot], self.slow[slot] = True, 0.0, 0.0

    def look(self, positions: np.ndarray) -> np.ndarray:
        """Take in new positions (K, 3); return each slot's outcome, -1 while it is free or its sphere on its way."""
        self.ended, self.fastest = judge_flights(positions, *self.state)
        return self.outcomes

    def late(self, slot: int) -> bool:
        """Return whether a flight has lasted as long as it may."""
        return self.time[slot] > self.physics.time_limit

    def rouse(self, slot: int):
        """Let a sphere that has stopped be watched for as long again."""
        self.slow[slot] = 0.0

    def fast(self, limit: float) -> list[int]:
        """Return the slots whose spheres are faster than a limit."""
        return np.flatnonzero(self.flying & (self.speeds > limit)).tolist()


@njit(cache=True, error_model="numpy")
def judge_flights(
    new, flying, positions, speeds, time, slow, outcomes, low, high, look, rest_speed, rest_time, time_limit
):
    """Update the flights' state from new positions, and write the outcomes of those that are over.

    Returns how many are, and the speed of the fastest sphere.
    """
    fastest = 0.0
    for i in range(len(flying)):
        outcomes[i] = IN_FLIGHT
        if not flying[i]:
            continue
        x, y, z = new[i, 0], new[i, 1], new[i, 2]
        dx, dy, dz = x - positions[i, 0], y - positions[i, 1], z - positions[i, 2]
        speeds[i] = math.sqrt(dx * dx + dy * dy + dz * dz) / look
        fastest = max(fastest, speeds[i])
        positions[i] = new[i]
        time[i] += look
        slow[i] = slow[i] + look if speeds[i] < rest_speed else 0.0
        reach = 1 + TOUCH
        beside = x < low[0] - reach or x > high[0] + reach or y < low[1] - reach or y > high[1] + reach
        if not math.isfinite(x + y + z):
            outcomes[i] = TIMED_OUT
        elif beside or z < 1 - SUNK:
            outcomes[i] = ROLLED_OFF
        elif slow[i] > rest_time:
            outcomes[i] = SETTLED
        elif time[i] > time_limit:
            outcomes[i] = TIMED_OUT
    withhold_leaning(positions, flying, outcomes)
    return np.sum(outcomes != IN_FLIGHT), fastest


@njit(cache=True, error_model="numpy")
def withhold_leaning(positions, flying, outcomes):
    """Take back rest from spheres that lean on one that still moves, and from those that lean on these."""
    changed = True
    while changed:
        changed = False
        for i in range(len(flying)):
            if not flying[i] or outcomes[i] != SETTLED:
                continue
            for j in range(len(flying)):
                if flying[j] and outcomes[j] == IN_FLIGHT and distance(positions, i, j) < LEANING:
                    outcomes[i] = IN_FLIGHT
                    changed = True
                    break


@njit(cache=True, error_model="numpy")
def distance(positions, i, j):
    """Return the distance between two centres."""
    x, y, z = positions[i] - positions[j]
    return math.sqrt(x * x + y * y + z * z)


@njit(cache=True, error_model="numpy")
def first_apart(columns, start, few, flying, positions, apart):
    """Put the first column that is apart from every sphere in the air before the others, among a few from a start on.

    Returns whether there is one.
    """
    for c in range(start, start + few):
        free = True
        for i in range(len(flying)):
            dx, dy = columns[c, 0] - positions[i, 0], columns[c, 1] - positions[i, 1]
            if flying[i] and dx * dx + dy * dy < apart * apart:
                free = False
                break
        if free:
            x, y = columns[c, 0], columns[c, 1]
            columns[start + 1 : c + 1] = columns[start:c].copy()
            columns[start, 0], columns[start, 1] = x, y
            return True
    return False
