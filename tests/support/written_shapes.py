"""``python tests/support/written_shapes.py DATA``: is what ``shapes --best`` writes worth writing?

Written URDFs and MJCFs are loaded in a plain PyBullet (`loadURDF`) and a plain MuJoCo, by nothing of this package, and
spheres that do not meet each other are dropped on them, as on the visual mesh: a concave one in PyBullet, a rigid flex
in MuJoCo. Of the spheres that stay on the mesh those are kept that stay on the shape at the same height, to 1.25 radii.
How exactly that can be asked is what the mesh keeps of itself where the same spheres are let go a tenth of a radius
beside. What contacts cost is a step with spheres at rest less one with them in the air.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections import defaultdict
from dataclasses import asdict, dataclass
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

import mujoco
import numpy as np
import pybullet as p

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.console import print_json, print_table, say
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.shapes.compared import compare_shapes
from spherefunc_bullet.shapes.files import FIRM, write_shape
from spherefunc_bullet.shapes.solid import Solid, of_pieces
from spherefunc_bullet.simulator.mechanics import Material
from spherefunc_bullet.simulator.statics.body import body_of

SIDE, STEP, SECONDS, NEAR = 14, 1 / 480, 1.5, 1.25  # spheres along a side, s, s of a fall, radii
AIR = 1_000.0  # radii: how high spheres are that touch nothing
BESIDE, THIN = 0.07, 0.01  # radii: how far along x and y spheres are let go beside, half the thickness of a flex
CONTACTS, TIMED = 50, 30  # spheres and steps of a timing
SAME_WAY, MARGIN = np.cos(np.deg2rad(20)), 0.001  # of directions; metres, that PyBullet adds to hulls
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
    bullet: float  # share of the mesh's spheres that are kept
    mujoco: float
    bullet_itself: float  # what the mesh keeps of itself
    mujoco_itself: float
    cheaper: float  # times, what contacts cost
    at_most: float  # times, were each sphere to lie on one box for each direction in which it is held
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

    def supports(self, centers: np.ndarray) -> list[list[np.ndarray]]:
        """Return for each sphere at rest the directions (3,) in which it is held, those that differ by 20 degrees."""
        bodies, found = self.add(centers), []
        p.stepSimulation(**self.at)
        for body in bodies:
            found.append([])
            for contact in p.getContactPoints(bodyA=body, bodyB=self.object, **self.at):
                if all(np.dot(contact[7], other) < SAME_WAY for other in found[-1]):
                    found[-1].append(np.array(contact[7]))
            p.removeBody(body, **self.at)
        return found

    def steps(self, centers: np.ndarray):
        """Yield the seconds of steps with spheres held in contact."""
        bodies = self.add(centers)
        while True:
            for body, center in zip(bodies, centers, strict=True):
                p.resetBasePositionAndOrientation(body, center, [0, 0, 0, 1], **self.at)
            started = time.thread_time()
            p.stepSimulation(**self.at)
            yield time.thread_time() - started

    def close(self):
        p.disconnect(**self.at)


def ideal(supports: list[list[np.ndarray]], radius: float) -> tuple[Solid, np.ndarray]:
    """Return a box for each direction in which a sphere is held, and centres (S, 3) on them: no pieces cost less."""
    along = np.arange(len(supports))
    centers, boxes = np.column_stack([along, 0 * along, 0 * along]) * 20 * radius + [0, 0, 100 * radius], []
    for center, ways in zip(centers, supports, strict=True):
        for way in ways:
            sides = np.linalg.svd(way[None])[2][1:] * 1.5 * radius
            touched = center - way * (radius + MARGIN)
            ends = [touched + a * sides[0] + b * sides[1] for a in (-1, 1) for b in (-1, 1)]
            boxes.append(np.vstack([ends, ends - radius * way]))
    return of_pieces("ideal", boxes), centers


def in_mujoco(path: Path | None, seen: Solid, starts: np.ndarray, radius: float) -> np.ndarray:
    """Return where spheres come to rest on a written MJCF, which stands still, or on the visual mesh itself.

    MuJoCo takes the hull of a mesh, but a rigid flex meets spheres with each of its triangles.
    """
    spec = mujoco.MjSpec.from_file(str(path)) if path else mujoco.MjSpec.from_string(concave(seen, radius))
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


def concave(seen: Solid, radius: float) -> str:
    """Return an MJCF of a mesh as it is, with contacts as firm as those of the written ones."""
    root = Element("mujoco")
    shape = {"type": "direct", "dim": "2", "rigid": "true", "radius": str(THIN * radius)}
    arrays = {"point": " ".join(map(str, seen.vertices.ravel())), "element": " ".join(map(str, seen.faces.ravel()))}
    flex = SubElement(SubElement(root, "worldbody"), "flexcomp", name="seen", **shape, **arrays)
    SubElement(flex, "contact", selfcollide="none", **FIRM)
    return tostring(root, encoding="unicode")


def starts_over(vertices: np.ndarray, radius: float, engine: Plain) -> np.ndarray:
    """Return places just above what is highest, on a grid over the footprint."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    x, y = (low[axis] + (np.arange(SIDE) + 0.5) / SIDE * (high - low)[axis] for axis in (0, 1))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    top = high[2] + 2 * radius
    rays = [[*place, top] for place in grid.tolist()], [[*place, 0.0] for place in grid.tolist()]
    hit = [result[3][2] if result[0] == engine.object else -1.0 for result in p.rayTestBatch(*rays, **engine.at)]
    above = np.array(hit) > 0
    return np.column_stack([grid[above], np.array(hit)[above] + 1.3 * radius])


def spread(centers: np.ndarray) -> np.ndarray:
    """Return as many of some centres (S, 3) as are timed, from all over; some of them twice where there are fewer."""
    return centers[np.linspace(0, len(centers) - 1, CONTACTS).astype(int)] if len(centers) else centers


def stay(mesh: np.ndarray, ends: np.ndarray, radius: float) -> float:
    """Return the share of the spheres on the mesh (S, 3) that end at the same height, of the same starts."""
    there = mesh[:, 2] > 1.3 * radius
    return float((np.abs(ends - mesh)[there, 2] <= NEAR * radius).mean()) if there.any() else 1.0


def checked(path: Path, label: str, group: str, folder: Path) -> Checked:
    """Return what becomes of one object."""
    started = time.process_time()
    shapes = compare_shapes(load_cloud(path), shapes=False)  # a cloud is its own frame, in which spheres are set below
    best, seconds = shapes.best, time.process_time() - started
    urdf, mjcf = best.write(folder / f"{path.stem}.urdf"), best.write(folder / f"{path.stem}.xml")
    seen, radius = shapes.subject.mesh, shapes.subject.radius
    visual = folder / f"{path.stem}_meshes" / "visual.obj"
    mesh, other, empty = engines = [Plain(file, visual, radius) for file in (None, urdf, None)]
    starts = starts_over(seen.vertices, radius, mesh)
    beside = starts + BESIDE * radius * np.array([1, 1, 0])
    bullet = mesh.drop(starts), other.drop(starts), mesh.drop(beside)
    flex = [in_mujoco(*asked, radius) for asked in ((None, seen, starts), (mjcf, seen, starts), (None, seen, beside))]
    on_mesh, rest = (spread(ends[ends[:, 2] > 1.3 * radius]) for ends in bullet[:2])
    rest = rest if len(rest) else on_mesh
    boxes, centers = ideal(mesh.supports(on_mesh), radius)
    body = body_of(shapes.subject.cloud, Material())
    engines.append(Plain(write_shape(folder / f"{path.stem}_ideal.urdf", seen, boxes, body), visual, radius))
    away = on_mesh + [AIR * radius, 0, AIR * radius]
    held = [mesh.steps(on_mesh), other.steps(rest), empty.steps(away), engines[-1].steps(centers)]
    times = np.array([next(zip(*held, strict=True)) for _ in range(TIMED)])
    for engine in engines:
        engine.close()
    seen_step, written, air, least = np.median(times, axis=0)
    return Checked(
        file=path.name, label=label, group=group, shape=best.name, keeps=best.row.keeps, pieces=best.solid.count,
        faces=len(seen.faces), cheaper=float((seen_step - air) / (written - air)), seconds=seconds,
        at_most=float((seen_step - air) / (least - air)),
        bullet=stay(*bullet[:2], radius), bullet_itself=stay(*bullet[::2], radius),
        mujoco=stay(*flex[:2], radius), mujoco_itself=stay(*flex[::2], radius),
    )  # fmt: skip


def main():
    """Check, and print a table by source."""
    parser = argparse.ArgumentParser(description="Do written shapes keep what is seen, in other programs?")
    parser.add_argument("data")
    parser.add_argument("--each", type=int, default=3, help="objects of each label and source")
    parser.add_argument("--chosen", default="", help="sources that the method was chosen on, comma-separated")
    arguments = parser.parse_args()
    chosen, rows = defaultdict(list), []
    for item in open_dataset(arguments.data).objects:
        for label in ("cup", "sittable", "table"):
            if label in item.functions:
                chosen[item.group, label].append(item)
    with tempfile.TemporaryDirectory() as folder:
        for number in range(arguments.each):  # every source first, in case it is stopped
            for (group, label), items in chosen.items():
                for item in items[:: max(1, len(items) // arguments.each)][number : number + 1]:
                    rows.append(checked(Path(item.path), label, group, Path(folder)))
                    say(str(rows[-1]))
    report(rows, arguments.chosen.split(","))
    print_json([asdict(row) for row in rows])


def report(rows: list[Checked], chosen: list[str]):
    """Print one line for each source, for those that the method was chosen on, for the others, and for all."""
    sources, table = sorted({row.group for row in rows}), []
    halves = {"chosen on": chosen, "left out": [source for source in sources if source not in chosen]}
    for name, groups in ({source: [source] for source in sources} | halves | {"all": sources}).items():
        own = [row for row in rows if row.group in groups]
        if not own:
            continue
        shares = np.array([[row.bullet, row.bullet_itself, row.mujoco, row.mujoco_itself] for row in own])
        shares = np.insert(shares, [2, 4], shares[:, [0, 2]] / shares[:, [1, 3]], axis=1)
        fine = [np.mean([row.keeps for row in own]), *(shares >= ENOUGH).mean(axis=0)]
        large, pieces = [row for row in own if row.faces > MANY_FACES], np.median([row.pieces for row in own])
        cheaper = [np.median([getattr(row, of) for row in large]) if large else np.nan for of in ("cheaper", "at_most")]
        shown = [*(f"{share:.2f}" for share in fine), f"{pieces:g}", *(f"{times:.2g}" for times in cheaper)]
        table.append([name, len(own), *shown])
    engines = [name for engine in ("PyBullet", "MuJoCo") for name in (engine, "mesh itself", "of that")]
    head = ["source", "objects", "said to keep", *engines, "pieces", "cheaper", "at most"]
    print_table("Share of objects that keep 0.95 of the spheres; times cheaper: > 5,000 faces", head, table)


if __name__ == "__main__":
    main()
