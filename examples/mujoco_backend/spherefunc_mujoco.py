"""MuJoCo as a backend: rigid spheres fall on the surface between a cloud's points, some at a time.

MuJoCo collides meshes as convex hulls, under which no cup fills. A flex that is fixed to the world is met triangle by
triangle; `bullet`'s collision surface, which needs no PyBullet, gives the triangles. Lengths are in radii and times in
sqrt(radius / g), as there, so that every radius is the same problem to the engine.
"""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import asdict, dataclass

import mujoco
import numpy as np
from scipy.spatial import cKDTree

from spherefunc_bullet.bullet.collision.shape import CollisionShape, collision_shape
from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.simulator import Columns, DropResult, DropSettings, Outcome, Stop, provenance_of, require_fitting

LOOK = 8  # time steps between two looks at the spheres
REST_SPEED, REST_TIME, TIME_LIMIT = 0.01, 1.6, 100.0  # as of `bullet`
TOUCH = 0.03  # radii: gap that counts as contact
SUNKEN = 0.03  # radii of overlap of a sphere that is not at rest yet
SKIN = 0.005  # radii: thickness of the surface
APART = 2.2  # radii between the columns of spheres that fall together
ROOM = 30.0  # square radii of the footprint for each sphere in the air
CLEARANCE = 0.1  # radii above the first contact at which a sphere starts
POOL = 64  # settled spheres between two compilations of the model
FAR = 1e3  # radii below the ground: where bodies wait that are not in use

WORLD = """
<mujoco>
  <option timestep="{step}" gravity="0 0 -1" cone="elliptic" impratio="10"/>
  <size memory="256M"/>
  <default><geom type="sphere" size="1" mass="1" condim="6" friction="0.5 0 0.14" priority="1" solref="0.2 1"
                 solimp="0.99 0.99 0.01"/></default>
  <worldbody>
    {moving}
    {waiting}
    {settled}
  </worldbody>
  <deformable>
    <flex name="object" dim="2" radius="{skin}" body="world" vertex="{vertices}" element="{faces}">
      <contact selfcollide="none"/>
    </flex>
  </deformable>
</mujoco>
"""


@dataclass(frozen=True, kw_only=True)
class MujocoSimulator:
    """Drops rigid spheres with MuJoCo. Cost: some milliseconds a sphere, more on large objects."""

    time_step: float = 0.1  # of sqrt(radius / g)
    in_air: int = 16  # spheres that fall together, where there is room for this many

    name = "mujoco"
    isolate = True  # C++ that may crash
    sphere_limit = 1000  # of a run for features, as of `bullet`

    def __post_init__(self):
        if not 0 < self.time_step <= 0.2 or self.in_air < 1:
            raise InputError("backend 'mujoco': expected time_step in 0 to 0.2 and in_air of at least 1")

    @property
    def version(self) -> str:
        return f"3, MuJoCo {mujoco.__version__}"

    def options(self) -> dict[str, float]:
        return asdict(self)

    def drop(self, cloud: Cloud, settings: DropSettings, seed: int = 0) -> DropResult:
        """Drop spheres on a cloud until the miss limit (see `Simulator.drop`)."""
        require_fitting(cloud, settings.radius)
        started = time.perf_counter()
        kind = "voxel" if cloud.mesh is None else "mesh"  # a surface that there is already is exact
        run = DropRun(self, collision_shape(cloud, settings.radius, kind), cloud, settings, seed)
        while run.stop is None:
            run.drop_some()
        counts = Counter(run.outcomes)
        return DropResult(
            centers=np.array(run.centers, float).reshape(-1, 3) * settings.radius,
            on_object=np.array(run.on_object, bool),
            rolled_off=counts[Outcome.ROLLED_OFF],
            rejected=counts[Outcome.REJECTED],
            timed_out=counts[Outcome.TIMED_OUT],
            stop=run.stop,
            seconds=time.perf_counter() - started,
            columns=np.array(run.columns, float).reshape(-1, 2) * settings.radius,
            outcomes=np.array(run.outcomes, np.int8),
            provenance=provenance_of(self, settings, seed),
        )


class DropRun:
    """The state of one run, in radii."""

    def __init__(
        self, simulator: MujocoSimulator, shape: CollisionShape, cloud: Cloud, settings: DropSettings, seed: int
    ):
        self.simulator, self.shape, self.settings = simulator, shape, settings
        self.low, self.high = cloud.bounds / settings.radius
        self.points = cKDTree(cloud.points / settings.radius)
        self.below, self.heights = cKDTree(shape.columns[:, :2]), shape.columns[:, 2]
        self.source = Columns(self.low[:2], self.high[:2], settings, seed)
        self.centers: list[np.ndarray] = []
        self.on_object: list[bool] = []
        self.columns: list[np.ndarray] = []
        self.outcomes: list[Outcome] = []
        self.misses = 0
        room = int(np.prod((self.high - self.low)[:2]) / ROOM)
        self.most = max(1, min(room, simulator.in_air))  # spheres that fall together
        self.waiting: list[np.ndarray] = []  # columns that were too near to others
        self.compile()

    @property
    def stop(self) -> Stop | None:
        """Why the run is over, or None."""
        if self.misses >= self.settings.miss_limit:
            return Stop.MISSES
        if len(self.centers) >= self.settings.max_spheres:
            return Stop.SPHERE_LIMIT
        return Stop.DROP_LIMIT if len(self.outcomes) == self.settings.max_drops else None

    def compile(self):
        """Make the model anew, with all spheres that have settled so far as parts of the world."""
        moving, pool = self.simulator.in_air, POOL
        xml = WORLD.format(
            step=self.simulator.time_step,
            skin=SKIN,
            moving=f"<body pos='0 0 {-FAR}'><freejoint/><geom/></body>" * moving,
            waiting=f"<body mocap='true' pos='0 0 {-2 * FAR}'><geom/></body>" * pool,
            settled="".join(f"<geom pos='{x!r} {y!r} {z!r}'/>" for x, y, z in np.array(self.centers).tolist()),
            vertices=" ".join(map(repr, self.shape.vertices.ravel().tolist())),
            faces=" ".join(map(str, self.shape.faces.ravel().tolist())),
        )
        self.model = mujoco.MjModel.from_xml_string(xml)
        self.data = mujoco.MjData(self.model)
        self.frozen = 0

    def drop_some(self):
        """Let spheres down columns that are apart, until each is at rest or gone, and count them in order."""
        columns = self.next_columns()
        heights = np.array([self.height(column) for column in columns])
        ends = self.fall(np.column_stack([columns, heights + CLEARANCE]))
        for column, outcome, center, to_object in zip(columns, self.judged(*ends), *ends[:2], strict=True):
            self.count(outcome, column)
            if outcome == Outcome.SETTLED:
                self.freeze(center, to_object <= TOUCH)
            if self.stop is not None:
                return
        if self.frozen + len(columns) > POOL:
            self.compile()

    def next_columns(self) -> np.ndarray:
        """Return columns (K, 2) that are apart from each other, first those that had to wait."""
        drawn = self.source.draw(self.most - len(self.waiting))
        chosen, waiting = [], []
        for column in [*self.waiting, *drawn]:
            apart = all(np.hypot(*(column - other)) > APART for other in chosen)
            (chosen if apart else waiting).append(column)
        self.waiting = waiting
        return np.array(chosen)

    def height(self, column: np.ndarray) -> float:
        """Return the height at which a sphere that comes down a column (2,) first touches something; -inf: nothing."""
        near = self.below.query_ball_point(column, 1.0)
        squared = ((self.below.data[near] - column) ** 2).sum(axis=1)
        highest = (self.heights[near] + np.sqrt(1 - np.minimum(squared, 1))).max(initial=-np.inf)
        if not self.centers:
            return highest
        settled = np.array(self.centers)
        squared = ((settled[:, :2] - column) ** 2).sum(axis=1)
        under = squared < 4
        return max(highest, (settled[under, 2] + np.sqrt(4 - squared[under])).max(initial=-np.inf))

    def fall(self, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return where spheres that start at (K, 3) end, their distances from the object (K,), and which rest (K,)."""
        count, step = len(starts), LOOK * self.simulator.time_step
        self.data.qpos.reshape(-1, 7)[:, :3] = [[10 * i, 0, -FAR] for i in range(self.simulator.in_air)]
        falling = np.isfinite(starts[:, 2])
        self.data.qpos.reshape(-1, 7)[:count][falling, :3] = starts[falling]
        self.data.qvel[:] = self.data.qacc_warmstart[:] = 0
        slow = np.zeros(count)
        for _ in range(int(TIME_LIMIT / step)):
            before = self.data.qpos.reshape(-1, 7)[:count, :3].copy()
            mujoco.mj_step(self.model, self.data, LOOK)
            ends = self.data.qpos.reshape(-1, 7)[:count, :3].copy()
            slow = np.where(np.linalg.norm(ends - before, axis=1) < REST_SPEED * step, slow + step, 0)
            self.hold_back()
            gone = ~(ends[:, 2] > 0.9) | ((ends < self.low - 1.02) | (ends > self.high + 1.02))[:, :2].any(axis=1)
            if (gone | (slow > REST_TIME)).all():
                slow[self.distances(count)[1] < -SUNKEN] = 0  # the engine still pushes these out, however slowly
                if (gone | (slow > 0)).all():
                    break
        ends[gone, 2] = -FAR
        return ends, self.distances(count)[0], ~gone & (slow > REST_TIME)

    def hold_back(self):
        """Limit the spheres' speed to 0.4 radii a step, so that what falls far does not fall through a surface."""
        velocities = self.data.qvel.reshape(-1, 6)[:, :3]
        speeds = np.linalg.norm(velocities, axis=1, keepdims=True)
        limit = 0.4 / self.simulator.time_step - LOOK * self.simulator.time_step
        velocities *= np.minimum(1, limit / np.maximum(speeds, limit))

    def distances(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Return how far spheres that fell are from the object, and from anything, in radii; infinite if not near."""
        to_object, to_any = np.full(count, np.inf), np.full(count, np.inf)
        for contact in self.data.contact:
            for body in self.model.geom_bodyid[[geom for geom in contact.geom if geom >= 0]] - 1:
                if 0 <= body < count:
                    to_any[body] = min(to_any[body], contact.dist)
                    if max(contact.flex) >= 0:
                        to_object[body] = min(to_object[body], contact.dist)
        return to_object, to_any

    def judged(self, ends: np.ndarray, to_object: np.ndarray, resting: np.ndarray) -> list[Outcome]:
        """Return what becomes of spheres that fell together; who leans on one that is taken away falls with it."""
        outcomes = [self.resting_place(*end) for end in zip(ends, to_object, resting, strict=True)]
        changed = True
        while changed:
            changed = False
            for i, j in np.argwhere(np.linalg.norm(ends[:, None] - ends, axis=2) < 2 + TOUCH).tolist():
                if outcomes[i] == Outcome.SETTLED != outcomes[j]:
                    outcomes[i], changed = Outcome.REJECTED, True
        return outcomes

    def resting_place(self, center: np.ndarray, to_object: float, resting: bool) -> Outcome:
        """Return what becomes of one sphere by where it ended (3,)."""
        if center[2] < 0.98:
            return Outcome.ROLLED_OFF
        if not resting or self.points.query(center)[0] < 0.96:
            return Outcome.TIMED_OUT
        if to_object > TOUCH and not ((center >= self.low) & (center <= self.high)).all():
            return Outcome.REJECTED
        return Outcome.SETTLED

    def count(self, outcome: Outcome, column: np.ndarray):
        """Take into account what became of the sphere that came down a column (2,)."""
        self.outcomes.append(outcome)
        self.columns.append(column)
        self.misses = 0 if outcome == Outcome.SETTLED else self.misses + 1

    def freeze(self, center: np.ndarray, on_object: bool):
        """Let a sphere stand still for ever."""
        self.data.mocap_pos[self.frozen] = center
        self.frozen += 1
        self.centers.append(center)
        self.on_object.append(bool(on_object))
