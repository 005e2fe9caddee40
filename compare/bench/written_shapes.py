"""``python -m spherefunc_bullet.compare.bench.written_shapes DATA``: is what ``shapes --best`` writes worth writing?

Written URDFs and MJCFs are loaded in a plain PyBullet (`loadURDF`) and a plain MuJoCo, by nothing of this package, and
spheres are dropped on them one by one. A sphere that stays on the visual mesh, loaded as a concave one, is kept if it
stays at the same height, to 1.25 radii; it is in its place if some sphere on the mesh rests so near to it. What
contacts cost is a step with spheres at rest less one with them in the air.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections import defaultdict
from dataclasses import asdict, dataclass
from pathlib import Path

import mujoco
import numpy as np
import pybullet as p
from scipy.spatial import cKDTree

from spherefunc_bullet.console import print_json, print_table, say
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.shapes.compared import compare_shapes

SIDE, STEP, SECONDS, NEAR = 14, 1 / 480, 1.5, 1.25  # spheres along a side, s, s of a fall, radii
AIR = 1_000.0  # radii: how high spheres are that touch nothing
CONTACTS, TIMED = 50, 30  # spheres and steps of a timing
MANY_FACES, ENOUGH = 5_000, 0.95


@dataclass(frozen=True, kw_only=True)
class Checked:
    """One written object."""

    file: str
    label: str
    group: str
    shape: str
    keeps: bool  # as the package says
    pieces: int
    faces: int  # of the visual mesh
    spread: float  # what the mesh keeps of itself, dropped beside
    bullet: float  # share of the mesh's spheres that are kept, at their height
    mujoco: float
    bullet_places: float  # share of them that are in a place of the mesh's
    mujoco_places: float
    cheaper: float  # times, what contacts cost
    seconds: float  # of the processor, to find the shape


class Plain:
    """A PyBullet of its own, with spheres that meet the object and the floor, not each other."""

    def __init__(self, urdf: Path | None, visual: Path, radius: float):
        self.at = {"physicsClientId": p.connect(p.DIRECT)}
        p.setPhysicsEngineParameter(fixedTimeStep=STEP, **self.at)
        p.setGravity(0, 0, -9.81, **self.at)
        floor = p.createCollisionShape(p.GEOM_PLANE, **self.at)
        p.createMultiBody(0, floor, **self.at)
        if urdf:
            self.object = p.loadURDF(str(urdf), useFixedBase=True, **self.at)
        else:
            flags = p.GEOM_FORCE_CONCAVE_TRIMESH
            mesh = p.createCollisionShape(p.GEOM_MESH, fileName=str(visual), flags=flags, **self.at)
            self.object = p.createMultiBody(0, mesh, **self.at)
        self.sphere, self.radius = p.createCollisionShape(p.GEOM_SPHERE, radius=radius, **self.at), radius

    def add(self, starts: np.ndarray) -> list[int]:
        """Add spheres at places (S, 3), metres, that meet the object but not each other; return their numbers."""
        bodies = [p.createMultiBody(1e-2, self.sphere, basePosition=start, **self.at) for start in starts.tolist()]
        for body in bodies:
            p.setCollisionFilterGroupMask(body, -1, 4, 1 | 2, **self.at)
            p.changeDynamics(body, -1, rollingFriction=0.05 * self.radius, linearDamping=0.2, **self.at)
            p.changeDynamics(body, -1, activationState=p.ACTIVATION_STATE_DISABLE_SLEEPING, **self.at)
        return bodies

    def drop(self, starts: np.ndarray) -> np.ndarray:
        """Return where spheres end (S, 3), metres, that are let go at places (S, 3)."""
        bodies = self.add(starts)
        for _ in range(round(SECONDS / STEP)):
            p.stepSimulation(**self.at)
        ends = np.array([p.getBasePositionAndOrientation(body, **self.at)[0] for body in bodies])
        for body in bodies:
            p.removeBody(body, **self.at)
        return ends

    def steps(self, centers: np.ndarray):
        """Yield the seconds of steps with spheres held in contact."""
        bodies = self.add(centers[np.arange(CONTACTS) % len(centers)])
        while True:
            for body, center in zip(bodies, centers[np.arange(CONTACTS) % len(centers)], strict=True):
                p.resetBasePositionAndOrientation(body, center, [0, 0, 0, 1], **self.at)
            started = time.thread_time()
            p.stepSimulation(**self.at)
            yield time.thread_time() - started

    def close(self):
        p.disconnect(**self.at)


def in_mujoco(path: Path, starts: np.ndarray, radius: float) -> np.ndarray:
    """Return where spheres come to rest on a written MJCF, which stands still."""
    spec = mujoco.MjSpec.from_file(str(path))
    for joint in list(spec.joints):
        spec.delete(joint)
    spec.option.timestep = STEP
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 0.1])
    for start in starts:
        body = spec.worldbody.add_body(pos=start)
        body.add_freejoint()
        friction = [0.5, 0.005, 0.05 * radius]
        body.add_geom(size=[radius] * 3, mass=1e-2, contype=0, conaffinity=1, condim=6, friction=friction)
    model = spec.compile()
    data = mujoco.MjData(model)
    for _ in range(round(SECONDS / STEP)):
        mujoco.mj_step(model, data)
    return data.qpos.reshape(-1, 7)[:, :3].copy()


def starts_over(vertices: np.ndarray, radius: float, engine: Plain, shift: float) -> np.ndarray:
    """Return places just above what is highest, on a grid over the footprint."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    steps = (np.arange(SIDE) + shift) / SIDE
    x, y = (low[axis] + steps * (high - low)[axis] for axis in (0, 1))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    top = high[2] + 2 * radius
    rays = [[*place, top] for place in grid.tolist()], [[*place, 0.0] for place in grid.tolist()]
    hit = [result[3][2] if result[0] == engine.object else -1.0 for result in p.rayTestBatch(*rays, **engine.at)]
    above = np.array(hit) > 0
    return np.column_stack([grid[above], np.array(hit)[above] + 1.3 * radius])


def on_object(ends: np.ndarray, radius: float) -> np.ndarray:
    """Return the ends of spheres that did not reach the floor."""
    return ends[ends[:, 2] > 1.3 * radius]


def in_places(reference: np.ndarray, ends: np.ndarray, count: int, radius: float) -> float:
    """Return the share of some count of spheres that lie in the place of one of the reference."""
    if not len(ends) or not len(reference) or not count:
        return float(not count)
    return min(1.0, int((cKDTree(reference).query(ends)[0] <= NEAR * radius).sum()) / count)


def stay(mesh: np.ndarray, ends: np.ndarray, radius: float) -> float:
    """Return the share of the spheres on the mesh (S, 3) that end at the same height, of the same starts."""
    there = mesh[:, 2] > 1.3 * radius
    return float((np.abs(ends - mesh)[there, 2] <= NEAR * radius).mean()) if there.any() else 1.0


def checked(path: Path, label: str, group: str, folder: Path) -> Checked:
    """Return what becomes of one object."""
    started = time.process_time()
    shapes = compare_shapes(path, shapes=False)
    best, seconds = shapes.best, time.process_time() - started
    urdf, mjcf = best.write(folder / f"{path.stem}.urdf"), best.write(folder / f"{path.stem}.xml")
    vertices, radius = shapes.subject.mesh.vertices, shapes.subject.radius
    visual = folder / f"{path.stem}_meshes" / "visual.obj"
    mesh, other = Plain(None, visual, radius), Plain(urdf, visual, radius)
    first, second = (starts_over(vertices, radius, mesh, shift) for shift in (0.5, 0.25))
    ends = [mesh.drop(starts) for starts in (first, second)]
    one, two = (on_object(end, radius) for end in ends)
    reference, share = np.vstack([one, two]), in_places(one, two, len(two), radius)
    loaded = other.drop(first), in_mujoco(mjcf, first, radius)
    rest = on_object(loaded[0], radius)
    empty = Plain(None, visual, radius)
    held = [mesh.steps(one), other.steps(rest if len(rest) else one), empty.steps(one + [0, 0, AIR * radius])]
    times = np.array([next(zip(*held, strict=True)) for _ in range(TIMED)])
    mesh.close(), other.close(), empty.close()
    seen, written, air = np.median(times, axis=0)
    return Checked(
        file=path.name, label=label, group=group, shape=best.name, keeps=best.row.keeps, pieces=best.solid.count,
        faces=len(shapes.subject.mesh.faces), spread=share,
        bullet=stay(ends[0], loaded[0], radius), mujoco=stay(ends[0], loaded[1], radius),
        bullet_places=in_places(reference, rest, len(one), radius),
        mujoco_places=in_places(reference, on_object(loaded[1], radius), len(one), radius),
        cheaper=float((seen - air) / (written - air)), seconds=seconds,
    )  # fmt: skip


def main():
    """Check, and print a table by source."""
    parser = argparse.ArgumentParser(description="Do written shapes keep what is seen, in other programs?")
    parser.add_argument("data")
    parser.add_argument("--each", type=int, default=3, help="objects of each label and source")
    parser.add_argument("--groups", default="", help="only these sources, comma-separated")
    arguments = parser.parse_args()
    chosen, rows = defaultdict(list), []
    for item in open_dataset(arguments.data).objects:
        for label in ("cup", "sittable", "table"):
            if label in item.functions and (not arguments.groups or item.group in arguments.groups.split(",")):
                chosen[item.group, label].append(item)
    with tempfile.TemporaryDirectory() as folder:
        for number in range(arguments.each):  # every source first, in case it is stopped
            for (group, label), items in chosen.items():
                for item in items[:: max(1, len(items) // arguments.each)][number : number + 1]:
                    rows.append(checked(Path(item.path), label, group, Path(folder)))
                    say(str(rows[-1]))
    report(rows)
    print_json([asdict(row) for row in rows])


def report(rows: list[Checked]):
    """Print one line for each source, and one for all."""
    table = []
    for group in [*sorted({row.group for row in rows}), "all"]:
        own = [row for row in rows if group in (row.group, "all")]
        names = ("bullet", "mujoco", "bullet_places", "mujoco_places")
        fine = [np.mean([getattr(row, name) >= ENOUGH for row in own]) for name in names]
        large = [row.cheaper for row in own if row.faces > MANY_FACES]
        said, pieces = np.mean([row.keeps for row in own]), np.median([row.pieces for row in own])
        cheaper = f"{np.median(large):.2g} (least {min(large):.2g})" if large else ""
        table.append([group, len(own), f"{said:.2f}", *(f"{share:.2f}" for share in fine), f"{pieces:g}", cheaper])
    head = ["source", "objects", "said to keep", "PyBullet", "MuJoCo", "in place", "in MuJoCo", "pieces"]
    head += ["times cheaper, > 5,000 faces"]
    print_table("Share of objects that keep 0.95 of the spheres", head, table)


if __name__ == "__main__":
    main()
