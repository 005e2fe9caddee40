"""Are objects that are put at the places still there two seconds later, on bare tables and on laid ones?"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, load_cloud
from spherefunc_bullet.formats.sources import joined_meshes
from spherefunc_bullet.places.finding import places_of
from spherefunc_bullet.places.place import Place

RATE, SECONDS = 240, 2.0
MOVED, TILTED = 0.02, 5.0  # metres and degrees, after `SECONDS`
MASS = 0.3  # kg


@dataclass(frozen=True, kw_only=True)
class StayCounts:
    """The numbers of objects that were set down, that stayed, and that touched others."""

    asked: int
    stayed: int
    touched: int  # by objects that stood there already


class OwnWorld:
    """A PyBullet world that shares no code with the backend's."""

    def __init__(self, cloud: Cloud):
        import pybullet as p

        self.p = p
        p.connect(p.DIRECT)  # the only one of this process; BulletClient would print on stdout
        p.setGravity(0, 0, -9.81)
        p.setTimeStep(1 / RATE)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{Path(folder).name}.obj"
            lines = [f"v {x:.8g} {y:.8g} {z:.8g}" for x, y, z in cloud.mesh.vertices]
            lines += [f"f {a} {b} {c}" for a, b, c in cloud.mesh.faces + 1]
            path.write_text("\n".join(lines) + "\n")
            shape = p.createCollisionShape(p.GEOM_MESH, fileName=str(path), flags=p.GEOM_FORCE_CONCAVE_TRIMESH)
        self.visual = p.createVisualShape(p.GEOM_SPHERE, radius=0.01)
        self.table = p.createMultiBody(0, shape, self.visual)
        p.setCollisionFilterGroupMask(self.table, -1, 1, 2)

    def stayed(self, put: Cloud, poses: Sequence[np.ndarray]) -> StayCounts:
        """Set an object down at several poses, where the copies do not touch, and count those that stay."""
        from scipy.spatial.transform import Rotation

        p = self.p
        corners = put.mesh.vertices[:: max(1, len(put.mesh.vertices) // 400)]
        middle = put.mesh.vertices.mean(axis=0)
        shape = p.createCollisionShape(p.GEOM_MESH, vertices=(corners - middle).tolist())
        bodies = []
        for pose in poses:
            place, turn = pose[:3, :3] @ middle + pose[:3, 3], Rotation.from_matrix(pose[:3, :3]).as_quat()
            bodies.append(p.createMultiBody(MASS, shape, self.visual, place.tolist(), turn.tolist()))
            p.setCollisionFilterGroupMask(bodies[-1], -1, 2, 1)
        starts = [p.getBasePositionAndOrientation(body) for body in bodies]
        touched = np.zeros(len(bodies), bool)
        for step in range(round(RATE * SECONDS)):
            p.stepSimulation()
            if step % 24 == 0:
                touched |= [self.beside(body, pose[2, 3]) for body, pose in zip(bodies, poses, strict=True)]
        ends = [p.getBasePositionAndOrientation(body) for body in bodies]
        for body in bodies:
            p.removeBody(body)
        stayed = sum(map(is_where_it_was, starts, ends))
        return StayCounts(asked=len(poses), stayed=stayed, touched=int(touched.sum()))

    def beside(self, body: int, height: float) -> bool:
        """Return whether a body touches something that is higher than the surface on which it stands."""
        contacts = self.p.getContactPoints(body, self.table)
        return any(contact[6][2] > height + 0.01 and contact[8] < 0 for contact in contacts)

    def close(self):
        """Close the engine."""
        self.p.disconnect()


def is_where_it_was(start: tuple, end: tuple) -> bool:
    """Return whether an object has hardly moved and tilted."""
    from scipy.spatial.transform import Rotation

    moved = np.linalg.norm(np.subtract(end[0], start[0]))
    up = (Rotation.from_quat(end[1]) * Rotation.from_quat(start[1]).inv()).apply([0, 0, 1])
    return bool(moved < MOVED and np.degrees(np.arccos(np.clip(up[2], -1, 1))) < TILTED)


POSES = 20  # of each table and object, chosen at random


def put_objects(folder: Path) -> dict[str, Cloud]:
    """Return a mug, a bottle, a plate and a book."""
    import trimesh

    book = trimesh.creation.box((0.15, 0.21, 0.03))
    named = {"mug": "misc_pybullet_mug.ply", "bottle": "bs0_023_bottle.ply", "plate": "jsk_coffee-cup-saucer_plate.ply"}
    objects = {name: load_cloud(folder / file) for name, file in named.items()}
    return objects | {"book": cloud_from_mesh(book.vertices, book.faces, "book")}


def lay_object(table: Cloud, objects: dict[str, Cloud], rng: np.random.Generator) -> Cloud | None:
    """Return a table with a mug, a bottle and a book on it, as one mesh; None if there is no place for one of them."""
    parts = [(table.mesh.vertices, table.mesh.faces)]
    for name in ("mug", "bottle", "book"):
        poses = [pose for place in put_on(table, objects[name]) for pose in place.poses]
        if not poses:
            return None
        pose, mesh = poses[rng.integers(len(poses))], objects[name].mesh
        parts.append((mesh.vertices @ pose[:3, :3].T + pose[:3, 3], mesh.faces))
    return cloud_from_mesh(*joined_meshes(parts), f"laid {table.name}")


def put_on(cloud: Cloud, put: Cloud) -> list[Place]:
    """Return the places at which an object can be put."""
    return places_of(cloud, put=put, scores={}, only="put")


def put_benchmark(cloud: Cloud, objects: dict[str, Cloud], rng: np.random.Generator) -> dict[str, StayCounts | None]:
    """Return the counts of each object at random poses on one table; None without poses."""
    world, rows = OwnWorld(cloud), {}
    for name, put in objects.items():
        poses = [pose for place in put_on(cloud, put) for pose in place.poses]
        chosen = [poses[k] for k in rng.permutation(len(poses))[:POSES]]
        rows[name] = world.stayed(put, chosen) if chosen else None
    world.close()
    return rows


def summary(rows: Sequence[dict[str, StayCounts | None]]) -> dict[str, dict[str, float]]:
    """Return for each object the poses tested, the share that stayed, and the numbers touched and without a pose."""
    results = {}
    for name in rows[0] if rows else ():
        got = [row[name] for row in rows if row[name] is not None]
        tested = sum(count.asked for count in got)
        results[name] = {
            "poses": tested,
            "stayed": round(sum(count.stayed for count in got) / max(1, tested), 4),
            "touched": sum(count.touched for count in got),
            "without": sum(row[name] is None for row in rows),
        }
    return results
