"""Dropping: spheres fall until 50 in a row were not placed (paper, §III-A), several in the air at once.

Columns are drawn over the bounding box in a fixed order, and a sphere starts just above what lies under its column as
soon as no other sphere in the air is near it. The engine moves all of them; every few steps each is checked: on the
ground, at rest, or still moving (`Flights`).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..clouds.cloud import Cloud
from ..processes.compilation import njit
from ..simulator import Columns, DropResult, DropSettings, Outcome, Stop
from .collision.shape import CollisionShape
from .columns import ColumnIndex
from .engine import Physics
from .world import World

IN_FLIGHT = -1
SETTLED, ROLLED_OFF, TIMED_OUT = int(Outcome.SETTLED), int(Outcome.ROLLED_OFF), int(Outcome.TIMED_OUT)
TOUCH = 0.02  # radii: gap that counts as contact, as in the engine
SUNK = 0.1  # radii: a sphere whose lowest point is so far below z = 0 is on the ground
LEANING = 2.05  # radii between centres at which one sphere may lean on another
CLEARANCE = (
    0.1  # radii above the first contact at which a sphere starts: faces rise less than that between their points
)
APART = 2.2  # radii between a new column and every sphere in the air
ROOM = 30.0  # square radii of the footprint for each sphere in the air
SUNKEN = 0.03  # radii of overlap from which on the engine still pushes a sphere out, however slowly
OVERLAP = 0.05  # radii: a sphere that rests deeper in the cloud, or stays wedged in deeper, is not placed
CHUNK = 1024  # columns drawn at a time


class Flights:
    """Slots, each for one sphere in the air; lengths in radii, times in sqrt(radius / g)."""

    def __init__(self, count: int, physics: Physics, low: np.ndarray, high: np.ndarray):
        self.physics = physics
        self.flying = np.zeros(count, bool)
        self.positions = np.zeros((count, 3))
        self.speeds = np.zeros(count)
        self.time = np.zeros(count)  # since the start
        self.slow = np.zeros(count)  # time for which it has been slower than the speed of rest
        self.outcomes = np.full(count, IN_FLIGHT)
        limits = (physics.check_interval, physics.rest_speed, 0.99 * physics.rest_time, physics.time_limit)
        arrays = (self.flying, self.positions, self.speeds, self.time, self.slow, self.outcomes)
        self.state = (*arrays, low, high, *limits)  # arguments of `update_flights`
        self.ended, self.fastest = 0, 0.0  # at the last check: number of flights that ended, and the highest speed

    @property
    def free(self) -> list[int]:
        """The slots in which no sphere is in the air."""
        return [] if self.flying.all() else np.flatnonzero(~self.flying).tolist()

    def start(self, slot: int, position: Sequence[float]):
        """Start a flight."""
        self.positions[slot] = position
        self.flying[slot], self.time[slot], self.slow[slot] = True, 0.0, 0.0

    def update(self, positions: np.ndarray) -> np.ndarray:
        """Update the positions (K, 3); return the outcome of each slot, -1 if it is free or its sphere still moves."""
        self.ended, self.fastest = update_flights(positions, *self.state)
        return self.outcomes

    def late(self, slot: int) -> bool:
        """Return whether a flight has exceeded the time limit."""
        return self.time[slot] > self.physics.time_limit

    def reset_rest(self, slot: int):
        """Restart the time of rest of a sphere that has stopped."""
        self.slow[slot] = 0.0

    def fast(self, limit: float) -> list[int]:
        """Return the slots whose spheres are faster than a limit."""
        return np.flatnonzero(self.flying & (self.speeds > limit)).tolist()


@njit(cache=True, error_model="numpy")
def update_flights(
    new, flying, positions, speeds, time, slow, outcomes, low, high, interval, rest_speed, rest_time, time_limit
):
    """Update the state of the flights from new positions, and write the outcomes of those that ended.

    Returns their number, and the speed of the fastest sphere.
    """
    fastest = 0.0
    for i in range(len(flying)):
        outcomes[i] = IN_FLIGHT
        if not flying[i]:
            continue
        x, y, z = new[i, 0], new[i, 1], new[i, 2]
        dx, dy, dz = x - positions[i, 0], y - positions[i, 1], z - positions[i, 2]
        speeds[i] = math.sqrt(dx * dx + dy * dy + dz * dz) / interval
        fastest = max(fastest, speeds[i])
        positions[i] = new[i]
        time[i] += interval
        slow[i] = slow[i] + interval if speeds[i] < rest_speed else 0.0
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
    """Reset the outcome of settled spheres that lean on a moving one, and of spheres that lean on these."""
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
    """Move the first of a few columns that is apart from every sphere in the air to their beginning.

    Returns whether there is such a column.
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


class DropRun:
    """The state of one run, in radii."""

    def __init__(self, world: World, shape: CollisionShape, cloud: Cloud, settings: DropSettings, seed: int):
        self.world, self.settings = world, settings
        self.low, self.high = cloud.bounds / settings.radius
        self.columns = ColumnIndex(shape.columns, self.low, self.high)
        points = cloud.points / settings.radius
        self.points = self.columns if shape.kind == "mesh" else ColumnIndex(points, self.low, self.high)
        self.source = Columns(self.low[:2], self.high[:2], settings, seed)
        self.drawn, self.next = np.empty((0, 2)), 0  # columns, and the first of them that is not used
        slots = int(np.clip(np.prod((self.high - self.low)[:2]) / ROOM, 1, world.physics.in_air))
        world.add_spheres(slots)
        self.flights = Flights(slots, world.physics, self.low, self.high)
        self.centers: list[np.ndarray] = []
        self.on_object: list[bool] = []
        self.starts = [(0.0, 0.0)] * slots  # the column of each slot's sphere
        self.ended_at: list[Sequence[float]] = []  # the columns of the drops that ended
        self.outcomes: list[Outcome] = []  # of these drops
        self.misses = 0

    def until_over(self):
        """Drop spheres until a limit is reached."""
        while not self.over:
            self.launch()
            if not self.over:
                self.world.step()
                self.check()

    @property
    def over(self) -> bool:
        limits = self.settings
        full = len(self.centers) >= limits.max_spheres or len(self.outcomes) == limits.max_drops
        return full or self.misses >= limits.miss_limit

    def launch(self):
        """Start a sphere in every free slot for which there is a column."""
        for slot in self.flights.free:
            xy = self.next_column()
            height = -np.inf if xy is None else self.columns.height(*xy)
            if height > -np.inf:
                start = (*xy, height + CLEARANCE)
                self.world.place(slot, start)
                self.flights.start(slot, start)
                self.starts[slot] = xy
                continue
            self.world.park(slot)
            if xy is not None:  # only the ground is below
                self.count(Outcome.ROLLED_OFF, xy)
                if self.over:
                    return

    def next_column(self) -> tuple[float, float] | None:
        """Return the first column that is apart from every sphere in the air; None if there is none among the next."""
        flights = self.flights
        few = len(flights.flying)
        if len(self.drawn) - self.next < few:
            new = self.source.draw(CHUNK)
            self.drawn, self.next = np.concatenate([self.drawn[self.next :], new]), 0
        if not first_apart(self.drawn, self.next, few, flights.flying, flights.positions, APART):
            return None
        x, y = self.drawn[self.next].tolist()
        self.next += 1
        return x, y

    def check(self):
        """Check the positions of the spheres, and end the flights that are over."""
        outcomes = self.flights.update(self.world.positions())
        limit = self.world.physics.terminal_speed
        if not self.flights.fastest <= 0.8 * limit:  # also if it is NaN
            for slot in self.flights.fast(0.8 * limit):
                self.world.limit_speed(slot, limit)
        for slot in np.flatnonzero(outcomes != IN_FLIGHT).tolist() if self.flights.ended else ():
            self.end(slot, Outcome(outcomes[slot]))
            if self.over:
                return

    def end(self, slot: int, outcome: Outcome):
        """End the flight of a slot; a sphere that has come to rest is settled or rejected."""
        center = self.flights.positions[slot].copy()
        if outcome == Outcome.SETTLED:
            to_object, deepest = self.world.contacts(slot)
            if deepest < -SUNKEN and not self.flights.late(slot):
                return self.flights.reset_rest(slot)
            outcome = Outcome.TIMED_OUT if deepest < -OVERLAP else self.resting_place(center, to_object <= TOUCH)
        elif not np.isfinite(center).all():
            self.world.renew(slot)
        self.flights.flying[slot] = False
        self.count(outcome, self.starts[slot])

    def resting_place(self, center: np.ndarray, on_object: bool) -> Outcome:
        """Return the outcome of a sphere at rest, and add it to the world if it has settled."""
        if center[2] < 1 - TOUCH:
            return Outcome.ROLLED_OFF
        if not on_object and not ((center >= self.low) & (center <= self.high)).all():
            return Outcome.REJECTED
        if not self.points.clear(center, 1 - OVERLAP):  # the shape may lack a few points of the cloud
            return Outcome.TIMED_OUT
        self.world.freeze(center)
        self.columns.add(center)
        self.centers.append(center)
        self.on_object.append(on_object)
        return Outcome.SETTLED

    def count(self, outcome: Outcome, column: Sequence[float]):
        """Record the outcome of the sphere that was dropped in a column (2,)."""
        self.outcomes.append(outcome)
        self.ended_at.append(column)
        self.misses = 0 if outcome == Outcome.SETTLED else self.misses + 1

    def stop(self) -> Stop:
        """Return why the run ended."""
        if self.misses >= self.settings.miss_limit:
            return Stop.MISSES
        return Stop.SPHERE_LIMIT if len(self.centers) >= self.settings.max_spheres else Stop.DROP_LIMIT

    def result(self, seconds: float, provenance: dict[str, Any]) -> DropResult:
        """Return the result of the run, in metres."""
        counts = Counter(self.outcomes)
        return DropResult(
            centers=np.array(self.centers, float).reshape(-1, 3) * self.settings.radius,
            on_object=np.array(self.on_object, bool),
            rolled_off=counts[Outcome.ROLLED_OFF],
            rejected=counts[Outcome.REJECTED],
            timed_out=counts[Outcome.TIMED_OUT],
            stop=self.stop(),
            seconds=seconds,
            columns=np.array(self.ended_at, float).reshape(-1, 2) * self.settings.radius,
            outcomes=np.array(self.outcomes, np.int8),
            provenance=provenance,
        )
