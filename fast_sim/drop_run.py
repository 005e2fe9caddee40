"""One run of the fast backend: its state, its drops, and when it ends."""

from __future__ import annotations

import math
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from spherefunc_bullet.clouds.cloud import PITCH, Cloud
from spherefunc_bullet.simulator import Columns, DropResult, DropSettings, Stop

from .contact import MAX_CONTACTS
from .dropping import drop_spheres
from .grid import BLOCK, PointGrid, enlarged, point_grid, point_spacing, sphere_grid
from .nearby import MAX_SPHERES, POINT_REACH, Neighbourhood
from .rolling import SETTLED, RollShape
from .strips import LARGE, Strips

CHUNK = 8192  # columns drawn at a time
FEW = 256  # fewer spheres are not dropped in strips
SPARSE = 0.5  # radii, approximate distance between points for runs with few drops
STALLED = 4  # steps without descent after which a sphere counts as blocked


def empty_neighborhood(point_count: int) -> Neighbourhood:
    """Return empty arrays for the neighbourhood of any place in a cloud with a number of points."""
    rooms = np.empty((3, point_count + 1)), np.empty((3, MAX_SPHERES)), np.zeros(2, np.int64)
    scratch = np.empty((MAX_CONTACTS + 1, 3)), np.array([-np.inf, np.inf] * 2), np.empty(16, np.uint64)
    return Neighbourhood(*rooms, np.full(3, np.inf), *scratch)


def sorted_points(cloud: Cloud, settings: DropSettings) -> tuple[PointGrid, float]:
    """Return a cloud's points in a grid, and their spacing, metres: once for all runs of few spheres of one radius."""
    low, high = cloud.bounds

    def sort(points: np.ndarray) -> tuple[PointGrid, float]:
        grid = point_grid(points, low, high, settings.radius)
        return grid, point_spacing(grid)

    if settings.max_drops is None:
        return sort(cloud.points)
    # Few spheres do not justify the cost of finer points.
    sparse = SPARSE * settings.radius
    return cloud.cached(("points for few spheres by fast", settings.radius), lambda: sort(cloud.thinned(sparse)))


class RollOptions(Protocol):
    """The options of `FastSimulator` that a run needs."""

    cores: int
    as_drawn: bool
    flat_angle_deg: float


class DropRun:
    """The state of one run, which can be continued: both grids, the counts, and scratch arrays of the kernel."""

    def __init__(self, cloud: Cloud, settings: DropSettings, how: RollOptions, seed: int):
        self.settings, self.how, self.seed = settings, how, seed
        self.seconds = 0.0
        self.low, self.high = cloud.bounds
        reach = POINT_REACH * settings.radius if settings.max_drops is None else None
        self.points, spacing = sorted_points(cloud, settings)
        if cloud.mesh is not None:  # the nearest sample may lie on the other side of a thin wall
            spacing = max(spacing, PITCH)
        self.shape = roll_shape(settings.radius, spacing, how.flat_angle_deg)
        self.inside = (self.low, self.high)  # where spheres may rest on spheres alone
        self.spheres = sphere_grid(self.points, self.low, self.high, settings.radius, reach, CHUNK)
        self.nearby = empty_neighborhood(len(self.points.xyz))
        self.strips = None
        if settings.max_drops is None and not how.as_drawn and self.spheres.nx * self.spheres.ny >= LARGE:
            scratch = [empty_neighborhood(len(self.points.xyz)) for _ in range(how.cores)]
            self.strips = Strips(self.spheres, settings.radius, scratch)
        self.state = np.zeros(5, np.int64)
        self.on_object = np.zeros(CHUNK, np.bool_)
        self.source = Columns(self.low[:2], self.high[:2], settings, seed)
        self.waiting = np.empty((0, 2))  # columns that are drawn but not used yet
        self.columns: list[np.ndarray] = []
        self.outcomes: list[np.ndarray] = []

    @property
    def settled(self) -> int:
        """Number of spheres that have settled."""
        return int(self.state[0])

    @property
    def drops(self) -> int:
        """Number of spheres that have been dropped."""
        return int(self.state[:4].sum())

    def is_prefix_of(self, settings: DropSettings, how: RollOptions, seed: int) -> bool:
        """Return whether another run begins with the drops of this one."""
        s = self.settings
        same = (s.radius, s.even_columns, self.how, self.seed) == (settings.radius, settings.even_columns, how, seed)
        longer = settings.max_drops is not None and settings.max_drops > self.drops
        return same and longer and settings.miss_limit >= s.miss_limit and settings.max_spheres >= s.max_spheres

    def prepare_strips(self) -> float:
        """Compile or load the code for strips, if there are any; return the seconds that it took."""
        started = perf_counter()
        if self.strips is not None:
            self.drop_in_strips(np.empty((0, 2)))
        return perf_counter() - started

    def continue_run(self, settings: DropSettings):
        """Drop more spheres until a limit is reached."""
        self.settings, ended = settings, False
        while not ended:
            together = 0 if self.strips is None else self.strips.together(self.drops)
            together = min(together, settings.max_spheres - self.settled)
            if together >= FEW:
                ended = self.drop_in_strips(self.draw_columns(together))
            else:
                left = CHUNK if self.strips is None else CHUNK // 4
                left = left if settings.max_drops is None else min(left, settings.max_drops - self.drops)
                ended = self.drop_in_order(self.draw_columns(left))

    def draw_columns(self, count: int) -> np.ndarray:
        """Return a number of columns (M, 2): first those drawn before and not used, then new ones."""
        if len(self.waiting) < count:
            drawn = self.source.draw(count - len(self.waiting))
            self.waiting = np.concatenate([self.waiting, drawn])
        taken, self.waiting = self.waiting[:count], self.waiting[count:]
        self.reserve(count)
        return taken

    def reserve(self, count: int):
        """Make room for more settled spheres, and for the spare blocks of strips."""
        spared = 0 if self.strips is None else BLOCK * max(len(self.strips.spares), count)
        capacity, needed = len(self.on_object), self.settled + count + spared
        if needed > capacity:
            self.spheres = enlarged(self.spheres, max(2 * capacity, needed))
            self.on_object = np.concatenate([self.on_object, np.zeros(len(self.spheres.centers) - capacity, np.bool_)])

    def drop_in_order(self, columns: np.ndarray) -> bool:
        """Drop a sphere down each of the columns (M, 2) in order; return True as soon as a limit is reached."""
        s, before = self.settings, self.drops
        outcomes = np.empty(len(columns), np.int8)
        limits = (s.miss_limit, s.max_spheres, self.state, self.on_object, outcomes)
        body = (self.points, self.spheres, self.nearby)
        ended = drop_spheres(*body, columns, s.radius, self.shape, *self.inside, *limits)
        done = self.drops - before
        self.columns.append(columns[:done])
        self.outcomes.append(outcomes[:done])
        self.waiting = np.concatenate([columns[done:], self.waiting])
        return ended or self.drops == s.max_drops

    def drop_in_strips(self, columns: np.ndarray) -> bool:
        """Drop a sphere down each of the columns (M, 2), strip by strip; return True if a limit is reached.

        There are too few columns to exceed the sphere limit. Consecutive misses are counted in the order in which the
        columns were drawn.
        """
        radius, limit, before = self.settings.radius, self.settings.miss_limit, self.settled
        ends = self.strips.drop(self.points, self.spheres, columns, radius, self.shape, *self.inside)
        self.columns.append(columns)
        self.outcomes.append(ends.outcomes)
        self.state[:4] += np.bincount(ends.outcomes, minlength=4)
        settled = np.flatnonzero(ends.outcomes == SETTLED)
        self.spheres.centers[before : self.settled] = ends.centers[settled]
        self.on_object[before : self.settled] = ends.touching[settled]
        in_a_row = np.diff(settled, prepend=-1 - self.state[4], append=len(columns)) - 1
        self.state[4] = limit if in_a_row.max() >= limit else in_a_row[-1]
        return self.state[4] >= limit or self.settled >= self.settings.max_spheres

    def stop(self) -> Stop:
        """Return why the run ended."""
        if self.state[4] >= self.settings.miss_limit:
            return Stop.MISSES
        return Stop.SPHERE_LIMIT if self.state[0] >= self.settings.max_spheres else Stop.DROP_LIMIT

    def result(self, provenance: dict[str, Any]) -> DropResult:
        """Return the result of the run so far."""
        settled, rolled_off, rejected, timed_out, _ = self.state.tolist()
        return DropResult(
            centers=self.spheres.centers[:settled].copy(),
            on_object=self.on_object[:settled].copy(),
            rolled_off=rolled_off,
            rejected=rejected,
            timed_out=timed_out,
            stop=self.stop(),
            seconds=self.seconds,
            columns=np.concatenate(self.columns),
            outcomes=np.concatenate(self.outcomes),
            provenance=provenance,
        )


def roll_shape(radius: float, spacing: float, flat_angle_deg: float):
    """Return the lengths used for rolling, metres, derived from the radius and the spacing of the cloud."""
    gap = min(0.75 * spacing, 0.6 * radius)  # slightly more than half the diagonal of a square lattice
    sink = radius - math.sqrt(radius * radius - gap * gap)
    return RollShape(
        gap=1.1 * gap,
        patch=max(1.4 * spacing, 0.5 * radius),
        bump=max(1.2 * sink, 0.015 * radius),
        flat=math.sin(math.radians(flat_angle_deg)),
        stalled=STALLED,
    )
