"""The fast backend as a simulator: the paper's low-fidelity roller (§III-A)."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, fields

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.simulator import DropResult, DropSettings, Stop, provenance_of, require_fitting
from spherefunc_bullet.simulator.mechanics import PoseResult, PoseSettings, StandResult, StandSettings

VERSION = "3"  # of the algorithm: another number, other centres
CHUNK = 8192  # columns drawn at a time
SPARSE = 0.5  # radii between points, about, where drops are few
SQUARE = 0.005  # metres: as far as samples of a mesh lie apart
SHORT = 100  # drops: a run of so few is kept with the cloud, since more are asked for where these do not tell
Columns = Callable[[np.random.Generator, int], np.ndarray]  # draws so many columns (M, 2) or more, metres


@dataclass(frozen=True, kw_only=True)
class FastSimulator:
    """Rolls spheres over a point cloud, one at a time, without forces or time.

    A cloud needs no mesh, no normals and no order. Cost: a few microseconds a sphere.
    """

    cores: int = 1  # that one object's drops are shared among; the same bits on any number of them
    flat_angle_deg: float = 5.0  # a slope that still counts as flat: more than sampling noise, less than a ramp
    # What the paper leaves open (§III-A); `spherefunc evaluate --alternatives` measures the other readings.
    columns: str = "box"  # over which spheres begin: the object's, or the "points": squares of 5 mm that hold some
    inside: str = "centre"  # of a sphere on spheres alone that is to lie within the object's box, or the whole "sphere"
    stalled_steps: int = 4  # steps that get no lower by which a sphere counts as blocked; 0: no such rule

    name = "fast"
    version = VERSION

    def __post_init__(self):
        require_one_of("columns", self.columns, ("box", "points"))
        require_one_of("inside", self.inside, ("centre", "sphere"))
        if not 1 <= self.cores <= (os.cpu_count() or 1):
            raise InputError(f"backend 'fast': cores: expected 1 to {os.cpu_count()}, got {self.cores}")
        if self.stalled_steps < 0:
            raise InputError(f"backend 'fast': stalled_steps: expected 0 or more, got {self.stalled_steps}")

    def options(self) -> dict:
        """Return what is not as by default, by name (see `Simulator.options`)."""
        return {"flat_angle_deg": self.flat_angle_deg} | {
            field.name: getattr(self, field.name)
            for field in fields(self)
            if field.name != "cores" and getattr(self, field.name) != field.default
        }

    def drop(self, cloud: Cloud, settings: DropSettings, seed: int = 0) -> DropResult:
        """Drop spheres on a cloud until the miss limit (see `Simulator.drop`).

        Raises
        ------
        InputError
            If the sphere is larger than the object.
        """
        from spherefunc_bullet.processes.compilation import prepare

        from .grid import find_nearest, mark_near_points
        from .sorting import sort_by_cell

        kernel, threads = self.kernel()
        prepare(kernel, sort_by_cell, find_nearest, mark_near_points)
        require_fitting(cloud, settings.radius)
        started = time.perf_counter()
        kept = cloud.once("the short run of each radius by fast", dict[float, DropRun])
        run = kept.pop(settings.radius, None)  # taken out, so that no other thread goes on with it
        if run is None or not run.begins(settings, self, seed):
            run = DropRun(cloud, settings, self, seed)
        with threads:
            run.go_on(kernel, settings)
        run.seconds += time.perf_counter() - started
        if settings.max_drops is not None and settings.max_drops <= SHORT:
            kept[settings.radius] = run
        return run.result()

    def kernel(self) -> tuple[Callable[..., bool], AbstractContextManager[None]]:
        """Return what drops spheres, and the threads that it needs."""
        if self.cores == 1:
            from .dropping import drop_spheres

            return drop_spheres, nullcontext()
        from .cores import Threads, drop_spheres_at_once

        return drop_spheres_at_once, Threads(self.cores)

    def poses(self, cloud: Cloud, settings: PoseSettings, seed: int = 0) -> PoseResult:
        """Return by statics how a cloud's object can lie (see `TellsPoses.poses`); nothing is dropped."""
        from spherefunc_bullet.simulator.statics.body import body_of
        from spherefunc_bullet.simulator.statics.facets import facets_of
        from spherefunc_bullet.simulator.statics.poses import ways_down

        started = time.perf_counter()
        body = body_of(cloud, settings.matter)
        return PoseResult(
            poses=ways_down(facets_of(body), settings),
            drops=0,
            timed_out=0,
            notes=body.notes,
            seconds=time.perf_counter() - started,
            provenance=provenance_of(self, settings, seed),
        )

    def stands(self, cloud: Cloud, settings: StandSettings, places: np.ndarray, seed: int = 0) -> StandResult:
        """Return by statics whether a cloud's object stands (see `TellsStance.stands`)."""
        from spherefunc_bullet.simulator.statics.body import body_of
        from spherefunc_bullet.simulator.statics.standing import stand, stood

        body, provenance = body_of(cloud, settings.matter), provenance_of(self, settings, seed)
        return stood(body, places, settings, lambda bodies: [stand(one, settings) for one in bodies], provenance)


class DropRun:
    """The state of one run, which can go on: both grids, the tallies, and what the kernel needs beside them."""

    def __init__(self, cloud: Cloud, settings: DropSettings, how: FastSimulator, seed: int):
        from .contact import MAX_CONTACTS
        from .grid import point_grid, point_spacing, sphere_grid
        from .nearby import POINT_REACH, nowhere

        self.settings, self.how, self.seed = settings, how, seed
        self.seconds = 0.0
        self.low, self.high = cloud.bounds
        points, reach = cloud.points, POINT_REACH * settings.radius
        if settings.max_drops is not None:  # a few spheres do not pay for more than they can feel
            points, reach = cloud.thinned(SPARSE * settings.radius), None
        self.points = point_grid(points, self.low, self.high, settings.radius)
        self.shape = roll_shape(settings.radius, point_spacing(self.points), how)
        margin = settings.radius if how.inside == "sphere" else 0.0
        self.inside = (self.low + margin, self.high - margin)  # of which spheres on spheres alone stay
        self.spheres = sphere_grid(self.points, self.low, self.high, settings.radius, reach, CHUNK)
        self.nearby = [nowhere(len(points), MAX_CONTACTS)]
        if how.cores > 1:
            from .cores import on_cores

            self.nearby.append(on_cores(how.cores, self.nearby[0]))
        self.state = np.zeros(5, np.int64)
        self.on_object = np.zeros(CHUNK, np.bool_)
        self.generator = np.random.default_rng(seed)
        self.draw = over_points(cloud.points) if how.columns == "points" else over_box(self.low, self.high)
        self.waiting = np.empty((0, 2))  # columns that are drawn, and down which nothing has been dropped
        self.columns: list[np.ndarray] = []
        self.outcomes: list[np.ndarray] = []

    @property
    def drops(self) -> int:
        """How many spheres have been dropped."""
        return int(self.state[:4].sum())

    def begins(self, settings: DropSettings, how: FastSimulator, seed: int) -> bool:
        """Tell whether a run is to make the same drops as this one, and more."""
        s = self.settings
        same = (s.radius, self.how, self.seed) == (settings.radius, how, seed)
        longer = settings.max_drops is not None and settings.max_drops > self.drops
        return same and longer and settings.miss_limit >= s.miss_limit and settings.max_spheres >= s.max_spheres

    def go_on(self, kernel: Callable[..., bool], settings: DropSettings):
        """Drop spheres until one of the limits is reached; the drops so far are the first ones."""
        self.settings, ended = settings, False
        while not ended:
            left = CHUNK if settings.max_drops is None else min(CHUNK, settings.max_drops - self.drops)
            if len(self.waiting) < left:
                self.waiting = np.concatenate([self.waiting, self.draw(self.generator, left - len(self.waiting))])
            self.reserve(left)
            ended = self.drop(kernel, self.waiting[:left])

    def reserve(self, count: int):
        """Make room for so many more settled spheres."""
        from .grid import grown

        capacity = len(self.on_object)
        if self.state[0] + count > capacity:
            self.spheres = grown(self.spheres, 2 * capacity)
            self.on_object = np.concatenate([self.on_object, np.zeros(capacity, np.bool_)])

    def drop(self, kernel: Callable[..., bool], columns: np.ndarray) -> bool:
        """Drop a sphere down each of the columns (M, 2), until one of the limits is reached: then return True."""
        s, before = self.settings, self.drops
        outcomes = np.empty(len(columns), np.int8)
        limits = (s.miss_limit, s.max_spheres, self.state, self.on_object, outcomes)
        body = (self.points, self.spheres, *self.nearby)
        ended = kernel(*body, columns, s.radius, self.shape, *self.inside, *limits)
        done = self.drops - before
        self.columns.append(columns[:done])
        self.outcomes.append(outcomes[:done])
        self.waiting = self.waiting[done:]
        return ended or self.drops == s.max_drops

    def stop(self) -> Stop:
        """Return why the run ended."""
        if self.state[4] >= self.settings.miss_limit:
            return Stop.MISSES
        return Stop.SPHERE_LIMIT if self.state[0] >= self.settings.max_spheres else Stop.DROP_LIMIT

    def result(self) -> DropResult:
        """Return what has come of the run so far."""
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
            provenance=provenance_of(self.how, self.settings, self.seed),
        )


def over_box(low: np.ndarray, high: np.ndarray) -> Columns:
    """Return what draws columns uniformly over a bounding box."""
    return lambda generator, count: generator.uniform(low[:2], high[:2], size=(count, 2))


def over_points(points: np.ndarray) -> Columns:
    """Return what draws columns uniformly over the squares of `SQUARE` that hold some of the points (N, 3).

    Always `CHUNK` of them, since squares are drawn before places in them.
    """
    squares = np.unique(np.floor(points[:, :2] / SQUARE), axis=0)
    return lambda generator, _: SQUARE * (generator.choice(squares, CHUNK) + generator.random((CHUNK, 2)))


def require_one_of(name: str, value: str, expected: Sequence[str]):
    """Raise InputError unless an option is one of those there are."""
    if value not in expected:
        raise InputError(f"backend 'fast': {name}: expected one of {', '.join(expected)}, got {value!r}")


def roll_shape(radius: float, spacing: float, how: FastSimulator):
    """Derive the roller's lengths from the radius and the cloud's spacing, in metres."""
    from .rolling import MAX_STEPS, RollShape

    gap = min(0.75 * spacing, 0.6 * radius)  # half the diagonal of a square lattice, and a little
    sink = radius - math.sqrt(radius * radius - gap * gap)
    return RollShape(
        gap=1.1 * gap,
        patch=max(1.4 * spacing, 0.5 * radius),
        bump=max(1.2 * sink, 0.015 * radius),
        flat=math.sin(math.radians(how.flat_angle_deg)),
        stalled=how.stalled_steps or MAX_STEPS,
    )
